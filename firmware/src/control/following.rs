//! Model-following control as the period's [`Control`]: the follower's loops around the reference model.

use model_core::control::{FollowState, Follower, Observed};
use model_core::number::PerUnit;
use model_core::ports::ChamberState;
use model_core::valve::ValveState;

use super::Control;
use super::reference::{Predicted, Reference};
use crate::measured::Measured;
use crate::set_point::SetPoint;

/// Follower and reference model, whose delay line has `DELAY` ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Following<const DELAY: usize> {
    follower: Follower,
    state: FollowState,
    reference: Reference<DELAY>,
    /// The valve's model under the command that the machine's valve gets; the reference's valve has the model's own command.
    valve: Option<ValveState<PerUnit, DELAY>>,
}

impl<const DELAY: usize> Following<DELAY> {
    /// From a follower and the reference model of the same machine and tick.
    #[must_use]
    pub fn new(follower: Follower, reference: Reference<DELAY>) -> Self {
        let model = reference.predicted();
        let position = model.position;
        let state = follower.at_rest(&model, &Observed { position, spool: None, pressures: None });
        let valve = reference.valve().map(|valve| valve.at_rest(follower.neutral()));
        Self { follower, state, reference, valve }
    }

    /// The reference model.
    #[must_use]
    pub fn reference(&self) -> &Reference<DELAY> {
        &self.reference
    }

    /// Passes on to the model what it cannot compute.
    fn inform(&mut self, measured: &Measured) {
        if let Some(temperature) = measured.oil_temperature {
            self.reference.set_oil_temperature(temperature);
        }
    }

    /// The machine's command, which makes it do what the model does under its own; the model is stepped.
    fn together(&mut self, model_command: PerUnit, model: &Predicted, measured: &Measured) -> PerUnit {
        let seen = self.reference.undistorted(&measured.observed());
        let command = self.follower.command(&mut self.state, model_command, model, &seen);
        self.inform(measured);
        self.reference.step(model_command);
        command
    }
}

impl<const DELAY: usize> Control for Following<DELAY> {
    fn start(&mut self, measured: &Measured) {
        let Predicted { pressure_a: a, pressure_b: b, .. } = self.reference.predicted();
        let shown = measured.observed();
        self.inform(measured);
        let mut seen = shown;
        // Twice, because a sensor's distortion of a pressure depends on that pressure.
        for _ in 0..2 {
            let pressures = seen.pressures.unwrap_or(ChamberState { a, b });
            self.reference.start_at(self.follower.neutral(), pressures, measured.position);
            seen = self.reference.undistorted(&shown);
        }
        self.state = self.follower.at_rest(&self.reference.predicted(), &seen);
        self.valve = self.reference.valve().map(|valve| valve.at_rest(self.follower.neutral()));
    }

    fn predicted(&self) -> Predicted {
        self.reference.sensed()
    }

    fn follow(&mut self, set_point: SetPoint, measured: &Measured) -> PerUnit {
        let model = self.reference.predicted();
        let model_command = self.follower.model_command(&mut self.state, set_point, &model);
        self.together(model_command, &model, measured)
    }

    fn play(&mut self, command: PerUnit, measured: &Measured) -> PerUnit {
        let model = self.reference.predicted();
        let model_command = self.follower.driven_command(&mut self.state, command, &model);
        self.together(model_command, &model, measured)
    }

    fn motion(&self) -> SetPoint {
        let Predicted { position, velocity, .. } = self.reference.predicted();
        SetPoint { position, velocity }
    }

    fn accompany(&mut self, command: PerUnit, measured: &Measured) {
        self.inform(measured);
        self.reference.step(command);
    }

    fn applied(&mut self, command: PerUnit) {
        if let (Some(valve), Some(state)) = (self.reference.valve(), &mut self.valve) {
            valve.step(state, command);
        }
    }

    fn spool_off(&self, measured: &Measured) -> Option<PerUnit> {
        let spool = self.reference.undistorted(&measured.observed()).spool?;
        Some(spool - self.valve.as_ref()?.spool())
    }
}

#[cfg(test)]
mod tests {
    use model_core::control::Tuning;
    use model_core::drive::{Drive, DriveInput, Load};
    use model_core::machine::{Machine, Parameter as P, Tick};
    use model_core::number::Number;

    use super::*;
    use crate::mock::press;

    const TICK: Tick = Tick::OneMillisecond;

    /// Commands for a machine with these sensors from a model of the same machine, and how far the measured position was from the predicted one.
    fn followed(machine: &Machine<f64>) -> (std::vec::Vec<PerUnit>, PerUnit) {
        let reference = Reference::<64>::at_rest(machine, TICK, 0.5).unwrap();
        let tuning = Tuning::by_rule(machine, true);
        let mut following = Following::new(Follower::new(machine, &tuning, TICK).unwrap(), reference);
        let plant = Drive::<PerUnit>::new::<64>(machine, TICK).unwrap();
        let mut state = *following.reference.state();
        let mut apart = PerUnit::ZERO;
        let commands = (0..600).map(|tick| {
            let seen = plant.sensed(&state);
            let position = PerUnit::of_travel(seen.position);
            let measured = Measured {
                position,
                spool: Some(seen.spool),
                pressure_a: Some(seen.pressure_a),
                pressure_b: Some(seen.pressure_b),
                oil_temperature: None,
            };
            if tick == 0 {
                following.start(&measured);
                // Model and plant now both rest, with the pressures that hold the plant.
                state = *following.reference.state();
            }
            apart = Ord::max(apart, (position - following.predicted().position).magnitude());
            let way = PerUnit::saturated(0.5 + 2e-4 * f64::from(tick.min(400)));
            let command = following.follow(SetPoint { position: way, velocity: PerUnit::ZERO }, &measured);
            plant.step(&mut state, DriveInput::Command(command), Load::NONE);
            command
        });
        (commands.collect(), apart)
    }

    #[test]
    fn what_the_model_knows_of_the_sensors_neither_moves_the_rod_nor_is_amiss() {
        let plain = press();
        let late = plain.with(&[(P::PositionLag, 0.005), (P::PositionDelay, 0.0073)]);
        let loose = plain.with(&[(P::BacklashPlay, 1e-3)]);
        let (commands, _) = followed(&plain);
        assert!(commands.iter().any(|command| *command != commands[0]), "it moves");
        for machine in [late, loose] {
            let (found, apart) = followed(&machine);
            let moved = found.iter().zip(&commands).map(|(one, other)| (*one - *other).magnitude()).max().unwrap();
            // Only what a command loses on its way through the loops.
            assert!(moved.to_f64() < 2e-5 && apart.to_f64() < 1e-7, "{moved:?} {apart:?}");
        }
    }
}
