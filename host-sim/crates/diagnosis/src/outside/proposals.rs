//! Forces from outside that would explain most of a misfit, each kind's best, by linear responses at a solution.

use std::f64::consts::TAU;

use identification::experiment::Prepared;
use identification::fit::{FitError, Sensitivity};
use identification::parallel;
use model_core::machine::Machine;

use super::shape::{NODES, PERIODIC_HZ, STRUCTURE_HZ, Shape, Window};
use super::{Force, directions, unit};

/// Longest push, as a share of the nodes of a recording: what lasts longer is no push.
const LONGEST_PUSH: usize = NODES / 4;
/// The shortest push that gains this share of what the best one gains is taken.
const ENOUGH_OF_BEST: f64 = 0.95;
/// A push in another recording has to gain this share of what the first one gains.
const FURTHER_PUSH: f64 = 0.1;
/// Least number of periods in the shortest recording.
const FEWEST_PERIODS: f64 = 4.0;
/// Two frequencies are told apart where they differ by this share of a period over a recording.
const FREQUENCY_STEP: f64 = 0.4;
/// Share of a command's variance at a frequency from which a period is the command's own.
const COMMANDED_FROM: f64 = 0.3;
/// Peaks of each channel's spectrum that are tried.
const PEAKS_TRIED: usize = 8;
/// Frequencies of a structure that are tried.
const STRUCTURES: usize = 80;
/// Dampings of a structure.
const STRUCTURE_DAMPING: [f64; 2] = [0.02, 0.08];
/// A wave has to have this many ticks a period.
const TICKS_A_PERIOD: f64 = 8.0;
/// And this many rows: with fewer a slower one looks the same.
const ROWS_A_PERIOD: f64 = 2.5;

/// A force with the gain that is expected of it.
pub(super) struct Proposal {
    pub(super) force: Force,
    pub(super) gain: f64,
}

/// What is sought.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Sought {
    /// What happens once: pushes.
    Pushes,
    /// Every force that is given in time.
    InTime,
    /// Also what the recorded motion drives.
    All,
}

/// The best of each kind that is sought.
pub(super) fn proposals(
    machine: &Machine<f64>,
    sensitivity: &Sensitivity<'_>,
    cases: &[&Prepared],
    sought: Sought,
) -> Result<Vec<Proposal>, FitError> {
    let at = |shape: Shape| -> Result<Proposal, FitError> {
        let (unit, amounts, positive) = (unit(machine, &shape), shape.amounts(cases.len()), shape.is_positive());
        let all = directions(sensitivity, shape.units(cases), unit, amounts, cases.len())?;
        let directed = sensitivity.directed(&all);
        let (mut steps, _) = directed.amounts(&vec![positive; amounts]);
        for step in &mut steps {
            *step = step.min(shape.most(machine) / unit);
        }
        let gain = directed.gain_of(&steps);
        let amounts = steps.into_iter().map(|step| unit * step).collect();
        Ok(Proposal { force: Force { shape, amounts }, gain })
    };
    let best_of = |shapes: Vec<Shape>| -> Result<Option<Proposal>, FitError> {
        let all = parallel::try_each(shapes, at)?;
        Ok(all.into_iter().max_by(|a, b| a.gain.total_cmp(&b.gain)))
    };
    let mut found: Vec<Proposal> = Vec::new();
    let windows = pushes(machine, sensitivity, cases)?;
    if !windows.is_empty() {
        found.push(at(Shape::Pushes(windows))?);
    }
    if sought == Sought::Pushes {
        return Ok(found);
    }
    if cases.len() > 1 {
        found.push(at(Shape::Load)?);
    }
    let hertz = standing_out(sensitivity, cases);
    found.extend(best_of(hertz.into_iter().map(|hz| Shape::Periodic { hz }).collect())?);
    if sought == Sought::All {
        found.extend(best_of(structures(cases))?);
    }
    Ok(found)
}

/// Where a push explains most: at most one in a recording, in no more than half of the recordings. What happens in more of them is no accident.
fn pushes(machine: &Machine<f64>, sensitivity: &Sensitivity<'_>, cases: &[&Prepared]) -> Result<Vec<Window>, FitError> {
    let in_case = |case: usize| -> Result<Option<(Window, f64)>, FitError> {
        let shape = Shape::Pushes(vec![Window { case, first: 0, last: NODES }]);
        let unit = unit(machine, &shape);
        let all = directions(sensitivity, shape.units(cases), unit, shape.amounts(cases.len()), cases.len())?;
        let directed = sensitivity.directed(&all);
        let gain = |first: usize, last: usize| {
            directed.amounts_of(&(first..=last).collect::<Vec<_>>()).map_or(0.0, |(_, gain)| gain)
        };
        let windows = (1..=LONGEST_PUSH).map(|nodes| {
            let each = (0..=NODES + 1 - nodes).map(|first| (first, first + nodes - 1));
            let gains = each.map(|(first, last)| (Window { case, first, last }, gain(first, last)));
            gains.max_by(|a, b| a.1.total_cmp(&b.1))
        });
        let best_of_length: Vec<(Window, f64)> = windows.flatten().collect();
        let most = best_of_length.iter().map(|(_, gain)| *gain).fold(0.0, f64::max);
        Ok(best_of_length.into_iter().find(|(_, gain)| *gain >= ENOUGH_OF_BEST * most))
    };
    let mut found: Vec<(Window, f64)> = parallel::try_each(0..cases.len(), in_case)?.into_iter().flatten().collect();
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    let first = found.first().map_or(0.0, |(_, gain)| *gain);
    let kept = found.into_iter().filter(|(_, gain)| *gain > FURTHER_PUSH * first).take((cases.len() / 2).max(1));
    Ok(kept.map(|(window, _)| window).collect())
}

/// Frequencies that are told apart in these recordings.
fn frequencies(cases: &[&Prepared]) -> Vec<f64> {
    let shortest_s = cases.iter().map(|case| case.duration_s()).fold(f64::INFINITY, f64::min);
    let longest_s = cases.iter().map(|case| case.duration_s()).fold(0.0, f64::max);
    let (least, most) = (PERIODIC_HZ.0.max(FEWEST_PERIODS / shortest_s), fastest_hz(cases, PERIODIC_HZ.1));
    let step = FREQUENCY_STEP / longest_s;
    std::iter::successors(Some(least), |hz| Some(hz + step)).take_while(|hz| *hz < most).collect()
}

/// Those at which some channel's residual has the most power, each higher than its neighbours, and that the command does not have itself. A rod that is
/// shaken moves the less the faster, and the power falls with the frequency anyway: it counts by its square.
fn standing_out(sensitivity: &Sensitivity<'_>, cases: &[&Prepared]) -> Vec<f64> {
    let hertz = frequencies(cases);
    let power = sensitivity.power_at(&hertz);
    let mut found: Vec<usize> = Vec::new();
    for channel in 0..power.first().map_or(0, Vec::len) {
        let weighed: Vec<f64> = power.iter().zip(&hertz).map(|(power, hz)| power[channel] * hz * hz).collect();
        let mut peaks: Vec<usize> = (0..weighed.len())
            .filter(|&at| {
                let around = &weighed[at.saturating_sub(1)..(at + 2).min(weighed.len())];
                around.iter().all(|other| *other <= weighed[at])
            })
            .collect();
        peaks.sort_by(|a, b| weighed[*b].total_cmp(&weighed[*a]));
        found.extend(peaks.into_iter().filter(|&at| !is_commanded(cases, hertz[at])).take(PEAKS_TRIED));
    }
    found.sort_unstable();
    found.dedup();
    found.into_iter().map(|at| hertz[at]).collect()
}

/// Whether a command has a frequency itself, or a half or a third of it: a misfit has harmonics of what the command has.
fn is_commanded(cases: &[&Prepared], hz: f64) -> bool {
    let has = |case: &&Prepared| {
        let (series, tick_s) = (case.stimulus.driving(), case.stimulus.tick.seconds());
        [1.0, 2.0, 3.0].into_iter().any(|order| share_at(series, hz / order * tick_s) > COMMANDED_FROM)
    };
    cases.iter().any(has)
}

/// The highest frequency that the recordings' grid and their rows can follow.
fn fastest_hz(cases: &[&Prepared], most_hz: f64) -> f64 {
    let tick_s = cases.iter().map(|case| case.stimulus.tick.seconds()).fold(0.0, f64::max);
    let row_s = cases.iter().map(|case| case.duration_s() / case.rows().max(1) as f64).fold(0.0, f64::max);
    most_hz.min(1.0 / (TICKS_A_PERIOD * tick_s)).min(1.0 / (ROWS_A_PERIOD * row_s))
}

/// Share of a series' variance that a line of this many cycles a value holds.
fn share_at(series: &[f64], cycles: f64) -> f64 {
    let mean = series.iter().sum::<f64>() / series.len().max(1) as f64;
    let (mut cosine, mut sine, mut square) = (0.0, 0.0, 0.0);
    for (index, value) in series.iter().enumerate() {
        let (angle, value) = (TAU * cycles * index as f64, value - mean);
        cosine += value * libm::cos(angle);
        sine += value * libm::sin(angle);
        square += value * value;
    }
    if square > 0.0 { 2.0 * (cosine * cosine + sine * sine) / (series.len() as f64 * square) } else { 0.0 }
}

/// Structures over their range of frequencies and dampings, as far as the rows can show them: none where they are too slow for the slowest.
fn structures(cases: &[&Prepared]) -> Vec<Shape> {
    let (low, high) = (STRUCTURE_HZ.0, fastest_hz(cases, STRUCTURE_HZ.1));
    if high <= low {
        return Vec::new();
    }
    // A part of the range has its part of the steps.
    let is_sparse = cases.iter().any(|case| case.is_sparse());
    let part = if is_sparse { libm::log(high / low) / libm::log(STRUCTURE_HZ.1 / low) } else { 1.0 };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of some dozens")]
    let count = ((STRUCTURES as f64 * part).ceil() as usize).max(2);
    let at = move |index: usize| low * libm::pow(high / low, index as f64 / (count - 1) as f64);
    let damped = |hz: f64, is_included: bool| {
        STRUCTURE_DAMPING.map(move |damping| Shape::Structure { hz, damping, is_included })
    };
    (0..count)
        .flat_map(|index| [false, true].into_iter().flat_map(move |is_included| damped(at(index), is_included)))
        .collect()
}
