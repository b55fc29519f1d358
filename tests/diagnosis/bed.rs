//! Cases made on the virtual test bed: a drive that deviates from its nominal values, with or without an effect.

use std::collections::BTreeMap;

use diagnosis::catalogue::Scene;
use diagnosis::{Diagnosis, diagnose};
use identification::experiment::Prepared;
use machine_file::MachineFile;
use model_core::machine::{Machine, Parameter as P};
use recording::excitation::signals::Excitation;
use recording::{Column, Recording, Signal};
use system_tests::drives;
use virtual_plant::concealed::Drawn;
use virtual_plant::sensor::sensors::PositionSensor;
use virtual_plant::{
    Bench, Drive, InitialState, LoadProfile, Plant, PlantEffect, PumpCommand, Sensors, SyntheticRecording, truth_near,
};

use super::root;

/// The input of a diagnosis.
pub(crate) struct Case {
    pub(crate) file: MachineFile,
    pub(crate) training: Vec<Recording>,
    pub(crate) held_out: Vec<Recording>,
}

impl Case {
    /// A drawn case as a diagnosis gets it: without its truth.
    pub(crate) fn of(drawn: &Drawn) -> Self {
        let recordings = |prefix: &str| {
            let wanted = drawn.recordings.iter().filter(|(name, _)| name.starts_with(prefix));
            wanted.map(|(name, synthetic)| synthetic.to_recording(name).unwrap()).collect()
        };
        Self { file: drawn.file.clone(), training: recordings("train"), held_out: recordings("holdout") }
    }

    pub(crate) fn diagnose(&self) -> Diagnosis {
        diagnose(&self.file, &self.training, &self.held_out, None, &|_| {}).unwrap()
    }

    /// Recordings as a fit takes them.
    pub(crate) fn prepared(&self, recordings: &[Recording]) -> Vec<Prepared> {
        let prepare = |recording| Prepared::new(recording, &self.file.machine, self.file.load_source, None).unwrap();
        recordings.iter().map(prepare).collect()
    }

    /// What is known of the drive before it is fitted, with recordings that begin as this one does.
    pub(crate) fn scene<'a>(&'a self, recording: &Prepared, judged: &'a [Signal]) -> Scene<'a> {
        Scene {
            machine: &self.file.machine,
            input_point: recording.stimulus.input_point,
            load: self.file.load_source,
            judged,
            travel_m: (0.05, 0.25),
            duration_s: 3.0,
            is_sparse: false,
            lowest_pa: f64::INFINITY,
            held: &[],
            asks_since: false,
            changeable: &[],
        }
    }
}

/// Names of what is accepted, joined; "none" where nothing is.
pub(crate) fn accepted(diagnosis: &Diagnosis) -> String {
    let names: Vec<&str> = diagnosis.findings.iter().map(|finding| finding.effect.name).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(" + ") }
}

/// Numbers that a seed draws (`SplitMix64`), the same everywhere.
pub(crate) struct Dice(u64);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5151)
    }

    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = self.0;
        word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        word ^ (word >> 31)
    }

    /// Evenly in [from, to).
    pub(crate) fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * ((self.word() >> 11) as f64 / 9_007_199_254_740_992.0)
    }

    /// One of the numbers from 0 to below `count`.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        usize::try_from(self.word() % count as u64).unwrap()
    }

    /// Evenly over the decades between two positive values.
    pub(crate) fn decades(&mut self, from: f64, to: f64) -> f64 {
        self.between(from.ln(), to.ln()).exp()
    }
}

/// The machine file of the shipped example: nominal values with their standard deviations.
pub(crate) fn press() -> MachineFile {
    machine_file::read(&root().join("examples/press-63-40/machine.toml")).unwrap()
}

/// An effect parameter that is visible in such recordings, within the effect's typical range.
pub(crate) fn effect(name: &str, dice: &mut Dice) -> Option<PlantEffect> {
    let (from, to) = match name {
        "internal-leakage" => (1e-12, 6e-12),
        // 1–5 % of full force, 22 kN
        "coulomb-friction" => (250.0, 1100.0),
        // 0.7 to 2.3 times the oil's own compressibility in A
        "hose-compliance" => (3e-13, 1e-12),
        // 3–15 % of 30 rev/s at 50 bar
        "pump-slip" => (3e-13, 1.5e-12),
        _ => return None,
    };
    PlantEffect::named(name, dice.decades(from, to))
}

/// A press with an effect (or none), four training recordings and two held out.
///
/// `push` presses on the rod in the training recording with its number.
pub(crate) fn valve_case(
    seed: u64,
    effect: Option<PlantEffect>,
    pressures: bool,
    push: Option<&(usize, LoadProfile)>,
) -> Case {
    valve_case_every(2e-3, seed, effect, pressures, push)
}

/// The same with a row every `tick_s`, s.
pub(crate) fn valve_case_every(
    tick_s: f64,
    seed: u64,
    effect: Option<PlantEffect>,
    pressures: bool,
    push: Option<&(usize, LoadProfile)>,
) -> Case {
    valve_case_as(tick_s, seed, effect, push, |mut made, name| {
        if !pressures {
            made.pressure_a_pa.clear();
            made.pressure_b_pa.clear();
        }
        made.rounded().to_recording(name).unwrap()
    })
}

/// The same, recorded in this way.
pub(crate) fn valve_case_as(
    tick_s: f64,
    seed: u64,
    effect: Option<PlantEffect>,
    push: Option<&(usize, LoadProfile)>,
    recorded: impl Fn(SyntheticRecording, &str) -> Recording,
) -> Case {
    let load =
        |index: usize| push.filter(|(at, _)| *at == index).map_or_else(LoadProfile::none, |(_, load)| load.clone());
    valve_case_loaded(tick_s, seed, effect.as_slice(), load, recorded)
}

/// The same with several effects and a load in each recording.
pub(crate) fn valve_case_loaded(
    tick_s: f64,
    seed: u64,
    effects: &[PlantEffect],
    load: impl Fn(usize) -> LoadProfile,
    recorded: impl Fn(SyntheticRecording, &str) -> Recording,
) -> Case {
    let file = press();
    let mut dice = Dice::new(seed);
    let truth = truth_near(&file.machine, &file.sigma, 1.0, seed);
    let mut random = |duration_s: f64, seed: u64| Excitation::Random {
        amplitude_v: dice.between(4.5, 8.0),
        shortest_s: 0.1,
        longest_s: 0.5,
        duration_s,
        seed,
    };
    let sweep = |amplitude_v: f64| Excitation::Sweep { amplitude_v, from_hz: 0.4, to_hz: 3.0, duration_s: 2.5 };
    let excitations = [
        ("train-1.csv", random(3.0, 10 * seed + 1)),
        ("train-2.csv", random(2.5, 10 * seed + 2)),
        ("train-3.csv", Excitation::paper_steps(5.5)),
        ("train-4.csv", Excitation::Triangle { amplitude_v: 5.0, frequency_hz: 0.5, duration_s: 2.0 }),
        ("holdout-1.csv", random(2.5, 10 * seed + 3)),
        ("holdout-2.csv", sweep(5.0)),
    ];
    let record = |(index, (name, excitation)): (usize, &(&str, Excitation))| {
        let plant = Plant::new(&truth, 1e-7).unwrap().with_effects(effects);
        let plant = plant.with_load(load(index));
        let mut sensors = Sensors::with_position(&truth, PositionSensor::Linear { resolution_m: 2.5e-5 });
        sensors.spool.noise_std = 5e-4;
        let bench = Bench { tick_s, seed: 1000 * seed + index as u64, ..Bench::new(plant, sensors) };
        recorded(within_stroke(&bench, *excitation, &truth), name)
    };
    let mut training: Vec<Recording> = excitations.iter().enumerate().map(record).collect();
    let held_out = training.split_off(4);
    Case { file, training, held_out }
}

/// The recording from mid-stroke; the signal is made smaller until the rod stays away from the ends.
fn within_stroke(bench: &Bench, excitation: Excitation, truth: &Machine<f64>) -> SyntheticRecording {
    let stroke_m = truth.get(P::Stroke);
    let initial = InitialState::at_rest(truth, 0.5 * stroke_m);
    let mut volts = excitation.sample(bench.tick_s);
    for _ in 0..20 {
        let recording = bench.record(&Drive::Commands(volts.clone()), &initial).unwrap();
        if recording.truth.iter().all(|state| (0.0..=stroke_m).contains(&state.position_m)) {
            return recording;
        }
        for volts in &mut volts {
            *volts *= 0.9;
        }
    }
    panic!("{excitation:?} leaves the stroke");
}

/// The same recording with a thermometer in the oil, which reads this temperature over time, °C.
pub(crate) fn in_oil(recording: &Recording, oil_c: impl Fn(f64) -> f64) -> Recording {
    let recorded = |&signal: &Signal| recording.signal(signal).map(|values| Column::si(signal, values.to_vec()));
    let mut columns = vec![Column::si(Signal::Time, recording.time_s().to_vec())];
    columns.extend(Signal::ALL.iter().filter(|signal| **signal != Signal::Time).filter_map(recorded));
    let read = recording.time_s().iter().map(|&time_s| oil_c(time_s)).collect();
    columns.push(Column::si(Signal::OilTemperature, read));
    Recording::new(recording.name(), columns).unwrap()
}

/// A pump-controlled cylinder with pressures and the external force recorded.
pub(crate) fn pump_case(seed: u64, effect: Option<PlantEffect>) -> Case {
    let nominal = drives::pump();
    let mut file = MachineFile::from_machine("pump drive", nominal);
    file.sigma = BTreeMap::from([
        (P::PumpDisplacement, 3e-8),
        (P::BulkModulus, 5e7),
        (P::ViscousFriction, 5e2),
        (P::ReturnCoefficient, 5e-9),
    ]);
    file.has_sigma_table = true;
    let truth = truth_near(&nominal, &file.sigma, 1.0, seed);
    let mut dice = Dice::new(seed);
    let mut recordings: Vec<Recording> = ["train-1", "train-2", "train-3", "train-4", "holdout-1", "holdout-2"]
        .iter()
        .enumerate()
        .map(|(index, name)| pump_recording(name, index, seed, &truth, effect, &mut dice))
        .collect();
    let held_out = recordings.split_off(4);
    Case { file, training: recordings, held_out }
}

/// A pump's speed: it rises and falls within 50 ms, while the directional valve is open.
fn speed_at(strokes: &[Stroke], time_s: f64) -> f64 {
    let along = |stroke: &Stroke| {
        let (since_s, left_s) = (time_s - stroke.from_s, stroke.to_s - time_s);
        stroke.speed_rev_per_s * (since_s.min(left_s) / 0.05).clamp(0.0, 1.0)
    };
    strokes.iter().map(along).fold(0.0, f64::max)
}

struct Stroke {
    from_s: f64,
    to_s: f64,
    speed_rev_per_s: f64,
    direction: i8,
}

/// Out and back at drawn speeds, with rests, against a force that differs from stroke to stroke.
fn pump_recording(
    name: &str,
    index: usize,
    seed: u64,
    truth: &Machine<f64>,
    effect: Option<PlantEffect>,
    dice: &mut Dice,
) -> Recording {
    const TICK_S: f64 = 2e-3;
    let (mut strokes, mut points, mut now_s) = (Vec::new(), vec![(0.0, 0.0)], 0.1);
    for _ in 0..2 {
        let speed_rev_per_s = dice.between(15.0, 45.0);
        for (direction, against) in [(1, -1.0), (-1, 0.7)] {
            let force_n = against * dice.between(500.0, 9000.0);
            strokes.push(Stroke { from_s: now_s, to_s: now_s + 0.45, speed_rev_per_s, direction });
            points.extend([(now_s, points[points.len() - 1].1), (now_s + 0.05, force_n)]);
            now_s += 0.6;
        }
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of ticks")]
    let ticks = (now_s / TICK_S).round() as usize;
    let times = || (0..ticks).map(|tick| tick as f64 * TICK_S);
    // A tick that falls on an edge, apart from rounding, counts as after the edge.
    let open = |time_s: f64| strokes.iter().find(|stroke| (stroke.from_s..stroke.to_s).contains(&(time_s + 1e-9)));
    let direction: Vec<i8> = times().map(|time_s| open(time_s).map_or(0, |stroke| stroke.direction)).collect();
    // The test bed holds a speed over a tick, a real pump changes it continuously: so each tick gets its mean over the tick.
    let held = times().zip(&direction).map(|(time_s, &direction)| PumpCommand {
        speed_rev_per_s: speed_at(&strokes, time_s + 0.5 * TICK_S),
        direction,
    });
    let load = LoadProfile::through(points.clone()).unwrap();
    let plant = Plant::new(truth, 1e-7).unwrap().with_effects(effect.as_slice()).with_load(load);
    let sensors = Sensors::with_position(truth, PositionSensor::Linear { resolution_m: 1e-5 });
    let bench = Bench { tick_s: TICK_S, seed: 1000 * seed + index as u64, ..Bench::new(plant, sensors) };
    let initial = InitialState::at_rest_with_level(truth, 0.1, 5e5);
    let made = bench.record(&Drive::Pump(held.collect()), &initial).unwrap();
    let sign = direction.iter().map(|&direction| f64::from(direction));
    let columns = vec![
        Column::si(Signal::Time, made.time_s),
        Column::si(
            Signal::PumpSpeed,
            times().zip(sign.clone()).map(|(t, sign)| sign * speed_at(&strokes, t)).collect(),
        ),
        Column::si(Signal::ValveDirection, sign.collect()),
        Column::si(Signal::LoadForce, times().map(|time_s| force_at(&points, time_s)).collect()),
        Column::si(Signal::Position, made.position_m),
        Column::si(Signal::PressureA, made.pressure_a_pa),
        Column::si(Signal::PressureB, made.pressure_b_pa),
    ];
    Recording::new(name, columns).unwrap()
}

/// The straight line between the neighbouring points.
fn force_at(points: &[(f64, f64)], time_s: f64) -> f64 {
    let next = points.partition_point(|point| point.0 <= time_s);
    match (next.checked_sub(1).map(|before| points[before]), points.get(next)) {
        (Some((from_s, from_n)), Some((to_s, to_n))) => from_n + (to_n - from_n) * (time_s - from_s) / (to_s - from_s),
        (Some((_, force_n)), None) | (None, Some(&(_, force_n))) => force_n,
        (None, None) => 0.0,
    }
}
