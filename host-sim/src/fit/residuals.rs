//! Residuals over noise, their derivatives and their loss.

use model_core::machine::{Machine, MachineError};
use rayon::prelude::*;

use crate::dual::Dual;
use crate::prepare::{Channel, Prepared};
use crate::simulate::{StartOffset, run};

/// Residuals beyond this many standard deviations of noise count linearly, not by their square.
const HUBER: f64 = 5.0;

/// The residual whose square is the pseudo-Huber loss of `residual`, and its derivative.
pub(super) fn soft(residual: f64) -> (f64, f64) {
    let root = (1.0 + (residual / HUBER).powi(2)).sqrt();
    let value = HUBER * (2.0 * (root - 1.0)).sqrt();
    if residual.abs() < 1e-6 {
        return (residual, 1.0);
    }
    (value.copysign(residual), residual.abs() / (root * value))
}

/// Runs of the core over cases.
pub(super) struct Evaluation;

impl Evaluation {
    /// Residuals of all cases, each over its noise, without loss and prior.
    pub(super) fn values(
        machine: &Machine<f64>,
        levels: &[f64],
        cases: &[&Prepared],
    ) -> Result<Vec<Vec<f64>>, MachineError> {
        cases.par_iter().zip(levels).map(|(case, &level)| Self::residuals(machine, level, case)).collect()
    }

    pub(super) fn residuals(machine: &Machine<f64>, level: f64, case: &Prepared) -> Result<Vec<f64>, MachineError> {
        let mut residuals = vec![0.0; case.channels.len() * case.time_s.len()];
        let offset = StartOffset { level };
        run::<f64>(machine, &case.stimulus, offset, |row, sample| {
            for (channel, residual) in case.channels.iter().zip(residuals.iter_mut().skip(row * case.channels.len())) {
                *residual = missed(channel, row, sample.signal(channel.signal));
            }
        })?;
        Ok(residuals)
    }

    /// Residuals with their derivatives by the slots' coordinates, row by row.
    pub(super) fn duals<const P: usize>(
        machine: &Machine<Dual<P>>,
        level: Dual<P>,
        case: &Prepared,
    ) -> Result<Vec<(f64, [f64; P])>, MachineError> {
        let mut residuals = vec![(0.0, [0.0; P]); case.channels.len() * case.time_s.len()];
        run::<Dual<P>>(machine, &case.stimulus, StartOffset { level }, |row, sample| {
            for (channel, residual) in case.channels.iter().zip(residuals.iter_mut().skip(row * case.channels.len())) {
                if let Some(simulated) = sample.signal(channel.signal) {
                    residual.0 = missed(channel, row, Some(simulated.value));
                    residual.1 = simulated.partials.map(|partial| -partial / channel.noise);
                }
            }
        })?;
        Ok(residuals)
    }
}

/// Recorded minus simulated over noise.
fn missed(channel: &Channel, row: usize, simulated: Option<f64>) -> f64 {
    simulated.map_or(0.0, |simulated| (channel.recorded[row] - simulated) / channel.noise)
}

/// How many independent samples a correlated series is worth: n·(1 − r)/(1 + r) with r its correlation at lag one.
pub(crate) fn effective_samples(series: &[f64]) -> f64 {
    let square: f64 = series.iter().map(|value| value * value).sum();
    let lagged: f64 = series.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let r = if square > 0.0 { (lagged / square).clamp(0.0, 1.0 - 1.0 / series.len() as f64) } else { 0.0 };
    (series.len() as f64 * (1.0 - r) / (1.0 + r)).max(1.0)
}
