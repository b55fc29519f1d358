//! Several recordings simulated at once in SIMD lanes. What a step looks up in the machine, it looks up once for all of them.

use std::array::from_fn;
use std::cmp::Reverse;

use machine_file::DELAY_LINE;
use model_core::drive::{Drive, DriveInput, DriveState, Load};
use model_core::flow::PumpDrive;
use model_core::machine::{Machine, MachineError, Parameter};
use model_core::number::{Field, Number};
use model_core::ports::{ChamberState, Spool};
use model_core::valve::ValveState;
use recording::Signal;

use crate::initial_state::{InitialState, StartOffset, ValveOnItsWay};
use crate::number::simd::{LANES, Lanes};
use crate::outflow::Edges;
use crate::run::{Rows, reading, run, through_valve, unbraked};
use crate::sensor_bias::{true_spool, within};
use crate::stimulus::{InputPoint, Stimulus, value_at};
use crate::whitening::Gaining;

/// The simulation of one recording.
#[derive(Clone, Debug)]
pub struct Run<'a> {
    /// The recording on the core's grid.
    pub stimulus: &'a Stimulus,
    /// The changes that a fit makes to its initial state.
    pub offset: StartOffset,
    /// Signals that are wanted at its rows.
    pub signals: Vec<Signal>,
}

/// Runs the core over several stimuli, and hands each recorded row's signals to `sink`: index of the run, row, and the values in SI units, 0
/// for what the model does not compute. The rows of one run come in order; each value equals that of `run` to the last bit.
///
/// Where a stimulus is whitened, it gets what the signals gain in place of the signals: the index of the gain in place of the row.
pub fn run_in_lanes(
    machine: &Machine<f64>,
    runs: &[Run<'_>],
    sink: &mut dyn FnMut(usize, usize, &[f64]),
) -> Result<(), MachineError> {
    let mut gaining: Vec<Option<Gaining<'_>>> =
        runs.iter().map(|run| Some(Gaining::of_signals(run.stimulus.whitening.as_ref()?, &run.signals))).collect();
    rows_in_lanes(machine, runs, &mut |run, row, values| match &mut gaining[run] {
        None => sink(run, row, values),
        Some(gaining) => {
            if let Some((gain, values)) = gaining.take(values.iter().copied()) {
                sink(run, gain, values);
            }
        }
    })
}

/// The same row by row, whitened or not.
fn rows_in_lanes(
    machine: &Machine<f64>,
    runs: &[Run<'_>],
    sink: &mut dyn FnMut(usize, usize, &[f64]),
) -> Result<(), MachineError> {
    // All lanes run until the longest of their recordings ends.
    let mut left: Vec<usize> = (0..runs.len()).collect();
    left.sort_by_key(|&index| Reverse(runs[index].stimulus.ticks));
    while !left.is_empty() {
        let first = left.remove(0);
        let mut together = vec![first];
        left.retain(|other| {
            let joins = together.len() < LANES && runs[first].stimulus.goes_with(runs[*other].stimulus);
            if joins {
                together.push(*other);
            }
            !joins
        });
        if together.len() > 1 {
            let chosen: Vec<&Run<'_>> = together.iter().map(|&index| &runs[index]).collect();
            in_lanes(machine, &chosen, &mut |lane, row, values| sink(together[lane], row, values))?;
        } else {
            alone(machine, &runs[first], &mut |row, values| sink(first, row, values))?;
        }
    }
    Ok(())
}

fn alone(machine: &Machine<f64>, one: &Run<'_>, sink: &mut dyn FnMut(usize, &[f64])) -> Result<(), MachineError> {
    let mut values = vec![0.0; one.signals.len()];
    run::<f64>(machine, one.stimulus, one.offset.lifted(), &mut |row, sample| {
        for (value, &signal) in values.iter_mut().zip(&one.signals) {
            *value = sample.signal(signal).unwrap_or_default();
        }
        sink(row, &values);
    })
}

/// Several recordings in the lanes of one drive.
struct InLanes<'a> {
    machine: Machine<f64>,
    /// The stimulus of each lane; a lane without a recording of its own repeats the first.
    stimuli: [&'a Stimulus; LANES],
    offsets: [StartOffset; LANES],
    drive: Drive<Lanes>,
    edges: Option<Edges<Lanes>>,
    state: DriveState<Lanes, DELAY_LINE>,
}

impl<'a> InLanes<'a> {
    /// Runs that can share lanes, at most `LANES`, each at its initial state.
    fn at_start(machine: &Machine<f64>, runs: &[&Run<'a>]) -> Result<Self, MachineError> {
        let of = |lane: usize| *runs.get(lane).unwrap_or(&runs[0]);
        let stimuli: [&Stimulus; LANES] = from_fn(|lane| of(lane).stimulus);
        let offsets = from_fn(|lane| of(lane).offset);
        let machine = unbraked(machine, stimuli[0]);
        let drive = Drive::<Lanes>::new::<DELAY_LINE>(&machine, stimuli[0].tick)?;
        let initial_states: [InitialState<f64>; LANES] =
            from_fn(|lane| InitialState::of(&machine, drive.bases(), &stimuli[lane].start, offsets[lane].lifted()));
        let packed = |value: fn(&InitialState<f64>) -> f64| Lanes::new(initial_states.each_ref().map(value));
        let pressures = ChamberState { a: packed(|of| within(of.pressures.a)), b: packed(|of| within(of.pressures.b)) };
        let mut state = drive.at_rest(packed(|of| f64::saturated(of.command)), pressures, packed(|of| of.strokes));
        state.motion.velocity = packed(|of| f64::saturated(of.velocity));
        state.motion.bristles = packed(|of| within(of.bristles));
        state.supply.pressure = state.supply.pressure - packed(|of| of.fallen);
        if machine.get(Parameter::BacklashPlay) != 0.0 {
            state.sensed.show(packed(|of| within(of.shown)));
        }
        if initial_states.iter().any(|of| of.velocity != 0.0) {
            state.sensed.trail(packed(|of| within(of.sensed_beyond)));
        }
        if initial_states.iter().any(|of| of.valve.is_some()) {
            let settled = state.valve.spool().values();
            let valve = |lane: usize, value: fn(&ValveOnItsWay<f64>) -> f64| {
                initial_states[lane].valve.as_ref().map_or(settled[lane], |valve| within(value(valve)))
            };
            let packed = |value| Lanes::new(from_fn(|lane| valve(lane, value)));
            state.valve = ValveState::on_its_way(packed(|of| of.spool), packed(|of| of.lag), packed(|of| of.set));
        }
        let edges = Edges::of(&machine, drive.bases());
        Ok(Self { machine, stimuli, offsets, drive, edges, state })
    }

    /// One tick.
    fn step(&mut self, tick: usize) {
        let (stimuli, bases) = (self.stimuli, *self.drive.bases());
        let read = |series: fn(&Stimulus) -> &[f64], index: usize, base: f64| {
            Lanes::new(stimuli.map(|stimulus| value_at(series(stimulus), index))) / Lanes::constant(base)
        };
        let drive_input = match stimuli[0].drive_input_by(tick, &bases, read) {
            DriveInput::Spool(spool) => DriveInput::Spool(self.truly(spool)),
            DriveInput::Followed { command, spool } => DriveInput::Followed { command, spool: self.truly(spool) },
            DriveInput::Flow { from, to } => through_valve(self.edges.as_ref(), &self.state, (from, to), |flow| flow),
            other => other,
        };
        let kept = self.state.oil_temperature.values();
        let oil = |lane: usize| stimuli[lane].oil_at(tick, &bases).unwrap_or(kept[lane]);
        self.state.oil_temperature = Lanes::new(from_fn(oil));
        if stimuli.iter().any(|stimulus| stimulus.knows_others()) {
            let others = |stimulus: &Stimulus| f64::saturated(stimulus.others_at(tick, &bases).unwrap_or_default());
            self.state.supply.other_flow = Lanes::new(stimuli.map(others));
        }
        let load = |index: usize| read(Stimulus::load, index, bases.force_n);
        self.drive.step(&mut self.state, drive_input, Load { from: load(tick), to: load(tick + 1) });
    }

    /// What the runs take from their recordings at a point of the grid.
    fn take_up(&mut self, point: usize) {
        let taken_up = self.stimuli.map(|stimulus| stimulus.taken_up_at(point));
        if taken_up.iter().all(Option::is_none) {
            return;
        }
        let readings_m = self.signal(Signal::Position, point);
        let further = |lane: usize| {
            let offset = self.offsets[lane].lifted();
            taken_up[lane].map_or(0.0, |taken_up| taken_up.further(&self.machine, offset, readings_m[lane]))
        };
        let further = from_fn(further);
        let shown = taken_up.map(|taken_up| Some(taken_up?.per_unit(&self.machine, self.drive.bases())));
        let taken = |kept: Lanes, value: fn(&(ChamberState<f64>, f64)) -> f64| {
            let kept = kept.values();
            Lanes::new(from_fn(|lane| shown[lane].as_ref().map_or(kept[lane], |shown| within(value(shown)))))
        };
        let DriveState { chambers, motion, sensed, .. } = &mut self.state;
        motion.position = motion.position + Lanes::new(further);
        sensed.shift(Lanes::new(further.map(within)));
        (chambers.a, chambers.b) = (taken(chambers.a, |(of, _)| of.a), taken(chambers.b, |(of, _)| of.b));
        motion.velocity = taken(motion.velocity, |(_, velocity)| *velocity);
    }

    /// The true spool behind the sensor's readings.
    fn truly(&self, Spool { from, to }: Spool<Lanes>) -> Spool<Lanes> {
        let behind = |reading: Lanes| Lanes::new(reading.values().map(|reading| true_spool(&self.machine, reading)));
        Spool { from: behind(from), to: behind(to) }
    }

    /// A signal at a point of the grid, SI; 0 for what the model does not compute.
    fn signal(&self, signal: Signal, point: usize) -> [f64; LANES] {
        let Self { machine, stimuli, drive, state, .. } = self;
        let metering = |lane: usize| stimuli[lane].metering_at::<f64>(point);
        let spool = || match stimuli[0].input_point {
            InputPoint::Spool => Lanes::new(from_fn(|lane| metering(lane).unwrap_or_default())),
            _ => drive.sensed(state).spool,
        };
        let flow_a = || {
            let own = drive.spool(state).values();
            let spool = |lane: usize| metering(lane).map_or(own[lane], |reading| true_spool(machine, reading));
            let none = PumpDrive { speed: Lanes::constant(0.0), direction: 0 };
            drive.flows_of(state, Lanes::new(from_fn(spool)), none).a
        };
        reading(drive, machine, state, signal, spool, flow_a).map_or([0.0; LANES], Lanes::values)
    }
}

/// Simulates runs that can share lanes, at most `LANES`.
fn in_lanes(
    machine: &Machine<f64>,
    runs: &[&Run<'_>],
    sink: &mut dyn FnMut(usize, usize, &[f64]),
) -> Result<(), MachineError> {
    let mut lanes = InLanes::at_start(machine, runs)?;
    let mut signals: Vec<Signal> = Vec::new();
    for signal in runs.iter().flat_map(|run| &run.signals) {
        if !signals.contains(signal) {
            signals.push(*signal);
        }
    }
    // Rows of each run, and the index of its signals among those of all runs.
    let place = |signal: &Signal| signals.iter().position(|known| known == signal);
    let places = |run: &&Run<'_>| run.signals.iter().filter_map(place).collect();
    let places: Vec<Vec<usize>> = runs.iter().map(places).collect();
    let mut rows: Vec<Rows<'_>> = runs.iter().map(|run| Rows { rows: &run.stimulus.rows, next: 0 }).collect();
    let (mut before, mut now) = (vec![[0.0; LANES]; signals.len()], vec![[0.0; LANES]; signals.len()]);
    let mut values = Vec::with_capacity(signals.len());
    for point in 0..=runs.iter().map(|run| run.stimulus.ticks).max().unwrap_or(0) {
        if point > 0 {
            lanes.step(point - 1);
        }
        lanes.take_up(point);
        if !rows.iter().any(|rows| rows.is_wanted(point)) {
            continue;
        }
        for (now, &signal) in now.iter_mut().zip(&signals) {
            *now = lanes.signal(signal, point);
        }
        for (lane, (rows, places)) in rows.iter_mut().zip(&places).enumerate() {
            while let Some((row, share)) = rows.at(point) {
                let value = |&place: &usize| {
                    let (before, now) = (before[place][lane], now[place][lane]);
                    if share == 0.0 { now } else { before + (now - before) * share }
                };
                values.clear();
                values.extend(places.iter().map(value));
                sink(lane, row, &values);
            }
        }
        if rows.iter().any(|rows| rows.is_mixed_of(point)) {
            std::mem::swap(&mut before, &mut now);
        }
    }
    Ok(())
}
