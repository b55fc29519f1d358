//! The reference model in a controller: coefficients and state together, one step per control period.

use model_core::drive::{Drive, DriveInput, DriveState, Load};
use model_core::machine::{Bases, Machine, MachineError, Parameter, Tick};
use model_core::number::{Number, PerUnit};
use model_core::ports::ChamberState;
use model_core::valve::Valve;

use model_core::control::Observed;
pub use model_core::control::Predicted;

/// The reference model with a delay line of `DELAY` ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference<const DELAY: usize> {
    drive: Drive<PerUnit>,
    state: DriveState<PerUnit, DELAY>,
    rest: Rest,
}

/// What determines the pressures at which a rod rests.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rest {
    /// α = Ab/Aa
    ratio: PerUnit,
    /// 1/(1 + α)
    share: PerUnit,
    /// Force of the oil that holds the model's own load, per unit.
    holding: PerUnit,
}

impl Rest {
    fn of(machine: &Machine<f64>, bases: &Bases) -> Self {
        let ratio = machine.get(Parameter::AreaB) / machine.get(Parameter::AreaA);
        Self {
            ratio: PerUnit::saturated(ratio),
            share: PerUnit::saturated(1.0 / (1.0 + ratio)),
            holding: -PerUnit::saturated(machine.get(Parameter::LoadForce) / bases.force_n),
        }
    }

    /// Of all pressures with the same sum, returns those that hold the load.
    fn balanced(&self, pressures: ChamberState<PerUnit>) -> ChamberState<PerUnit> {
        let excess = pressures.a - self.ratio.times(pressures.b) - self.holding;
        let moved = excess.times(self.share);
        ChamberState { a: pressures.a - moved, b: pressures.b + moved }
    }
}

impl<const DELAY: usize> Reference<DELAY> {
    /// The model at rest with no command, at a position of 0..1 of the stroke; the pressures balance the load at half the supply.
    ///
    /// # Errors
    /// A parameter is out of range or does not fit the fixed-point formats; the error says which.
    pub fn at_rest(machine: &Machine<f64>, tick: Tick, position: f64) -> Result<Self, MachineError> {
        let drive = Drive::new::<DELAY>(machine, tick)?;
        let rest = Rest::of(machine, drive.bases());
        let half = PerUnit::saturated(0.5);
        let pressures = ChamberState { a: half.times(rest.ratio) + rest.holding, b: half };
        let state = drive.at_rest(PerUnit::ZERO, pressures, PerUnit::travel(position));
        Ok(Self { drive, state, rest })
    }

    /// Starts again at rest where the machine is: at this position (share of the stroke), with `command` (in units of 10 V) held for long,
    /// and at these pressures, shifted so that they hold the model's own load: with a load that only the machine has, the model would not
    /// rest. A controller that starts so is bumpless.
    pub fn start_at(&mut self, command: PerUnit, pressures: ChamberState<PerUnit>, position: PerUnit) {
        let oil_temperature = self.state.oil_temperature;
        self.state = self.drive.at_rest(command, self.rest.balanced(pressures), position.as_travel());
        self.state.oil_temperature = oil_temperature;
    }

    /// One control period with a command in units of 10 V, of any size.
    pub fn step(&mut self, command: PerUnit) -> Predicted {
        self.drive.step(&mut self.state, DriveInput::Command(command), Load::NONE);
        self.predicted()
    }

    /// Gives the model the oil's measured temperature, per unit of [`Bases::temperature_c`]; it takes effect from the next period on.
    /// Without it, the oil stays at the temperature for which the machine's values hold.
    pub fn set_oil_temperature(&mut self, temperature: PerUnit) {
        self.state.oil_temperature = temperature;
    }

    /// The valve link, where the machine has one.
    #[must_use]
    pub fn valve(&self) -> Option<&Valve<PerUnit>> {
        self.drive.valve()
    }

    /// What the model predicts now.
    #[must_use]
    pub fn predicted(&self) -> Predicted {
        let DriveState { chambers, motion, .. } = &self.state;
        Predicted {
            spool: self.drive.spool(&self.state),
            pressure_a: chambers.a,
            pressure_b: chambers.b,
            velocity: motion.velocity,
            position: PerUnit::of_travel(motion.position),
        }
    }

    /// What the model's sensors show of this prediction.
    #[must_use]
    pub fn sensed(&self) -> Predicted {
        let sensed = self.drive.sensed(&self.state);
        Predicted {
            spool: sensed.spool,
            pressure_a: sensed.pressure_a,
            pressure_b: sensed.pressure_b,
            velocity: sensed.velocity,
            position: PerUnit::of_travel(sensed.position),
        }
    }

    /// What the machine's sensors show, less the distortion by the model's sensors: the remaining difference to the model then comes from
    /// the machine, not from its sensors.
    #[must_use]
    pub fn undistorted(&self, seen: &Observed) -> Observed {
        let (is, shows) = (self.predicted(), self.sensed());
        Observed {
            position: seen.position + (is.position - shows.position),
            spool: seen.spool.map(|spool| spool + (is.spool - shows.spool)),
            pressures: seen.pressures.map(|ChamberState { a, b }| ChamberState {
                a: a + (is.pressure_a - shows.pressure_a),
                b: b + (is.pressure_b - shows.pressure_b),
            }),
        }
    }

    /// What 1 per unit stands for, in SI units.
    #[must_use]
    pub fn bases(&self) -> &Bases {
        self.drive.bases()
    }

    /// The state, to be stored.
    #[must_use]
    pub fn state(&self) -> &DriveState<PerUnit, DELAY> {
        &self.state
    }

    /// Goes on from a stored state, bit for bit.
    pub fn restore(&mut self, state: DriveState<PerUnit, DELAY>) {
        self.state = state;
    }
}

#[cfg(test)]
mod tests {
    use model_core::machine::Source;

    use super::*;

    fn press() -> Machine<f64> {
        let mut machine = Machine::with_defaults(Source::Valve);
        machine.set(Parameter::AreaA, 3.117e-3);
        machine.set(Parameter::AreaB, 1.861e-3);
        machine.set(Parameter::VolumeA, 5.2e-4);
        machine.set(Parameter::VolumeB, 3.3e-4);
        machine
    }

    fn reference() -> Reference<64> {
        Reference::at_rest(&press(), Tick::OneMillisecond, 0.5).unwrap()
    }

    #[test]
    fn a_positive_command_extends_and_none_holds() {
        let mut model = reference();
        let before = model.predicted();
        assert_eq!(model.step(PerUnit::ZERO).position, before.position);
        for _ in 0..200 {
            model.step(PerUnit::saturated(0.5));
        }
        assert!(model.predicted().position > before.position);
    }

    #[test]
    fn warm_oil_lets_the_rod_run_faster() {
        let mut machine = press();
        machine.set(Parameter::ViscosityLossPerKelvin, 0.04);
        let travelled = |measured_c: Option<f64>| {
            let mut model = Reference::<64>::at_rest(&machine, Tick::OneMillisecond, 0.3).unwrap();
            if let Some(celsius) = measured_c {
                model.set_oil_temperature(PerUnit::saturated(celsius / model.bases().temperature_c));
            }
            for _ in 0..300 {
                model.step(PerUnit::saturated(0.5));
            }
            model.predicted().position
        };
        assert_eq!(travelled(Some(40.0)), travelled(None));
        assert!(travelled(Some(70.0)) > travelled(None) && travelled(None) > travelled(Some(10.0)));
    }

    #[test]
    fn a_start_where_the_machine_is_rests_there_whatever_its_load() {
        let mut model = reference();
        model.step(PerUnit::ONE);
        let position = PerUnit::saturated(0.123_456_7);
        let pressures = ChamberState { a: PerUnit::saturated(0.71), b: PerUnit::saturated(0.47) };
        model.start_at(PerUnit::ZERO, pressures, position);
        let first = model.predicted();
        assert_eq!((first.position, first.velocity), (position, PerUnit::ZERO));
        assert!(((first.pressure_a + first.pressure_b) - (pressures.a + pressures.b)).magnitude().to_f64() < 1e-7);
        for _ in 0..1000 {
            model.step(PerUnit::ZERO);
        }
        assert!((model.predicted().position - position).magnitude().to_f64() < 1e-8);
    }

    #[test]
    fn a_stored_state_goes_on_bit_for_bit() {
        let mut model = reference();
        let command = |k: i32| PerUnit::saturated(f64::from(k % 40 - 20) / 20.0);
        for k in 0..100 {
            model.step(command(k));
        }
        let stored = *model.state();
        let first: [Predicted; 50] = core::array::from_fn(|k| model.step(command(i32::try_from(k).unwrap())));
        model.restore(stored);
        let again: [Predicted; 50] = core::array::from_fn(|k| model.step(command(i32::try_from(k).unwrap())));
        assert_eq!(first, again);
    }
}
