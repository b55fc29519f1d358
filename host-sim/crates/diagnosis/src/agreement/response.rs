//! How the machine file's model answers the recorded input, beside what was recorded: a first look that needs one simulation and no fit.

use identification::compare::CompareError;
use identification::experiment::Prepared;
use machine_file::{LoadSource, MachineFile};
use model_core::machine::{Machine, Parameter, Source, Tick};
use recording::{Recording, Signal};
use simulation::signal::correlation::{correlation, deviation, rows_early};
use simulation::signal::noise::extent;
use simulation::signal::slope::slopes;
use simulation::signal::window::rows_in;
use simulation::{InputPoint, StartOffset, first_input_point, is_carried, natural_tick, simulate_f64, tick_for};

use super::change::{Change, rows};
use super::scale::factors_of;

/// Longest part of a recording that is looked at and refitted, s: a few strokes, so that a refit takes a fraction of a second.
const PART_S: f64 = 5.0;
/// It has at least so many rows.
const LEAST_ROWS: usize = 100;
/// It begins this long before the input has moved by [`BEGINS`] of its range.
const BEFORE_S: f64 = 0.3;
const BEGINS: f64 = 0.05;
/// A position is compared by its slope over this time, s: a free run drifts away, its speed does not.
const SLOPE_S: f64 = 0.1;
/// A signal moves if it does so by more than this many times its noise, which then adds little to how far it moves.
const MOVES: f64 = 3.0;
/// A command is looked for so far before its stamp, s.
const EARLIEST_S: f64 = 0.08;
/// Pressures above this many times the supply pressure are in another unit: a load or a thin rod raises them by half.
const BEYOND_SUPPLY: f64 = 3.0;
/// They are scaled to the factor with which the largest one lies between these shares of the supply pressure.
const WITHIN_SUPPLY: std::ops::RangeInclusive<f64> = 0.15..=1.5;

/// What one judged signal does.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    pub(super) signal: Signal,
    /// Correlation of recorded and simulated.
    pub(super) correlation: f64,
    /// How far it moves, recorded over simulated; infinite where the simulated one hardly does.
    pub(super) ratio: f64,
    /// How much earlier it moves than the simulated one, s; 0 where it is later.
    pub(super) early_s: f64,
}

/// What all judged signals that move do.
#[derive(Clone, Debug)]
pub(super) struct Responses {
    /// What drives the model.
    pub(super) input_point: InputPoint,
    /// Time between two rows, s.
    pub(super) interval_s: f64,
    pub(super) each: Vec<Response>,
    /// How far both pressures are from each other's simulation over how far they are from their own; infinite where they are not both recorded.
    pub(super) crossed: f64,
    /// Changes of which the recording needs one to be simulated at all: pressures far above the supply start the model in a state that no drive has.
    pub(super) needed: Vec<Change>,
    /// The largest recorded load over the largest force of the drive.
    pub(super) load: f64,
    /// Whether the direction of a pump's flow is recorded beside its speed.
    pub(super) has_direction: bool,
}

impl Responses {
    /// Of a recording; `None` where the model cannot be simulated with it: why, is told when it is prepared.
    pub(super) fn of(file: &MachineFile, recording: &Recording) -> Option<Self> {
        let machine = &file.machine;
        let mut recording = part(file, recording);
        let needed = needed(&recording, machine);
        if let Some(change) = needed.first() {
            recording = change.of(&recording, machine);
        }
        let recording = &recording;
        let case = prepared(recording, machine, file.load_source).ok()?;
        let run = simulate_f64(machine, &case.stimulus, StartOffset::none()).ok()?;
        let reach = (rows_in(&case.time_s, SLOPE_S) / 2).max(1);
        let moving = |signal: Signal, values: &[f64]| match signal {
            Signal::Position => slopes(&case.time_s, values, reach),
            _ => values.to_vec(),
        };
        let mut each = Vec::new();
        let mut pressures = Vec::new();
        for channel in case.channels.iter().filter(|channel| channel.signal != Signal::SupplyPressure) {
            let Some(simulated) = run.signal(channel.signal) else { continue };
            let noise = match channel.signal {
                Signal::Position => channel.noise / (reach as f64 * recording.sample_interval_s()),
                _ => channel.noise,
            };
            let (here, there) = (moving(channel.signal, &channel.bridged()), moving(channel.signal, simulated));
            let (recorded, answered) = (deviation(&here), deviation(&there));
            if !(recorded > MOVES * noise && recorded.is_finite()) {
                continue;
            }
            if matches!(channel.signal, Signal::PressureA | Signal::PressureB) {
                pressures.push((here.clone(), there.clone()));
            }
            // Less than a thousandth is no movement: the smallest gain that is told apart is a thousandth.
            let moves = answered > 1e-3 * recorded;
            each.push(Response {
                signal: channel.signal,
                correlation: if moves { correlation(&here, &there) } else { 0.0 },
                ratio: if moves { recorded / answered } else { f64::INFINITY },
                early_s: rows_early(&here, &there, rows_in(&case.time_s, EARLIEST_S)) as f64
                    * recording.sample_interval_s(),
            });
        }
        let crossed = match pressures.as_slice() {
            [(a, simulated_a), (b, simulated_b)] => {
                let crossed = distance(a, simulated_b) + distance(b, simulated_a);
                crossed / (distance(a, simulated_a) + distance(b, simulated_b))
            }
            _ => f64::INFINITY,
        };
        let largest_n = machine.full_force_n();
        let (low, high) = recording.signal(Signal::LoadForce).map_or((0.0, 0.0), extent);
        Some(Self {
            input_point: case.stimulus.input_point,
            interval_s: recording.sample_interval_s(),
            each,
            crossed,
            needed,
            load: low.abs().max(high.abs()) / largest_n,
            has_direction: recording.has(Signal::ValveDirection),
        })
    }

    /// Of this signal, where it moves.
    pub(super) fn to(&self, signal: Signal) -> Option<Response> {
        self.each.iter().copied().find(|response| response.signal == signal)
    }

    /// The signal whose sign says which way the model is driven.
    pub(super) fn driver(&self) -> Signal {
        if self.input_point == InputPoint::Pump && self.has_direction {
            Signal::ValveDirection
        } else {
            self.input_point.driving()
        }
    }
}

/// A recording prepared as cheaply as possible: at a coarse tick, and without the noise that its input causes.
pub(super) fn prepared(
    recording: &Recording,
    machine: &Machine<f64>,
    load: LoadSource,
) -> Result<Prepared, CompareError> {
    let coarse = match natural_tick(recording) {
        Tick::HalfMillisecond => Tick::OneMillisecond,
        _ => Tick::TwoMilliseconds,
    };
    let tick = if is_carried(machine, coarse) { coarse } else { tick_for(recording, machine) };
    Prepared::entered_at(first_input_point(machine.source, recording)?, recording, machine, load, Some(tick))
}

/// The part of a recording in which its input begins to move.
pub(super) fn part(file: &MachineFile, recording: &Recording) -> Recording {
    let time_s = recording.time_s();
    let input = first_input_point(file.machine.source, recording).ok();
    let values = input.and_then(|input| recording.signal(input.driving())).unwrap_or(time_s);
    let (low, high) = extent(values);
    let begins = values.iter().position(|value| (value - values[0]).abs() > BEGINS * (high - low)).unwrap_or_default();
    let from = time_s.partition_point(|time| *time < time_s[begins] - BEFORE_S);
    let to = time_s.partition_point(|time| *time <= time_s[from] + PART_S).max((from + LEAST_ROWS).min(time_s.len()));
    rows(recording, from..to).unwrap_or_else(|| recording.clone())
}

/// The factors that bring pressures far above the supply pressure below it.
fn needed(recording: &Recording, machine: &Machine<f64>) -> Vec<Change> {
    let pressures = [Signal::PressureA, Signal::PressureB].into_iter().filter_map(|signal| recording.signal(signal));
    let (_, high) = extent(pressures.flatten());
    if machine.source == Source::Force {
        return Vec::new();
    }
    let share = high / machine.get(Parameter::SupplyPressure);
    let within = |factor: &f64| WITHIN_SUPPLY.contains(&(factor * share));
    if share <= BEYOND_SUPPLY {
        return Vec::new();
    }
    let factors = factors_of(Signal::PressureA).map(|factor| 1.0 / factor).filter(within);
    factors.map(|factor| Change::Scaled(Signal::PressureA, factor)).collect()
}

/// Mean square difference.
fn distance(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| (one - other).powi(2)).sum::<f64>() / one.len() as f64
}
