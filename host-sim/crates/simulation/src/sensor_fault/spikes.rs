//! Failed rows that stand alone.

use super::bridged;

/// A spike differs from its neighbours by more than this many standard deviations of the noise…
const SPIKE: f64 = 8.0;
/// … plus this many times the variation of a moving signal.
const MOVING: f64 = 6.0;

/// Rows where the sensor failed for a moment: up to three together where the signal hardly moves, and single ones where it moves.
pub(crate) fn spikes(values: &[f64], noise: f64) -> Vec<bool> {
    let mut spikes = off_the_median(values, noise);
    let known = bridged(values, &spikes);
    for row in off_the_line(&known, noise) {
        spikes[row] = true;
    }
    spikes
}

/// Rows far from the median of the seven around them, compared with the distance of these seven from it (Hampel's identifier).
fn off_the_median(values: &[f64], noise: f64) -> Vec<bool> {
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
        // Most rows are close to their neighbours, and need no median; the second of two spikes is close to the first.
        let suspect = far(row.saturating_sub(1)) || far((row + 1).min(last)) || (row > 0 && spikes[row - 1]);
        spikes[row] = suspect && is_spike(row);
    }
    spikes
}

/// Rows far outside the range between their two neighbours, compared with the curvature of the three rows before and the three
/// after: a signal that moves evenly, however fast, has little curvature, and a signal that jumps lies between its neighbours.
fn off_the_line(values: &[f64], noise: f64) -> impl Iterator<Item = usize> {
    values.windows(7).enumerate().filter_map(move |(from, around)| {
        let &[a, b, c, value, d, e, f] = around else { return None };
        let outside = (value - c.max(d)).max(c.min(d) - value);
        let bend = || (a - 2.0 * b + c).abs().max((d - 2.0 * e + f).abs()).max((e - d - (c - b)).abs());
        (outside > SPIKE * noise && outside > SPIKE * noise + MOVING * bend()).then_some(from + 3)
    })
}
