//! Several recordings simulated abreast: as many as a number has lanes, with what a step asks of the machine asked once for all.

use std::array::from_fn;

use model_core::chambers::ChamberState;
use model_core::drive::{Drive, Entry, Load};
use model_core::flow::PumpDrive;
use model_core::machine::{Machine, MachineError};
use model_core::number::Number;
use model_core::valve::Slider;

use super::stimulus::value_at;
use super::{
    DELAY_LINE, Departure, EntryPoint, Rows, StartOffset, Stimulus, Units, run, true_slider, unbraked, within,
};
use crate::lanes::{LANES, Lanes};
use crate::recording::Signal;

/// What is simulated of one recording.
#[derive(Clone, Debug)]
pub struct Run<'a> {
    /// The recording on the core's grid.
    pub stimulus: &'a Stimulus,
    /// What a fit moved about its start.
    pub offset: StartOffset<f64>,
    /// Signals that are wanted at its rows.
    pub signals: Vec<Signal>,
}

/// Runs the core over several stimuli, and hands each recorded row's signals to `sink`: which run, which row, and the values in SI
/// units, 0 for what the chain does not compute. The rows of one run come in order; each value is that of [`run`] to the last bit.
pub fn run_abreast(
    machine: &Machine<f64>,
    runs: &[Run<'_>],
    mut sink: impl FnMut(usize, usize, &[f64]),
) -> Result<(), MachineError> {
    let mut left: Vec<usize> = (0..runs.len()).collect();
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
            in_lanes(machine, &chosen, |lane, row, values| sink(together[lane], row, values))?;
        } else {
            alone(machine, &runs[first], |row, values| sink(first, row, values))?;
        }
    }
    Ok(())
}

fn alone(machine: &Machine<f64>, one: &Run<'_>, mut sink: impl FnMut(usize, &[f64])) -> Result<(), MachineError> {
    let mut values = vec![0.0; one.signals.len()];
    run::<f64>(machine, one.stimulus, one.offset, |row, sample| {
        for (value, &signal) in values.iter_mut().zip(&one.signals) {
            *value = sample.signal(signal).unwrap_or_default();
        }
        sink(row, &values);
    })
}

/// One recording in its lane.
struct Lane<'a> {
    rows: Rows<'a>,
    /// Its signals among those of all.
    places: Vec<usize>,
}

/// Runs that go together, `LANES` at most; lanes without one repeat the first.
fn in_lanes(
    machine: &Machine<f64>,
    runs: &[&Run<'_>],
    mut sink: impl FnMut(usize, usize, &[f64]),
) -> Result<(), MachineError> {
    let of = |lane: usize| *runs.get(lane).unwrap_or(&runs[0]);
    let stimuli: [&Stimulus; LANES] = from_fn(|lane| of(lane).stimulus);
    let first = stimuli[0];
    let machine = &unbraked(machine, first);
    let drive = Drive::<Lanes>::new::<DELAY_LINE>(machine, first.tick)?;
    let bases = *drive.bases();
    let departures: [Departure<f64>; LANES] =
        from_fn(|lane| Departure::of(machine, &bases, &stimuli[lane].start, of(lane).offset));
    let pressures = ChamberState {
        a: packed(&departures, |departure| within(departure.pressures.a)),
        b: packed(&departures, |departure| within(departure.pressures.b)),
    };
    let command = packed(&departures, |departure| f64::saturated(departure.command));
    let mut state = drive.at_rest(command, pressures, packed(&departures, |departure| departure.strokes));

    let mut signals: Vec<Signal> = Vec::new();
    let mut lanes: Vec<Lane<'_>> = Vec::new();
    for run in runs {
        for &signal in &run.signals {
            if !signals.contains(&signal) {
                signals.push(signal);
            }
        }
        let place = |signal: &Signal| signals.iter().position(|known| known == signal);
        let places = run.signals.iter().filter_map(place).collect();
        lanes.push(Lane { rows: Rows { rows: &run.stimulus.rows, next: 0 }, places });
    }
    let units = Units {
        drive: &drive,
        si: |value: Lanes, base: f64| value * Lanes::all(base),
        strokes: |travel: Lanes| travel,
        of: Lanes::all,
    };
    let of_reading = |reading: Lanes| Lanes::new(reading.values().map(|reading| true_slider(machine, reading)));
    let truly = |Slider { from, to }| Slider { from: of_reading(from), to: of_reading(to) };
    let (mut before, mut now) = (vec![[0.0; LANES]; signals.len()], vec![[0.0; LANES]; signals.len()]);
    let mut values = Vec::with_capacity(signals.len());
    for point in 0..=runs.iter().map(|run| run.stimulus.ticks).max().unwrap_or(0) {
        if point > 0 {
            let tick = point - 1;
            let read = |series: fn(&Stimulus) -> &[f64], index: usize, base: f64| {
                Lanes::new(stimuli.map(|stimulus| value_at(series(stimulus), index))) / Lanes::all(base)
            };
            let entry = match first.entry_by(tick, &bases, read) {
                Entry::Slider(slider) => Entry::Slider(truly(slider)),
                Entry::Followed { command, slider } => Entry::Followed { command, slider: truly(slider) },
                other => other,
            };
            let kept = state.oil_temperature.values();
            let oil = |lane: usize| stimuli[lane].oil_at(tick, &bases).unwrap_or(kept[lane]);
            state.oil_temperature = Lanes::new(from_fn(oil));
            let load = |index: usize| read(Stimulus::load, index, bases.force_n);
            drive.step(&mut state, entry, Load { from: load(tick), to: load(tick + 1) });
        }
        let metering = |lane: usize| stimuli[lane].metering_at::<f64>(point);
        let spool = || match first.entry {
            EntryPoint::Slider => Lanes::new(from_fn(|lane| metering(lane).unwrap_or_default())),
            _ => drive.sensed(&state).spool,
        };
        let flow_a = || {
            let own = drive.slider(&state).values();
            let slider = |lane: usize| metering(lane).map_or(own[lane], |reading| true_slider(machine, reading));
            let pump = PumpDrive { speed: Lanes::ZERO, direction: 0 };
            drive.flows_from(state.supply.pressure, Lanes::new(from_fn(slider)), pump, state.chambers).a
        };
        let computed = signals.iter().map(|&signal| units.reading(machine, &state, signal, spool, flow_a));
        for (now, computed) in now.iter_mut().zip(computed) {
            *now = computed.unwrap_or(Lanes::ZERO).values();
        }
        for (index, lane) in lanes.iter_mut().enumerate() {
            while let Some((row, share)) = lane.rows.at(point) {
                values.clear();
                values.extend(lane.places.iter().map(|&place| {
                    let (before, now) = (before[place][index], now[place][index]);
                    if share == 0.0 { now } else { before + (now - before) * share }
                }));
                sink(index, row, &values);
            }
        }
        if lanes.iter().any(|lane| lane.rows.is_mixed_of(point)) {
            std::mem::swap(&mut before, &mut now);
        }
    }
    Ok(())
}

/// One value of each.
fn packed<T>(of: &[T; LANES], value: impl Fn(&T) -> f64) -> Lanes {
    Lanes::new(from_fn(|lane| value(&of[lane])))
}
