//! A sweep divided where its input turns back, and the inputs at which its branches cross a level of the output.

use std::ops::Range;

use simulation::signal::noise::extent;

/// A part of a sweep without a turn.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Its rows.
    pub rows: Range<usize>,
    /// Whether the input rises.
    pub rising: bool,
}

/// A turn counts if the input goes back by this share of its span: a sensor's noise does not.
const TURN: f64 = 0.05;
/// A branch counts if it covers this share of the input's span.
const LEAST_SPAN: f64 = 0.25;

/// The branches of a sweep that are long enough to be read, in the order of their rows.
#[must_use]
pub fn branches(input: &[f64]) -> Vec<Branch> {
    let (low, high) = extent(input);
    let (turn, least) = (TURN * (high - low), LEAST_SPAN * (high - low));
    // Row of the last turn, and of the extremum since.
    let (mut from, mut lowest, mut highest) = (0, 0, 0);
    let mut rising: Option<bool> = None;
    let mut found = Vec::new();
    let mut add = |rows: Range<usize>, rising: bool| {
        if (input[rows.end - 1] - input[rows.start]).abs() >= least && least > 0.0 {
            found.push(Branch { rows, rising });
        }
    };
    for (row, &value) in input.iter().enumerate() {
        if value > input[highest] {
            highest = row;
        }
        if value < input[lowest] {
            lowest = row;
        }
        if rising != Some(false) && input[highest] - value > turn {
            if rising == Some(true) {
                add(from..highest + 1, true);
            }
            (from, lowest, rising) = (highest, row, Some(false));
        } else if rising != Some(true) && value - input[lowest] > turn {
            if rising == Some(false) {
                add(from..lowest + 1, false);
            }
            (from, highest, rising) = (lowest, row, Some(true));
        }
    }
    if let Some(rising) = rising {
        add(from..(if rising { highest } else { lowest }) + 1, rising);
    }
    found
}

impl Branch {
    /// Its points, input and output.
    #[must_use]
    pub fn points(&self, input: &[f64], output: &[f64]) -> Vec<(f64, f64)> {
        self.rows.clone().map(|row| (input[row], output[row])).collect()
    }

    /// The input at which the output crosses a level: the mean of the several crossings that noise makes of one. On a
    /// staircase this is the edge of a step, wherever on the step's height the level lies.
    #[must_use]
    pub fn crossing(&self, input: &[f64], output: &[f64], level: f64) -> Option<f64> {
        let rows = self.rows.start..self.rows.end - 1;
        let crossed = |row: &usize| (output[*row] > level) != (output[*row + 1] > level);
        let at: Vec<f64> = rows.filter(crossed).map(|row| f64::midpoint(input[row], input[row + 1])).collect();
        (!at.is_empty()).then(|| at.iter().sum::<f64>() / at.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_noisy_triangle_has_its_long_branches_only() {
        let triangle: Vec<f64> = (0..500)
            .map(|row| {
                let phase = f64::from(row % 200);
                (if phase < 100.0 { phase } else { 200.0 - phase }) + if row % 3 == 0 { 0.4 } else { 0.0 }
            })
            .collect();
        let found = branches(&triangle);
        assert_eq!(found.iter().map(|branch| branch.rising).collect::<Vec<_>>(), [true, false, true, false, true]);
        assert!(found[1].rows.start.abs_diff(100) < 3 && found[1].rows.end.abs_diff(200) < 4, "{found:?}");
        assert_eq!(branches(&[2.0; 9]), []);
    }

    #[test]
    fn a_level_is_crossed_at_the_edge_of_a_step() {
        let input: Vec<f64> = (0..10).map(f64::from).collect();
        let output: Vec<f64> = input.iter().map(|value| (value / 5.0).floor()).collect();
        let branch = &branches(&input)[0];
        for level in [0.1, 0.5, 0.9] {
            assert_eq!(branch.crossing(&input, &output, level), Some(4.5));
        }
        assert_eq!(branch.crossing(&input, &output, 2.0), None);
    }
}
