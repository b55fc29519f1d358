//! One case: drive, setting, effects, recordings; it is drawn again until its effects show in the recordings.

use machine_file::MachineFile;
use model_core::machine::{Machine, Parameter as P, Source};
use recording::seeded_noise::Noise;

use super::bench::{RunInput, Setting, spiked, travel};
use super::signals::{self, HELD_OUT, Kind, TRAINING};
use super::strength::{self, About};
use super::truth::{CaseTruth, noise_floor};
use super::visibility::{Shown, Visible};
use super::{CAVITATION, Channels, Concealed, Drawn, Lot, Mode, OUTSIDE, PUMP_SLIP, VOCABULARY, drive};
use crate::effect::PlantEffect;
use crate::effect::load::LoadEffect;
use crate::excitation::input::LoadProfile;
use crate::plant::PlantError;
use crate::rig::recorded::SyntheticRecording;

/// Draws of one case before the last one is accepted as it is, if it can be used at all.
const ATTEMPTS: u64 = 12;
/// The misfit, noise included, that a refit without the effect must at least leave, relative to the noise.
const SHOWS_FROM: f64 = 1.04;

/// Case `index` of a lot, counted from 0. None if no draw of it stays inside its stroke.
pub fn draw(lot: &Lot, index: u64) -> Result<Option<Drawn>, PlantError> {
    let mut kept = None;
    for attempt in 0..ATTEMPTS {
        // A random stream for each attempt of each case.
        let mut dice = Noise::new(lot.seed, (index << 8) | (attempt + 1));
        let Some(drawn) = attempt_at(lot, index, &names(lot, index), &mut dice)? else { continue };
        let shows = drawn.truth.visible.iter().all(|&visible| visible >= SHOWS_FROM);
        kept = Some(drawn);
        if shows {
            break;
        }
    }
    Ok(kept)
}

/// The effects that the case conceals. Over a lot, every name is used once before one is used again.
fn names(lot: &Lot, index: u64) -> Vec<String> {
    let mut order = Noise::new(lot.seed, 0);
    let (outside, asked): (Vec<String>, Vec<String>) = lot.only.iter().cloned().partition(|name| name.starts_with('~'));
    let or_all = |names: Vec<String>, all: &[&str]| {
        if names.is_empty() { all.iter().map(|&name| name.to_owned()).collect() } else { names }
    };
    let only_outside = asked.is_empty() && !outside.is_empty();
    let (outside, mut shuffled): (Vec<String>, Vec<String>) = (or_all(outside, &OUTSIDE), or_all(asked, &VOCABULARY));
    for last in (1..shuffled.len()).rev() {
        shuffled.swap(last, order.below(last + 1));
    }
    let mut dice = Noise::new(lot.seed, index << 8);
    let turn = |index: u64| shuffled[usize::try_from(index).unwrap_or(0) % shuffled.len()].clone();
    let concealed = match lot.concealed {
        _ if only_outside => Concealed::Outside,
        Concealed::Mixed => match dice.below(20) {
            0..=2 => Concealed::None,
            3..=4 => Concealed::Outside,
            5..=8 => Concealed::Pair,
            _ => Concealed::Single,
        },
        other => other,
    };
    match concealed {
        Concealed::None => Vec::new(),
        Concealed::Outside => vec![outside[dice.below(outside.len())].clone()],
        Concealed::Single | Concealed::Mixed => vec![turn(index)],
        Concealed::Pair => {
            let first = turn(index);
            let others: Vec<&String> = shuffled.iter().filter(|name| compatible(name, &first)).collect();
            let second = others.get(dice.below(others.len().max(1))).map(|name| (*name).clone());
            std::iter::once(first).chain(second).collect()
        }
    }
}

/// Two kinds of dry friction are the same as one richer kind; two effects with the same name are the same as one.
fn compatible(one: &str, other: &str) -> bool {
    let friction = |name: &str| name.ends_with("friction") || name == "friction-asymmetry" || name == "presliding";
    one != other && !(friction(one) && friction(other)) && one != PUMP_SLIP && other != PUMP_SLIP
}

fn attempt_at(lot: &Lot, index: u64, names: &[String], dice: &mut Noise) -> Result<Option<Drawn>, PlantError> {
    let id = format!("c{index:03}");
    let pump = names.iter().any(|name| name == PUMP_SLIP);
    let machine = if pump { drive::draw_pump(dice) } else { drive::draw(dice) };
    let is_drawn_on = names.iter().any(|name| name == CAVITATION);
    let machine = if is_drawn_on { drive::heavy(&machine, dice) } else { machine };
    let file = drive::file(&id, &machine, lot.hard, dice);
    let setting = setting(lot, &machine, names, dice);
    let training = if lot.hard { [2, 3, 4][dice.below(3)] } else { 4 };
    let mut signals = signals(&setting, training, names, dice);
    if lot.thermometer {
        warm(&mut signals, &mut Noise::new(lot.seed, u64::MAX - index));
    }

    // The travel of the drive without effects shows where stops and tight places can be.
    let probe = needs_range(names);
    let mut reach = Vec::new();
    if probe {
        for signal in &mut signals {
            let Some(recording) = setting.fitted(&[], signal)? else { return Ok(None) };
            reach.push(travel(&recording));
        }
    }
    let travel_m = usual_travel(&reach, machine.get(P::Stroke));
    let about = About { machine: &machine, channels: setting.channels, travel_m, thermometer: lot.thermometer };
    let effects: Vec<PlantEffect> = names.iter().filter_map(|name| strength::draw(name, &about, dice)).collect();
    for signal in &mut signals {
        signal.start_m = before_stops(&effects, signal.start_m);
    }

    let mut made = Vec::new();
    for mut signal in signals {
        let recording =
            if probe { Some(setting.run(&effects, &signal)?) } else { setting.fitted(&effects, &mut signal)? };
        let Some(recording) = recording else { return Ok(None) };
        let (low, high) = travel(&recording);
        if low < 0.0 || high > machine.get(P::Stroke) {
            return Ok(None);
        }
        made.push((signal, recording));
    }
    if !stops_are_met(&effects, &made) {
        return Ok(None);
    }
    let pushed = names.iter().any(|name| name == "~external-disturbance");
    let visible = if names.is_empty() {
        Visible::default()
    } else {
        let made = &made[..training.min(2)];
        Shown { setting: &setting, sigma: &file.sigma, made, effects: &effects }.refits()?.visible(pushed)?
    };
    Ok(Some(Attempt { lot, setting, file, names, effects, visible, made, training }.finished(dice)))
}

fn setting(lot: &Lot, machine: &Machine<f64>, names: &[String], dice: &mut Noise) -> Setting {
    use Channels::{Full, Position, Pressures, Spool};
    let channels = if lot.hard {
        [Position, Position, Spool, Spool, Pressures, Pressures, Pressures, Full][dice.below(8)]
    } else {
        [Position, Spool, Spool, Pressures, Pressures, Pressures, Full, Full][dice.below(8)]
    };
    let rate_hz = if lot.hard { [1000.0, 1000.0, 500.0, 500.0, 200.0] } else { [1000.0, 1000.0, 1000.0, 500.0, 500.0] };
    let rate_hz: f64 = rate_hz[dice.below(5)];
    let mode = match dice.below(20) {
        16.. => Mode::Closed,
        12..=15 if rate_hz > 300.0 => Mode::Dither,
        _ => Mode::Open,
    };
    // Dither removes stiction.
    let mode =
        if mode == Mode::Dither && names.iter().any(|name| name == "spool-stiction") { Mode::Open } else { mode };
    // In closed loop the heavy load would oscillate, and no valve would close suddenly.
    let mode = if names.iter().any(|name| name == CAVITATION) { Mode::Open } else { mode };
    let pump = machine.source == Source::Pump;
    let (mode, channels) = if pump { (Mode::Pump, Channels::Pump) } else { (mode, channels) };
    let noise = if lot.hard { [1.0, 1.0, 2.0, 3.0][dice.below(4)] } else { [1.0, 1.0, 1.0, 2.0][dice.below(4)] };
    // Speed of the rod per volt beyond the dead zone, at half the supply pressure.
    let area = 0.5 * (machine.get(P::AreaA) + machine.get(P::AreaB));
    let flow_per_volt =
        machine.get(P::ValveGain) * machine.get(P::FlowCoefficient) * (0.5 * machine.get(P::SupplyPressure)).sqrt();
    Setting {
        machine: *machine,
        mode,
        channels,
        tick_s: 1.0 / rate_hz,
        noise,
        pressure_noise_share: dice.decades(3e-4, 1e-3),
        pressure_bits: [12, 14, 16][dice.below(3)],
        dither: (dice.uniform(0.15, 0.5), dice.uniform(40.0, 0.2 * rate_hz.min(600.0))),
        gain_v_per_m: dice.uniform(4.0, 9.0) * area / flow_per_volt,
    }
}

fn signals(setting: &Setting, training: usize, names: &[String], dice: &mut Noise) -> Vec<RunInput> {
    let machine = &setting.machine;
    let (stroke_m, seed) = (machine.get(P::Stroke), dice.uniform(0.0, 1e9).to_bits());
    let dead_v = machine.get(P::DeadZone) / machine.get(P::ValveGain);
    let first = dice.below(TRAINING.len());
    // Steps and random steps are always the first two.
    let kinds = (0..training).map(|k| if k < 2 { TRAINING[k] } else { TRAINING[2 + (first + k) % 4] });
    let pushed = names.iter().any(|name| name == "~external-disturbance");
    kinds
        .chain(HELD_OUT)
        .enumerate()
        .map(|(index, kind)| {
            // A pump needs time to reach its speed.
            let kind = if setting.mode == Mode::Pump { Kind::Trapezoids } else { kind };
            let duration_s = dice.uniform(4.0, 5.5);
            let amplitude = match setting.mode {
                Mode::Closed => stroke_m * dice.uniform(0.12, 0.3),
                Mode::Pump => dice.uniform(15.0, 40.0),
                Mode::Open | Mode::Dither => (1.2 * dead_v + dice.uniform(1.8, 6.0)).min(9.5),
            };
            // In extension, the whole piston area has to be filled.
            let slower = if setting.mode == Mode::Closed { 1.0 } else { dice.uniform(0.75, 1.0) };
            let load = if pushed && (index == 0 || index == training) {
                push(machine, duration_s, dice)
            } else {
                LoadProfile::none()
            };
            RunInput {
                shape: signals::draw(kind, duration_s, setting.tick_s, dice),
                amplitude: [amplitude, amplitude * slower],
                start_m: stroke_m * dice.uniform(0.4, 0.6),
                seed: seed.wrapping_add(index as u64),
                load,
                oil_c: None,
            }
        })
        .collect()
}

/// The drive warms up from recording to recording; the held-out ones are the warmest.
fn warm(signals: &mut [RunInput], dice: &mut Noise) {
    let (first_c, rise_k) = (dice.uniform(18.0, 34.0), dice.uniform(5.0, 9.0));
    for (index, signal) in signals.iter_mut().enumerate() {
        signal.oil_c = Some(first_c + index as f64 * rise_k);
    }
}

/// Somebody pushes on the rod once.
fn push(machine: &Machine<f64>, duration_s: f64, dice: &mut Noise) -> LoadProfile {
    let force_n = dice.sign() * machine.get(P::SupplyPressure) * machine.get(P::AreaA) * dice.decades(0.05, 0.25);
    let (start_s, rise_s, hold_s) =
        (duration_s * dice.uniform(0.2, 0.6), dice.uniform(0.02, 0.1), dice.uniform(0.15, 0.5));
    let points = vec![
        (start_s, 0.0),
        (start_s + rise_s, force_n),
        (start_s + rise_s + hold_s, force_n),
        (start_s + 2.0 * rise_s + hold_s, 0.0),
    ];
    LoadProfile::through(points).unwrap_or_default()
}

fn needs_range(names: &[String]) -> bool {
    names.iter().any(|name| ["end-stop", "position-dependent-friction", "position-dependent-load"].contains(&&**name))
}

/// The range that half of the recordings reach.
fn usual_travel(reach: &[(f64, f64)], stroke_m: f64) -> (f64, f64) {
    if reach.is_empty() {
        return (0.3 * stroke_m, 0.7 * stroke_m);
    }
    let middle = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    (middle(reach.iter().map(|r| r.0).collect()), middle(reach.iter().map(|r| r.1).collect()))
}

/// A start position on the near side of any stop, since no rod can start beyond one.
fn before_stops(effects: &[PlantEffect], start_m: f64) -> f64 {
    effects.iter().fold(start_m, |start_m, effect| match effect {
        PlantEffect::Load(LoadEffect::EndStop { at_m, extending: true, .. }) => start_m.min(*at_m),
        PlantEffect::Load(LoadEffect::EndStop { at_m, .. }) => start_m.max(*at_m),
        _ => start_m,
    })
}

/// False if there is a stop that no training recording reaches: it would have no effect.
fn stops_are_met(effects: &[PlantEffect], made: &[(RunInput, SyntheticRecording)]) -> bool {
    effects.iter().all(|effect| match effect {
        PlantEffect::Load(LoadEffect::EndStop { at_m, extending, .. }) => {
            let pressed = |recording: &SyntheticRecording| {
                let (low, high) = travel(recording);
                if *extending { high > *at_m } else { low < *at_m }
            };
            pressed(&made[0].1) || pressed(&made[1].1)
        }
        _ => true,
    })
}

/// A case that stays inside its stroke, before its recordings are degraded.
struct Attempt<'a> {
    lot: &'a Lot,
    setting: Setting,
    file: MachineFile,
    names: &'a [String],
    effects: Vec<PlantEffect>,
    visible: Visible,
    made: Vec<(RunInput, SyntheticRecording)>,
    training: usize,
}

impl Attempt<'_> {
    /// Adds spikes and rounding, keeps only the channels that the case records, and adds the truth.
    fn finished(self, dice: &mut Noise) -> Drawn {
        let spikes = if dice.happens(if self.lot.hard { 0.25 } else { 0.08 }) { 0.003 } else { 0.0 };
        let mut floors = Vec::new();
        let mut recordings = Vec::new();
        for (index, (_, mut recording)) in self.made.into_iter().enumerate() {
            let stem = if index < self.training {
                format!("train-{}", index + 1)
            } else {
                format!("holdout-{}", index + 1 - self.training)
            };
            if spikes > 0.0 {
                for channel in [
                    &mut recording.spool,
                    &mut recording.position_m,
                    &mut recording.pressure_a_pa,
                    &mut recording.pressure_b_pa,
                ] {
                    spiked(channel, spikes, dice);
                }
            }
            let mut recording = recording.rounded();
            floors.push((stem.clone(), noise_floor(&recording, self.setting.channels)));
            recording.reference_m.clear();
            let [spool, _, pressures, _] = self.setting.channels.recorded();
            if !spool {
                recording.spool.clear();
            }
            if !pressures {
                recording.pressure_a_pa.clear();
                recording.pressure_b_pa.clear();
            }
            recordings.push((format!("{stem}.csv"), recording));
        }
        let known = VOCABULARY.iter().chain(&super::ON_REQUEST).chain(&OUTSIDE);
        let truth = CaseTruth {
            effects: self.names.iter().filter_map(|name| known.clone().find(|known| *known == name).copied()).collect(),
            forms: self.effects,
            channels: self.setting.channels.name(),
            mode: self.setting.mode.name(),
            noise: self.setting.noise,
            rate_hz: (1.0 / self.setting.tick_s).round(),
            spikes,
            hard: self.lot.hard,
            noise_floor: floors,
            visible: self.visible.each.iter().map(|visible| drive::rounded(*visible, 4)).collect(),
            visible_together: self.visible.together.map(|visible| drive::rounded(visible, 4)),
            plainer: self
                .visible
                .plainer
                .iter()
                .map(|plainer| plainer.map(|(name, left)| (name, drive::rounded(left, 4))))
                .collect(),
        };
        Drawn { id: self.file.name.clone(), file: self.file, recordings, truth }
    }
}
