//! A straight line through the amounts of some nights, by weighted least squares, and when it reaches a limit.

use distrs::Normal;

/// Days of a month, on average.
const DAYS_OF_A_MONTH: f64 = 30.4375;
/// Share of cases in which a stated range holds the true value.
const SURE: f64 = 0.95;

/// An amount in one night.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The night, in days from any fixed one.
    pub day: f64,
    /// The amount, SI.
    pub value: f64,
    /// Its standard deviation, SI, > 0.
    pub std: f64,
}

/// A line through points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// The mean day, by weight: there level and rate are not correlated.
    centre: f64,
    level: f64,
    level_std: f64,
    /// Per day.
    rate: f64,
    rate_std: f64,
}

/// When a limit is reached, in days as the points have them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// At the rate that is most likely.
    pub expected: f64,
    /// The earliest day that is consistent with what is known.
    pub earliest: f64,
    /// The latest one; `None` where it may never be.
    pub latest: Option<f64>,
}

impl Line {
    /// The line through these points; `None` without a point. The rate of a single night is 0, and not known.
    #[must_use]
    pub fn through(points: &[Point]) -> Option<Self> {
        let weight = |point: &Point| point.std.powi(-2);
        let weights: f64 = points.iter().map(weight).sum();
        if points.is_empty() || !weights.is_finite() {
            return None;
        }
        let mean = |of: fn(&Point) -> f64| points.iter().map(|point| weight(point) * of(point)).sum::<f64>() / weights;
        let (centre, level) = (mean(|point| point.day), mean(|point| point.value));
        let across: f64 = points.iter().map(|point| weight(point) * (point.day - centre).powi(2)).sum();
        let along: f64 = points.iter().map(|point| weight(point) * (point.day - centre) * (point.value - level)).sum();
        let (rate, rate_std) =
            if across > 0.0 { (along / across, across.sqrt().recip()) } else { (0.0, f64::INFINITY) };
        Some(Self { centre, level, level_std: weights.sqrt().recip(), rate, rate_std })
    }

    /// The level that these points have, if it does not change.
    pub(crate) fn flat(self) -> Self {
        Self { rate: 0.0, rate_std: 0.0, ..self }
    }

    /// The amount on a day, with its standard deviation.
    #[must_use]
    pub fn at(&self, day: f64) -> (f64, f64) {
        let from = day - self.centre;
        // Of a single night the rate is not known, and its own day needs none.
        let by_rate = if from == 0.0 { 0.0 } else { self.rate_std * from };
        (self.level + self.rate * from, libm::hypot(self.level_std, by_rate))
    }

    /// How fast the amount changes, per month, with its standard deviation.
    #[must_use]
    pub fn per_month(&self) -> (f64, f64) {
        (self.rate * DAYS_OF_A_MONTH, self.rate_std * DAYS_OF_A_MONTH)
    }

    /// When the magnitude reaches a limit, after a day: where the line does, and where its band does (Fieller 1954). `None` where it does not grow on that day,
    /// or is beyond the limit.
    #[must_use]
    pub fn reaches(&self, limit: f64, after: f64) -> Option<Reach> {
        let (now, _) = self.at(after);
        let sign = if now < 0.0 { -1.0 } else { 1.0 };
        let (below, rate) = (limit.abs() - sign * self.level, sign * self.rate);
        if rate <= 0.0 || !self.rate_std.is_finite() || sign * now >= limit.abs() {
            return None;
        }
        // (below − rate·u)² = sure²·(level_std² + rate_std²·u²), in days u from the centre.
        let sure2 = sure().powi(2);
        let square = rate.powi(2) - sure2 * self.rate_std.powi(2);
        let rest = below.powi(2) - sure2 * self.level_std.powi(2);
        let root = ((below * rate).powi(2) - square * rest).max(0.0).sqrt();
        // The lower edge of the band meets the limit later, and only if even the slowest rate grows.
        Some(Reach {
            expected: self.centre + below / rate,
            earliest: (self.centre + rest / (below * rate + root)).max(after),
            latest: (square > 0.0).then(|| self.centre + (below * rate + root) / square),
        })
    }
}

/// How many standard deviations make the stated range.
fn sure() -> f64 {
    Normal::ppf(0.5 + 0.5 * SURE, 0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(values: impl Fn(f64) -> f64, nights: i32, std: f64) -> Vec<Point> {
        (0..nights).map(|day| Point { day: day.into(), value: values(day.into()), std }).collect()
    }

    #[test]
    fn a_line_goes_through_its_points_and_says_when_it_reaches_a_limit() {
        let line = Line::through(&points(|day| 2.0 + 0.1 * day, 21, 0.05)).unwrap();
        let (value, _) = line.at(20.0);
        assert!((value - 4.0).abs() < 1e-12, "{line:?}");
        assert!((line.per_month().0 - 0.1 * DAYS_OF_A_MONTH).abs() < 1e-9);
        let reach = line.reaches(6.0, 20.0).unwrap();
        let latest = reach.latest.unwrap();
        assert!((reach.expected - 40.0).abs() < 1e-9, "{reach:?}");
        assert!(reach.earliest < 40.0 && 40.0 < latest, "{reach:?}");
        // On both days the limit is at the edge of the band.
        for day in [reach.earliest, latest] {
            let (value, std) = line.at(day);
            assert!(((value - 6.0).abs() - sure() * std).abs() < 1e-9, "{day}");
        }
    }

    #[test]
    fn of_a_magnitude_that_falls_or_hardly_grows_the_limit_may_never_be_reached() {
        assert_eq!(Line::through(&points(|day| 5.0 - 0.1 * day, 9, 0.1)).unwrap().reaches(6.0, 8.0), None);
        // What is negative and falls grows.
        assert!(Line::through(&points(|day| -5.0 - 0.1 * day, 9, 0.01)).unwrap().reaches(6.0, 8.0).is_some());
        let slow = Line::through(&points(|day| 5.0 + 1e-3 * day, 9, 0.1)).unwrap().reaches(6.0, 8.0).unwrap();
        assert_eq!(slow.latest, None, "{slow:?}");
        assert_eq!(Line::through(&points(|_| 5.0, 1, 0.1)).unwrap().reaches(6.0, 0.0), None);
        assert_eq!(Line::through(&[]), None);
        let alone = Line::through(&points(|_| 5.0, 1, 0.1)).unwrap();
        assert_eq!(alone.at(0.0), (5.0, 0.1));
        // What has passed through zero grows on the other side.
        let through = Line::through(&points(|day| -1.05 + 0.1 * day, 21, 0.01)).unwrap();
        assert!((through.reaches(2.0, 20.0).unwrap().expected - 30.5).abs() < 1e-9);
        assert_eq!(through.reaches(0.5, 20.0), None, "it is beyond it");
    }

    /// Of many drives with the same true rate, the range holds the true day in 95 of 100.
    #[test]
    fn the_range_holds_the_true_day_as_often_as_it_says() {
        let mut dice = recording::seeded_noise::Noise::new(3, 0);
        let held = (0..2000).filter(|_| {
            let noisy: Vec<Point> = points(|day| 1.0 + 0.05 * day, 15, 0.1)
                .iter()
                .map(|at| Point { value: at.value + dice.gaussian(0.1), ..*at })
                .collect();
            let reach = Line::through(&noisy).unwrap().reaches(3.0, 14.0).unwrap();
            reach.earliest <= 40.0 && reach.latest.is_none_or(|latest| latest >= 40.0)
        });
        let share = f64::from(u32::try_from(held.count()).unwrap()) / 2000.0;
        assert!((0.94..0.99).contains(&share), "{share}");
    }
}
