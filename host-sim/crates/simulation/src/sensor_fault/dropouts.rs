//! Runs of one reading that start or end with a jump.

use recording::Signal;

use super::{FailureKind, Stretch};
use crate::signal::noise::median;

/// Fewest rows that repeat one value and are more than a spike.
const LEAST_ROWS: usize = 4;
/// A jump is at least this many times larger than every change that is no jump.
const JUMP: f64 = 3.0;
/// More jumps than this are normal for the signal.
const MOST_JUMPS: usize = 16;
/// Number of changes needed to show how the signal moves: at least this many for each jump.
const USUAL_CHANGES: usize = 20;
/// An interval of more than this many times the median is a gap in time: a change over it is no jump.
const GAP: f64 = 1.5;
/// A repeated reading is a failure if noise causes it less often than once in this many recordings.
const ONCE_IN: f64 = 1e6;
/// Number of rows in which it is counted how often the noise repeats a reading.
const SEGMENT: usize = 32;

/// Rows from `from` to before `to` with one and the same reading.
#[derive(Clone, Copy)]
struct Run {
    from: usize,
    to: usize,
}

/// Failures of a sensor over several rows; `grain` is the part of any change that noise and resolution cause.
pub(crate) fn stretches(signal: Signal, time_s: &[f64], values: &[f64], spikes: &[bool], grain: f64) -> Vec<Stretch> {
    let changes = changes(time_s, values, spikes);
    let runs = runs(values);
    let Some(least) = least_jump(&changes, &runs, grain) else { return Vec::new() };
    // The jump that leads to a row, with its sign; none leads to the first row, and none leads away from the last.
    let jump = |row: usize| row.checked_sub(1).and_then(|at| changes.get(at)).copied().filter(|by| by.abs() >= least);
    let suspects: Vec<Run> =
        runs.into_iter().filter(|run| jump(run.from).is_some() || jump(run.to).is_some()).collect();
    let repeats = if signal == Signal::Position { 0.0 } else { repeats(values, &suspects) };
    let away = |run: &Run| jump(run.from).zip(jump(run.to)).is_some_and(|(there, back)| there * back < 0.0);
    let mut found = Vec::new();
    // A jump is assigned to one run: a run that it leads to and the next jump leads back from, or else the run that it ends.
    // A run that begins with a jump and goes on smoothly is where the signal really was.
    let mut explained = 0;
    for (index, run) in suspects.iter().enumerate() {
        let begins = jump(run.from).is_some() && explained != run.from;
        let next_is_away = suspects.get(index + 1).is_some_and(|next| next.from == run.to && away(next));
        let kind = if begins && away(run) {
            FailureKind::Dropout
        } else if (jump(run.to).is_some() && !next_is_away) || (begins && run.to == values.len()) {
            FailureKind::Stuck
        } else {
            continue;
        };
        explained = run.to;
        let times = i32::try_from(run.to - run.from - 1).unwrap_or(i32::MAX);
        if repeats.powi(times) * values.len() as f64 * ONCE_IN < 1.0 {
            found.push(Stretch { kind, from: run.from, to: run.to, reading: values[run.from] });
        }
    }
    found
}

/// Change from each row to the next; 0 at a spike and over a gap in time, where the change shows nothing.
fn changes(time_s: &[f64], values: &[f64], spikes: &[bool]) -> Vec<f64> {
    let mut intervals: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let longest = GAP * median(&mut intervals);
    (1..values.len())
        .map(|row| {
            let tells = !spikes[row] && !spikes[row - 1] && time_s[row] - time_s[row - 1] < longest;
            if tells { values[row] - values[row - 1] } else { 0.0 }
        })
        .collect()
}

fn runs(values: &[f64]) -> Vec<Run> {
    let mut runs = Vec::new();
    let mut from = 0;
    for row in 1..=values.len() {
        if row == values.len() || values[row].to_bits() != values[from].to_bits() {
            if row - from >= LEAST_ROWS {
                runs.push(Run { from, to: row });
            }
            from = row;
        }
    }
    runs
}

/// The least change that is a jump: each larger change is at the beginning or end of a run, and every other change is several times
/// smaller. `None` where the changes show no such gap, or where the signal moves so little that they show nothing.
fn least_jump(changes: &[f64], runs: &[Run], grain: f64) -> Option<f64> {
    let mut is_edge = vec![false; changes.len()];
    for run in runs {
        for row in [run.from, run.to] {
            if let Some(edge) = row.checked_sub(1).and_then(|at| is_edge.get_mut(at)) {
                *edge = true;
            }
        }
    }
    let mut sorted: Vec<(f64, bool)> = changes.iter().map(|change| change.abs()).zip(is_edge).collect();
    let usual = sorted.iter().filter(|(size, edge)| *size > 0.0 && !edge).count();
    sorted.sort_by(|a, b| b.0.total_cmp(&a.0));
    let edges = sorted.iter().take_while(|(_, edge)| *edge).count().min(MOST_JUMPS);
    let most = edges.min(usual / USUAL_CHANGES);
    // Other changes count at least as much as the grain of a reading.
    let stands_out = |count: &usize| {
        let others = sorted.get(*count).map_or(0.0, |(size, _)| *size).max(grain);
        sorted[*count - 1].0 > JUMP * others
    };
    (1..=most).rev().find(stands_out).map(|count| sorted[count - 1].0)
}

/// How often a reading repeats the one before, in the rows where it does so most, outside the suspects: 1 for a sensor at
/// rest without noise.
fn repeats(values: &[f64], suspects: &[Run]) -> f64 {
    let touched = |from: usize| suspects.iter().any(|run| run.from < from + SEGMENT && from < run.to);
    (0..values.len().saturating_sub(SEGMENT - 1))
        .step_by(SEGMENT)
        .filter(|from| !touched(*from))
        .map(|from| {
            let same = values[from..from + SEGMENT].windows(2).filter(|pair| pair[0].to_bits() == pair[1].to_bits());
            (same.count() + 1) as f64 / SEGMENT as f64
        })
        .fold(0.0, f64::max)
}
