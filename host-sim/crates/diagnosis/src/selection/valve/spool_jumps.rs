//! The jumps of a spool that sticks, and what they measure.
//!
//! The recorded spool shows when it jumps, from where and to where. The free spool is where the springs would hold the spool without stiction; at the
//! instant of a jump it is `band` away from the former rest and `kept·band` away from the new one. It is ahead of the middle between both by
//! ½·band·(1 + kept), and the jump is band·(1 − kept) long, whatever else the valve does. So each jump measures the free spool once, except for the
//! distance that it is ahead, which is the same for all jumps.

use identification::experiment::{JudgedSignal, Prepared};
use identification::fit::{FitError, Sensitivity};
use recording::Signal;
use simulation::signal::noise::{median, resolution};

use crate::selection::candidate::Candidate;
use crate::selection::decision_rule::{
    FEWEST_JUMPS, JUMP_BEYOND_NOISE, JUMP_MEASURES_WITHIN, JUMP_TAKES_ROWS, JUMPS_ALIKE, JUMPS_ALIKE_SHARE,
};

/// Least noise of a row, of full travel, for a spool whose readings at rest are equal to the last bit.
const LEAST_NOISE: f64 = 1e-5;
/// Most rows on either side of a jump over which its two levels are averaged.
const MOST_LEVEL: usize = 16;

/// A jump of the spool.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Jump {
    /// The first row after it.
    row: usize,
    /// Where the spool rested before the jump.
    from: f64,
    /// Where it rests after it.
    to: f64,
    /// Jumps per row, from the lengths of the rests before and after.
    per_row: f64,
}

impl Jump {
    fn length(&self) -> f64 {
        (self.to - self.from).abs()
    }
}

/// Every jump of a spool between two rests; `noise` is that of a row at rest.
fn jumps(spool: &JudgedSignal, noise: f64) -> Vec<Jump> {
    let x = &spool.bridged();
    let is_known = |row: usize| !spool.failed[row] && !spool.failed[row - 1];
    let is_far = |row: usize| is_known(row) && (x[row] - x[row - 1]).abs() > JUMP_BEYOND_NOISE * noise;
    // First and last row of each stretch in which the spool moves without a pause.
    let mut moves: Vec<(usize, usize)> = Vec::new();
    for row in (1..x.len()).filter(|&row| is_far(row)) {
        match moves.last_mut() {
            Some((_, last)) if *last + 1 == row => *last = row,
            _ => moves.push((row, row)),
        }
    }
    let mean = |rows: &[f64]| rows.iter().sum::<f64>() / rows.len() as f64;
    let ends = moves.iter().skip(1).map(|(first, _)| *first).chain([x.len()]);
    let starts = std::iter::once(0).chain(moves.iter().map(|(_, last)| *last));
    starts
        .zip(&moves)
        .zip(ends)
        .filter(|((start, (first, last)), end)| {
            *first >= start + 2 && *end >= last + 2 && last - first < JUMP_TAKES_ROWS
        })
        .map(|((start, &(row, last)), end)| Jump {
            row,
            from: mean(&x[start.max(row.saturating_sub(MOST_LEVEL))..row]),
            to: mean(&x[last..end.min(last + MOST_LEVEL)]),
            per_row: 0.5 * (1.0 / (row - start) as f64 + 1.0 / (end - last) as f64),
        })
        .collect()
}

/// Noise of a row of a spool that mostly rests. It is at least the sensor's resolution, since all changes by one count are equally long and would
/// pass for jumps.
fn noise_at_rest(spool: &JudgedSignal) -> f64 {
    // For white noise: median of the absolute differences over their standard deviation, times that standard deviation over the noise's.
    const SHARE: f64 = 0.6745 * std::f64::consts::SQRT_2;
    let readings = spool.bridged();
    let mut steps: Vec<f64> = readings.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    (median(&mut steps) / SHARE).max(resolution(&readings)).max(LEAST_NOISE)
}

/// Whether two jumps have about the same length.
pub(crate) fn is_alike(one: f64, other: f64) -> bool {
    (one / other - 1.0).abs() < JUMPS_ALIKE
}

/// Recordings of a spool that sticks, each with its jumps.
pub(crate) struct Sticking<'a> {
    /// Each recording with the jumps that measure the free spool.
    recordings: Vec<(&'a Prepared, Vec<Jump>)>,
    /// How long a jump is.
    pub(crate) length: f64,
    /// Standard deviation with which a jump measures the free spool.
    noise: f64,
}

impl<'a> Sticking<'a> {
    /// The recordings in which the spool jumps, at least so many of them; `None` where it does not stick.
    pub(crate) fn of(cases: &[&'a Prepared], at_least: usize) -> Option<Self> {
        let with_jumps = |case: &&'a Prepared| {
            let spool = case.channels.iter().find(|channel| channel.signal == Signal::Spool)?;
            let noise = noise_at_rest(spool);
            Some((*case, jumps(spool, noise), noise))
        };
        let all: Vec<_> = cases.iter().filter_map(with_jumps).collect();
        let sensor = median(&mut all.iter().map(|(.., noise)| *noise).collect::<Vec<f64>>());
        let lengths: Vec<f64> = all.iter().flat_map(|(_, jumps, _)| jumps.iter().map(Jump::length)).collect();
        let mut sorted = lengths.clone();
        sorted.sort_by(f64::total_cmp);
        // Number of jumps with about this length; sorted, since an hour may hold a hundred thousand.
        let with = |length: f64| {
            let shorter = sorted.partition_point(|one| *one < length && !is_alike(*one, length));
            sorted[shorter..].partition_point(|one| is_alike(*one, length))
        };
        let length = lengths.iter().copied().max_by(|a, b| with(*a).cmp(&with(*b)))?;
        if (with(length) as f64) < JUMPS_ALIKE_SHARE * lengths.len() as f64 {
            return None;
        }
        let length = median(&mut lengths.iter().copied().filter(|one| is_alike(*one, length)).collect::<Vec<f64>>());
        // From jump to jump the free spool moves by one jump length; this gives about how far it moves between two rows.
        let unseen = |jump: &Jump| length * jump.per_row / 12.0_f64.sqrt();
        let jumps = || all.iter().flat_map(|(_, jumps, _)| jumps).filter(|jump| is_alike(jump.length(), length));
        let usual = median(&mut jumps().map(unseen).collect::<Vec<f64>>());
        // Where the free spool moves far between two rows, a jump does not measure it.
        let is_slow = |jump: &Jump| unseen(jump) <= JUMP_MEASURES_WITHIN * usual;
        let slow: Vec<f64> = jumps().filter(|jump| is_slow(jump)).map(|jump| unseen(jump).powi(2)).collect();
        let unseen = (slow.iter().sum::<f64>() / slow.len() as f64).sqrt();
        let recordings: Vec<(&Prepared, Vec<Jump>)> = all
            .iter()
            .map(|(case, jumps, _)| {
                let tells = |jump: &&Jump| is_alike(jump.length(), length) && is_slow(jump);
                (*case, jumps.iter().filter(tells).copied().collect::<Vec<Jump>>())
            })
            .filter(|(_, jumps)| jumps.len() >= FEWEST_JUMPS)
            .collect();
        // The middle between two levels, each of which is the mean of a few rows.
        let noise = libm::hypot(0.5 * sensor, unseen);
        (recordings.len() >= at_least).then_some(Self { recordings, length, noise })
    }

    /// The free spool as the jumps measure it, if it is ahead of their middles by `ahead`.
    pub(crate) fn freed(&self, ahead: f64) -> Vec<Prepared> {
        let freed = |(case, jumps): &(&Prepared, Vec<Jump>)| {
            let mut freed = case.judged_by(|signal| signal == Signal::Spool);
            freed.stimulus = case.stimulus.midway();
            for channel in &mut freed.channels {
                channel.noise = self.noise;
                channel.tolerance = 1.0;
                channel.failed.fill(true);
                for jump in jumps {
                    channel.failed[jump.row] = false;
                    channel.recorded[jump.row] =
                        f64::midpoint(jump.from, jump.to) + ahead.copysign(jump.to - jump.from);
                }
            }
            freed
        };
        self.recordings.iter().map(freed).collect()
    }

    /// How much further ahead the free spool is according to these residuals, with all free values of the fit adapted to it.
    pub(crate) fn further(&self, candidate: &Candidate, freed: &[&Prepared]) -> Result<f64, FitError> {
        let Some(sensitivity) = Sensitivity::at(&candidate.fit, freed)? else { return Ok(0.0) };
        let mut there = sensitivity.simulated(&candidate.fit.machine)?;
        // A recording that is further ahead acts on the residual like a simulation that is less far ahead. The spool is the only channel.
        for ((_, jumps), there) in self.recordings.iter().zip(&mut there) {
            for jump in jumps {
                if let Some(at) = sensitivity.place_of(jump.row).and_then(|place| there.get_mut(place)) {
                    *at -= self.noise.copysign(jump.to - jump.from);
                }
            }
        }
        let (amounts, _) = sensitivity.amounts(&[sensitivity.change(&there)], &[false]);
        Ok(amounts.first().map_or(0.0, |amount| amount * self.noise))
    }

    /// Stiction whose free spool is this far ahead of the middle of a jump: its band, and the kept share by which a jump ends short.
    pub(crate) fn effect_parameters(&self, ahead: f64) -> (f64, f64) {
        let band = ahead + 0.5 * self.length;
        (band, (ahead - 0.5 * self.length).max(0.0) / band)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spool with so many rows that follows `at`, with a sensor's noise.
    fn spool(rows: usize, at: impl Fn(f64) -> f64) -> JudgedSignal {
        let mut generator = recording::seeded_noise::Noise::new(5, 1);
        let time_s: Vec<f64> = (0..rows).map(|row| row as f64 * 1e-3).collect();
        let recorded: Vec<f64> = time_s.iter().map(|time_s| at(*time_s) + generator.gaussian(3e-4)).collect();
        JudgedSignal::of(Signal::Spool, &time_s, &recorded)
    }

    /// Position of a spool that jumps by 0.01 each time and follows a free spool that rises and falls at 0.2/s.
    fn staircase(time_s: f64) -> f64 {
        let free = 0.2 * (0.5 - (time_s - 0.5).abs());
        (free / 0.01).floor() * 0.01
    }

    #[test]
    fn every_jump_of_a_staircase_is_found_with_its_levels() {
        let spool = spool(1000, staircase);
        let noise = noise_at_rest(&spool);
        assert!((noise / 3e-4 - 1.0).abs() < 0.1, "{noise}");
        let found = jumps(&spool, noise);
        // 0 to 0.09 and back, in steps; jumps next to the turn or an end of the recording may be missing.
        assert!((17..=20).contains(&found.len()), "{}", found.len());
        for jump in &found {
            assert!(is_alike(jump.length(), 0.01), "{jump:?}");
            assert!(
                (spool.recorded[jump.row] - jump.to).abs() < 2e-3 && (jump.per_row * 50.0 - 1.0).abs() < 0.6,
                "{jump:?}"
            );
        }
    }

    #[test]
    fn a_sensor_that_counts_does_not_make_a_spool_jump() {
        const COUNT: f64 = 1.0 / 2048.0;
        let time_s: Vec<f64> = (0..4000).map(|row| f64::from(row) * 1e-3).collect();
        let triangle = |time_s: &f64| 0.05 * (1.0 - (time_s - 2.0).abs());
        let counted: Vec<f64> = time_s.iter().map(|at| (triangle(at) / COUNT).round() * COUNT).collect();
        let spool = JudgedSignal::of(Signal::Spool, &time_s, &counted);
        assert!(jumps(&spool, noise_at_rest(&spool)).is_empty());
    }

    #[test]
    fn a_spool_that_follows_steps_of_one_size_does_not_jump() {
        let lagged = |time_s: f64| {
            let (step, since_s) = ((time_s / 0.1).floor(), time_s.rem_euclid(0.1));
            let (from, to) = if step.rem_euclid(2.0) < 1.0 { (0.1, 0.0) } else { (0.0, 0.1) };
            to + (from - to) * (-since_s / 0.01).exp()
        };
        let spool = spool(1000, lagged);
        assert!(jumps(&spool, noise_at_rest(&spool)).len() < FEWEST_JUMPS);
    }
}
