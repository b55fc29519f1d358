//! How alike two series are, side by side and shifted.

/// Σ one(t)·other(t + lag) over the rows that both have.
#[must_use]
pub fn lagged_product(one: &[f64], other: &[f64], lag: usize) -> f64 {
    one.iter().zip(other.get(lag..).unwrap_or_default()).map(|(one, other)| one * other).sum()
}

/// Correlation of two series of the same length, −1 to 1; 0 where one of them does not move.
#[must_use]
pub fn correlation(one: &[f64], other: &[f64]) -> f64 {
    let (mean_one, mean_other) = (mean(one), mean(other));
    let product: f64 = one.iter().zip(other).map(|(one, other)| (one - mean_one) * (other - mean_other)).sum();
    let both = deviation(one) * deviation(other) * one.len() as f64;
    if both > 0.0 { product / both } else { 0.0 }
}

/// By how many rows, at most so many, one series is earlier than the other of its length: where they are most alike, the fewest of equals.
#[must_use]
pub fn rows_early(one: &[f64], other: &[f64], most: usize) -> usize {
    let most = most.min(one.len() / 4);
    let alike = (0..=most).map(|rows| correlation(&one[..one.len() - rows], &other[rows..])).enumerate();
    alike.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map_or(0, |(rows, _)| rows)
}

/// Standard deviation of a series about its mean, in its unit.
#[must_use]
pub fn deviation(values: &[f64]) -> f64 {
    let mean = mean(values);
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shifted_series_is_most_alike_at_its_shift() {
        let late: Vec<f64> = (0..200).map(|row: u32| f64::from(row * row % 17)).collect();
        let early = [&late[5..], &[0.0; 5]].concat();
        assert_eq!(rows_early(&early, &late, 20), 5);
        assert!((lagged_product(&early[..195], &late, 5) - lagged_product(&late[5..], &late[5..], 0)).abs() < 1e-9);
        assert!((correlation(&late, &late) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_does_not_move_is_like_nothing() {
        assert!(correlation(&[2.0; 9], &[1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0, 2.0, 3.0]).abs() < 1e-12);
        assert_eq!(rows_early(&[1.0; 40], &[1.0; 40], 10), 0);
        assert!(lagged_product(&[1.0; 3], &[1.0; 3], 9).abs() < 1e-12);
    }
}
