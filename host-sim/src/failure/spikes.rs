//! Rows that stand alone.

/// A row is a spike that is further from the median of the seven around it than so many standard deviations of the noise…
const SPIKE: f64 = 8.0;
/// … and so many times their own median distance from it, which is what a moving signal makes.
const MOVING: f64 = 6.0;

/// Rows where the sensor failed for a moment, up to three in a row (Hampel's identifier).
pub(super) fn spikes(values: &[f64], noise: f64) -> Vec<bool> {
    let last = values.len() - 1;
    let is_spike = |row: usize| {
        let (from, to) = (row.saturating_sub(3), (row + 3).min(last));
        let mut around = [0.0; 7];
        let around = &mut around[..=to - from];
        around.copy_from_slice(&values[from..=to]);
        around.sort_by(f64::total_cmp);
        let median = around[around.len() / 2];
        for value in around.iter_mut() {
            *value = (*value - median).abs();
        }
        around.sort_by(f64::total_cmp);
        (values[row] - median).abs() > SPIKE * noise + MOVING * around[around.len() / 2]
    };
    let mut spikes = vec![false; values.len()];
    for row in 0..values.len() {
        let far = |other: usize| (values[row] - values[other]).abs() > 0.5 * SPIKE * noise;
        // Most rows are next to their neighbours, and cost no median; the second of two spikes is next to the first.
        let suspect = far(row.saturating_sub(1)) || far((row + 1).min(last)) || (row > 0 && spikes[row - 1]);
        spikes[row] = suspect && is_spike(row);
    }
    spikes
}
