//! Motion of the rod that no command asks for, and a supply pressure that falls while the own command is at neutral.
//!
//! Only motion counts that begins after the valve has had time to follow: every row looks back over its lag. Of each stretch without a command that opens the
//! valve the way that the rod goes, the distance between its ends counts, so that a load which swings to and fro counts nothing.

use identification::experiment::Prepared;
use model_core::machine::{Machine, Parameter};
use recording::Signal;
use simulation::signal::noise::{noise, resolution};

use crate::before_after::Shown;

/// Share of all the way of the rod that has to be made without a command: more than any leak or drift makes of a drive that is moved by its valve.
const OF_ALL_WAY: f64 = 0.2;
/// A stretch counts if the rod goes further than so many standard deviations of noise.
const BEYOND_NOISE: f64 = 6.0;
/// Chosen: a valve counts as closed within its dead zone and this share of its travel: nobody knows a neutral better.
const NEAR_NEUTRAL: f64 = 0.02;
/// The rod has to go at least at this share of the speed that it has under command.
const OF_SPEED: f64 = 0.25;
/// Time constants of the valve until it has followed.
const SETTLED: f64 = 5.0;
/// A supply that falls by less than this share while the command rests may do so by itself.
const SAGS_BY: f64 = 0.1;

/// Motion without a command, or against it.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncommanded {
    /// Way of the rod in all recordings, m.
    pub all_m: f64,
    /// The part of it made while the command is at neutral, m.
    pub at_neutral_m: f64,
    /// The part of it made against the command, m.
    pub against_m: f64,
    /// Whether it only retracts so.
    pub only_retracts: bool,
    /// Whether the command never asks for the way that it goes so.
    pub is_never_asked: bool,
    /// The longest such stretch: its recording, and where it is, s.
    pub recording: String,
    /// Its beginning, s.
    pub from_s: f64,
    /// Its end, s.
    pub to_s: f64,
}

/// A supply pressure that falls while the command is at neutral.
#[derive(Clone, Debug, PartialEq)]
pub struct SupplySag {
    /// The recording.
    pub recording: String,
    /// When it begins to fall, s.
    pub from_s: f64,
    /// When it is lowest, s.
    pub to_s: f64,
    /// By how much, Pa.
    pub by_pa: f64,
}

/// What was asked for by the commands of a row and of the valve's lag before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Asked {
    extends: bool,
    retracts: bool,
}

/// A stretch in which the command asks for the same all the time.
struct Stretch {
    from: usize,
    to: usize,
    asked: Asked,
}

/// Looks at recordings that a command drives; `lag_s` is how late the rod follows it by a linear model.
pub(super) fn look(
    shown: &[Shown],
    machine: &Machine<f64>,
    lag_s: f64,
    supply_pa: &[Option<&[f64]>],
) -> (Option<Uncommanded>, Option<SupplySag>) {
    let get = |parameter| machine.get(parameter);
    let of_valve_s = machine.spool_lag_s();
    let settled_s = get(Parameter::TransportDelay) + SETTLED * of_valve_s + SETTLED * lag_s;
    let stretches: Vec<Vec<Stretch>> =
        shown.iter().map(|shown| stretches(&shown.prepared, machine, settled_s)).collect();
    let cases = || shown.iter().map(|shown| &shown.prepared).zip(&stretches);
    // Where it is recorded what others take, a supply that falls is no riddle.
    let riddles = cases().zip(supply_pa).filter(|((case, _), _)| !case.stimulus.knows_others());
    let sag = riddles.filter_map(|((case, stretches), supply)| sag(case, stretches, (*supply)?));
    (moves(cases()), sag.max_by(|a, b| a.by_pa.total_cmp(&b.by_pa)))
}

/// The stretches of a recording.
fn stretches(case: &Prepared, machine: &Machine<f64>, settled_s: f64) -> Vec<Stretch> {
    let get = |parameter| machine.get(parameter);
    let closed = get(Parameter::DeadZone) + NEAR_NEUTRAL;
    let tick_s = case.stimulus.tick.seconds();
    let asked: Vec<Asked> = case
        .stimulus
        .driving()
        .iter()
        .map(|command| {
            let opening = get(Parameter::ValveGain) * command + get(Parameter::ValveOffset);
            Asked { extends: opening > closed, retracts: opening < -closed }
        })
        .collect();
    // The last tick up to each at which it asked for either way; before the recording it asked for what it asks for first.
    let (mut extended, mut retracted) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    let mut within: Vec<Asked> = Vec::with_capacity(asked.len());
    for (tick, now) in asked.iter().enumerate() {
        let time_s = tick as f64 * tick_s;
        if now.extends {
            extended = time_s;
        }
        if now.retracts {
            retracted = time_s;
        }
        within.push(Asked { extends: time_s - extended <= settled_s, retracts: time_s - retracted <= settled_s });
    }
    let mut found: Vec<Stretch> = Vec::new();
    for (row, tick) in case.stimulus.row_ticks().enumerate().take(case.rows()) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a tick of the recording")]
        let Some(now) = within.get((tick as usize).min(within.len().saturating_sub(1))) else { continue };
        match found.last_mut() {
            Some(last) if last.asked == *now => last.to = row,
            _ => found.push(Stretch { from: row, to: row, asked: *now }),
        }
    }
    // A rod that moves as its recording begins may still do so by what was asked before it.
    for stretch in &mut found {
        while stretch.from < stretch.to && case.time_s[stretch.from] - case.time_s[0] < settled_s {
            stretch.from += 1;
        }
    }
    found.retain(|stretch| stretch.to > stretch.from);
    found
}

/// The way that is made without a command or against it, where that is much of all.
fn moves<'a>(cases: impl Iterator<Item = (&'a Prepared, &'a Vec<Stretch>)>) -> Option<Uncommanded> {
    let (mut all_m, mut asked_m, mut asked_s) = (0.0, 0.0, 0.0);
    let (mut at_neutral_m, mut against_m, mut apart_s) = (0.0, 0.0, 0.0);
    let (mut extends, mut retracts, mut asks) = (false, false, Asked::default());
    let mut longest: Option<(f64, &Prepared, &Stretch)> = None;
    for (case, stretches) in cases {
        let Some(channel) = case.channels.iter().find(|channel| channel.signal == Signal::Position) else { continue };
        let position_m = channel.bridged();
        for stretch in stretches {
            let by_m = position_m[stretch.to] - position_m[stretch.from];
            let took_s = took_s(case, &position_m, stretch);
            asks.extends |= stretch.asked.extends;
            asks.retracts |= stretch.asked.retracts;
            if by_m.abs() < BEYOND_NOISE * channel.noise {
                continue;
            }
            all_m += by_m.abs();
            let is_asked = if by_m > 0.0 { stretch.asked.extends } else { stretch.asked.retracts };
            if is_asked {
                asked_m += by_m.abs();
                asked_s += took_s;
                continue;
            }
            let goes_against = stretch.asked.extends || stretch.asked.retracts;
            *(if goes_against { &mut against_m } else { &mut at_neutral_m }) += by_m.abs();
            apart_s += took_s;
            extends |= by_m > 0.0;
            retracts |= by_m < 0.0;
            if longest.is_none_or(|(longest_m, ..)| by_m.abs() > longest_m) {
                longest = Some((by_m.abs(), case, stretch));
            }
        }
    }
    let (_, case, stretch) = longest?;
    let apart_m = at_neutral_m + against_m;
    let is_fast = asked_s <= 0.0 || apart_m / apart_s > OF_SPEED * asked_m / asked_s;
    let is_never_asked = (!extends || !asks.extends) && (!retracts || !asks.retracts);
    (is_fast && apart_m > OF_ALL_WAY * all_m).then(|| Uncommanded {
        all_m,
        at_neutral_m,
        against_m,
        only_retracts: !extends,
        is_never_asked,
        recording: case.name.clone(),
        from_s: case.time_s[stretch.from],
        to_s: case.time_s[stretch.to],
    })
}

/// How long the rod takes from a tenth to nine tenths of its way in a stretch, and a quarter more, s.
fn took_s(case: &Prepared, position_m: &[f64], stretch: &Stretch) -> f64 {
    let (start_m, end_m) = (position_m[stretch.from], position_m[stretch.to]);
    let tenth_m = 0.1 * (end_m - start_m).abs();
    let is_away = |row: &usize, from_m: f64| (position_m[*row] - from_m).abs() > tenth_m;
    let rows = stretch.from..=stretch.to;
    let leaves = rows.clone().find(|row| is_away(row, start_m)).unwrap_or(stretch.from);
    let arrives = rows.rev().find(|row| is_away(row, end_m)).unwrap_or(stretch.to).max(leaves);
    1.25 * (case.time_s[arrives] - case.time_s[leaves])
}

/// The largest fall of the supply pressure while the command is at neutral.
fn sag(case: &Prepared, stretches: &[Stretch], supply_pa: &[f64]) -> Option<SupplySag> {
    let scatter_pa = noise(supply_pa, resolution(supply_pa));
    let mean_pa = supply_pa.iter().sum::<f64>() / supply_pa.len() as f64;
    let least_pa = (SAGS_BY * mean_pa).max(2.0 * BEYOND_NOISE * scatter_pa);
    let mut found: Option<SupplySag> = None;
    for stretch in stretches.iter().filter(|stretch| stretch.asked == Asked::default()) {
        let mut high = stretch.from;
        for row in stretch.from..=stretch.to.min(supply_pa.len() - 1) {
            if supply_pa[row] > supply_pa[high] {
                high = row;
            }
            let by_pa = supply_pa[high] - supply_pa[row];
            if by_pa > least_pa && found.as_ref().is_none_or(|found| by_pa > found.by_pa) {
                let (from_s, to_s) = (case.time_s[high], case.time_s[row]);
                found = Some(SupplySag { recording: case.name.clone(), from_s, to_s, by_pa });
            }
        }
    }
    found
}
