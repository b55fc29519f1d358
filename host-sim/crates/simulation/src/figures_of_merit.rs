//! Recorded minus simulated, and the figures of merit of a simulation.

use recording::Signal;

use crate::signal::noise::{noise, resolution};

/// How well one simulated signal follows the recorded one.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SignalFit {
    /// The signal.
    #[serde(skip)]
    pub signal: Signal,
    /// NRMSE fit, %: 100·(1 − ‖y − ŷ‖/‖y − mean y‖). 100 is perfect, 0 no better than the mean.
    pub nrmse_percent: f64,
    /// Coefficient of determination R² = 1 − ‖y − ŷ‖²/‖y − mean y‖².
    pub r_squared: f64,
    /// Root of the mean square error, in the signal's SI unit.
    pub rmse: f64,
    /// Largest error, in the signal's SI unit.
    pub max_error: f64,
    /// Time of the largest error, s.
    pub max_at_s: f64,
    /// RMSE over the noise of the recorded signal; about 1 for a perfect model.
    pub over_noise: f64,
}

impl SignalFit {
    /// Compares two series over the same times.
    ///
    /// A recorded series that never changes has no NRMSE fit: the result is then −∞ or 100; callers check this before.
    #[must_use]
    pub fn of(signal: Signal, time_s: &[f64], recorded: &[f64], simulated: &[f64]) -> Self {
        let mean = recorded.iter().sum::<f64>() / recorded.len() as f64;
        let spread: f64 = recorded.iter().map(|value| (value - mean).powi(2)).sum();
        let square: f64 = residual(recorded, simulated).map(|error| error * error).sum();
        let (max_error, max_at_s) = residual(recorded, simulated)
            .zip(time_s)
            .map(|(error, time)| (error.abs(), *time))
            .fold((0.0, 0.0), |worst, here| if here.0 > worst.0 { here } else { worst });
        let share = if square == 0.0 { 0.0 } else { square / spread };
        let rmse = (square / recorded.len() as f64).sqrt();
        Self {
            signal,
            nrmse_percent: 100.0 * (1.0 - share.sqrt()),
            r_squared: 1.0 - share,
            rmse,
            max_error,
            max_at_s,
            over_noise: rmse / noise(recorded, resolution(recorded)),
        }
    }
}

/// Recorded minus simulated.
pub fn residual<'a>(recorded: &'a [f64], simulated: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    recorded.iter().zip(simulated).map(|(recorded, simulated)| recorded - simulated)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simulation_that_is_the_mean_has_fit_zero_and_a_perfect_one_a_hundred() {
        let (time, recorded) = ([0.0, 1.0, 2.0], [1.0, 2.0, 3.0]);
        let mean = SignalFit::of(Signal::Position, &time, &recorded, &[2.0; 3]);
        assert!(mean.nrmse_percent.abs() < 1e-12 && mean.r_squared.abs() < 1e-12);
        assert!((mean.max_error - 1.0).abs() < 1e-15 && mean.max_at_s == 0.0);
        let perfect = SignalFit::of(Signal::Position, &time, &recorded, &recorded);
        assert!((perfect.nrmse_percent - 100.0).abs() < 1e-12);
    }
}
