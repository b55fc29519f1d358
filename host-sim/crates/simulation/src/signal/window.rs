//! Short windows with a smooth bump as weight, over which balances are integrated.

/// Length of a window, s: longer than the noise of a tick, shorter than the start of a stroke.
pub const WINDOW_S: f64 = 0.05;
/// Fewest rows of a window.
const LEAST_ROWS: usize = 9;

/// Number of rows in this many seconds: at least 1.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive count")]
pub fn rows_in(time_s: &[f64], span_s: f64) -> usize {
    let interval_s = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1).max(1) as f64;
    (span_s / interval_s).round().clamp(1.0, 1e6) as usize
}

/// The sum of the values before each row, and of all values.
pub fn running_sums(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut sums = vec![0.0];
    for value in values {
        sums.push(sums[sums.len() - 1] + value);
    }
    sums
}

/// A bump over a few rows: weights of the value, of its first and of its second derivative.
#[derive(Clone, Debug)]
pub struct Window {
    /// First row.
    pub from: usize,
    /// φ, −φ′ and φ″ at each row, times the row's share of time; both derivatives are differences.
    weights: Vec<[f64; 3]>,
}

impl Window {
    /// Windows that overlap by half, over a whole recording.
    #[must_use]
    pub fn over(time_s: &[f64], window_s: f64) -> Vec<Self> {
        use std::f64::consts::TAU;
        let rows = rows_in(time_s, window_s).max(LEAST_ROWS);
        let last = time_s.len().saturating_sub(rows);
        (0..last)
            .step_by((rows / 2).max(1))
            .map(|from| {
                let (start, span) = (time_s[from], time_s[from + rows] - time_s[from]);
                let bump = |row: usize| 0.5 * (1.0 - libm::cos(TAU * (time_s[row] - start) / span));
                // Differences of the bump, not its derivatives: summed by parts they are differences of the signal.
                let weights = (from..=from + rows)
                    .map(|row| {
                        let (before, after) = (row.max(from + 1) - 1, (row + 1).min(from + rows));
                        let slope = |one: usize, other: usize| {
                            if one == other { 0.0 } else { (bump(other) - bump(one)) / (time_s[other] - time_s[one]) }
                        };
                        let share = 0.5 * (time_s[after] - time_s[before]);
                        [share * bump(row), -0.5 * (bump(after) - bump(before)), slope(row, after) - slope(before, row)]
                    })
                    .collect();
                Self { from, weights }
            })
            .collect()
    }

    /// Last row.
    #[must_use]
    pub fn to(&self) -> usize {
        self.from + self.weights.len() - 1
    }

    /// The row in the middle.
    #[must_use]
    pub fn middle(&self) -> usize {
        self.from + self.weights.len() / 2
    }

    fn weighed(&self, values: &[f64], derivative: usize) -> f64 {
        // A constant has no derivative; with it subtracted, rounding of the weights' sum does not matter.
        let off = if derivative == 0 { 0.0 } else { values[self.middle()] };
        self.weights.iter().zip(&values[self.from..]).map(|(weight, value)| weight[derivative] * (value - off)).sum()
    }

    /// ∫φ·z dt.
    #[must_use]
    pub fn sum(&self, values: &[f64]) -> f64 {
        self.weighed(values, 0)
    }

    /// ∫φ·ż dt.
    #[must_use]
    pub fn change(&self, values: &[f64]) -> f64 {
        self.weighed(values, 1)
    }

    /// ∫φ·z̈ dt.
    #[must_use]
    pub fn curvature(&self, values: &[f64]) -> f64 {
        self.weighed(values, 2)
    }

    /// Variance that white noise causes in a combination of value, first and second derivative, each with a factor per row.
    pub fn variance(&self, factors: impl Fn(usize) -> [f64; 3]) -> f64 {
        self.weights
            .iter()
            .enumerate()
            .map(|(index, weight)| {
                let by = factors(self.from + index);
                (weight[0] * by[0] + weight[1] * by[1] + weight[2] * by[2]).powi(2)
            })
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_changes_and_curves_as_its_derivatives_say() {
        let time_s: Vec<f64> = (0..200).map(|row| f64::from(row) * 1e-3).collect();
        let values: Vec<f64> = time_s.iter().map(|t| 3.0 + 2.0 * t + 5.0 * t * t).collect();
        let ones = vec![1.0; 200];
        for window in Window::over(&time_s, WINDOW_S) {
            let weight = window.sum(&ones);
            let middle = time_s[window.middle()];
            assert!((weight - 0.5 * WINDOW_S).abs() < 1e-9);
            assert!((window.change(&values) / weight - (2.0 + 10.0 * middle)).abs() < 1e-6);
            assert!((window.curvature(&values) / weight - 10.0).abs() < 1e-6);
        }
    }
}
