//! The noise of a sensor, estimated from what it recorded.

use std::borrow::Borrow;

/// Rows of one segment from which the noise is estimated: few, so that some segments are at rest even if a signal moves and rings most of the time.
const SEGMENT: usize = 16;
/// Median of the segments' mean squares for white noise, over its variance.
const MEDIAN: f64 = 0.9;

/// Standard deviation of white noise in a smooth signal: root mean square of its third differences over √20 (Gasser, Sroka,
/// Jennen-Steinmetz 1986) in short segments, of which the median is taken, so that steps and spikes have no influence. It is at
/// least that of rounding to the resolution, and at least 1e-5 of the signal's span: no sensor is better, and no tick finer.
pub fn noise(values: &[f64], resolution: f64) -> f64 {
    let squares: Vec<f64> = values.windows(4).map(|w| ((w[3] - w[0]) - 3.0 * (w[2] - w[1])).powi(2) / 20.0).collect();
    let mut segments: Vec<f64> =
        squares.chunks(SEGMENT).map(|segment| segment.iter().sum::<f64>() / segment.len() as f64).collect();
    let (low, high) = extent(values);
    (median(&mut segments) / MEDIAN)
        .sqrt()
        .max(resolution / 12.0_f64.sqrt())
        .max(1e-5 * (high - low))
        .max(f64::MIN_POSITIVE)
}

/// The step by which most neighbouring values differ, if a sensor has one: the smallest difference that is not zero and
/// is not rare. Where steps grow along the range, as those of an encoder behind a linkage do, it is their root mean square over the rows. Where readings
/// that had steps already were rounded once more, it is the root of both steps' squares: the step whose rounding has the noise of the two.
pub fn resolution(values: &[f64]) -> f64 {
    let mut steps: Vec<f64> =
        values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0).collect();
    if steps.is_empty() {
        return 0.0;
    }
    let rank = steps.len() / 20;
    let (_, step, _) = steps.select_nth_unstable_by(rank, f64::total_cmp);
    let step = *step;
    // With a resolution, steps are multiples of it; noise with many digits has no resolution.
    let multiples = values
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs() / step)
        .filter(|ratio| (ratio - ratio.round()).abs() < 0.02)
        .count();
    if multiples * 10 >= values.len() * 9 { step * rounded_twice(values, step) } else { uneven_resolution(values) }
}

/// Fewest transitions between levels that show two steps.
const TRANSITIONS: usize = 24;
/// From this mean of them on, in steps, there are two; what is below may be a few levels that noise has skipped.
const TWICE_FROM: f64 = 1.2;

/// By what the noise of readings is larger than that of rounding to `step`, because they had a coarser step before; 1 where they had none.
///
/// Of a rod so slow that it stays on each level for two rows or more, every level is seen: the mean way from one to the next is the coarser step.
fn rounded_twice(values: &[f64], step: f64) -> f64 {
    let levels: Vec<&[f64]> = values.chunk_by(|a, b| (a - b).abs() < 0.5 * step).collect();
    let slow = levels.windows(2).filter(|pair| pair[0].len() > 1 && pair[1].len() > 1);
    let ways: Vec<f64> = slow.map(|pair| (pair[1][0] - pair[0][0]).abs() / step).filter(|way| *way < 2.5).collect();
    let mean = ways.iter().sum::<f64>() / ways.len() as f64;
    if ways.len() >= TRANSITIONS && mean > TWICE_FROM { libm::hypot(mean, 1.0) } else { 1.0 }
}

/// Least share of the rows that repeat the reading before: with fewer, third differences show what rounding does.
const REPEATS: f64 = 0.25;
/// Fewest levels that show how steps grow along the range.
const LEVELS: usize = 16;
/// Levels on either side among which the smallest step is the step at that place.
const BESIDE: usize = 4;
/// How far a step from level to level may be off a whole number of steps there: the step grows, and readings are written with few digits.
const OFF: f64 = 0.15;

/// Root mean square over the rows of a step that grows along the range; 0 where the readings do not lie on levels.
///
/// Levels are the readings that occur. Those of noise with many digits are irregularly spaced: a fifth of them or so would pass.
fn uneven_resolution(values: &[f64]) -> f64 {
    let repeats = values.windows(2).filter(|pair| pair[0].to_bits() == pair[1].to_bits()).count();
    if (repeats as f64) < REPEATS * values.len() as f64 {
        return 0.0;
    }
    // A reading of −0 is one of 0.
    let mut sorted: Vec<f64> = values.iter().map(|value| value + 0.0).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let levels: Vec<&[f64]> = sorted.chunk_by(|a, b| a.to_bits() == b.to_bits()).collect();
    // Readings of a rod that moves on from row to row lie as far apart as it goes in a row: most levels occur once.
    let once = levels.iter().filter(|level| level.len() == 1).count();
    if levels.len() < LEVELS || once * 2 > levels.len() {
        return 0.0;
    }
    let gaps: Vec<f64> = levels.windows(2).map(|pair| pair[1][0] - pair[0][0]).collect();
    let step_at = |gap: usize| {
        let beside = &gaps[gap.saturating_sub(BESIDE)..gaps.len().min(gap + BESIDE + 1)];
        beside.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let steps: Vec<f64> = (0..gaps.len()).map(step_at).collect();
    let whole =
        gaps.iter().zip(&steps).map(|(gap, step)| gap / step).filter(|ratio| (ratio - ratio.round()).abs() < OFF);
    if whole.count() * 10 < gaps.len() * 9 {
        return 0.0;
    }
    let rows_and_steps =
        levels.iter().enumerate().map(|(at, level)| (level.len() as f64, steps[at.min(steps.len() - 1)]));
    let square: f64 = rows_and_steps.map(|(rows, step)| rows * step * step).sum();
    (square / values.len() as f64).sqrt()
}

/// Lowest and highest value; without values, the lowest is above the highest.
pub fn extent<V: Borrow<f64>>(values: impl IntoIterator<Item = V>) -> (f64, f64) {
    let widened = |(low, high): (f64, f64), value: V| (low.min(*value.borrow()), high.max(*value.borrow()));
    values.into_iter().fold((f64::MAX, f64::MIN), widened)
}

/// The value that this share of all values lies below, by rank; `None` without values.
pub fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a rank")]
    let rank = (share * values.len().checked_sub(1)? as f64).round() as usize;
    Some(*values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// The median; 0 without values.
pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use recording::seeded_noise::Noise;

    use super::*;

    #[test]
    fn noise_of_a_quantised_ramp_is_that_of_its_rounding() {
        let ramp: Vec<f64> = (0..4000).map(|k| (f64::from(k) * 0.013).floor() * 0.5).collect();
        let step = resolution(&ramp);
        assert!((step - 0.5).abs() < 1e-12);
        assert!((noise(&ramp, step) - 0.5 / 12.0_f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn counts_that_a_logger_rounds_once_more_have_the_noise_of_both() {
        // An encoder of 13.9 µm, written in steps of 9.2 µm; slow strokes, and a rest at either end.
        let (counts, written) = (13.9e-6, 9.2e-6);
        let exact = |k: u32| 2e-3 * (f64::from(k) * 1.1e-3).sin();
        let values: Vec<f64> =
            (0..9000).map(|k| (((exact(k) / counts).round() * counts) / written).round() * written).collect();
        let square: f64 = values.iter().zip(0..).map(|(value, k)| (value - exact(k)).powi(2)).sum();
        let found = noise(&values, resolution(&values));
        assert!((found / (square / values.len() as f64).sqrt() - 1.0).abs() < 0.1, "{found}");
        // The encoder by itself, and with noise.
        let mut dice = Noise::new(5, 0);
        for sigma in [0.0, 0.3, 1.0] {
            let noisy = |k| ((exact(k) / counts + dice.gaussian(sigma)).round()) * counts;
            let values: Vec<f64> = (0..9000).map(noisy).collect();
            assert!((resolution(&values) / counts - 1.0).abs() < 0.01, "{sigma}: {}", resolution(&values));
        }
    }

    /// A joint whose encoder has a step of 0.1 degrees: at both ends of the stroke it is another length.
    fn behind_a_linkage(written: impl Fn(f64) -> f64) -> Vec<f64> {
        let angle = |k: u32| {
            // It rests half of the time, and a fine disturbance moves it on.
            let way = (f64::from(k / 1500) + f64::from((k % 1500).min(750)) / 750.0) / 6.0;
            let exact = 0.3 + 1.9 * way.min(2.0 - way) + 1e-5 * f64::from(k).sin();
            written((exact / 1.745e-3).round() * 1.745e-3)
        };
        (0..9000).map(|k| (0.61 - 0.6 * angle(k).cos()).sqrt()).collect()
    }

    #[test]
    fn steps_that_grow_along_the_range_count_by_their_root_mean_square() {
        for written in [|angle: f64| angle, |angle: f64| (angle * 1e4).round() * 1e-4] {
            let values = behind_a_linkage(written);
            // By the slope of the law of cosines.
            let step = |y: f64| 0.3 * (1.0 - ((0.61 - y * y) / 0.6).powi(2)).sqrt() / y * 1.745e-3;
            let mean = (values.iter().map(|y| step(*y).powi(2)).sum::<f64>() / values.len() as f64).sqrt();
            let found = resolution(&values);
            assert!((found / mean - 1.0).abs() < 0.1, "{found} {mean}");
            assert!((noise(&values, found) / (mean / 12.0_f64.sqrt()) - 1.0).abs() < 0.25, "{}", noise(&values, found));
            // A level at 0 that is written with either sign is one level.
            let middle = values[values.len() / 3];
            let signed = |(row, y): (usize, &f64)| if row % 2 == 0 { y - middle } else { -(middle - y) };
            let about_zero: Vec<f64> = values.iter().enumerate().map(signed).collect();
            assert!(about_zero.iter().any(|y| y.to_bits() == (-0.0_f64).to_bits()));
            assert!((resolution(&about_zero) / found - 1.0).abs() < 0.01, "{} {found}", resolution(&about_zero));
        }
    }

    #[test]
    fn a_rod_that_moves_evenly_and_rests_has_not_the_resolution_of_its_way_from_row_to_row() {
        // 7 to 8 counts of 20 µm in a row, and half of the time at rest.
        let counts = |k: u32| (7.4 * f64::from((k % 900).min(450))).round();
        let values: Vec<f64> = (0..900).map(|k| 2e-5 * counts(k)).collect();
        assert!(resolution(&values) < 4e-5, "{}", resolution(&values));
    }

    #[test]
    fn noise_that_is_held_for_some_rows_has_no_resolution() {
        let mut noise = Noise::new(9, 0);
        let held: Vec<f64> = (0..2000).flat_map(|_| [noise.gaussian(1.0); 3]).collect();
        assert!(resolution(&held).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn noise_on_a_sine_is_found_within_a_tenth() {
        let mut seed = 1_u32;
        let mut uniform = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        let values: Vec<f64> =
            (0..5000).map(|k| (f64::from(k) * 0.01).sin() + 0.02 * (uniform() + uniform() + uniform())).collect();
        let found = noise(&values, resolution(&values));
        assert!((found / 0.01 - 1.0).abs() < 0.1, "{found}");
    }

    #[test]
    fn white_noise_is_found_without_bias() {
        let mut white = Noise::new(3, 0);
        let values: Vec<f64> = (0..50_000).map(|_| white.gaussian(0.01)).collect();
        let found = super::noise(&values, 0.0);
        assert!((found / 0.01 - 1.0).abs() < 0.02, "{found}");
    }

    #[test]
    fn ringing_is_not_taken_for_noise() {
        // A pressure at 200 Hz that rings after a jump every 0.4 s.
        let mut noise = Noise::new(7, 0);
        let ringing = |k: u32| 50.0 * (-0.3 * f64::from(k)).exp() * (0.63 * f64::from(k)).sin();
        let values: Vec<f64> = (0..4000).map(|k| ringing(k % 80) + noise.gaussian(0.01)).collect();
        let found = super::noise(&values, resolution(&values));
        assert!((0.9..1.5).contains(&(found / 0.01)), "{found}");
    }
}
