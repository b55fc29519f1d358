//! Model-following control as the firmware runs it in a period, with its readings made per unit here.

use firmware::reference::Reference;
use model_core::chambers::ChamberState;
use model_core::fixed_point::PerUnit;
use model_core::follow::{FollowState, Follower, Observed, Tuning};
use model_core::machine::Machine;
use model_core::number::Number;

use crate::rig::{Controller, Readings, Rig, TICK, Wanted};

/// Which sensors there are beside the position's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sight {
    /// Slider and both pressures.
    Full,
    /// None.
    PositionOnly,
}

impl Sight {
    fn of(self, seen: Observed) -> Observed {
        match self {
            Sight::Full => seen,
            Sight::PositionOnly => Observed { slider: None, pressures: None, ..seen },
        }
    }
}

pub(crate) struct Following {
    follower: Follower,
    state: FollowState,
    reference: Reference<64>,
    sight: Sight,
}

fn observed(reference: &Reference<64>, seen: &Readings) -> Observed {
    let bases = reference.bases();
    let pressure = |pressure_pa: f64| PerUnit::saturated(pressure_pa / bases.pressure_pa);
    Observed {
        position: PerUnit::saturated(seen.position_m / bases.stroke_m),
        slider: Some(PerUnit::saturated(seen.slider)),
        pressures: Some(ChamberState { a: pressure(seen.pressure_a_pa), b: pressure(seen.pressure_b_pa) }),
    }
}

impl Following {
    /// Started on a machine at rest, with `model` as what is known of it.
    pub(crate) fn new(model: &Machine<f64>, tuning: &Tuning, rig: &Rig) -> Self {
        Self::seeing(Sight::Full, model, tuning, rig)
    }

    /// The same with these sensors.
    pub(crate) fn seeing(sight: Sight, model: &Machine<f64>, tuning: &Tuning, rig: &Rig) -> Self {
        let follower = Follower::new(model, tuning, TICK).unwrap();
        let mut reference = Reference::at_rest(model, TICK, 0.5).unwrap();
        let first = sight.of(observed(&reference, &rig.at_rest()));
        // Without pressures, those that the model itself rests under.
        let pressures = first.pressures.unwrap_or(reference.state().chambers);
        reference.start_at(follower.neutral(), pressures, first.position);
        let state = follower.at_rest(&reference.predicted(), &first);
        Self { follower, state, reference, sight }
    }
}

impl Controller for Following {
    fn command_v(&mut self, wanted: Wanted, seen: &Readings) -> f64 {
        let observed = self.sight.of(observed(&self.reference, seen));
        let model = self.reference.predicted();
        let model_command = self.follower.model_command(&mut self.state, wanted.per_unit, &model);
        let command = self.follower.command(&mut self.state, model_command, &model, &observed);
        self.reference.step(model_command);
        command.to_f64() * self.reference.bases().command_v
    }
}
