//! Doubts about the scale of a signal: a wrong unit, or a factor that was left out.

use recording::{Recording, Signal};
use simulation::InputPoint;

use super::change::Change;
use super::response::{Response, Responses};

/// A signal that moves this many times as far as the model, or as little, has another scale. Parameters from a data sheet are off by tens of per cent,
/// and friction or overlap may take a half of a small motion.
const OFF: f64 = 4.0;
/// Factors of units, and of decimal places that were left out.
const POWERS: [f64; 3] = [10.0, 100.0, 1000.0];
/// Millimetres in an inch.
const INCH: f64 = 25.4;
/// Seconds in a minute.
const MINUTE: f64 = 60.0;
/// Pa in a bar and in a MPa, psi in a bar, and kPa in a psi.
const PRESSURES: [f64; 4] = [1e5, 1e6, 14.504, 6.8948];
/// A factor is tried if it is within this ratio of what was seen.
const NEAR: f64 = 2.0;
/// Rows that are so far apart, s, hold no motion of a drive.
const SLOW_S: f64 = 0.3;
/// A load of more than this many times the force of the supply pressure on the piston cannot be moved or held.
const BEARABLE: f64 = 1.5;

/// Changes to try, and the signals that raise the doubt.
pub(super) fn changes(responses: &Responses) -> (Vec<Vec<Change>>, Vec<Signal>) {
    let off = |signal: Signal| responses.to(signal).filter(|response| is_off(response.ratio));
    let mut found: Vec<Vec<Change>> = Vec::new();
    let mut raise = |change: Vec<Change>| {
        if !found.contains(&change) {
            found.push(change);
        }
    };
    let motion: Vec<Response> = [Signal::Position, Signal::Velocity].into_iter().filter_map(off).collect();
    let spool = off(Signal::Spool);
    let pressures: Vec<Response> = [Signal::PressureA, Signal::PressureB].into_iter().filter_map(off).collect();
    // The measured spool tells more about the command than what moves behind it.
    let driven = if responses.to(Signal::Spool).is_some() { spool } else { motion.first().copied() };
    if let Some(response) = driven {
        let driver = responses.input_point.driving();
        for factor in factors(driver, response.ratio).into_iter().chain(beyond(response.ratio)) {
            raise(vec![Change::Scaled(driver, factor)]);
        }
    }
    if let Some(spool) = spool {
        for factor in factors(Signal::Spool, 1.0 / spool.ratio) {
            raise(vec![Change::Scaled(Signal::Spool, factor)]);
        }
    }
    if let Some(first) = motion.first() {
        for factor in factors(first.signal, 1.0 / first.ratio) {
            raise(motion.iter().map(|response| Change::Scaled(response.signal, factor)).collect());
        }
    }
    if pressures.len() == 2 || (pressures.len() == 1 && both_pressures(responses) == 1) {
        for factor in factors(Signal::PressureA, 1.0 / pressures[0].ratio) {
            raise(vec![Change::Scaled(pressures[0].signal, factor)]);
        }
    }
    let mut signals: Vec<Signal> =
        spool.into_iter().chain(motion).chain(pressures).map(|response| response.signal).collect();
    if responses.load > BEARABLE && responses.input_point != InputPoint::Force {
        for factor in [0.001, 0.1] {
            raise(vec![Change::Scaled(Signal::LoadForce, factor)]);
        }
        if signals.is_empty() {
            signals = responses.each.iter().map(|response| response.signal).collect();
        }
    }
    // A change without which nothing can be simulated goes before all others, and may be enough.
    if !responses.needed.is_empty() {
        found.push(Vec::new());
        let beside = |needed: &Change| found.iter().map(|changes| [&[*needed], changes.as_slice()].concat()).collect();
        found = responses.needed.iter().flat_map(|needed| -> Vec<Vec<Change>> { beside(needed) }).collect();
        let pressures =
            [Signal::PressureA, Signal::PressureB].into_iter().filter(|signal| responses.to(*signal).is_some());
        signals = pressures.chain(signals).collect();
        signals.dedup();
    }
    (found, signals)
}

fn both_pressures(responses: &Responses) -> usize {
    [Signal::PressureA, Signal::PressureB].into_iter().filter(|signal| responses.to(*signal).is_some()).count()
}

/// Times in ms that are taken for s, of recordings whose rows are too far apart for a drive. The signals that raise the doubt: all that may be judged.
pub(super) fn times(recordings: &[&Recording]) -> (Vec<Vec<Change>>, Vec<Signal>) {
    let is_slow = |recording: &&Recording| recording.sample_interval_s() > SLOW_S;
    let moves = [Signal::Spool, Signal::Position, Signal::Velocity, Signal::PressureA, Signal::PressureB];
    let signals: Vec<Signal> =
        moves.into_iter().filter(|signal| recordings.iter().all(|recording| recording.has(*signal))).collect();
    if recordings.is_empty() || signals.is_empty() || !recordings.iter().all(is_slow) {
        return (Vec::new(), Vec::new());
    }
    (vec![vec![Change::Scaled(Signal::Time, 1e-3)]], signals)
}

/// Whether a signal moves much further, or much less, than the model's.
pub(super) fn is_off(ratio: f64) -> bool {
    !(1.0 / OFF..=OFF).contains(&ratio)
}

/// The usual factors of a signal, all above 1.
pub(super) fn factors_of(signal: Signal) -> impl Iterator<Item = f64> {
    let own: &[f64] = match signal {
        Signal::Position => &[INCH],
        Signal::Velocity => &[INCH, MINUTE],
        Signal::PumpSpeed => &[MINUTE, std::f64::consts::TAU],
        Signal::PressureA | Signal::PressureB => &PRESSURES,
        _ => &[],
    };
    POWERS.iter().chain(own).copied()
}

/// Those near a ratio.
fn factors(signal: Signal, ratio: f64) -> Vec<f64> {
    let of = |factor: f64| if ratio < 1.0 { 1.0 / factor } else { factor };
    let near = |factor: &f64| (1.0 / NEAR..=NEAR).contains(&(ratio / factor));
    factors_of(signal).map(of).filter(near).collect()
}

/// Powers of ten beyond a ratio: the overlap of a valve makes a small input smaller, and its end of travel holds back a large one.
fn beyond(ratio: f64) -> Vec<f64> {
    let of = |factor: &f64| if ratio < 1.0 { 1.0 / factor } else { *factor };
    let is_beyond = |factor: &f64| if ratio < 1.0 { *factor < ratio } else { ratio.is_infinite() };
    POWERS.iter().map(of).filter(is_beyond).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factors_near_a_ratio_are_tried_to_both_sides() {
        assert_eq!(factors(Signal::Position, 15.0), [10.0, INCH]);
        assert_eq!(factors(Signal::Command, 1.0 / 900.0), [1e-3]);
        assert_eq!(beyond(f64::INFINITY), [10.0, 100.0, 1000.0]);
        assert_eq!(beyond(0.05), [1e-2, 1e-3]);
        assert!(is_off(f64::INFINITY) && is_off(0.1) && !is_off(0.5) && !is_off(2.0));
    }
}
