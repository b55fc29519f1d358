//! Residuals over noise, their derivatives and their loss.

use model_core::machine::{Machine, MachineError};
use recording::Signal;
use simulation::{InputPoint, Run, run_in_lanes};

use super::initial_state::StartState;
use super::{Fit, FitError};
use crate::experiment::{JudgedSignal, Prepared};

/// Residuals beyond this many times a channel's tolerance count linearly, not by their square.
const HUBER: f64 = 5.0;

/// The residual whose square is the pseudo-Huber loss of `residual`, and its derivative.
#[must_use]
pub fn soft(residual: f64, tolerance: f64) -> (f64, f64) {
    let share = residual / (HUBER * tolerance);
    let root = (1.0 + share * share).sqrt();
    // 2·(root − 1) = share² · 2/(root + 1), which loses nothing where the residual is small.
    let divisor = (0.5 * (root + 1.0)).sqrt();
    (residual / divisor, divisor / root)
}

/// Residuals as their squares enter the loss: [`standardised`], softened.
pub fn softened(machine: &Machine<f64>, case: &Prepared, start: StartState) -> Result<Vec<Vec<f64>>, MachineError> {
    Ok(softened_all(machine, [(case, start)])?.swap_remove(0))
}

/// The same for several recordings.
pub fn softened_all<'a>(
    machine: &Machine<f64>,
    cases: impl IntoIterator<Item = (&'a Prepared, StartState)>,
) -> Result<Residuals, MachineError> {
    let cases: Vec<(&Prepared, StartState)> = cases.into_iter().collect();
    let mut all = standardised_all(machine, cases.iter().copied())?;
    for ((case, _), all) in cases.iter().zip(&mut all) {
        soften(case, all);
    }
    Ok(all)
}

/// Softens the residuals of a recording.
pub fn soften(case: &Prepared, residuals: &mut [Vec<f64>]) {
    for (channel, series) in case.channels.iter().zip(residuals) {
        for residual in series {
            *residual = soft(*residual, channel.tolerance).0;
        }
    }
}

/// Sets the tolerance of every channel by a model's residuals on all recordings: their root mean square over the noise.
pub fn set_tolerances(
    machine: &Machine<f64>,
    cases: &mut [Prepared],
    starts: &[StartState],
) -> Result<(), MachineError> {
    let misfits = misfits(machine, cases.iter().zip(starts.iter().copied()))?;
    for channel in cases.iter_mut().flat_map(|case| &mut case.channels) {
        let found = misfits.iter().find(|misfit| misfit.signal == channel.signal);
        channel.tolerance = found.map_or(1.0, |misfit| misfit.mean_square().sqrt().max(1.0));
    }
    Ok(())
}

/// A first fit, with the tolerances that the nominal machine leaves; then sets those that the fit leaves.
pub fn with_channel_tolerances(
    machine: &Machine<f64>,
    cases: &mut [Prepared],
    search: impl FnOnce(&[&Prepared]) -> Result<Fit, FitError>,
) -> Result<Fit, FitError> {
    set_tolerances(machine, cases, &vec![StartState::default(); cases.len()])?;
    let fit = search(&cases.iter().collect::<Vec<_>>())?;
    set_tolerances(&fit.machine, cases, &fit.starts)?;
    Ok(fit)
}

/// Misfit of a machine in one signal over several recordings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// The signal.
    pub signal: Signal,
    /// Sum of its squared residuals over noise.
    pub square: f64,
    /// Rows that were judged.
    pub rows: f64,
}

impl Misfit {
    /// Mean square of its residuals over noise; 0 where no row was judged.
    #[must_use]
    pub fn mean_square(&self) -> f64 {
        self.square / self.rows.max(1.0)
    }
}

/// Misfit of a machine in each judged signal of these recordings together, each from its initial state.
pub fn misfits<'a>(
    machine: &Machine<f64>,
    cases: impl IntoIterator<Item = (&'a Prepared, StartState)>,
) -> Result<Vec<Misfit>, MachineError> {
    let cases: Vec<(&Prepared, StartState)> = cases.into_iter().collect();
    let residuals = standardised_all(machine, cases.iter().copied())?;
    Ok(misfits_of(cases.iter().map(|(case, _)| *case), &residuals))
}

/// The same of residuals that are known.
pub fn misfits_of<'a>(cases: impl IntoIterator<Item = &'a Prepared>, residuals: &Residuals) -> Vec<Misfit> {
    let mut misfits: Vec<Misfit> = Vec::new();
    for (case, all) in cases.into_iter().zip(residuals) {
        for (channel, series) in case.channels.iter().zip(all) {
            let (signal, square, rows) = (channel.signal, loss(series), series.len() as f64);
            match misfits.iter_mut().find(|misfit| misfit.signal == signal) {
                Some(misfit) => (misfit.square, misfit.rows) = (misfit.square + square, misfit.rows + rows),
                None => misfits.push(Misfit { signal, square, rows }),
            }
        }
    }
    misfits
}

/// Residuals over noise: for each recording one series per channel.
pub type Residuals = Vec<Vec<Vec<f64>>>;

/// Residuals of a machine on one recording, each over its channel's noise: one series for each channel, only of the rows
/// in which its sensor worked. The other rows, counted as residual 0, would make every mean too small.
pub fn standardised(machine: &Machine<f64>, case: &Prepared, start: StartState) -> Result<Vec<Vec<f64>>, MachineError> {
    Ok(standardised_all(machine, [(case, start)])?.swap_remove(0))
}

/// The same for several recordings.
pub fn standardised_all<'a>(
    machine: &Machine<f64>,
    cases: impl IntoIterator<Item = (&'a Prepared, StartState)>,
) -> Result<Residuals, MachineError> {
    let cases: Vec<(&Prepared, StartState)> = cases.into_iter().collect();
    let room = |(case, _): &(&Prepared, StartState)| {
        case.channels.iter().map(|_| Vec::with_capacity(case.time_s.len())).collect::<Vec<Vec<f64>>>()
    };
    let mut all: Residuals = cases.iter().map(room).collect();
    run_in_lanes(machine, &runs(machine, cases.iter().copied()), &mut |run, row, values| {
        for ((channel, value), series) in cases[run].0.channels.iter().zip(values).zip(&mut all[run]) {
            if !channel.failed[row] {
                series.push(missed(channel, row, Some(*value)));
            }
        }
    })?;
    Ok(all)
}

/// What runs yield at some of their rows, SI: one vector each, row by row; 0 for what the model does not compute.
pub(crate) fn simulated(
    machine: &Machine<f64>,
    runs: &[Run<'_>],
    keeps: impl Fn(usize) -> bool,
) -> Result<Vec<Vec<f64>>, MachineError> {
    let mut simulated = vec![Vec::new(); runs.len()];
    run_in_lanes(machine, runs, &mut |run, row, values| {
        if keeps(row) {
            simulated[run].extend_from_slice(values);
        }
    })?;
    Ok(simulated)
}

/// Runs of the judged channels of recordings.
pub(crate) fn runs<'a>(
    machine: &Machine<f64>,
    cases: impl Iterator<Item = (&'a Prepared, StartState)>,
) -> Vec<Run<'a>> {
    let run = |(case, start): (&'a Prepared, StartState)| {
        case.effort.simulated(case.stimulus.ticks());
        Run {
            stimulus: &case.stimulus,
            offset: start.offset(machine, case),
            signals: case.channels.iter().map(|channel| channel.signal).collect(),
        }
    };
    cases.map(run).collect()
}

/// Recorded minus simulated over noise; 0 where the sensor failed.
pub(crate) fn missed(channel: &JudgedSignal, row: usize, simulated: Option<f64>) -> f64 {
    match simulated {
        Some(simulated) if !channel.failed[row] => (channel.recorded[row] - simulated) / channel.noise,
        _ => 0.0,
    }
}

/// How many independent samples a correlated series is worth: n·(1 − r)/(1 + r) with r its correlation at lag one.
#[must_use]
pub fn effective_samples(series: &[f64]) -> f64 {
    let square: f64 = series.iter().map(|value| value * value).sum();
    let lagged: f64 = series.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let r = if square > 0.0 { (lagged / square).clamp(0.0, 1.0 - 1.0 / series.len() as f64) } else { 0.0 };
    (series.len() as f64 * (1.0 - r) / (1.0 + r)).max(1.0)
}

/// The same by the means of blocks, each twice as long as the last, down to sixteen of them (Flyvbjerg and Petersen 1989), if that
/// gives fewer samples: a smooth part beneath independent noise hardly shows in the correlation at lag one.
pub fn samples_by_blocks(series: &[f64]) -> f64 {
    /// With fewer blocks their mean square is not reliable.
    const FEWEST: usize = 16;
    let mean_square = |of: &[f64]| loss(of) / of.len() as f64;
    let (mut blocks, mut rows, mut most) = (series.to_vec(), 1.0, 0.0_f64);
    while blocks.len() >= 2 * FEWEST {
        blocks = blocks.chunks_exact(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        rows *= 2.0;
        most = most.max(rows * mean_square(&blocks));
    }
    let samples = effective_samples(series);
    if most > 0.0 { (loss(series) / most).clamp(1.0, samples) } else { samples }
}

/// How many times more rows there are than independent samples.
#[must_use]
pub fn inflation(residuals: &Residuals, counts: Counts) -> f64 {
    let (mut rows, mut independent) = (0.0, 0.0);
    for series in residuals.iter().flatten() {
        rows += series.len() as f64;
        independent += counts(series);
    }
    rows / independent
}

/// How the independent samples of a residual are counted.
pub type Counts = fn(&[f64]) -> f64;

/// How they are counted in recordings that drive the model at this input point. If a sensor's signal drives the model,
/// its noise is integrated: the residual then has a smooth part beneath the independent noise of the judged signal.
pub fn counts_from(input_point: InputPoint) -> Counts {
    if input_point.is_set() { effective_samples } else { samples_by_blocks }
}

/// The sum of the squares of a series; of softened residuals, their loss.
#[must_use]
pub fn loss(residuals: &[f64]) -> f64 {
    residuals.iter().map(|residual| residual * residual).sum()
}

#[cfg(test)]
mod tests;
