//! One amount of one drive over time.

use crate::line::Point;
use crate::pieces::{Piece, pieces};

/// An amount over the nights that tell it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trend {
    /// The nights in their order, with the deviations that the recordings of the night state. Nights that do not tell the amount are not among them.
    pub points: Vec<Point>,
    /// Which of them is far from its neighbours on both sides, and takes no part.
    pub odd: Vec<bool>,
    /// How many times more nights scatter than their own deviations say; at least 1.
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
    /// The trend of these nights; `None` where none tells the amount. `scatter` is how many times more nights usually scatter than their deviations say;
    /// `false_changes` is the share of series without a change for which a jump, or a rate, is told by chance.
    #[must_use]
    pub fn of(points: Vec<Point>, scatter: f64, false_changes: f64) -> Option<Self> {
        let points = telling(points);
        let scatter = scatters(&squares(&points)).max(scatter);
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

    /// Whether what it is now was told in one night alone, and nights after it, up to this day, did not tell it again.
    #[must_use]
    pub fn is_told_once(&self, up_to: f64) -> bool {
        self.now().is_some_and(|piece| piece.nights.1 - piece.nights.0 == 1) && self.last_day() < up_to
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

/// The points that tell something, in the order of their nights: what is no number, or has no deviation, does not.
pub(crate) fn telling(mut points: Vec<Point>) -> Vec<Point> {
    points.retain(|point| point.value.is_finite() && point.std.is_finite() && point.std > 0.0);
    points.sort_by(|one, other| one.day.total_cmp(&other.day));
    points
}

/// Of each night how far it is from the line through its two neighbours, in deviations, squared: what grows steadily is not far.
pub(crate) fn squares(points: &[Point]) -> Vec<f64> {
    let square = |three: &[Point]| {
        let [before, own, after] = three else { return f64::NAN };
        let share = (own.day - before.day) / (after.day - before.day);
        let far = own.value - (1.0 - share) * before.value - share * after.value;
        far.powi(2) / (own.std.powi(2) + ((1.0 - share) * before.std).powi(2) + (share * after.std).powi(2))
    };
    points.windows(3).map(square).filter(|square| square.is_finite()).collect()
}

/// How many times more nights scatter than their deviations say, by such squares; 1 where few tell it.
pub(crate) fn scatters(squares: &[f64]) -> f64 {
    if squares.len() < NEIGHBOURS {
        return 1.0;
    }
    median(squares.iter().copied()).map_or(1.0, |square| (square / MEDIAN_SQUARE).sqrt().max(1.0))
}

/// Whether a night is far from its neighbours on both sides. What happened in the last nights is seen.
fn is_odd(points: &[Point], index: usize, scatter: f64) -> bool {
    let half = NEIGHBOURS / 2;
    let around = index.checked_sub(half).and_then(|from| points.get(from..=index + half));
    let middle = around.and_then(|around| median(around.iter().map(|point| point.value)));
    middle.is_some_and(|middle| (points[index].value - middle).abs() > ODD * scatter * points[index].std)
}

/// The middle value; `None` of nothing.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut all: Vec<f64> = values.collect();
    all.sort_by(f64::total_cmp);
    let (low, high) = (all.get(all.len().checked_sub(1)? / 2)?, all.get(all.len() / 2)?);
    Some(f64::midpoint(*low, *high))
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
        let trend = Trend::of(points, 1.0, 0.01).unwrap();
        assert_eq!((trend.points.len(), trend.odd.iter().filter(|odd| **odd).count()), (16, 1), "{trend:?}");
        assert!(trend.odd[7] && trend.changes.is_empty(), "{trend:?}");
        let now = trend.now().unwrap();
        assert!(!now.grows && (now.line.at(19.0).0 - 3.0).abs() < 0.1, "{now:?}");
    }

    #[test]
    fn what_happens_in_the_last_night_is_seen_and_steady_growth_is_no_scatter() {
        let mut dice = Noise::new(3, 0);
        let mut points: Vec<Point> =
            (0..30).map(|day| Point { day: day.into(), value: dice.gaussian(1.0), std: 1.0 }).collect();
        points[29].value = 100.0;
        let trend = Trend::of(points, 1.0, 1e-4).unwrap();
        assert_eq!((trend.changes.as_slice(), trend.odd[29]), (&[29.0][..], false));
        let grows =
            (0..30).map(|day| Point { day: day.into(), value: f64::from(5 * day) + dice.gaussian(1.0), std: 1.0 });
        let trend = Trend::of(grows.collect(), 1.0, 1e-4).unwrap();
        assert!(trend.scatter < 1.5 && trend.now().unwrap().grows, "{trend:?}");
    }

    #[test]
    fn days_that_scatter_more_than_their_recordings_say_are_no_changes() {
        let mut dice = Noise::new(2, 0);
        let told = (0..300).filter(|_| {
            let points = (0..40).map(|day| Point { day: day.into(), value: dice.gaussian(1.0), std: 0.1 }).collect();
            let trend = Trend::of(points, 1.0, 0.01).unwrap();
            !trend.changes.is_empty() || trend.now().unwrap().grows
        });
        let told = told.count();
        assert!(told <= 15, "{told} of 300");
    }
}
