//! One amount of one drive over time.

use crate::line::Point;
use crate::pieces::{Piece, median, pieces};

/// An amount over the nights that tell it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trend {
    /// The nights in their order, with the deviations that the recordings of the night state. Nights that do not tell the amount are not among them.
    pub points: Vec<Point>,
    /// Which of them is far from its neighbours on both sides, and takes no part.
    pub odd: Vec<bool>,
    /// How many times more they scatter from night to night than their own deviations say; at least 1.
    pub scatter: f64,
    /// Between changes, in their order; nights are counted without the odd ones.
    pub pieces: Vec<Piece>,
    /// The days on which a piece begins, but the first.
    pub changes: Vec<f64>,
}

/// Neighbours that tell whether a night is odd, itself included.
const NEIGHBOURS: usize = 5;
/// Standard deviations from the middle of its neighbours beyond which a night is odd.
const ODD: f64 = 5.0;
/// Squares of standard normal values have this median.
const MEDIAN_SQUARE: f64 = 0.454_936;

impl Trend {
    /// The trend of these nights; `None` where none tells the amount. What is no number, or has no deviation, tells nothing. `false_changes` is the share of
    /// series without a change for which one is told by chance.
    #[must_use]
    pub fn of(mut points: Vec<Point>, false_changes: f64) -> Option<Self> {
        points.retain(|point| point.value.is_finite() && point.std.is_finite() && point.std > 0.0);
        points.sort_by(|one, other| one.day.total_cmp(&other.day));
        let scatter = scatter(&points);
        let odd: Vec<bool> = (0..points.len()).map(|index| is_odd(&points, index, scatter)).collect();
        let kept: Vec<Point> = points
            .iter()
            .zip(&odd)
            .filter(|(_, odd)| !**odd)
            .map(|(point, _)| Point { std: scatter * point.std, ..*point })
            .collect();
        let pieces = pieces(&kept, false_changes);
        let changes = pieces.iter().skip(1).filter_map(|piece| Some(kept.get(piece.nights.0)?.day)).collect();
        (!pieces.is_empty()).then_some(Self { points, odd, scatter, pieces, changes })
    }

    /// What it is since the last change.
    #[must_use]
    pub fn now(&self) -> Option<&Piece> {
        self.pieces.last()
    }

    /// The last night that tells the amount.
    #[must_use]
    pub fn last_day(&self) -> f64 {
        self.points.last().map_or(f64::NAN, |point| point.day)
    }

    /// The first and the last night of a piece.
    #[must_use]
    pub fn days(&self, piece: &Piece) -> (f64, f64) {
        let kept: Vec<f64> =
            self.points.iter().zip(&self.odd).filter(|(_, odd)| !**odd).map(|(point, _)| point.day).collect();
        let day = |index: usize| kept.get(index).copied().unwrap_or(f64::NAN);
        (day(piece.nights.0), day(piece.nights.1.saturating_sub(1)))
    }
}

/// From one night to the next values differ by √2 of their deviations, unless the day itself scatters them. What grows or jumps hardly counts.
fn scatter(points: &[Point]) -> f64 {
    let squares = points
        .windows(2)
        .map(|pair| (pair[1].value - pair[0].value).powi(2) / (pair[0].std.powi(2) + pair[1].std.powi(2)));
    if points.len() < NEIGHBOURS {
        return 1.0;
    }
    median(squares).map_or(1.0, |square| (square / MEDIAN_SQUARE).sqrt().max(1.0))
}

fn is_odd(points: &[Point], index: usize, scatter: f64) -> bool {
    let half = NEIGHBOURS / 2;
    let around = &points[index.saturating_sub(half)..(index + half + 1).min(points.len())];
    let far = |point: &Point, middle: f64| (point.value - middle).abs() > ODD * scatter * point.std;
    points.len() >= NEIGHBOURS
        && median(around.iter().map(|point| point.value)).is_some_and(|middle| far(&points[index], middle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use recording::seeded_noise::Noise;

    #[test]
    fn a_night_far_from_its_neighbours_takes_no_part_and_a_gap_is_no_zero() {
        let mut dice = Noise::new(1, 0);
        let mut points: Vec<Point> = (0..20)
            .filter(|day| !(5..9).contains(day))
            .map(|day| Point { day: day.into(), value: 3.0 + dice.gaussian(0.1), std: 0.1 })
            .collect();
        points[7].value = 30.0;
        points.push(Point { day: 30.0, value: f64::NAN, std: 1.0 });
        let trend = Trend::of(points, 0.01).unwrap();
        assert_eq!((trend.points.len(), trend.odd.iter().filter(|odd| **odd).count()), (16, 1), "{trend:?}");
        assert!(trend.odd[7] && trend.changes.is_empty(), "{trend:?}");
        let now = trend.now().unwrap();
        assert!(!now.grows && (now.line.at(19.0).0 - 3.0).abs() < 0.1, "{now:?}");
    }

    #[test]
    fn days_that_scatter_more_than_their_recordings_say_are_no_changes() {
        let mut dice = Noise::new(2, 0);
        let told = (0..300).filter(|_| {
            let points = (0..40).map(|day| Point { day: day.into(), value: dice.gaussian(1.0), std: 0.1 }).collect();
            let trend = Trend::of(points, 0.01).unwrap();
            !trend.changes.is_empty() || trend.now().unwrap().grows
        });
        let told = told.count();
        assert!(told <= 15, "{told} of 300");
    }
}
