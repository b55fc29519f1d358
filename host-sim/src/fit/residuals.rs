//! Residuals over noise, their derivatives and their loss.

use model_core::machine::{Machine, MachineError};

use super::start::StartState;
use crate::prepare::{Channel, Prepared};
use crate::recording::Signal;
use crate::simulate::run;

/// Residuals beyond this many times a channel's tolerance count linearly, not by their square.
const HUBER: f64 = 5.0;

/// The residual whose square is the pseudo-Huber loss of `residual`, and its derivative.
#[must_use]
pub fn soft(residual: f64, tolerance: f64) -> (f64, f64) {
    let limit = HUBER * tolerance;
    if residual.abs() < 1e-6 * limit {
        return (residual, 1.0);
    }
    let root = (1.0 + (residual / limit).powi(2)).sqrt();
    let value = limit * (2.0 * (root - 1.0)).sqrt();
    (value.copysign(residual), residual.abs() / (root * value))
}

/// Residuals as their squares enter the loss: [`standardised`], softened.
pub fn softened(machine: &Machine<f64>, case: &Prepared, start: StartState) -> Result<Vec<Vec<f64>>, MachineError> {
    let mut all = standardised(machine, case, start)?;
    for (channel, series) in case.channels.iter().zip(&mut all) {
        for residual in series {
            *residual = soft(*residual, channel.tolerance).0;
        }
    }
    Ok(all)
}

/// Gives every channel the tolerance that a model's residuals on all recordings ask for: their root mean square over the noise.
pub fn set_tolerances(
    machine: &Machine<f64>,
    cases: &mut [Prepared],
    starts: &[StartState],
) -> Result<(), MachineError> {
    let mut sums: Vec<(Signal, f64, f64)> = Vec::new();
    for (case, start) in cases.iter().zip(starts) {
        for (channel, series) in case.channels.iter().zip(standardised(machine, case, *start)?) {
            let square: f64 = series.iter().map(|residual| residual * residual).sum();
            match sums.iter_mut().find(|(signal, ..)| *signal == channel.signal) {
                Some(sum) => (sum.1, sum.2) = (sum.1 + square, sum.2 + series.len() as f64),
                None => sums.push((channel.signal, square, series.len() as f64)),
            }
        }
    }
    let tolerances: Vec<_> =
        sums.into_iter().map(|(signal, square, rows)| (signal, (square / rows).sqrt().max(1.0))).collect();
    for channel in cases.iter_mut().flat_map(|case| &mut case.channels) {
        let found = tolerances.iter().find(|(signal, _)| *signal == channel.signal);
        channel.tolerance = found.map_or(1.0, |(_, tolerance)| *tolerance);
    }
    Ok(())
}

/// Residuals of a machine on one recording, each over its channel's noise: one series for each channel. A row whose sensor
/// failed misses nothing.
pub fn standardised(machine: &Machine<f64>, case: &Prepared, start: StartState) -> Result<Vec<Vec<f64>>, MachineError> {
    let mut series: Vec<Vec<f64>> = case.channels.iter().map(|_| vec![0.0; case.time_s.len()]).collect();
    run::<f64>(machine, &case.stimulus, start.offset(machine, case), |row, sample| {
        for (channel, series) in case.channels.iter().zip(series.iter_mut()) {
            series[row] = missed(channel, row, sample.signal(channel.signal));
        }
    })?;
    Ok(series)
}

/// Recorded minus simulated over noise.
pub(super) fn missed(channel: &Channel, row: usize, simulated: Option<f64>) -> f64 {
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

/// The loss of a series of softened residuals.
#[must_use]
pub fn loss(softened: &[f64]) -> f64 {
    softened.iter().map(|residual| residual * residual).sum()
}
