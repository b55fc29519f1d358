//! The course of one branch: means of the output along the input with their standard errors, and where it turns back by more than these.

use super::line::{FittedLine, median};

/// Mean of the output at one place of the input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) input: f64,
    pub(crate) output: f64,
    /// Standard error of `output`.
    pub(crate) error: f64,
}

/// The means along a branch, in the order of rising input.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Course {
    pub(crate) places: Vec<Place>,
    /// Scatter of single rows about them.
    pub(crate) scatter: f64,
}

/// Rows that a mean is taken of, at least.
const ROWS_A_PLACE: usize = 8;
/// From so many rows on, rows are joined to means; fewer are a table, each row a place.
const DENSE: usize = 10 * ROWS_A_PLACE;
/// Chance that a branch that does not turn back is found to.
const FALSE_TURN: f64 = 1e-3;

impl Course {
    /// Means over at most `most` intervals of equal width.
    pub(crate) fn of(points: &[(f64, f64)], most: usize) -> Self {
        let mut points = points.to_vec();
        if points.len() < DENSE {
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let scatter = scatter_of_table(&points);
            let place = |&(input, output): &(f64, f64)| Place { input, output, error: scatter };
            return Self { places: points.iter().map(place).collect(), scatter };
        }
        let (low, high) = simulation::signal::noise::extent(points.iter().map(|point| point.0));
        let count = most.min(points.len() / ROWS_A_PLACE);
        let mut intervals = vec![Vec::new(); count];
        for point in points {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and count")]
            let index = ((point.0 - low) / (high - low) * count as f64) as usize;
            intervals[index.min(count - 1)].push(point);
        }
        intervals.retain(|rows| rows.len() > 3);
        Self::of_intervals(&intervals)
    }

    /// The rows of an interval scatter about its line. Rows that are alike their neighbours count for less: of n rows of which each is correlated
    /// by r with the next, n·(1 − r)/(1 + r) are independent (Bartlett 1946).
    fn of_intervals(intervals: &[Vec<(f64, f64)>]) -> Self {
        let about: Vec<Vec<f64>> = intervals.iter().map(|rows| about_line(rows)).collect();
        let squares = |rows: &Vec<f64>| rows.iter().map(|value| value * value).sum::<f64>();
        let variances: Vec<f64> = about.iter().map(|rows| squares(rows) / (rows.len() - 2) as f64).collect();
        let usual = median(variances.clone());
        let products: f64 = about.iter().flat_map(|rows| rows.windows(2)).map(|pair| pair[0] * pair[1]).sum();
        let all: f64 = about.iter().map(squares).sum();
        let rows = about.iter().map(Vec::len).sum::<usize>() as f64 / about.len().max(1) as f64;
        // Taking a line out of n rows lowers the correlation that is found by about 4/n.
        let alike = if all > 0.0 { (products / all + 4.0 / rows).clamp(0.0, 0.95) } else { 0.0 };
        let dependent = (1.0 + alike) / (1.0 - alike);
        let place = |(rows, variance): (&Vec<(f64, f64)>, &f64)| {
            let count = rows.len() as f64;
            let mean = |of: fn(&(f64, f64)) -> f64| rows.iter().map(of).sum::<f64>() / count;
            let error = (variance.max(usual) * dependent / count).sqrt();
            Place { input: mean(|row| row.0), output: mean(|row| row.1), error }
        };
        Self { places: intervals.iter().zip(&variances).map(place).collect(), scatter: usual.sqrt() }
    }

    /// The places at which the course turns back by more than its standard errors, with both of its ends; none where it nowhere changes by more.
    /// Changes of less than `least` do not count; the threshold is raised by a factor, `times`.
    pub(crate) fn turns(&self, least: f64, times: f64) -> Vec<Place> {
        let places = &self.places;
        let z = times * beyond_chance(places.len());
        let beyond = |high: usize, low: usize| {
            let error = libm::hypot(places[high].error, places[low].error);
            places[high].output - places[low].output > (z * error).max(least)
        };
        let (mut lowest, mut highest) = (0, 0);
        let mut rising: Option<bool> = None;
        let mut found = Vec::new();
        for (index, place) in places.iter().enumerate() {
            if place.output > places[highest].output {
                highest = index;
            }
            if place.output < places[lowest].output {
                lowest = index;
            }
            if rising != Some(false) && beyond(highest, index) {
                found.push(places[highest]);
                (lowest, rising) = (index, Some(false));
            } else if rising != Some(true) && beyond(index, lowest) {
                found.push(places[lowest]);
                (highest, rising) = (index, Some(true));
            }
        }
        if let Some(rising) = rising {
            found.push(places[if rising { highest } else { lowest }]);
        }
        found
    }
}

/// Standard errors by which two of so many values differ by chance in a thousandth of the cases: of their n(n − 1)/2 pairs none may differ by more
/// (Bonferroni; the tail of the normal distribution by its bound exp(−z²/2)/2 on either side).
pub(crate) fn beyond_chance(values: usize) -> f64 {
    let pairs = (values * values.saturating_sub(1) / 2).max(1) as f64;
    (2.0 * libm::log(pairs / FALSE_TURN)).sqrt()
}

/// What rows are off their line.
fn about_line(rows: &[(f64, f64)]) -> Vec<f64> {
    let mean = rows.iter().map(|row| row.1).sum::<f64>() / rows.len() as f64;
    let level = FittedLine { at_zero: mean, slope: 0.0, r_squared: 0.0 };
    let line = FittedLine::through(rows).unwrap_or(level);
    rows.iter().map(|row| row.1 - line.at_zero - line.slope * row.0).collect()
}

/// Noise of a table's rows from their third divided differences, which a parabola does not have (Gasser, Sroka, Jennen-Steinmetz 1986).
fn scatter_of_table(points: &[(f64, f64)]) -> f64 {
    let difference = |four: &[(f64, f64)]| {
        let weight =
            |one: usize| (0..4).filter(|other| *other != one).map(|other| four[one].0 - four[other].0).product();
        let weights: Vec<f64> =
            (0..4).map(|one| 1.0 / f64::max(1e-300, f64::abs(weight(one))) * f64::signum(weight(one))).collect();
        let size = weights.iter().map(|weight| weight * weight).sum::<f64>().sqrt();
        weights.iter().zip(four).map(|(weight, point)| weight / size * point.1).sum::<f64>().abs()
    };
    let found: Vec<f64> = points.windows(4).map(difference).filter(|value| value.is_finite()).collect();
    if found.is_empty() { 0.0 } else { 1.4826 * median(found) }
}
