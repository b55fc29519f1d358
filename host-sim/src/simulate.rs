//! Recording → simulation: the core driven by what was recorded.
//!
//! A [`Stimulus`] is a recording laid on the core's tick grid: where the chain is entered, with what, from which state.
//! [`run`] steps the core over it in any number type and hands out the signals at the recorded rows.

use model_core::chambers::ChamberState;
use model_core::drive::{Drive, DriveState, Entry, Load};
use model_core::flow::{Flows, PumpDrive};
use model_core::machine::{Bases, Machine, MachineError, Source, Tick};
use model_core::number::{Number, Real};
use model_core::parameter::Parameter;
use model_core::valve::Slider;

use crate::machine_file::LoadSource;
use crate::recording::{Recording, Signal};

/// Ticks of delay line on the desktop: more than a quarter of a second at any tick.
pub const DELAY_LINE: usize = 512;

/// Where the chain is entered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum EntryPoint {
    /// Command at the valve.
    Command,
    /// Measured slider.
    Slider,
    /// Speed of the pump and direction of its valve.
    Pump,
    /// Measured flow into A; what leaves B is taken to be the same times the area ratio.
    Flow,
    /// Measured force of the oil, or the one that follows from both recorded pressures.
    Force,
}

/// Why a recording cannot drive a simulation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulateError {
    /// No signal to enter the chain with.
    #[error("{recording}: nothing drives the model; expected a column {expected}")]
    NoInput {
        /// The recording.
        recording: String,
        /// Columns that would do.
        expected: &'static str,
    },
    /// A signal that the entry or the load needs is missing.
    #[error("{recording}: no column `{signal}`; expected it because {reason}")]
    Missing {
        /// The recording.
        recording: String,
        /// The signal.
        signal: Signal,
        /// What needs it.
        reason: &'static str,
    },
    /// The recording is longer than the grid can hold.
    #[error("{recording}: {duration_s} s at a tick of {tick_s} s; expected at most {limit} ticks")]
    TooLong {
        /// The recording.
        recording: String,
        /// Its duration.
        duration_s: f64,
        /// The tick.
        tick_s: f64,
        /// Most ticks.
        limit: usize,
    },
    /// The machine does not become a drive.
    #[error(transparent)]
    Machine(#[from] MachineError),
}

/// Most ticks of one simulation: 14 hours at 1 kHz.
const MAX_TICKS: usize = 50_000_000;

/// What drives the chain, one value a grid point (`ticks + 1` of them) or a tick (`ticks`), in SI units.
#[derive(Clone, Debug, PartialEq)]
enum Input {
    /// Held over each tick, V.
    Command(Vec<f64>),
    /// At grid points, 1.
    Slider(Vec<f64>),
    /// Mean speed (rev/s) and direction over each tick.
    Pump(Vec<f64>, Vec<i8>),
    /// At grid points, m³/s.
    Flow(Vec<f64>),
    /// At grid points, N.
    Force(Vec<f64>),
}

/// State that a simulation starts from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Command held before, V.
    pub command_v: f64,
    /// Chamber pressures, Pa; `None` where the recording does not have them: half the supply and the balance of forces.
    pub pressures_pa: Option<(f64, f64)>,
    /// Position, m.
    pub position_m: f64,
}

/// A recording laid on the core's grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Stimulus {
    /// Where the chain is entered.
    pub entry: EntryPoint,
    /// The core's tick.
    pub tick: Tick,
    /// State at the first row.
    pub start: Start,
    ticks: usize,
    input: Input,
    /// External force at grid points, N.
    load_n: Option<Vec<f64>>,
    /// For each recorded row: the grid point at or before it, and how far on to the next, 0..1.
    rows: Vec<(usize, f64)>,
}

/// Signals of the chain at one recorded row, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<R> {
    /// Slider position, 1.
    pub spool: R,
    /// Flow into A, m³/s.
    pub flow_a_m3_per_s: R,
    /// Pressure in A, Pa.
    pub pressure_a_pa: R,
    /// Pressure in B, Pa.
    pub pressure_b_pa: R,
    /// Force of the oil on the rod, N.
    pub force_n: R,
    /// Velocity, m/s.
    pub velocity_m_per_s: R,
    /// Position, m.
    pub position_m: R,
}

impl<R: Real> Sample<R> {
    /// The value of a recorded signal, if the chain computes it.
    #[must_use]
    pub fn signal(&self, signal: Signal) -> Option<R> {
        match signal {
            Signal::Spool => Some(self.spool),
            Signal::Flow => Some(self.flow_a_m3_per_s),
            Signal::PressureA => Some(self.pressure_a_pa),
            Signal::PressureB => Some(self.pressure_b_pa),
            Signal::Force => Some(self.force_n),
            Signal::Velocity => Some(self.velocity_m_per_s),
            Signal::Position => Some(self.position_m),
            _ => None,
        }
    }

    fn between(a: Self, b: Self, share: f64) -> Self {
        let mix = |a: R, b: R| a + (b - a) * R::constant(share);
        Self {
            spool: mix(a.spool, b.spool),
            flow_a_m3_per_s: mix(a.flow_a_m3_per_s, b.flow_a_m3_per_s),
            pressure_a_pa: mix(a.pressure_a_pa, b.pressure_a_pa),
            pressure_b_pa: mix(a.pressure_b_pa, b.pressure_b_pa),
            force_n: mix(a.force_n, b.force_n),
            velocity_m_per_s: mix(a.velocity_m_per_s, b.velocity_m_per_s),
            position_m: mix(a.position_m, b.position_m),
        }
    }
}

/// Signals that the chain computes below an entry, in its order.
#[must_use]
pub fn computed_below(entry: EntryPoint) -> &'static [Signal] {
    const ALL: &[Signal] = &[
        Signal::Spool,
        Signal::Flow,
        Signal::PressureA,
        Signal::PressureB,
        Signal::Force,
        Signal::Velocity,
        Signal::Position,
    ];
    match entry {
        EntryPoint::Command => ALL,
        EntryPoint::Slider | EntryPoint::Pump => &ALL[1..],
        EntryPoint::Flow => &ALL[2..],
        EntryPoint::Force => &ALL[5..],
    }
}

/// The signals of a simulation at the recorded rows, in SI units.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Trajectory {
    /// One series for each signal computed below the entry.
    pub series: Vec<(Signal, Vec<f64>)>,
}

impl Trajectory {
    /// A computed signal.
    #[must_use]
    pub fn signal(&self, signal: Signal) -> Option<&[f64]> {
        self.series.iter().find(|(found, _)| *found == signal).map(|(_, values)| values.as_slice())
    }
}

/// The entry furthest upstream that a recording allows for a machine's oil source.
pub fn first_entry(source: Source, recording: &Recording) -> Result<EntryPoint, SimulateError> {
    let has = |signal| recording.has(signal);
    let candidates: &[(EntryPoint, bool)] = match source {
        Source::Valve => &[
            (EntryPoint::Command, has(Signal::Command)),
            (EntryPoint::Slider, has(Signal::Spool)),
            (EntryPoint::Flow, has(Signal::Flow)),
            (EntryPoint::Force, has(Signal::Force)),
        ],
        Source::Pump => &[
            (EntryPoint::Pump, has(Signal::PumpSpeed)),
            (EntryPoint::Flow, has(Signal::Flow)),
            (EntryPoint::Force, has(Signal::Force)),
        ],
    };
    let expected = match source {
        Source::Valve => "command, spool, flow or force",
        Source::Pump => "pump_speed, flow or force",
    };
    let found = candidates.iter().find(|(_, there)| *there).map(|(entry, _)| *entry);
    found.ok_or_else(|| SimulateError::NoInput { recording: recording.name().to_owned(), expected })
}

/// The tick that suits a recording: 1 ms, or 0.5 ms where it is sampled faster than 1 kHz.
#[must_use]
pub fn natural_tick(recording: &Recording) -> Tick {
    if recording.sample_interval_s() < 0.75e-3 { Tick::HalfMillisecond } else { Tick::OneMillisecond }
}

impl Stimulus {
    /// Lays a recording on the grid of `tick`.
    pub fn new(
        recording: &Recording,
        machine: &Machine<f64>,
        entry: EntryPoint,
        load: LoadSource,
        tick: Tick,
    ) -> Result<Self, SimulateError> {
        let grid = Grid::new(recording, tick)?;
        let need = |signal, reason| {
            recording.signal(signal).ok_or_else(|| SimulateError::Missing {
                recording: recording.name().to_owned(),
                signal,
                reason,
            })
        };
        let input = match entry {
            EntryPoint::Command => {
                Input::Command(grid.held(need(Signal::Command, "the chain is entered at the command")?))
            }
            EntryPoint::Slider => {
                Input::Slider(grid.points(need(Signal::Spool, "the chain is entered at the slider")?))
            }
            EntryPoint::Flow => Input::Flow(grid.points(need(Signal::Flow, "the chain is entered at the flow")?)),
            EntryPoint::Pump => {
                let speed = grid.points(need(Signal::PumpSpeed, "the pump drives the chain")?);
                let mean: Vec<f64> = speed.windows(2).map(|pair| f64::midpoint(pair[0], pair[1])).collect();
                let direction = match recording.signal(Signal::ValveDirection) {
                    Some(direction) => grid.held(direction).iter().map(|&value| sign(value)).collect(),
                    None => mean.iter().map(|&value| sign(value)).collect(),
                };
                Input::Pump(mean, direction)
            }
            EntryPoint::Force => Input::Force(match recording.signal(Signal::Force) {
                Some(force) => grid.points(force),
                None => grid.points(&pressure_force(recording, machine)?),
            }),
        };
        let load_n = match (load, entry) {
            (
                LoadSource::RecordedPressures,
                EntryPoint::Command | EntryPoint::Slider | EntryPoint::Pump | EntryPoint::Flow,
            ) => {
                let balance: Vec<f64> = pressure_force(recording, machine)?.iter().map(|force| -force).collect();
                let constant = machine.get(Parameter::LoadForce);
                Some(
                    grid.points(&smoothed(&balance, 0.05 / recording.sample_interval_s()))
                        .iter()
                        .map(|force| force - constant)
                        .collect(),
                )
            }
            _ => recording.signal(Signal::LoadForce).map(|force| grid.points(force)),
        };
        Ok(Self { entry, tick, start: start(recording), ticks: grid.ticks, input, load_n, rows: grid.rows })
    }

    /// How many rows the recording has.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    /// How many ticks a run takes.
    #[must_use]
    pub fn ticks(&self) -> usize {
        self.ticks
    }

    fn entry_at<N: Number>(&self, tick: usize, bases: &Bases) -> Entry<N> {
        let at = |values: &[f64], base: f64| N::saturated(values.get(tick).copied().unwrap_or(0.0) / base);
        let next = |values: &[f64], base: f64| N::saturated(values.get(tick + 1).copied().unwrap_or(0.0) / base);
        match &self.input {
            Input::Command(volts) => Entry::Command(at(volts, bases.command_v)),
            Input::Slider(spool) => Entry::Slider(Slider { from: at(spool, 1.0), to: next(spool, 1.0) }),
            Input::Pump(speed, direction) => Entry::Pump(PumpDrive {
                speed: at(speed, bases.pump_speed_rev_per_s),
                direction: direction.get(tick).copied().unwrap_or(0),
            }),
            Input::Flow(flow) => {
                let base = bases.flow_m3_per_s;
                let both = |flow: N| Flows { a: flow, b: flow };
                Entry::Flow { from: both(at(flow, base)), to: both(next(flow, base)) }
            }
            Input::Force(force) => Entry::Force { from: at(force, bases.force_n), to: next(force, bases.force_n) },
        }
    }

    fn load_at<N: Number>(&self, tick: usize, bases: &Bases) -> Load<N> {
        self.load_n.as_ref().map_or(Load::NONE, |force| {
            let at = |index: usize| N::saturated(force.get(index).copied().unwrap_or(0.0) / bases.force_n);
            Load { from: at(tick), to: at(tick + 1) }
        })
    }

    fn pump_at<N: Number>(&self, tick: usize, bases: &Bases) -> PumpDrive<N> {
        match self.entry_at(tick, bases) {
            Entry::Pump(pump) => pump,
            _ => PumpDrive { speed: N::ZERO, direction: 0 },
        }
    }

    fn slider_at<N: Number>(&self, point: usize) -> Option<N> {
        match &self.input {
            Input::Slider(spool) => spool.get(point).map(|&value| N::saturated(value)),
            _ => None,
        }
    }
}

/// Pressures at the start where the recording has none: the level in B, and the balance of forces.
fn balanced<R: Real>(machine: &Machine<R>, level: R) -> (R, R) {
    let get = |parameter| machine.get(parameter);
    let a = (level * get(Parameter::AreaB) - get(Parameter::LoadForce)) / get(Parameter::AreaA);
    let supply = get(Parameter::SupplyPressure);
    let (low, high) = (supply * R::constant(0.02), supply * R::constant(0.98));
    let a = if a < low {
        low
    } else if a > high {
        high
    } else {
        a
    };
    let b = (a * get(Parameter::AreaA) + get(Parameter::LoadForce)) / get(Parameter::AreaB);
    (
        a,
        if b < low {
            low
        } else if b > high {
            high
        } else {
            b
        },
    )
}

/// Freedom of a run beyond the recording: what a fit may move about the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartOffset<R> {
    /// Share of supply pressure in chamber B at rest, where pressures are not recorded.
    pub level: R,
}

impl<R: Real> StartOffset<R> {
    /// Half the supply.
    #[must_use]
    pub fn none() -> Self {
        Self { level: R::constant(0.5) }
    }
}

/// Runs the core over a stimulus and hands each recorded row's sample to `sink`, in order.
pub fn run<N: Number>(
    machine: &Machine<N::Real>,
    stimulus: &Stimulus,
    offset: StartOffset<N::Real>,
    mut sink: impl FnMut(usize, &Sample<N::Real>),
) -> Result<(), MachineError> {
    let drive = Drive::<N>::new::<DELAY_LINE>(machine, stimulus.tick)?;
    let bases = *drive.bases();
    let constant = N::Real::constant;
    let (pressure_a, pressure_b) = match stimulus.start.pressures_pa {
        Some((a, b)) => (constant(a), constant(b)),
        None => balanced(machine, offset.level * machine.get(Parameter::SupplyPressure)),
    };
    let fit = |value: N::Real| N::signal(value).unwrap_or_else(|| N::saturated(value.value()));
    let pressures = ChamberState {
        a: fit(pressure_a / constant(bases.pressure_pa)),
        b: fit(pressure_b / constant(bases.pressure_pa)),
    };
    let position = N::travel(constant(stimulus.start.position_m) / machine.get(Parameter::Stroke));
    let command = N::saturated(stimulus.start.command_v / bases.command_v);
    let mut state: DriveState<N, DELAY_LINE> = drive.at_rest(command, pressures, position);

    let mut rows = stimulus.rows.iter().enumerate().peekable();
    let mut before = sample(&drive, machine, stimulus, &state, 0);
    for point in 0..=stimulus.ticks {
        if point > 0 {
            let tick = point - 1;
            drive.step(&mut state, stimulus.entry_at(tick, &bases), stimulus.load_at(tick, &bases));
        }
        // A row lies on this point, or in the tick before it.
        let wanted = |at: usize, share: f64| if share == 0.0 { at == point } else { at + 1 == point };
        if rows.peek().is_none_or(|(_, (at, _))| *at > point) {
            continue;
        }
        let now = sample(&drive, machine, stimulus, &state, point);
        while let Some((row, &(_, share))) = rows.next_if(|(_, (at, share))| wanted(*at, *share)) {
            if share == 0.0 {
                sink(row, &now);
            } else {
                sink(row, &Sample::between(before, now, share));
            }
        }
        before = now;
    }
    Ok(())
}

fn sample<N: Number>(
    drive: &Drive<N>,
    machine: &Machine<N::Real>,
    stimulus: &Stimulus,
    state: &DriveState<N, DELAY_LINE>,
    point: usize,
) -> Sample<N::Real> {
    let bases = drive.bases();
    let constant = N::Real::constant;
    let spool = stimulus.slider_at(point).unwrap_or_else(|| state.valve.slider());
    let flows = drive.flows(spool, stimulus.pump_at(point, bases), state.chambers);
    let pressure_a_pa = state.chambers.a.to_real() * constant(bases.pressure_pa);
    let pressure_b_pa = state.chambers.b.to_real() * constant(bases.pressure_pa);
    Sample {
        spool: spool.to_real(),
        flow_a_m3_per_s: flows.a.to_real() * constant(bases.flow_m3_per_s),
        pressure_a_pa,
        pressure_b_pa,
        force_n: machine.get(Parameter::AreaA) * pressure_a_pa - machine.get(Parameter::AreaB) * pressure_b_pa,
        velocity_m_per_s: state.motion.velocity.to_real() * constant(bases.velocity_m_per_s),
        position_m: N::strokes(state.motion.position) * machine.get(Parameter::Stroke),
    }
}

/// A whole simulation in a plain number type.
pub fn simulate<N: Number<Real = f64>>(
    machine: &Machine<f64>,
    stimulus: &Stimulus,
    offset: StartOffset<f64>,
) -> Result<Trajectory, MachineError> {
    let signals = computed_below(stimulus.entry);
    let mut series: Vec<(Signal, Vec<f64>)> =
        signals.iter().map(|&signal| (signal, Vec::with_capacity(stimulus.rows()))).collect();
    run::<N>(machine, stimulus, offset, |_, sample| {
        for (signal, values) in &mut series {
            values.extend(sample.signal(*signal));
        }
    })?;
    Ok(Trajectory { series })
}

/// The core's grid over a recording.
struct Grid<'a> {
    time_s: &'a [f64],
    tick_s: f64,
    ticks: usize,
    rows: Vec<(usize, f64)>,
}

impl<'a> Grid<'a> {
    fn new(recording: &'a Recording, tick: Tick) -> Result<Self, SimulateError> {
        let time_s = recording.time_s();
        let (first, tick_s) = (time_s[0], tick.seconds());
        let duration_s = time_s[time_s.len() - 1] - first;
        if duration_s / tick_s > MAX_TICKS as f64 {
            let recording = recording.name().to_owned();
            return Err(SimulateError::TooLong { recording, duration_s, tick_s, limit: MAX_TICKS });
        }
        let rows: Vec<(usize, f64)> = time_s
            .iter()
            .map(|time| {
                let at = (time - first) / tick_s;
                // Times are written with a few digits: within a thousandth of a tick they are on the grid.
                let nearest = at.round();
                let (point, share) =
                    if (at - nearest).abs() < 1e-3 { (nearest, 0.0) } else { (at.floor(), at - at.floor()) };
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "0..MAX_TICKS by the check above"
                )]
                (point as usize, share)
            })
            .collect();
        let ticks = rows.last().map_or(0, |(point, share)| point + usize::from(*share > 0.0));
        Ok(Self { time_s, tick_s, ticks, rows })
    }

    /// For each tick the last recorded value at or before its start.
    fn held(&self, values: &[f64]) -> Vec<f64> {
        let mut row = 0;
        (0..self.ticks)
            .map(|tick| {
                while self
                    .rows
                    .get(row + 1)
                    .is_some_and(|(point, share)| *point < tick || (*point == tick && *share == 0.0))
                {
                    row += 1;
                }
                values[row]
            })
            .collect()
    }

    /// At each grid point the recorded values, linear in between.
    fn points(&self, values: &[f64]) -> Vec<f64> {
        let mut row = 0;
        (0..=self.ticks)
            .map(|point| {
                let time = self.time_s[0] + point as f64 * self.tick_s;
                while row + 2 < self.time_s.len() && self.time_s[row + 1] <= time {
                    row += 1;
                }
                let share = ((time - self.time_s[row]) / (self.time_s[row + 1] - self.time_s[row])).clamp(0.0, 1.0);
                // Exactly the recorded value where a row lies on the grid.
                let share = if (share - share.round()).abs() < 1e-6 { share.round() } else { share };
                if share >= 1.0 { values[row + 1] } else { values[row] + share * (values[row + 1] - values[row]) }
            })
            .collect()
    }
}

fn sign(value: f64) -> i8 {
    if value > 0.5e-9 {
        1
    } else if value < -0.5e-9 {
        -1
    } else {
        0
    }
}

/// Aa·pa − Ab·pb of the recorded pressures, N.
fn pressure_force(recording: &Recording, machine: &Machine<f64>) -> Result<Vec<f64>, SimulateError> {
    let need = |signal| {
        recording.signal(signal).ok_or_else(|| SimulateError::Missing {
            recording: recording.name().to_owned(),
            signal,
            reason: "the force on the rod is taken from both chamber pressures",
        })
    };
    let (area_a, area_b) = (machine.get(Parameter::AreaA), machine.get(Parameter::AreaB));
    let (a, b) = (need(Signal::PressureA)?, need(Signal::PressureB)?);
    Ok(a.iter().zip(b).map(|(a, b)| area_a * a - area_b * b).collect())
}

/// Centred moving average over `width` samples (at least one); shorter at both ends.
fn smoothed(values: &[f64], width: f64) -> Vec<f64> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive count")]
    let half = (0.5 * width).clamp(0.0, 1e6) as usize;
    let mut sums = Vec::with_capacity(values.len() + 1);
    sums.push(0.0);
    for value in values {
        sums.push(sums[sums.len() - 1] + value);
    }
    (0..values.len())
        .map(|index| {
            let reach = half.min(index).min(values.len() - 1 - index);
            (sums[index + reach + 1] - sums[index - reach]) / (2 * reach + 1) as f64
        })
        .collect()
}

/// Length of the stretch at the start over which pressures are averaged, s.
const REST_S: f64 = 0.02;

/// The state a recording starts from.
fn start(recording: &Recording) -> Start {
    let first = |signal| recording.signal(signal).map(|values: &[f64]| values[0]);
    let time_s = recording.time_s();
    let rest = time_s.iter().take_while(|time| **time - time_s[0] < REST_S).count().max(1);
    let mean = |signal| recording.signal(signal).map(|values: &[f64]| values[..rest].iter().sum::<f64>() / rest as f64);
    Start {
        command_v: first(Signal::Command).unwrap_or(0.0),
        pressures_pa: mean(Signal::PressureA).zip(mean(Signal::PressureB)),
        position_m: first(Signal::Position).unwrap_or(0.0),
    }
}
