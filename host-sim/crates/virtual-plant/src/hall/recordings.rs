//! How a drawn drive is driven and recorded: three recordings to train on and one held out, two seconds each, inside the stroke.

use crate::{Bench, Drive, InitialState, LoadProfile, Plant, PlantEffect, SyntheticRecording, Thermometer};
use model_core::machine::Parameter as P;
use recording::Signal;
use recording::excitation::signals::Excitation;
use recording::seeded_noise::Noise;

use super::drive::Hall;

/// Recordings of a case; the last one is held out.
pub const RECORDINGS: usize = 4;
/// Length of a recording, s.
pub const DURATION_S: f64 = 2.0;
/// The drive settles for so long at least before anything is recorded, s.
const SETTLING_S: f64 = 0.4;
const TOLERANCE: f64 = 1e-6;
/// Share of the stroke that is kept free at each end.
const MARGIN: f64 = 0.03;
/// Pressure below which no chamber of a healthy drive comes, Pa: oil that is drawn on boils.
const LEAST_PA: f64 = 2e4;
/// Least share of the signal that was meant.
const FEEBLE: f64 = 0.4;

/// One run of a drive.
#[derive(Clone, Debug)]
pub struct Run {
    drive: Drive,
    start_m: f64,
    seed: u64,
    /// Rows before the recording.
    before: usize,
}

/// What is different for a run of a drive with a cause that no catalogue has.
#[derive(Clone, Debug, Default)]
pub struct Change {
    /// Effects beside those of the drive.
    pub effects: Vec<PlantEffect>,
    /// From the start of the recording on.
    pub load: LoadProfile,
    /// Temperature of the oil, °C, of a drive with an oil whose temperature acts.
    pub oil_c: Option<f64>,
    /// Whether that is recorded.
    pub sees_oil: bool,
}

impl Run {
    /// Seconds before the recording.
    pub fn before_s(&self, hall: &Hall) -> f64 {
        self.before as f64 * hall.tick_s
    }

    /// Everything that happens, the time before the recording included.
    pub fn whole(&self, hall: &Hall, change: &Change) -> Option<SyntheticRecording> {
        let effects = [hall.effects.as_slice(), &change.effects].concat();
        let effects: Vec<PlantEffect> =
            effects.iter().map(|effect| change.oil_c.map_or(*effect, |oil_c| effect.in_oil_at(oil_c))).collect();
        let plant = Plant::new(&hall.truth, TOLERANCE).ok()?.with_effects(&effects);
        let load = change.load.later(self.before_s(hall));
        let read = |oil_c| Thermometer { oil_c, noise_std_k: 0.2, resolution_k: 0.1 };
        let thermometer = change.oil_c.filter(|_| change.sees_oil).map(read);
        let (tick_s, seed, plant) = (hall.tick_s, self.seed, plant.with_load(load));
        let bench = Bench { thermometer, tick_s, seed, ..Bench::new(plant, hall.sensors) };
        bench.record(&self.drive, &InitialState::at_rest(&hall.truth, self.start_m)).ok()
    }

    /// The same run with these commands, whatever they answer to.
    #[must_use]
    pub fn commanded(&self, command_v: Vec<f64>) -> Self {
        Self { drive: Drive::Commands(command_v), ..self.clone() }
    }

    /// The same run at another time: only the noise of the sensors is another.
    #[must_use]
    pub fn again(&self, seed: u64) -> Self {
        Self { seed, ..self.clone() }
    }

    /// The same run of a drive that nobody moves.
    #[must_use]
    pub fn resting(&self, tick_s: f64) -> Self {
        self.commanded(vec![0.0; self.before + ticks(DURATION_S, tick_s) + 1])
    }
}

/// Whether the rod keeps away from the ends, and the oil is never drawn on.
#[must_use]
pub fn stays_inside(hall: &Hall, whole: &SyntheticRecording) -> bool {
    let stroke_m = hall.truth.get(P::Stroke);
    let inside = MARGIN * stroke_m..(1.0 - MARGIN) * stroke_m;
    whole
        .truth
        .iter()
        .all(|state| inside.contains(&state.position_m) && state.pressure_a_pa.min(state.pressure_b_pa) > LEAST_PA)
}

/// The runs of a case on the drive as it is; none where the drive does not stay inside its stroke.
pub fn runs(hall: &Hall, dice: &mut Noise) -> Option<Vec<Run>> {
    let regulated = dice.happens(0.3);
    (0..RECORDINGS).map(|index| run(hall, index, regulated && index % 2 == 1, dice)).collect()
}

/// A signal within ±1.
fn shape(index: usize, duration_s: f64, tick_s: f64, dice: &mut Noise) -> Vec<f64> {
    let random = |dice: &mut Noise| Excitation::Random {
        amplitude_v: 1.0,
        shortest_s: dice.uniform(0.08, 0.15),
        longest_s: dice.uniform(0.35, 0.6),
        duration_s,
        seed: dice.uniform(0.0, 1e9).to_bits(),
    };
    let signal = match (index, dice.below(3)) {
        (1, _) => Excitation::Steps { amplitude_v: 1.0 },
        (2, 0) => {
            let (from_hz, to_hz) = (dice.uniform(0.4, 0.8), dice.uniform(2.0, 4.0));
            Excitation::Sweep { amplitude_v: 1.0, from_hz, to_hz, duration_s }
        }
        (2, 1) => Excitation::Triangle { amplitude_v: 1.0, frequency_hz: dice.uniform(0.6, 1.2), duration_s },
        _ => random(dice),
    };
    let mut shape = signal.sample(tick_s);
    shape.resize(ticks(duration_s, tick_s) + 1, 0.0);
    shape
}

fn ticks(duration_s: f64, tick_s: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of ticks")]
    let count = (duration_s / tick_s).round() as usize;
    count
}

fn run(hall: &Hall, index: usize, regulated: bool, dice: &mut Noise) -> Option<Run> {
    let get = |parameter| hall.truth.get(parameter);
    let stroke_m = get(P::Stroke);
    let moving_s = if dice.happens(0.3) { dice.uniform(0.3, 0.7) } else { 0.0 };
    let shape = shape(index, DURATION_S + moving_s, hall.tick_s, dice);
    let settling = ticks(SETTLING_S + dice.uniform(0.0, 0.15), hall.tick_s);
    let before = settling + ticks(moving_s, hall.tick_s);
    let seed = dice.uniform(0.0, 1e9).to_bits();
    let dead_v = get(P::DeadZone) / get(P::ValveGain);
    let flow_per_volt = get(P::ValveGain) * get(P::FlowCoefficient) * (0.5 * get(P::SupplyPressure)).sqrt();
    let gain_v_per_m = dice.uniform(3.0, 6.0) * 0.5 * (get(P::AreaA) + get(P::AreaB)) / flow_per_volt;
    let most =
        if regulated { stroke_m * dice.uniform(0.1, 0.25) } else { (1.2 * dead_v + dice.uniform(2.5, 7.0)).min(9.5) };
    let (mut sides, mut start_m) = ([most; 2], stroke_m * dice.uniform(0.4, 0.6));
    for _ in 0..14 {
        let scaled = std::iter::repeat_n(0.0, settling).chain(shape.iter().map(|s| s * sides[usize::from(*s < 0.0)]));
        let drive = if regulated {
            Drive::Closed { reference_m: scaled.map(|off_m| start_m + off_m).collect(), gain_v_per_m }
        } else {
            Drive::Commands(scaled.collect())
        };
        let run = Run { drive, start_m, seed, before };
        let whole = run.whole(hall, &Change::default())?;
        if stays_inside(hall, &whole) {
            return Some(run);
        }
        let (low, high) = whole
            .truth
            .iter()
            .map(|state| state.position_m)
            .fold((f64::MAX, f64::MIN), |(low, high), y| (low.min(y), high.max(y)));
        if !regulated
            && high - low < (1.0 - 3.0 * MARGIN) * stroke_m
            && !(low > MARGIN * stroke_m && high < (1.0 - MARGIN) * stroke_m)
        {
            start_m = (start_m + 0.5 * (stroke_m - low - high))
                .clamp(2.0 * MARGIN * stroke_m, (1.0 - 2.0 * MARGIN) * stroke_m);
            continue;
        }
        // The side towards which the rod wanders is driven less; if it does not wander, both are.
        let wandered = whole.truth.last()?.position_m - whole.truth.first()?.position_m;
        let wanders = wandered.abs() > 0.4 * (high - low);
        for (side, towards) in sides.iter_mut().zip([wandered > 0.0, wandered < 0.0]) {
            *side *= if towards || !wanders { 0.85 } else { 1.0 };
        }
        if sides.iter().any(|side| *side < FEEBLE * most) {
            return None;
        }
    }
    None
}

/// What is kept of a run: from where the recording begins, only what is measured.
#[must_use]
pub fn recorded(hall: &Hall, run: &Run, whole: &SyntheticRecording) -> SyntheticRecording {
    let mut kept = whole.clone();
    kept.cut_before(run.before);
    kept.reference_m.clear();
    for (signal, values) in [
        (Signal::Spool, &mut kept.spool),
        (Signal::Position, &mut kept.position_m),
        (Signal::PressureA, &mut kept.pressure_a_pa),
        (Signal::PressureB, &mut kept.pressure_b_pa),
    ] {
        if !hall.signals.contains(&signal) {
            values.clear();
        }
    }
    kept.rounded()
}

/// The name of each recording, for a file too.
#[must_use]
pub fn name(index: usize) -> String {
    if index + 1 < RECORDINGS { format!("train-{}.csv", index + 1) } else { "holdout-1.csv".to_owned() }
}
