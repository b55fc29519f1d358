//! Long series thinned so that a plot shows every peak and stays small.

/// Most points of a thinned trace.
pub(crate) const MOST_POINTS: usize = 2000;

/// The finite points of a series, at most `most` or [`MOST_POINTS`]: the lowest and the highest of each of equal stretches, in order.
pub(crate) fn thinned(time_s: &[f64], values: &[f64], most: Option<usize>) -> Vec<(f64, f64)> {
    let most = most.unwrap_or(MOST_POINTS).max(4);
    let points: Vec<(f64, f64)> = time_s
        .iter()
        .copied()
        .zip(values.iter().copied())
        .filter(|(time, value)| time.is_finite() && value.is_finite())
        .collect();
    if points.len() <= most {
        return points;
    }
    let stretches = most / 2;
    let mut kept = Vec::with_capacity(most);
    for stretch in 0..stretches {
        let (from, to) = (stretch * points.len() / stretches, (stretch + 1) * points.len() / stretches);
        let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let (low, high) = (points[from..to].iter().min_by(by_value), points[from..to].iter().max_by(by_value));
        let (Some(&low), Some(&high)) = (low, high) else { continue };
        let (first, second) = if low.0 <= high.0 { (low, high) } else { (high, low) };
        kept.push(first);
        if second != first {
            kept.push(second);
        }
    }
    kept
}

/// Rows of series over the same times, about `most`: the lowest and the highest of every series in each of equal stretches, and the first row there that no
/// series has a value in, which breaks the lines.
pub(crate) fn kept_rows(series: &[&[f64]], most: usize) -> Vec<usize> {
    let rows = series.iter().map(|values| values.len()).min().unwrap_or(0);
    if rows <= most {
        return (0..rows).collect();
    }
    let stretches = (most / (2 * series.len().max(1))).max(1);
    let mut kept = Vec::with_capacity(most);
    for stretch in 0..stretches {
        let (from, to) = (stretch * rows / stretches, (stretch + 1) * rows / stretches);
        kept.extend((from..to).find(|row| series.iter().all(|values| !values[*row].is_finite())));
        for values in series {
            let finite = || (from..to).filter(|row| values[*row].is_finite());
            kept.extend(finite().min_by(|a, b| values[*a].total_cmp(&values[*b])));
            kept.extend(finite().max_by(|a, b| values[*a].total_cmp(&values[*b])));
        }
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_kept_in_which_any_series_peaks() {
        let slow: Vec<f64> = (0..50_000).map(|row| (f64::from(row) * 1e-4).cos()).collect();
        let mut other = slow.clone();
        other[31_234] = 9.0;
        other[7] = f64::NAN;
        let kept = kept_rows(&[&slow, &other], 1000);
        assert!(kept.len() <= 1000 && kept.contains(&31_234) && !kept.contains(&7), "{}", kept.len());
        assert!(kept.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(kept_rows(&[&slow[..3]], 1000), [0, 1, 2]);
        assert!(kept_rows(&[], 1000).is_empty());
    }

    #[test]
    fn a_gap_stays_a_gap() {
        let mut values: Vec<f64> = (0..50_000).map(|row| (f64::from(row) * 1e-4).cos()).collect();
        values[20_000] = f64::NAN;
        assert!(kept_rows(&[&values], 1000).contains(&20_000));
    }

    #[test]
    fn thinning_keeps_order_and_a_single_peak() {
        let time_s: Vec<f64> = (0..100_000).map(f64::from).collect();
        let mut values: Vec<f64> = time_s.iter().map(|time| (time * 1e-3).sin()).collect();
        values[54_321] = 7.0;
        values[11] = f64::NAN;
        let kept = thinned(&time_s, &values, None);
        assert!(kept.len() <= MOST_POINTS);
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert!(kept.contains(&(54_321.0, 7.0)));
    }

    #[test]
    fn a_short_series_stays_as_it_is() {
        assert_eq!(thinned(&[0.0, 1.0], &[5.0, 5.0], None), [(0.0, 5.0), (1.0, 5.0)]);
    }
}
