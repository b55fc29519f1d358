//! Where a series of amounts has changed: nights between which it stays as it is or grows steadily.
//!
//! PELT (Killick, Fearnhead and Eckley 2012) finds the partition into levels that costs least. Wear that grows makes a staircase of them, so neighbours are
//! joined again wherever a single level or straight line follows both as well as chance allows. What is left are jumps (a part was exchanged, a seal broke)
//! and the nights from which on something grows.

use std::f64::consts::FRAC_1_SQRT_2;
use std::num::NonZero;

use distrs::Normal;
use pelt::{Pelt, SegmentCostFunction};

use crate::line::{Line, Point};

/// Values that stand for a night in the library's search.
const EACH: NonZero<usize> = NonZero::new(2).unwrap();

/// Nights between two changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Its nights' places in the series: from, and to before.
    pub nights: (usize, usize),
    /// The line through them; where the piece does not grow, a level.
    pub line: Line,
    /// The line through them, whatever is said of it.
    pub(crate) any: Line,
    /// Whether the amount changes from night to night by more than chance.
    pub grows: bool,
}

impl Piece {
    fn of(points: &[Point], nights: (usize, usize), false_changes: f64) -> Option<Self> {
        let any = Line::through(&points[nights.0..nights.1])?;
        let grows = any.chi2_of_level - any.chi2 > squares(1, false_changes);
        Some(Self { nights, line: if grows { any } else { any.flat() }, any, grows })
    }

    fn chi2(&self) -> f64 {
        if self.grows { self.any.chi2 } else { self.any.chi2_of_level }
    }

    fn freedoms(&self) -> usize {
        1 + usize::from(self.grows)
    }
}

/// By how much a sum of squares falls by chance in this share of cases, when so many values more are free: the quantile of χ².
fn squares(values: usize, share: f64) -> f64 {
    match values {
        0 | 1 => Normal::ppf(1.0 - 0.5 * share, 0.0, 1.0).powi(2),
        _ => -2.0 * libm::log(share),
    }
}

/// The pieces of a series of nights in their order. Deviations are what the values scatter by; a share of series in which nothing changes shows a change by
/// chance.
pub(crate) fn pieces(points: &[Point], false_changes: f64) -> Vec<Piece> {
    #[expect(clippy::cast_precision_loss, reason = "a number of nights")]
    let each = false_changes / points.len().max(1) as f64;
    let ends = levels(points, squares(1, each));
    let starts = [0].into_iter().chain(ends.iter().copied());
    let mut all: Vec<Piece> =
        starts.zip(&ends).filter_map(|(from, to)| Piece::of(points, (from, *to), false_changes)).collect();
    loop {
        let joined = all.windows(2).enumerate().filter_map(|(index, pair)| {
            let both = Piece::of(points, (pair[0].nights.0, pair[1].nights.1), false_changes)?;
            let fewer = (pair[0].freedoms() + pair[1].freedoms()).saturating_sub(both.freedoms());
            let costs = both.chi2() - pair[0].chi2() - pair[1].chi2() - squares(fewer, each);
            Some((costs, index, both))
        });
        let cheapest = joined.min_by(|one, other| one.0.total_cmp(&other.0));
        let Some((_, index, both)) = cheapest.filter(|(costs, ..)| *costs <= 0.0) else { return all };
        all.splice(index..=index + 1, [both]);
    }
}

/// The ends of the levels that cost least, each new one at this price.
fn levels(points: &[Point], price: f64) -> Vec<usize> {
    // Its costs know no weights: the unit is the usual deviation. They are differences of sums, so values are counted from their middle.
    let usual = median(points.iter().map(|point| point.std)).unwrap_or(1.0);
    let middle = median(points.iter().map(|point| point.value)).unwrap_or(0.0);
    // The library's search is exact in steps of two, so every night stands twice, with half its square each.
    let scaled: Vec<f64> =
        points.iter().flat_map(|point| [(point.value - middle) / usual * FRAC_1_SQRT_2; EACH.get()]).collect();
    let pelt = Pelt::new()
        .with_segment_cost_function(SegmentCostFunction::L2)
        .with_jump(EACH)
        .with_minimum_segment_length(EACH);
    // Without a night there is nothing to search.
    let mut ends = pelt.predict(&scaled[..], price).unwrap_or_default();
    ends.retain(|end| *end < scaled.len());
    ends.push(scaled.len());
    ends.into_iter().map(|end| end / EACH).collect()
}

/// The middle value; `None` of nothing.
pub(crate) fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut all: Vec<f64> = values.collect();
    all.sort_by(f64::total_cmp);
    let (low, high) = (all.get(all.len().checked_sub(1)? / 2)?, all.get(all.len() / 2)?);
    Some(f64::midpoint(*low, *high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use recording::seeded_noise::Noise;

    fn series(dice: &mut Noise, nights: i32, value: impl Fn(f64) -> f64) -> Vec<Point> {
        (0..nights)
            .map(|day| Point { day: day.into(), value: value(day.into()) + dice.gaussian(1.0), std: 1.0 })
            .collect()
    }

    #[test]
    fn a_steady_drive_has_no_change_in_ninety_nine_of_a_hundred() {
        let mut dice = Noise::new(5, 0);
        let told = (0..1000).filter(|_| {
            let found = pieces(&series(&mut dice, 30, |_| 4.0), 0.01);
            found.len() > 1 || found[0].grows
        });
        let told = told.count();
        assert!(told < 30, "{told} of 1000");
    }

    #[test]
    fn wear_is_one_line_from_the_night_on_from_which_it_grows() {
        let mut dice = Noise::new(6, 0);
        let right = (0..200).filter(|_| {
            let found = pieces(&series(&mut dice, 60, |day| 10.0 + 0.5 * (day - 25.0).max(0.0)), 0.01);
            found.len() == 2 && !found[0].grows && found[1].grows && found[1].nights.0.abs_diff(25) <= 8
        });
        let right = right.count();
        assert!(right >= 180, "{right} of 200");
    }

    #[test]
    fn a_part_that_was_exchanged_is_a_jump_and_what_grows_after_it_has_its_own_rate() {
        let mut dice = Noise::new(7, 0);
        let right = (0..200).filter(|_| {
            let found =
                pieces(&series(&mut dice, 60, |day| if day < 30.0 { 0.8 * day } else { 0.4 * (day - 30.0) }), 0.01);
            let last = found[found.len() - 1];
            found.len() == 2 && last.nights.0.abs_diff(30) <= 1 && (last.any.per_month().0 / 30.4375 - 0.4).abs() < 0.1
        });
        let right = right.count();
        assert!(right >= 190, "{right} of 200");
    }

    #[test]
    fn a_few_nights_are_one_piece() {
        assert!(pieces(&[], 0.01).is_empty());
        let at = |day: f64, value: f64| Point { day, value, std: 1.0 };
        for nights in 1..4 {
            let all: Vec<Point> = (0..nights).map(|day| at(f64::from(day), f64::from(day % 2))).collect();
            assert_eq!(pieces(&all, 0.01).len(), 1, "{nights}");
        }
    }
}
