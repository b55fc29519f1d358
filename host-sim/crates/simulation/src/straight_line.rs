//! The straight line through some rows of a channel, and what its noise leaves uncertain of it.

use crate::signal::noise::{noise, resolution};

/// Most rows from which the noise is estimated: the same for a whole recording and for its first part.
const ROWS_OF_NOISE: usize = 1000;
/// A slope that is that many standard deviations from 0 is none of noise: once in sixteen thousand recordings.
const SLOPE_BEYOND_NOISE: f64 = 4.0;

/// Noise of a channel from its first rows.
pub(crate) fn noise_of(values: &[f64]) -> f64 {
    let values = &values[..values.len().min(ROWS_OF_NOISE)];
    noise(values, resolution(values))
}

/// The line by least squares.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) mean: f64,
    pub(crate) slope: f64,
    /// Where it is at the first of its rows.
    pub(crate) at_start: f64,
    /// How uncertain the mean of its rows is.
    pub(crate) mean_std: f64,
    /// How uncertain its slope is.
    pub(crate) slope_std: f64,
    middle_s: f64,
}

impl Line {
    /// Through rows of a channel with this noise.
    pub(crate) fn through(time_s: &[f64], values: &[f64], noise: f64) -> Self {
        let count = values.len() as f64;
        let (middle_s, mean) = (time_s.iter().sum::<f64>() / count, values.iter().sum::<f64>() / count);
        let spread: f64 = time_s.iter().map(|time| (time - middle_s).powi(2)).sum();
        let slope =
            time_s.iter().zip(values).map(|(time, value)| (time - middle_s) * (value - mean)).sum::<f64>() / spread;
        Self {
            mean,
            slope,
            at_start: mean + slope * (time_s[0] - middle_s),
            mean_std: noise / count.sqrt(),
            slope_std: noise / spread.sqrt(),
            middle_s,
        }
    }

    /// Where it is at a time.
    pub(crate) fn at(&self, time_s: f64) -> f64 {
        self.mean + self.slope * (time_s - self.middle_s)
    }

    /// How uncertain that is.
    pub(crate) fn std_at(&self, time_s: f64) -> f64 {
        libm::hypot(self.mean_std, self.slope_std * (time_s - self.middle_s))
    }

    /// The slope, where it is not one of noise; else 0.
    pub(crate) fn clear_slope(&self) -> f64 {
        if self.slope.abs() > SLOPE_BEYOND_NOISE * self.slope_std { self.slope } else { 0.0 }
    }
}
