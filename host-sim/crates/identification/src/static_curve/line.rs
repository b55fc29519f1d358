//! Lines through points, and robust statistics.

/// The middle value; NaN for no values.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    let (count, middle) = (values.len(), values.len() / 2);
    if values.is_empty() {
        return f64::NAN;
    }
    let (low, &mut high, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let below = low.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if count % 2 == 1 { high } else { f64::midpoint(below, high) }
}

/// Median, and the standard deviation that corresponds to the median of absolute deviations for Gaussian noise.
pub(crate) fn median_and_std(values: &[f64]) -> (f64, f64) {
    let middle = median(values.to_vec());
    (middle, 1.4826 * median(values.iter().map(|value| (value - middle).abs()).collect()))
}

/// y = `at_zero` + slope·x.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct FittedLine {
    /// y at x = 0.
    pub at_zero: f64,
    /// dy/dx.
    pub slope: f64,
    /// Share of the variance of y that the line accounts for.
    pub r_squared: f64,
}

impl FittedLine {
    /// The line of least squares; `None` through fewer than three points or points of one x.
    pub(crate) fn through(points: &[(f64, f64)]) -> Option<Self> {
        let count = points.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
        let (x, y) = (mean(|point| point.0), mean(|point| point.1));
        let sum = |of: &dyn Fn(f64, f64) -> f64| points.iter().map(|point| of(point.0 - x, point.1 - y)).sum::<f64>();
        let (xx, xy, yy) = (sum(&|dx, _| dx * dx), sum(&|dx, dy| dx * dy), sum(&|_, dy| dy * dy));
        if points.len() < 3 || xx <= 0.0 {
            return None;
        }
        let slope = xy / xx;
        let r_squared = if yy > 0.0 { xy * xy / (xx * yy) } else { 1.0 };
        Some(Self { at_zero: y - slope * x, slope, r_squared })
    }

    /// The median of the slopes of all pairs of points (Theil 1950, Sen 1968): a third of the points may be wrong.
    pub(crate) fn robust(points: &[(f64, f64)]) -> Option<Self> {
        const MOST: usize = 400;
        let every = points.len().div_ceil(MOST).max(1);
        let used: Vec<(f64, f64)> = points.iter().step_by(every).copied().collect();
        let pairs = used.iter().enumerate().flat_map(|(index, a)| used[..index].iter().map(move |b| (a, b)));
        let slopes: Vec<f64> =
            pairs.filter(|(a, b)| a.0 - b.0 != 0.0).map(|(a, b)| (a.1 - b.1) / (a.0 - b.0)).collect();
        let squares = Self::through(points)?;
        let slope = median(slopes);
        let at_zero = median(used.iter().map(|point| point.1 - slope * point.0).collect());
        Some(Self { at_zero, slope, ..squares })
    }

    /// Standard error of the slope through these points. Neighbours that are alike count for less, as r = correlation of one point's distance from the
    /// line with the next one's says: n·(1 − r)/(1 + r) are independent (Bartlett 1946).
    pub(crate) fn slope_error(self, points: &[(f64, f64)]) -> f64 {
        let count = points.len() as f64;
        let mean = points.iter().map(|point| point.0).sum::<f64>() / count;
        let across = points.iter().map(|point| (point.0 - mean).powi(2)).sum::<f64>();
        let off: Vec<f64> = points.iter().map(|point| point.1 - self.at_zero - self.slope * point.0).collect();
        let squares = off.iter().map(|value| value * value).sum::<f64>();
        let products = off.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
        let alike = if squares > 0.0 { (products / squares + 4.0 / count).clamp(0.0, 0.95) } else { 0.0 };
        (squares / (count - 2.0) / across * (1.0 + alike) / (1.0 - alike)).sqrt()
    }

    /// Where it crosses zero.
    pub(crate) fn zero(self) -> f64 {
        -self.at_zero / self.slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_points_with_outliers_is_the_robust_one() {
        let mut points: Vec<(f64, f64)> = (0..20).map(|x| (f64::from(x), 3.0 - 0.5 * f64::from(x))).collect();
        points[3].1 = 40.0;
        points[11].1 = -70.0;
        let line = FittedLine::robust(&points).unwrap();
        assert!((line.slope + 0.5).abs() < 1e-12 && (line.zero() - 6.0).abs() < 1e-9, "{line:?}");
        assert!(FittedLine::through(&points[..2]).is_none() && FittedLine::through(&[(1.0, 1.0); 5]).is_none());
    }

    #[test]
    fn the_median_is_the_middle() {
        assert!((median(vec![3.0, 1.0, 2.0]) - 2.0).abs() < 1e-15);
        assert!((median(vec![4.0, 1.0, 2.0, 3.0]) - 2.5).abs() < 1e-15);
        assert!(median(Vec::new()).is_nan());
    }
}
