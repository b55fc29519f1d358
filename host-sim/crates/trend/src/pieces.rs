//! Where a series of amounts has changed: nights between which it stays as it is or grows steadily.
//!
//! Of all ways to cut the series into pieces, each a level or a straight line, the one is taken whose squares and price together are least (optimal
//! partitioning, Jackson et al. 2005): every piece more and every line has the price that chance would pay. Libraries of change points look for levels alone,
//! of which wear that grows makes a staircase, and know no weights.

use distrs::Normal;

use crate::line::{Line, Point};

/// Nights that tell a rate, at least: between two or three nothing tells growth from a jump.
const TELL_A_RATE: usize = 5;

/// Nights between two changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Its nights' places in the series: from, and to before.
    pub nights: (usize, usize),
    /// The line through them; where the piece does not grow, a level.
    pub line: Line,
    /// Whether the amount changes from night to night by more than chance.
    pub grows: bool,
}

/// By how much a sum of squares falls by chance in this share of cases, when one value more is free: the quantile of χ².
fn squares(share: f64) -> f64 {
    Normal::ppf(1.0 - 0.5 * share, 0.0, 1.0).powi(2)
}

/// Weighted sums of points, which tell the squares that a level and a line leave.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: usize,
    weight: f64,
    day: f64,
    value: f64,
    day2: f64,
    day_value: f64,
    value2: f64,
}

impl Sums {
    /// With one more point, counted from an origin near it.
    fn with(self, point: &Point, origin: &Point) -> Self {
        let (weight, day, value) = (point.std.powi(-2), point.day - origin.day, point.value - origin.value);
        Self {
            count: self.count + 1,
            weight: self.weight + weight,
            day: self.day + weight * day,
            value: self.value + weight * value,
            day2: self.day2 + weight * day * day,
            day_value: self.day_value + weight * day * value,
            value2: self.value2 + weight * value * value,
        }
    }

    /// The squares that a level leaves, and those that a line leaves, where so many nights tell one.
    fn left(&self) -> (f64, Option<f64>) {
        let level = (self.value2 - self.value * self.value / self.weight).max(0.0);
        let across = self.day2 - self.day * self.day / self.weight;
        let along = self.day_value - self.day * self.value / self.weight;
        let tells = self.count >= TELL_A_RATE && across > 0.0;
        (level, tells.then(|| (level - along * along / across).max(0.0)))
    }
}

/// The best way to cut the first nights of a series.
#[derive(Clone, Copy)]
struct Cut {
    costs: f64,
    /// Where its last piece begins, and whether that grows.
    from: usize,
    grows: bool,
}

/// The pieces of a series of nights in their order. Deviations are what the values scatter by; a share of series in which nothing changes shows a change by
/// chance.
pub(crate) fn pieces(points: &[Point], false_changes: f64) -> Vec<Piece> {
    #[expect(clippy::cast_precision_loss, reason = "a number of nights")]
    let (of_piece, of_rate) = (squares(false_changes / points.len().max(1) as f64), squares(false_changes));
    let mut best = vec![Cut { costs: 0.0, from: 0, grows: false }];
    for end in 1..=points.len() {
        let mut cut = Cut { costs: f64::INFINITY, from: 0, grows: false };
        let mut sums = Sums::default();
        // Backwards, so that each piece has one point more than the one before.
        for from in (0..end).rev() {
            sums = sums.with(&points[from], &points[end - 1]);
            let (level, line) = sums.left();
            let before = best[from].costs + if from > 0 { of_piece } else { 0.0 };
            let grows = line.filter(|line| line + of_rate < level);
            let costs = before + grows.map_or(level, |line| line + of_rate);
            if costs < cut.costs {
                cut = Cut { costs, from, grows: grows.is_some() };
            }
        }
        best.push(cut);
    }
    let mut found = Vec::new();
    let mut end = points.len();
    while end > 0 {
        let Cut { from, grows, .. } = best[end];
        let line = Line::through(&points[from..end]);
        found.extend(line.map(|line| Piece {
            nights: (from, end),
            line: if grows { line } else { line.flat() },
            grows,
        }));
        end = from;
    }
    found.reverse();
    found
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
    fn a_steady_drive_has_no_change_in_ninety_eight_of_a_hundred() {
        let mut dice = Noise::new(5, 0);
        let told = (0..1000).filter(|_| {
            let found = pieces(&series(&mut dice, 30, |_| 4.0), 0.01);
            found.len() > 1 || found[0].grows
        });
        // One in a hundred by a jump, one by a rate.
        let told = told.count();
        assert!(told <= 30, "{told} of 1000");
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
            let worn = |day: f64| if day < 30.0 { 0.8 * day } else { 0.4 * (day - 30.0) };
            let found = pieces(&series(&mut dice, 60, worn), 0.01);
            let last = found[found.len() - 1];
            found.len() == 2 && last.nights.0.abs_diff(30) <= 1 && (last.line.per_month().0 / 30.4375 - 0.4).abs() < 0.1
        });
        let right = right.count();
        assert!(right >= 190, "{right} of 200");
    }

    #[test]
    fn nights_that_tell_more_count_more() {
        let mut dice = Noise::new(8, 0);
        let right = (0..100).filter(|_| {
            let at = |day: i32| {
                let (value, std) = (if day < 26 { 0.0 } else { 0.8 }, if day < 20 { 1.0 } else { 0.05 });
                Point { day: day.into(), value, std }
            };
            let noisy: Vec<Point> =
                (0..32).map(at).map(|point| Point { value: point.value + dice.gaussian(point.std), ..point }).collect();
            let found = pieces(&noisy, 0.01);
            found.len() == 2 && found[1].nights.0 == 26
        });
        let right = right.count();
        assert!(right >= 95, "{right} of 100");
    }

    #[test]
    fn of_a_few_nights_nothing_is_said_to_grow() {
        assert!(pieces(&[], 0.01).is_empty());
        let at = |day: f64, value: f64| Point { day, value, std: 0.02 };
        for nights in 1..5 {
            let all: Vec<Point> = (0..nights).map(|day| at(day.into(), 1.0 + f64::from(day))).collect();
            assert!(pieces(&all, 0.01).iter().all(|piece| !piece.grows), "{nights}");
        }
        let steady: Vec<Point> = (0..3).map(|day| at(day.into(), 1.0 + 0.01 * f64::from(day))).collect();
        assert_eq!(pieces(&steady, 0.01).len(), 1);
    }
}
