//! The slope of a sampled signal.

/// Slope of a series at each row, in its unit per second: between the row `reach` before and the one `reach` after, or as
/// far as there are rows.
///
/// There are as many rising times as values; `reach` is at least 1.
pub fn slopes(time_s: &[f64], values: &[f64], reach: usize) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    (0..values.len())
        .map(|row| {
            let (before, after) = (row.saturating_sub(reach), (row + reach).min(last));
            (values[after] - values[before]) / (time_s[after] - time_s[before])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_one_slope_on_uneven_rows_and_to_both_ends() {
        let time_s = [0.0, 1.0, 3.0, 3.5];
        for reach in [1, 2, 9] {
            let slopes = slopes(&time_s, &time_s.map(|time| 4.0 - 2.0 * time), reach);
            assert!(slopes.len() == 4 && slopes.iter().all(|slope| (slope + 2.0).abs() < 1e-12), "{slopes:?}");
        }
    }
}
