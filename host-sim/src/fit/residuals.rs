//! Residuals over noise, their derivatives and their loss.

use model_core::machine::{Machine, MachineError};

use super::start::StartState;
use crate::prepare::{Channel, Prepared};
use crate::simulate::run;

/// Residuals beyond this many standard deviations of noise count linearly, not by their square.
const HUBER: f64 = 5.0;

/// The residual whose square is the pseudo-Huber loss of `residual`, and its derivative.
#[must_use]
pub fn soft(residual: f64) -> (f64, f64) {
    if residual.abs() < 1e-6 {
        return (residual, 1.0);
    }
    let root = (1.0 + (residual / HUBER).powi(2)).sqrt();
    let value = HUBER * (2.0 * (root - 1.0)).sqrt();
    (value.copysign(residual), residual.abs() / (root * value))
}

/// Residuals of a machine on one recording, each over its channel's noise: one series for each channel. A row whose sensor
/// failed misses nothing.
pub fn standardised(machine: &Machine<f64>, case: &Prepared, start: StartState) -> Result<Vec<Vec<f64>>, MachineError> {
    let mut series: Vec<Vec<f64>> = case.channels.iter().map(|_| vec![0.0; case.time_s.len()]).collect();
    run::<f64>(machine, &case.stimulus, start.offset(case), |row, sample| {
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

/// The pseudo-Huber loss of a series of residuals over noise: their square where they are small.
#[must_use]
pub fn loss(series: &[f64]) -> f64 {
    series.iter().map(|residual| soft(*residual).0.powi(2)).sum()
}
