//! Model-following control as the period's [`Control`]: the follower's loops around the reference model.

use model_core::chambers::ChamberState;
use model_core::fixed_point::PerUnit;
use model_core::follow::{FollowState, Follower, Observed};

use crate::control::Control;
use crate::measured::Measured;
use crate::reference::{Predicted, Reference};
use crate::set_point::SetPoint;

/// Follower and reference model, whose delay line has `DELAY` ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Following<const DELAY: usize> {
    follower: Follower,
    state: FollowState,
    reference: Reference<DELAY>,
}

impl<const DELAY: usize> Following<DELAY> {
    /// From a follower and the reference model of the same machine and tick.
    #[must_use]
    pub fn new(follower: Follower, reference: Reference<DELAY>) -> Self {
        let model = reference.predicted();
        let position = model.position;
        let state = follower.at_rest(&model, &Observed { position, slider: None, pressures: None });
        Self { follower, state, reference }
    }

    /// The reference model.
    #[must_use]
    pub fn reference(&self) -> &Reference<DELAY> {
        &self.reference
    }

    /// Tells the model what it cannot know by itself.
    fn inform(&mut self, measured: &Measured) {
        if let Some(temperature) = measured.oil_temperature {
            self.reference.set_oil_temperature(temperature);
        }
    }
}

impl<const DELAY: usize> Control for Following<DELAY> {
    fn start(&mut self, measured: &Measured) {
        let Predicted { pressure_a: a, pressure_b: b, .. } = self.reference.predicted();
        let pressures = measured.observed().pressures.unwrap_or(ChamberState { a, b });
        self.inform(measured);
        self.reference.start_at(self.follower.neutral(), pressures, measured.position);
        self.state = self.follower.at_rest(&self.reference.predicted(), &measured.observed());
    }

    fn predicted(&self) -> Predicted {
        self.reference.predicted()
    }

    fn follow(&mut self, set_point: SetPoint, measured: &Measured) -> PerUnit {
        let model = self.reference.predicted();
        let model_command = self.follower.model_command(&mut self.state, set_point, &model);
        let command = self.follower.command(&mut self.state, model_command, &model, &measured.observed());
        self.inform(measured);
        self.reference.step(model_command);
        command
    }

    fn accompany(&mut self, command: PerUnit, measured: &Measured) {
        self.inform(measured);
        self.reference.step(command);
    }
}
