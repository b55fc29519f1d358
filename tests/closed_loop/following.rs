//! Model-following control as the firmware runs it in a period; its readings are converted to per unit here.

use firmware::control::{Control, Following as Inner, Reference};
use firmware::measured::Measured;
use model_core::control::{Follower, Tuning};
use model_core::machine::Machine;
use model_core::number::{Number, PerUnit};
use system_tests::rig::{Controller, Readings, Rig, TICK, Wanted};

/// The sensors that exist beside the position's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sight {
    /// Spool and both pressures.
    Full,
    /// None.
    PositionOnly,
}

pub(crate) struct Following {
    inner: Inner<64>,
    sight: Sight,
}

impl Following {
    /// Started on a machine at rest; `model` is what is known of the machine.
    pub(crate) fn new(model: &Machine<f64>, tuning: &Tuning, rig: &Rig) -> Self {
        Self::seeing(Sight::Full, model, tuning, rig)
    }

    /// The same with these sensors.
    pub(crate) fn seeing(sight: Sight, model: &Machine<f64>, tuning: &Tuning, rig: &Rig) -> Self {
        let follower = Follower::new(model, tuning, TICK).unwrap();
        let inner = Inner::new(follower, Reference::at_rest(model, TICK, 0.5).unwrap());
        let mut following = Self { inner, sight };
        let first = following.measured(&rig.at_rest());
        following.inner.start(&first);
        following
    }

    fn measured(&self, seen: &Readings) -> Measured {
        let bases = self.inner.reference().bases();
        let beside = |value: f64| (self.sight == Sight::Full).then(|| PerUnit::saturated(value));
        Measured {
            position: PerUnit::saturated(seen.position_m / bases.stroke_m),
            spool: beside(seen.spool),
            pressure_a: beside(seen.pressure_a_pa / bases.pressure_pa),
            pressure_b: beside(seen.pressure_b_pa / bases.pressure_pa),
            oil_temperature: None,
        }
    }
}

impl Controller for Following {
    fn command_v(&mut self, wanted: Wanted, seen: &Readings) -> f64 {
        let measured = self.measured(seen);
        self.inner.follow(wanted.per_unit, &measured).to_f64() * self.inner.reference().bases().command_v
    }
}
