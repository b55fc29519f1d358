//! A straight line through the amounts of some nights, by weighted least squares, and when it reaches a limit.

use distrs::StudentsT;

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
    /// Σ((value − line)/std)².
    pub(crate) chi2: f64,
    /// The same of a level.
    pub(crate) chi2_of_level: f64,
    count: usize,
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
        let chi2_of = |rate: f64| -> f64 {
            points.iter().map(|at| ((at.value - level - rate * (at.day - centre)) / at.std).powi(2)).sum()
        };
        Some(Self {
            centre,
            level,
            level_std: weights.sqrt().recip(),
            rate,
            rate_std,
            chi2: chi2_of(rate),
            chi2_of_level: chi2_of(0.0),
            count: points.len(),
        })
    }

    /// The level that these points have, if it does not change.
    pub(crate) fn flat(self) -> Self {
        Self { rate: 0.0, rate_std: 0.0, ..self }
    }

    /// The amount on a day, with its standard deviation.
    #[must_use]
    pub fn at(&self, day: f64) -> (f64, f64) {
        let from = day - self.centre;
        (self.level + self.rate * from, libm::hypot(self.level_std, self.rate_std * from))
    }

    /// How fast the amount changes, per month, with its standard deviation.
    #[must_use]
    pub fn per_month(&self) -> (f64, f64) {
        (self.rate * DAYS_OF_A_MONTH, self.rate_std * DAYS_OF_A_MONTH)
    }

    /// How many standard deviations make the stated range: more where few nights tell them.
    #[must_use]
    pub fn sure(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a number of nights")]
        let freedom = self.count.saturating_sub(2).max(1) as f64;
        StudentsT::ppf(0.5 + 0.5 * SURE, freedom)
    }

    /// When the magnitude reaches a limit: where the line does, and where its band does (Fieller 1954). `None` where it does not grow.
    #[must_use]
    pub fn reaches(&self, limit: f64) -> Option<Reach> {
        let sign = if self.level < 0.0 { -1.0 } else { 1.0 };
        let (below, rate) = (limit.abs() - sign * self.level, sign * self.rate);
        if rate <= 0.0 || !self.rate_std.is_finite() {
            return None;
        }
        // (below − rate·u)² = sure²·(level_std² + rate_std²·u²)
        let sure2 = self.sure().powi(2);
        let square = rate.powi(2) - sure2 * self.rate_std.powi(2);
        let rest = below.powi(2) - sure2 * self.level_std.powi(2);
        let root = ((below * rate).powi(2) - square * rest).max(0.0).sqrt();
        // Of the two places where the band meets the limit the lower edge's is the later one, which is there only if even the slowest rate grows.
        let of = |with: f64| self.centre + rest / (below * rate + with);
        Some(Reach {
            expected: self.centre + below / rate,
            earliest: of(root),
            latest: (square > 0.0).then(|| self.centre + (below * rate + root) / square),
        })
    }
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
        assert!((value - 4.0).abs() < 1e-12 && line.chi2 < 1e-12, "{line:?}");
        assert!((line.per_month().0 - 0.1 * DAYS_OF_A_MONTH).abs() < 1e-9);
        let reach = line.reaches(6.0).unwrap();
        let latest = reach.latest.unwrap();
        assert!((reach.expected - 40.0).abs() < 1e-9, "{reach:?}");
        assert!(reach.earliest < 40.0 && 40.0 < latest, "{reach:?}");
        // On both days the limit is at the edge of the band.
        for day in [reach.earliest, latest] {
            let (value, std) = line.at(day);
            assert!(((value - 6.0).abs() - line.sure() * std).abs() < 1e-9, "{day}");
        }
    }

    #[test]
    fn of_a_magnitude_that_falls_or_hardly_grows_the_limit_may_never_be_reached() {
        assert_eq!(Line::through(&points(|day| 5.0 - 0.1 * day, 9, 0.1)).unwrap().reaches(6.0), None);
        // What is negative and falls grows.
        assert!(Line::through(&points(|day| -5.0 - 0.1 * day, 9, 0.01)).unwrap().reaches(6.0).is_some());
        let slow = Line::through(&points(|day| 5.0 + 1e-3 * day, 9, 0.1)).unwrap().reaches(6.0).unwrap();
        assert_eq!(slow.latest, None, "{slow:?}");
        assert_eq!(Line::through(&points(|_| 5.0, 1, 0.1)).unwrap().reaches(6.0), None);
        assert_eq!(Line::through(&[]), None);
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
            let reach = Line::through(&noisy).unwrap().reaches(3.0).unwrap();
            reach.earliest <= 40.0 && reach.latest.is_none_or(|latest| latest >= 40.0)
        });
        let share = f64::from(u32::try_from(held.count()).unwrap()) / 2000.0;
        assert!((0.94..0.99).contains(&share), "{share}");
    }
}
