//! What a signal gains from one block of rows to the next.
//!
//! A rod that is driven by a measured force integrates what that force lacks: the simulated velocity is off for as long as friction lets it coast, and
//! the position for ever. A single wrong newton then shows in every later row, and a residual of ten thousand rows says no more than a few. What the residual
//! *gains* over a block is the impulse that the force lacked in it, and blocks are nearly independent.
//!
//! With r the share of a wrong velocity that is left a block later, a velocity y whose means over blocks are ȳ gains ȳₙ − r·ȳₙ₋₁, and a position, which
//! integrates the velocity, ȳₙ − 2r·ȳₙ₋₁ + r²·ȳₙ₋₂: the residual is *whitened* by the inverse of what made it. A constant error stays visible, reduced to
//! (1 − r) in a velocity and (1 − r)² in a position, so that a wrong mean force still counts.

use recording::Signal;

/// Blocks before the first gain.
const BEFORE: usize = 2;

/// The blocks of a recording, and how much of what a signal had is left a block later.
#[derive(Clone, Debug, PartialEq)]
pub struct Whitening {
    /// Index of the row after each block's last.
    ends: Vec<usize>,
    /// Of each block, whether it follows the one before without a gap and has at least half of the rows that fit into it.
    is_whole: Vec<bool>,
    /// What is left of a wrong velocity a block later, 0..1.
    left: f64,
}

impl Whitening {
    /// Blocks of `block_s` seconds in these times, s, in which a wrong velocity decays with the time constant `memory_s`.
    #[must_use]
    pub fn new(time_s: &[f64], block_s: f64, memory_s: f64) -> Self {
        let first = time_s.first().copied().unwrap_or_default();
        let last = time_s.last().copied().unwrap_or_default();
        let fit = block_s * time_s.len().saturating_sub(1) as f64 / (last - first).max(f64::MIN_POSITIVE);
        let (mut ends, mut is_whole) = (Vec::new(), Vec::new());
        let (mut block, mut begins, mut follows) = (0.0, 0, true);
        let mut end_at = |row: usize, follows: bool, begins: usize| {
            ends.push(row);
            is_whole.push(follows && (row - begins) as f64 >= 0.5 * fit);
        };
        for (row, time) in time_s.iter().enumerate() {
            let of_row = ((time - first) / block_s + 1e-6).floor();
            if of_row > block {
                end_at(row, follows, begins);
                (follows, begins) = (of_row < block + 1.5, row);
                block = of_row;
            }
        }
        end_at(time_s.len(), follows, begins);
        Self { ends, is_whole, left: libm::exp(-block_s / memory_s) }
    }

    /// The same where only these rows are left; `None` where a block has none of them.
    pub(crate) fn of_kept(&self, kept: &[usize]) -> Option<Self> {
        let ends: Vec<usize> = self.ends.iter().map(|end| kept.partition_point(|row| row < end)).collect();
        let are_all = ends.first().is_some_and(|first| *first > 0) && ends.windows(2).all(|pair| pair[0] < pair[1]);
        are_all.then(|| Self { ends, is_whole: self.is_whole.clone(), left: self.left })
    }

    /// Number of gains in a recording.
    #[must_use]
    pub fn gains(&self) -> usize {
        self.ends.len().saturating_sub(BEFORE)
    }

    /// One value for each gain: that of its last row.
    #[must_use]
    pub fn at_ends<T: Copy>(&self, rows: &[T]) -> Vec<T> {
        self.ends.iter().skip(BEFORE).filter_map(|end| rows.get(end.checked_sub(1)?).copied()).collect()
    }

    /// The gains that say nothing: a marked row takes part, a gap in time, or a block with few rows.
    #[must_use]
    pub fn spoilt(&self, rows: &[bool]) -> Vec<bool> {
        let begins = [0].into_iter().chain(self.ends.iter().copied());
        let gains = begins.zip(self.ends.iter().skip(BEFORE)).zip(self.is_whole.windows(BEFORE + 1));
        gains.map(|((from, &to), whole)| rows[from..to].contains(&true) || whole.contains(&false)).collect()
    }

    /// What a recorded signal gains.
    #[must_use]
    pub fn gains_of(&self, signal: Signal, values: &[f64]) -> Vec<f64> {
        let mut gaining = Gaining::new(self, [integrations(signal)]);
        values.iter().filter_map(|&value| gaining.take([value]).map(|(_, gained)| gained[0])).collect()
    }

    /// Standard deviation of a gain over that of each row's independent noise.
    #[must_use]
    pub fn noise_of(&self, signal: Signal) -> f64 {
        let rows = self.ends.last().copied().unwrap_or(1) as f64 / self.ends.len().max(1) as f64;
        let squares: f64 = self.weights(integrations(signal)).iter().map(|weight| weight * weight).sum();
        (squares / rows.max(1.0)).sqrt()
    }

    /// Weights of the mean over a block, over the one before, and the one before that.
    fn weights(&self, integrations: usize) -> [f64; 3] {
        match integrations {
            0 => [1.0, 0.0, 0.0],
            1 => [1.0, -self.left, 0.0],
            _ => [1.0, -2.0 * self.left, self.left * self.left],
        }
    }
}

/// How many times a force that is lacking is integrated to what it changes in a signal, as far as it decays with the velocity.
fn integrations(signal: Signal) -> usize {
    match signal {
        Signal::Velocity => 1,
        Signal::Position => 2,
        _ => 0,
    }
}

/// Values that gain, row by row.
pub(crate) struct Gaining<'a> {
    whitening: &'a Whitening,
    /// Of each value.
    weights: Vec<[f64; 3]>,
    /// Of each value: the sum over the block so far, and the means over the two blocks before, the last first.
    sums: Vec<f64>,
    means: [Vec<f64>; 2],
    gained: Vec<f64>,
    row: usize,
    rows_in_block: f64,
    block: usize,
}

impl<'a> Gaining<'a> {
    pub(crate) fn of_signals(whitening: &'a Whitening, signals: &[Signal]) -> Self {
        Self::new(whitening, signals.iter().map(|&signal| integrations(signal)))
    }

    /// So many values that belong to one signal.
    pub(crate) fn of_signal(whitening: &'a Whitening, signal: Signal, values: usize) -> Self {
        Self::new(whitening, std::iter::repeat_n(integrations(signal), values))
    }

    fn new(whitening: &'a Whitening, integrations: impl IntoIterator<Item = usize>) -> Self {
        let weights: Vec<[f64; 3]> = integrations.into_iter().map(|times| whitening.weights(times)).collect();
        let zeros = vec![0.0; weights.len()];
        let means = [zeros.clone(), zeros.clone()];
        Self { whitening, weights, sums: zeros.clone(), means, gained: zeros, row: 0, rows_in_block: 0.0, block: 0 }
    }

    /// Takes the next row; where it ends a block, the index of the gain, and what each value gained.
    pub(crate) fn take(&mut self, row: impl IntoIterator<Item = f64>) -> Option<(usize, &[f64])> {
        self.sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
        self.rows_in_block += 1.0;
        self.row += 1;
        if self.whitening.ends.get(self.block) != Some(&self.row) {
            return None;
        }
        let [before, long_before] = &mut self.means;
        for (place, gained) in self.gained.iter_mut().enumerate() {
            let now = self.sums[place] / self.rows_in_block;
            let [a, b, c] = self.weights[place];
            *gained = a * now + b * before[place] + c * long_before[place];
            long_before[place] = before[place];
            before[place] = now;
            self.sums[place] = 0.0;
        }
        self.rows_in_block = 0.0;
        self.block += 1;
        Some((self.block.checked_sub(BEFORE + 1)?, &self.gained))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A force that is wrong for one block, and friction that lets the velocity decay: position and velocity gain in that block and the next, and no
    /// longer, however long they stay wrong.
    #[test]
    fn a_wrong_force_shows_where_it_acts_and_not_in_what_it_leaves() {
        const ROWS: usize = 4000;
        let time_s: Vec<f64> = (0..ROWS).map(|row| row as f64 * 1e-3).collect();
        let memory_s = 0.4;
        let (mut velocity, mut position) = (0.0, 0.0);
        let (mut velocities, mut positions) = (Vec::new(), Vec::new());
        for row in 0..ROWS {
            let wrong = if (1000..1040).contains(&row) { 1.0 } else { 0.0 };
            velocity += (wrong - velocity / memory_s) * 1e-3;
            position += velocity * 1e-3;
            velocities.push(velocity);
            positions.push(position);
        }
        let whitening = Whitening::new(&time_s, 0.04, memory_s);
        let gains = whitening.gains_of(Signal::Velocity, &velocities);
        assert_eq!(gains.len(), whitening.gains());
        let most = gains.iter().copied().fold(0.0, f64::max);
        // Half of what it gains falls into the block after, as a mean lags behind; later blocks have 2 % of it, for a decay is no step.
        let at = 1000 / 40 - BEFORE;
        assert!(gains[at] > 0.4 * most && gains[at + 1] > 0.4 * most, "{:?}", &gains[at - 1..at + 4]);
        let after = gains[at + 2..].iter().map(|gain| gain.abs()).fold(0.0, f64::max);
        assert!(after < 0.02 * most && gains[..at].iter().all(|gain| *gain == 0.0), "{after} {most}");
        // A position has the slow part of a friction that ends its motion: a tenth here, where it stays wrong for three seconds.
        let gains = whitening.gains_of(Signal::Position, &positions);
        let most = gains.iter().copied().fold(0.0, f64::max);
        let last = gains.last().copied().unwrap_or_default();
        assert!(last < 0.15 * most && position > 0.95 * 0.04 * memory_s, "{last} {most}");
    }

    #[test]
    fn what_is_kept_of_the_rows_has_the_same_blocks() {
        let time_s: Vec<f64> = (0..100).map(|row| f64::from(row) * 1e-3).collect();
        let whitening = Whitening::new(&time_s, 0.01, 0.1);
        assert_eq!(whitening.gains(), 8);
        let kept: Vec<usize> = (0..100).step_by(2).collect();
        let fewer = whitening.of_kept(&kept).unwrap();
        assert_eq!(fewer.gains(), 8);
        let every_second: Vec<f64> = kept.iter().map(|&row| time_s[row]).collect();
        let (all, some) = (whitening.gains_of(Signal::Force, &time_s), fewer.gains_of(Signal::Force, &every_second));
        assert!(all.iter().zip(&some).all(|(one, other)| (one - other - 5e-4).abs() < 1e-9), "{all:?} {some:?}");
        // Rows of a failed sensor spoil each gain that they take part in.
        let failed: Vec<bool> = (0..100).map(|row| row == 35).collect();
        assert_eq!(
            whitening.spoilt(&failed).iter().map(|any| u8::from(*any)).collect::<Vec<_>>(),
            [0, 1, 1, 1, 0, 0, 0, 0]
        );
        assert_eq!(whitening.at_ends(&time_s)[0].to_bits(), time_s[29].to_bits());
        // A block of a single row has none left of every second.
        assert_eq!(Whitening::new(&time_s, 1.2e-3, 0.1).of_kept(&kept), None);
        // Over a gap nothing is told: of the three gains that it takes part in.
        let gap: Vec<f64> = time_s.iter().map(|time| if *time < 0.0545 { *time } else { time + 0.5 }).collect();
        let spoilt = Whitening::new(&gap, 0.01, 0.1).spoilt(&[false; 100]);
        assert!(
            spoilt.iter().filter(|spoilt| **spoilt).count() >= 3 && !spoilt[0] && !spoilt[spoilt.len() - 1],
            "{spoilt:?}"
        );
    }

    #[test]
    fn noise_of_rows_is_that_of_its_gains() {
        let time_s: Vec<f64> = (0..40_000).map(|row| f64::from(row) * 1e-3).collect();
        let whitening = Whitening::new(&time_s, 0.02, 0.2);
        let mut noise = recording::seeded_noise::Noise::new(3, 1);
        let values: Vec<f64> = time_s.iter().map(|_| noise.gaussian(2.0)).collect();
        for signal in [Signal::Position, Signal::Velocity, Signal::PressureA] {
            let gains = whitening.gains_of(signal, &values);
            let rms = (gains.iter().map(|gain| gain * gain).sum::<f64>() / gains.len() as f64).sqrt();
            assert!((rms / (2.0 * whitening.noise_of(signal)) - 1.0).abs() < 0.06, "{signal:?} {rms}");
        }
    }
}
