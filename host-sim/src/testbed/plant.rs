//! The plant over time: from commands and an initial state to the true signals at every tick.

use std::cell::Cell;
use std::rc::Rc;

use diffsol::DiffsolError;
use model_core::machine::{Machine, Source};
use model_core::parameter::Parameter;
use thiserror::Error;

use super::effect::PlantEffect;
use super::input::{Commands, LoadLine, LoadProfile, PumpCommand};
use super::physics::{BASE_STATES, Inputs, Physics};
use super::slider::{Slider, SliderParameters, SliderPiece};
use super::stiff::{self, Stepper};

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
    /// At rest with the forces balanced and pa + pb = p0: what a closed, even valve settles to.
    #[must_use]
    pub fn at_rest(machine: &Machine<f64>, position_m: f64) -> Self {
        Self::at_rest_with_level(machine, position_m, 0.5 * machine.get(Parameter::SupplyPressure))
    }

    /// At rest with the forces balanced and `level_pa` the mean of both pressures.
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
    /// Slider position x, 1; positive extends.
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
}

/// Why a plant could not be simulated.
#[derive(Debug, Error)]
pub enum PlantError {
    /// Commands and times do not pair up.
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
    /// Commands of a valve for a pump drive, or the other way round.
    #[error("commands of another kind for a drive whose source is {source_of_drive:?}")]
    CommandKind {
        /// The source the machine has.
        source_of_drive: Source,
    },
    /// A parameter that the plant needs is not a number.
    #[error("{} is {value}, expected a number within its range", parameter.description().key)]
    Parameter {
        /// Which one.
        parameter: Parameter,
        /// Its value.
        value: f64,
    },
    /// The tolerance is not one the arithmetic can keep.
    #[error("relative tolerance {found}, expected {} to {}", TOLERANCES.0, TOLERANCES.1)]
    Tolerance {
        /// What was asked for.
        found: f64,
    },
    /// The integrator gave up.
    #[error("integration failed after {time_s} s: {cause}")]
    Integration {
        /// Start of the interval on which it failed, s.
        time_s: f64,
        /// What the integrator says.
        cause: DiffsolError,
    },
}

/// Smallest and largest relative tolerance.
const TOLERANCES: (f64, f64) = (1e-13, 1e-2);

/// A stretch of time on which everything that acts from outside is smooth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    slider: SliderPiece,
    pump: Option<PumpCommand>,
    load: LoadLine,
    /// Which side of the dead zone the slider is on: decided once, so that no rounding at the edge
    /// of the stretch puts a kink inside it.
    side: i8,
    dead_zone: f64,
}

impl Segment {
    pub(super) fn inputs(&self, physics: &Physics, time_s: f64) -> Inputs {
        let spool = self.slider.position(time_s);
        let spool = match self.side {
            1.. => spool.max(self.dead_zone),
            0 => spool.clamp(-self.dead_zone, self.dead_zone),
            ..=-1 => spool.min(-self.dead_zone),
        };
        physics.inputs(spool, self.pump, self.load.at(time_s))
    }
}

/// A command for one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Valve drives: V.
    Valve(f64),
    /// Pump drives.
    Pump(PumpCommand),
}

/// The plant: a machine's physics with effects and a load, to be simulated to a tolerance.
#[derive(Clone, Debug)]
pub struct Plant {
    machine: Machine<f64>,
    physics: Rc<Physics>,
    load: LoadProfile,
    tolerance: f64,
}

impl Plant {
    /// The paper's model of `machine`, solved to `tolerance` (relative, and absolute in parts of the
    /// supply pressure, of the stroke and of 1 m/s): 1e-10 for an oracle, 1e-7 for recordings.
    pub fn new(machine: &Machine<f64>, tolerance: f64) -> Result<Self, PlantError> {
        if !(TOLERANCES.0..=TOLERANCES.1).contains(&tolerance) {
            return Err(PlantError::Tolerance { found: tolerance });
        }
        for &parameter in Parameter::ALL {
            let value = machine.get(parameter);
            let optional = matches!(parameter, Parameter::VolumeA | Parameter::VolumeB);
            let description = parameter.description();
            if !(description.min..=description.max).contains(&value) && !(optional && value.is_nan()) {
                return Err(PlantError::Parameter { parameter, value });
            }
        }
        let physics = Rc::new(Physics::new(machine, &[]));
        Ok(Self { machine: *machine, physics, load: LoadProfile::none(), tolerance })
    }

    /// The same plant with effects that the paper's model leaves out.
    #[must_use]
    pub fn with_effects(mut self, effects: &[PlantEffect]) -> Self {
        self.physics = Rc::new(Physics::new(&self.machine, effects));
        self
    }

    /// The same plant with a force on the rod beside the machine's constant load.
    #[must_use]
    pub fn with_load(mut self, load: LoadProfile) -> Self {
        self.load = load;
        self
    }

    /// The machine it was made of.
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
    /// a controller in the loop. Before the first tick the first command has always been there.
    pub fn run(
        &self,
        initial: &InitialState,
        times_s: &[f64],
        mut choose: impl FnMut(usize, &PlantState) -> Command,
    ) -> Result<Vec<PlantState>, PlantError> {
        let Some(&start_s) = times_s.first() else { return Ok(Vec::new()) };
        let integration = |time_s| move |cause| PlantError::Integration { time_s, cause };
        let scales = self.physics.scales();
        let mut scaled = vec![0.0; self.physics.states()];
        let initial_si =
            [initial.pressure_a_pa, initial.pressure_b_pa, initial.velocity_m_per_s, initial.position_m];
        for ((state, si), scale) in scaled.iter_mut().zip(initial_si).zip(scales) {
            *state = si / scale;
        }

        let mut drive = Outside::new(self, start_s);
        let mut state = drive.observe(&scaled, start_s);
        let mut command = choose(0, &state);
        drive.command(start_s, command)?;

        let segment = Rc::new(Cell::new(drive.segment_from(start_s, start_s).0));
        let problem = stiff::problem(&self.physics, &segment, start_s, scaled.clone(), self.tolerance)
            .map_err(integration(start_s))?;
        let mut stepper = Stepper::new(&problem).map_err(integration(start_s))?;

        let mut states = Vec::with_capacity(times_s.len());
        for (tick, &time_s) in times_s.iter().enumerate() {
            if tick > 0 {
                let previous_s = times_s[tick - 1];
                if time_s.is_nan() || time_s <= previous_s {
                    return Err(PlantError::TimesNotRising { tick, found_s: time_s, previous_s });
                }
                let mut now_s = previous_s;
                while now_s < time_s {
                    let (next, end_s) = drive.segment_from(now_s, time_s);
                    segment.set(next);
                    stepper.advance(end_s).map_err(integration(now_s))?;
                    now_s = end_s;
                }
                for (index, state) in scaled.iter_mut().enumerate() {
                    *state = stepper.state(index);
                }
                state = drive.observe(&scaled, time_s);
                command = choose(tick, &state);
                drive.command(time_s, command)?;
            }
            // With a pump, or a valve without delay and lags, the command acts in this very tick.
            state = drive.observe(&scaled, time_s);
            states.push(state);
        }
        Ok(states)
    }
}

/// Everything that acts on the hydraulics from outside, in the order of time.
struct Outside<'a> {
    plant: &'a Plant,
    slider: Option<Slider>,
    pump: Option<PumpCommand>,
}

impl<'a> Outside<'a> {
    fn new(plant: &'a Plant, _start_s: f64) -> Self {
        Self { plant, slider: None, pump: None }
    }

    fn command(&mut self, time_s: f64, command: Command) -> Result<(), PlantError> {
        match (self.plant.physics.source(), command) {
            (Source::Valve, Command::Valve(volts)) => match &mut self.slider {
                Some(slider) => slider.command(time_s, volts),
                None => {
                    let parameters = SliderParameters::of(&self.plant.machine);
                    self.slider = Some(Slider::at_rest(parameters, time_s, volts));
                }
            },
            (Source::Pump, Command::Pump(pump)) => self.pump = Some(pump),
            (source_of_drive, _) => return Err(PlantError::CommandKind { source_of_drive }),
        }
        Ok(())
    }

    /// What is in force from `from_s` on, and until when it is smooth, at most until `to_s`.
    fn segment_from(&mut self, from_s: f64, to_s: f64) -> (Segment, f64) {
        let (load, load_end_s) = self.plant.load.line_from(from_s);
        let dead_zone = self.plant.physics.dead_zone();
        let rest = (SliderPiece::resting_at(0.0), f64::INFINITY);
        let (slider, corner_s) = self.slider.as_mut().map_or(rest, |slider| slider.piece_from(from_s));
        let end_s = to_s.min(load_end_s).min(corner_s);
        let (side, end_s) = dead_zone_side(&slider, dead_zone, from_s, end_s);
        (Segment { slider, pump: self.pump, load, side, dead_zone }, end_s)
    }

    fn observe(&mut self, scaled: &[f64], time_s: f64) -> PlantState {
        let mut si = [0.0; BASE_STATES];
        for ((si, state), scale) in si.iter_mut().zip(scaled).zip(self.plant.physics.scales()) {
            *si = state * scale;
        }
        let [pressure_a_pa, pressure_b_pa, velocity_m_per_s, position_m] = si;
        let spool = self.slider.as_mut().map_or(0.0, |slider| slider.piece_from(time_s).0.position(time_s));
        let inputs = self.plant.physics.inputs(spool, self.pump, 0.0);
        let (flow_a_m3_per_s, flow_b_m3_per_s) = self.plant.physics.flows(&inputs, pressure_a_pa, pressure_b_pa);
        PlantState {
            spool,
            flow_a_m3_per_s,
            flow_b_m3_per_s,
            pressure_a_pa,
            pressure_b_pa,
            position_m,
            velocity_m_per_s,
        }
    }
}

/// The side of the dead zone (+1 beyond it, 0 inside, −1) right after `from_s`, and when the slider
/// leaves that side, at most `to_s`.
///
/// A slider that touches an edge and turns back between two ticks is not noticed here: the error
/// control of the integrator has to see that one.
fn dead_zone_side(slider: &SliderPiece, dead_zone: f64, from_s: f64, to_s: f64) -> (i8, f64) {
    let side = |time_s: f64| {
        let x = slider.position(time_s);
        if x > dead_zone {
            1_i8
        } else if x < -dead_zone {
            -1
        } else {
            0
        }
    };
    // A hair inside the stretch, since at its start the slider may stand exactly on an edge.
    let inside_s = from_s + (to_s - from_s) * 1e-6;
    let start = side(inside_s);
    if side(to_s) == start {
        return (start, to_s);
    }
    let (mut low_s, mut high_s) = (inside_s, to_s);
    for _ in 0..60 {
        let middle_s = 0.5 * (low_s + high_s);
        if side(middle_s) == start {
            low_s = middle_s;
        } else {
            high_s = middle_s;
        }
    }
    (start, high_s)
}
