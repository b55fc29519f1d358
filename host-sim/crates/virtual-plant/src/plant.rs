//! The plant over time: from commands and an initial state to the true signals at every tick.

use std::cell::Cell;
use std::rc::Rc;
use std::sync::Arc;

use diffsol::DiffsolError;
use thiserror::Error;

use model_core::machine::{Machine, Parameter, Source};

use crate::boundary::Boundary;
use crate::effect::PlantEffect;
use crate::excitation::input::{Command, Commands, LoadProfile};
use crate::integrator::{self, Stepper};
use crate::physics::Physics;

/// Where the drive starts, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialState {
    /// Pressure in chamber A, Pa.
    pub pressure_a_pa: f64,
    /// Pressure in chamber B, Pa.
    pub pressure_b_pa: f64,
    /// Rod position, m; positive extended.
    pub position_m: f64,
    /// Rod velocity, m/s; positive extends.
    pub velocity_m_per_s: f64,
}

impl InitialState {
    /// At rest with the forces balanced and pa + pb = p0: the state to which a closed valve with equal edges settles.
    #[must_use]
    pub fn at_rest(machine: &Machine<f64>, position_m: f64) -> Self {
        Self::at_rest_with_level(machine, position_m, 0.5 * machine.get(Parameter::SupplyPressure))
    }

    /// At rest with the forces balanced; `level_pa` is the mean of both pressures.
    #[must_use]
    pub fn at_rest_with_level(machine: &Machine<f64>, position_m: f64, level_pa: f64) -> Self {
        let (area_a, area_b) = (machine.get(Parameter::AreaA), machine.get(Parameter::AreaB));
        let load_n = machine.get(Parameter::LoadForce);
        let pressure_a_pa = (2.0 * level_pa * area_b - load_n) / (area_a + area_b);
        Self { pressure_a_pa, pressure_b_pa: 2.0 * level_pa - pressure_a_pa, position_m, velocity_m_per_s: 0.0 }
    }
}

/// The true signals at one tick, in SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlantState {
    /// Spool position x, 1; positive extends.
    pub spool: f64,
    /// Flow Qa into chamber A, m³/s.
    pub flow_a_m3_per_s: f64,
    /// Flow Qb out of chamber B, m³/s.
    pub flow_b_m3_per_s: f64,
    /// Pressure in chamber A, Pa.
    pub pressure_a_pa: f64,
    /// Pressure in chamber B, Pa.
    pub pressure_b_pa: f64,
    /// Rod position, m.
    pub position_m: f64,
    /// Rod velocity, m/s.
    pub velocity_m_per_s: f64,
    /// Pressure at the valve's port P, Pa.
    pub supply_pressure_pa: f64,
}

/// Why a plant could not be simulated.
#[derive(Debug, Error)]
pub enum PlantError {
    /// The numbers of commands and of times differ.
    #[error("{commands} commands for {times} times; expected one command per time")]
    Lengths {
        /// Number of commands found.
        commands: usize,
        /// Number of times found.
        times: usize,
    },
    /// Times do not rise.
    #[error("time {found_s} s at tick {tick} does not follow {previous_s} s")]
    TimesNotRising {
        /// Which tick.
        tick: usize,
        /// Its time, s.
        found_s: f64,
        /// The time before, s.
        previous_s: f64,
    },
    /// A time, a command or an initial value is not a number.
    #[error("{what} at tick {tick} is {value}, expected a finite number")]
    NotFinite {
        /// Which signal.
        what: &'static str,
        /// Which tick.
        tick: usize,
        /// The value found.
        value: f64,
    },
    /// Commands of a valve for a pump drive, or the other way round.
    #[error("commands of another kind for a drive whose source is {source_of_drive:?}")]
    CommandKind {
        /// The source the machine has.
        source_of_drive: Source,
    },
    /// The plant is hydraulic.
    #[error("a machine that a force moves; expected one with a valve or a pump")]
    NoOil,
    /// A parameter that the plant needs is not a number.
    #[error("{} is {value}, expected a number within its range", parameter.description().key)]
    Parameter {
        /// Which one.
        parameter: Parameter,
        /// Its value.
        value: f64,
    },
    /// The tolerance is outside the range that the arithmetic can keep.
    #[error("relative tolerance {found}, expected {} to {}", TOLERANCES.0, TOLERANCES.1)]
    Tolerance {
        /// The tolerance found.
        found: f64,
    },
    /// The integrator gave up.
    #[error("integration failed after {time_s} s: {cause}; expected a drive whose pressures and forces stay finite")]
    Integration {
        /// Start of the interval on which it failed, s.
        time_s: f64,
        /// The integrator's error.
        cause: DiffsolError,
    },
}

/// Smallest and largest relative tolerance.
const TOLERANCES: (f64, f64) = (1e-12, 1e-2);

/// The plant: a machine's physics with effects and a load, to be simulated to a tolerance.
#[derive(Clone, Debug)]
pub struct Plant {
    pub(crate) machine: Machine<f64>,
    pub(crate) physics: Arc<Physics>,
    pub(crate) load: LoadProfile,
    tolerance: f64,
}

impl Plant {
    /// The paper's model of `machine`, solved to `tolerance` (relative; and absolute, relative to the
    /// supply pressure, to the stroke and to 1 m/s): 1e-10 for an oracle, 1e-7 for recordings.
    pub fn new(machine: &Machine<f64>, tolerance: f64) -> Result<Self, PlantError> {
        if !(TOLERANCES.0..=TOLERANCES.1).contains(&tolerance) {
            return Err(PlantError::Tolerance { found: tolerance });
        }
        if machine.source == Source::Force {
            return Err(PlantError::NoOil);
        }
        for &parameter in Parameter::ALL {
            let value = machine.get(parameter);
            let description = parameter.description();
            let derived = matches!(parameter, Parameter::VolumeA | Parameter::VolumeB) && value.is_nan();
            if !(derived || (description.min..=description.max).contains(&value)) {
                return Err(PlantError::Parameter { parameter, value });
            }
        }
        let physics = Arc::new(Physics::new(machine, &[]));
        Ok(Self { machine: *machine, physics, load: LoadProfile::none(), tolerance })
    }

    /// The same plant with effects that the paper's model leaves out, in the plant's own forms.
    /// The effect parameters in the machine itself belong to the core and are not used here.
    #[must_use]
    pub fn with_effects(mut self, effects: &[PlantEffect]) -> Self {
        self.physics = Arc::new(Physics::new(&self.machine, effects));
        self
    }

    /// The same plant with a force on the rod in addition to the machine's constant load.
    #[must_use]
    pub fn with_load(mut self, load: LoadProfile) -> Self {
        self.load = load;
        self
    }

    /// The machine that it was made from.
    #[must_use]
    pub fn machine(&self) -> &Machine<f64> {
        &self.machine
    }

    /// The true signals at `times_s` under recorded commands: one per time, held until the next.
    pub fn simulate(
        &self,
        commands: &Commands,
        initial: &InitialState,
        times_s: &[f64],
    ) -> Result<Vec<PlantState>, PlantError> {
        if commands.len() != times_s.len() {
            return Err(PlantError::Lengths { commands: commands.len(), times: times_s.len() });
        }
        match commands {
            Commands::Valve(volts) => self.run(initial, times_s, |tick, _| Command::Valve(volts[tick])),
            Commands::Pump(pump) => self.run(initial, times_s, |tick, _| Command::Pump(pump[tick])),
        }
    }

    /// The true signals at `times_s`, with a command chosen at each tick from the state at that tick:
    /// a controller in the loop. The first command counts as having been held since always; the
    /// state shown at the first tick, before that command is known, has the spool at its offset.
    pub fn run(
        &self,
        initial: &InitialState,
        times_s: &[f64],
        mut choose: impl FnMut(usize, &PlantState) -> Command,
    ) -> Result<Vec<PlantState>, PlantError> {
        let Some(&start_s) = times_s.first() else { return Ok(Vec::new()) };
        check_times(times_s)?;
        let integration = |time_s| move |cause| PlantError::Integration { time_s, cause };
        let scales = self.physics.scales();
        let mut scaled = vec![0.0; self.physics.states()];
        let initial_si = [initial.pressure_a_pa, initial.pressure_b_pa, initial.velocity_m_per_s, initial.position_m];
        for ((state, value), scale) in scaled.iter_mut().zip(initial_si).zip(scales) {
            if !value.is_finite() {
                return Err(PlantError::NotFinite { what: "initial state", tick: 0, value });
            }
            *state = value / scale;
        }

        let mut drive = Boundary::new(self);
        let mut state = drive.observe(&scaled, start_s);
        let mut command = choose(0, &state);
        drive.command(0, start_s, command)?;

        let segment = Rc::new(Cell::new(drive.segment_from(start_s, start_s, &scaled).0));
        let problem = integrator::problem(&self.physics, &segment, start_s, scaled.clone(), self.tolerance)
            .map_err(integration(start_s))?;
        let mut stepper = Stepper::new(&problem).map_err(integration(start_s))?;

        let mut states = Vec::with_capacity(times_s.len());
        for (tick, &time_s) in times_s.iter().enumerate() {
            if tick > 0 {
                let mut now_s = times_s[tick - 1];
                while now_s < time_s {
                    let (next, end_s) = drive.segment_from(now_s, time_s, &scaled);
                    segment.set(next);
                    stepper.advance(end_s).map_err(integration(now_s))?;
                    now_s = end_s;
                    for (index, state) in scaled.iter_mut().enumerate() {
                        *state = stepper.state(index);
                    }
                }
                state = drive.observe(&scaled, time_s);
                command = choose(tick, &state);
                drive.command(tick, time_s, command)?;
            }
            // With a pump, or a valve without delay and lags, the command acts already at this tick.
            state = drive.observe(&scaled, time_s);
            states.push(state);
        }
        Ok(states)
    }
}

fn check_times(times_s: &[f64]) -> Result<(), PlantError> {
    for (tick, &found_s) in times_s.iter().enumerate() {
        if !found_s.is_finite() {
            return Err(PlantError::NotFinite { what: "time", tick, value: found_s });
        }
        let previous_s = tick.checked_sub(1).map_or(f64::NEG_INFINITY, |before| times_s[before]);
        if found_s <= previous_s {
            return Err(PlantError::TimesNotRising { tick, found_s, previous_s });
        }
    }
    Ok(())
}
