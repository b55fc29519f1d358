//! What the jumps of a slider that no sensor sees leave in the position.
//!
//! A slider that sticks follows the free one, x, as a saw-tooth of its travel: from −½·L to ½·L around it and back at a jump,
//! L = band·(1 − kept) long, wherever a stroke began. The rod goes k = |v|/(|x| − dead zone) faster for each opening, so a model without jumps
//! leaves in the position ∫ k·saw(x/L + θ) dt. It repeats with x, and L and its height are one: of a stroke only the phase θ is not known.
//!
//! A simulation with jumps does not find that. When one of them comes hangs on the valve's gain to a three-hundredth, which the position does
//! not tell from the flow gain, and every neighbouring value has other jumps. Here the phase is free instead: the evidence for jumps of a length
//! is the likelihood of what is left under that saw-tooth, averaged over all courses of the phase, over that of noise alone.
//!
//! What is left is made white first, by an autoregression of its own: what is smooth in it, of whatever form's error, has little weight then.

use std::fmt;

use model_core::machine::{Machine, MachineError};
use model_core::parameter::Parameter;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use rustfft::num_complex::Complex;

use crate::fit::{CHANCE, StartState, settle};
use crate::noise::{median, quantile};
use crate::prepare::{Channel, Prepared};
use crate::presentation::significant;
use crate::recording::Signal;
use crate::simulate::{EntryPoint, Run, run_abreast};

/// Shortest and longest jump that is looked for, of full travel. Shorter ones a position hardly holds.
const LENGTHS: (f64, f64) = (0.003, 0.03);
/// Lengths between them, each 2 % longer than the last.
const COUNT: usize = 116;
/// Harmonics of the saw-tooth.
const HARMONICS: usize = 2;
/// Phases of a stroke.
const PHASES: usize = 24;
/// Times the height that belongs to a length: gain and dead zone are not exact.
const HEIGHTS: [f64; 5] = [0.5, 0.7, 0.85, 1.0, 1.2];
/// Speeds of the slider, 1/s, beyond which it no longer jumps: where a jump takes its time, a fast one glides.
const GLIDES: [f64; 4] = [f64::INFINITY, 1.0, 0.3, 0.1];
/// Most rows that are looked at: more say the same.
const MOST_ROWS: usize = 60_000;
/// Opening, of full travel, below which a valve that hardly opens says little of its gain.
const LEAST_OPENING: f64 = 0.004;
/// Length of a block, s: over so long a phase may be taken as it is.
const BLOCK_S: f64 = 0.1;
/// How far back the autoregression looks, s.
const MEMORY_S: f64 = 0.04;
/// Log-likelihood by which training recordings have to prefer jumps of some length to none: one chance in a hundred.
const TELLS: f64 = 4.6;
/// Neighbouring lengths, by their logarithm, say the same within the one, and something else beyond the other.
const NEAR: f64 = 0.06;
const FAR: f64 = 0.2;

/// Jumps of a slider that the position holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rhythm {
    /// How long a jump is, of full travel.
    pub length: f64,
    /// Log-likelihood that the recordings gain by jumps of any length over none.
    pub evidence: f64,
}

impl fmt::Display for Rhythm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "no sensor sees the slider, but the position repeats every {} % of its travel, as jumps so long leave it (log-likelihood {} over none)",
            significant(100.0 * self.length, 2),
            significant(self.evidence, 2)
        )
    }
}

impl Rhythm {
    /// What training recordings say, by a machine that follows them without jumps; `None` where they do not tell of any, or
    /// hold no position of a drive that its command alone drives.
    pub fn of(machine: &Machine<f64>, training: &[&Prepared]) -> Result<Option<Self>, MachineError> {
        let Some(by_length) = evidence(machine, training)? else { return Ok(None) };
        let lengths = lengths();
        let Some((best, most)) = by_length.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) else {
            return Ok(None);
        };
        let is_far = |length: &f64| (length / lengths[best]).ln().abs() > FAR;
        let elsewhere = lengths.iter().zip(&by_length).filter(|(length, _)| is_far(length)).map(|(_, value)| *value);
        let evidence = mean_of_logarithms(&by_length);
        // What form errors leave is alike at every length; what jumps leave stands out at theirs.
        let stands_out = most - elsewhere.fold(f64::NEG_INFINITY, f64::max) > CHANCE;
        Ok((evidence > TELLS && stands_out).then_some(Self { length: lengths[best], evidence }))
    }

    /// Whether held-out recordings prefer jumps as long as these to none, by more than chance.
    pub fn is_in(&self, machine: &Machine<f64>, held_out: &[&Prepared]) -> Result<bool, MachineError> {
        let Some(by_length) = evidence(machine, held_out)? else { return Ok(false) };
        let is_near = |length: &f64| (length / self.length).ln().abs() < NEAR;
        let near: Vec<f64> =
            lengths().iter().zip(by_length).filter(|(length, _)| is_near(length)).map(|(_, value)| value).collect();
        // Neighbours are alike: about three of them are independent.
        let most = near.into_iter().fold(f64::NEG_INFINITY, f64::max);
        Ok(most - 3.0_f64.ln() > CHANCE)
    }
}

/// The lengths that are looked for.
fn lengths() -> Vec<f64> {
    let (shortest, longest) = LENGTHS;
    let share = |index: usize| index as f64 / (COUNT - 1) as f64;
    (0..COUNT).map(|index| shortest * (longest / shortest).powf(share(index))).collect()
}

/// The logarithm of the mean of numbers of which the logarithms are given.
fn mean_of_logarithms(values: &[f64]) -> f64 {
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most + (values.iter().map(|value| (value - most).exp()).sum::<f64>() / values.len() as f64).ln()
}

/// Log-likelihood that recordings gain by jumps of each length. `None` where they cannot say.
fn evidence(machine: &Machine<f64>, cases: &[&Prepared]) -> Result<Option<Vec<f64>>, MachineError> {
    let Some(mut tracks) = tracks(machine, cases)? else { return Ok(None) };
    let Some(memory) = whitened(&mut tracks) else { return Ok(None) };
    let squares: Vec<f64> = tracks.iter().flat_map(Track::squares_while_moving).collect();
    let variance = usual(squares);
    if variance <= 0.0 {
        return Ok(None);
    }
    let of_length = |length: &f64| {
        let chains: Vec<Vec<Heard>> = tracks.iter().map(|track| track.heard(*length, &memory, variance)).collect();
        let under = |(height, glides)| chains.iter().map(|chain| along(chain, *length, height, glides)).sum();
        let models = (0..HEIGHTS.len()).flat_map(|height| GLIDES.iter().map(move |glides| (height, *glides)));
        mean_of_logarithms(&models.map(under).collect::<Vec<f64>>())
    };
    Ok(Some(lengths().par_iter().map(of_length).collect()))
}

/// The variance of normal noise, from the median of its squares.
fn usual(mut squares: Vec<f64>) -> f64 {
    const MEDIAN: f64 = 0.4549;
    median(&mut squares) / MEDIAN
}

/// A recording of the position, with what a machine simulates.
struct Track {
    time_s: Vec<f64>,
    /// Position recorded less simulated, m; then white, in the same unit.
    missed_m: Vec<f64>,
    /// Noise of the position's sensor, m.
    noise_m: f64,
    /// The simulated slider, of full travel.
    x: Vec<f64>,
    /// How much faster the rod is for each opening, m/s.
    gain: Vec<f64>,
    blocks: Vec<Block>,
}

/// Rows of a stroke over which a phase is taken as it is.
struct Block {
    first: usize,
    end: usize,
    /// Which way the slider goes.
    rises: bool,
    /// How far it goes, of full travel.
    travel: f64,
    /// Its mean speed, 1/s.
    speed: f64,
}

/// What a block says of jumps of a length: its log-likelihood over noise alone, for each height and phase.
struct Heard<'a> {
    block: &'a Block,
    gains: [[f64; PHASES]; HEIGHTS.len()],
}

/// The recordings with what a machine simulates of them; `None` unless all hold a position, and none the slider, which says itself when it jumps.
fn tracks(machine: &Machine<f64>, cases: &[&Prepared]) -> Result<Option<Vec<Track>>, MachineError> {
    let position = |case: &&'_ Prepared| case.channels.iter().position(|channel| channel.signal == Signal::Position);
    let tells = |case: &&Prepared| {
        case.stimulus.entry == EntryPoint::Command
            && position(case).is_some()
            && case.channels.iter().all(|channel| channel.signal != Signal::Spool)
    };
    if cases.is_empty() || !cases.iter().all(tells) {
        return Ok(None);
    }
    let starts: Vec<StartState> = cases.par_iter().map(|case| settle(machine, case)).collect::<Result<_, _>>()?;
    let signals = vec![Signal::Position, Signal::Spool, Signal::Velocity];
    let run = |(case, start): (&&'_ Prepared, &StartState)| start.offset(machine, case);
    let runs: Vec<Run<'_>> = cases
        .iter()
        .zip(&starts)
        .map(|pair| Run { stimulus: &pair.0.stimulus, offset: run(pair), signals: signals.clone() })
        .collect();
    let most = MOST_ROWS / cases.len();
    let mut simulated: Vec<[Vec<f64>; 3]> = cases.iter().map(|_| std::array::from_fn(|_| Vec::new())).collect();
    run_abreast(machine, &runs, |run, row, values| {
        if row < most {
            simulated[run].iter_mut().zip(values).for_each(|(series, value)| series.push(*value));
        }
    })?;
    let dead_zone = machine.get(Parameter::DeadZone);
    let track = |(case, [position, x, velocity]): (&&Prepared, [Vec<f64>; 3])| {
        let channel = case.channels.iter().find(|channel| channel.signal == Signal::Position)?;
        Some(Track::of(&case.time_s[..x.len()], channel, &position, x, &velocity, dead_zone))
    };
    Ok(cases.iter().zip(simulated).map(track).collect())
}

impl Track {
    fn of(time_s: &[f64], channel: &Channel, position: &[f64], x: Vec<f64>, velocity: &[f64], dead_zone: f64) -> Self {
        let missed: Vec<f64> =
            channel.bridged().iter().zip(position).map(|(recorded, simulated)| recorded - simulated).collect();
        let gain = |(x, velocity): (&f64, &f64)| {
            let opening = x.abs() - dead_zone;
            if opening > LEAST_OPENING { velocity.abs() / opening } else { 0.0 }
        };
        let mut gain: Vec<f64> = x.iter().zip(velocity).map(gain).collect();
        // Next to the dead zone a little is divided by a little.
        let most = quantile(gain.iter().copied().filter(|gain| *gain > 0.0).collect(), 0.9).unwrap_or(0.0);
        for gain in &mut gain {
            *gain = gain.min(1.5 * most);
        }
        let blocks = blocks(time_s, &x, &gain);
        Self { time_s: time_s.to_vec(), missed_m: without_spikes(&missed), noise_m: channel.noise, x, gain, blocks }
    }

    fn rows(&self) -> usize {
        self.x.len()
    }

    /// From row to row, s.
    fn interval_s(&self) -> f64 {
        (self.time_s[self.rows() - 1] - self.time_s[0]) / (self.rows() - 1) as f64
    }

    fn squares_while_moving(&self) -> impl Iterator<Item = f64> + '_ {
        let rows = self.missed_m.iter().zip(&self.gain);
        rows.filter(|(_, gain)| **gain > 0.0).map(|(missed, _)| missed * missed)
    }

    /// What each block says of jumps of a length. `variance` is that of the noise, m²; `memory` makes it white.
    fn heard<'s>(&'s self, length: f64, memory: &[f64], variance: f64) -> Vec<Heard<'s>> {
        /// Of neighbouring rows, whose noise is not quite independent, so many are.
        const INDEPENDENT: f64 = 0.8;
        /// The usual variance counts as so many rows: that of a short block says little.
        const ROWS_BEFORE: f64 = 10.0;
        /// Share of what is left above which no saw-tooth explains it.
        const LEAST_LEFT: f64 = 1e-3;
        let waves: [Vec<Complex<f64>>; HARMONICS] = std::array::from_fn(|index| self.wave(length, index + 1, memory));
        let of_block = |block: &'s Block| {
            let rows = block.first..block.end;
            let missed = &self.missed_m[rows.clone()];
            // Of each harmonic its sine and its cosine.
            let parts: Vec<Vec<f64>> = waves
                .iter()
                .flat_map(|wave| {
                    let wave = &wave[rows.clone()];
                    [wave.iter().map(|value| value.re).collect(), wave.iter().map(|value| value.im).collect()]
                })
                .collect();
            let product = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
            let along: Vec<f64> = parts.iter().map(|part| product(part, missed)).collect();
            let between: Vec<Vec<f64>> =
                parts.iter().map(|one| parts.iter().map(|other| product(one, other)).collect()).collect();
            let noise = product(missed, missed) + ROWS_BEFORE * variance;
            let weight = 0.5 * (INDEPENDENT * missed.len() as f64 + ROWS_BEFORE);
            let mut gains = [[0.0; PHASES]; HEIGHTS.len()];
            for phase in 0..PHASES {
                let angle = std::f64::consts::TAU * phase as f64 / PHASES as f64;
                let shares: Vec<f64> = (1..=HARMONICS)
                    .flat_map(|harmonic| {
                        let (sine, cosine) = (harmonic as f64 * angle).sin_cos();
                        [sine, cosine]
                    })
                    .collect();
                let matched = product(&shares, &along);
                let own: f64 = between.iter().zip(&shares).map(|(row, share)| share * product(row, &shares)).sum();
                for (height, gains) in HEIGHTS.iter().zip(&mut gains) {
                    let left = 1.0 + (height * height * own - 2.0 * height * matched) / noise;
                    gains[phase] = -weight * left.max(LEAST_LEFT).ln();
                }
            }
            Heard { block, gains }
        };
        self.blocks.iter().map(of_block).collect()
    }

    /// What a harmonic of the saw-tooth leaves in the position, m, as what is missed was made white.
    fn wave(&self, length: f64, harmonic: usize, memory: &[f64]) -> Vec<Complex<f64>> {
        let per_travel = std::f64::consts::TAU * harmonic as f64 / length;
        let height = length / (std::f64::consts::PI * harmonic as f64);
        let mut sum = Complex::new(0.0, 0.0);
        let mut wave = vec![sum];
        for row in 1..self.rows() {
            let (x, before) = (self.x[row], self.x[row - 1]);
            let gain = 0.5 * (self.gain[row] + self.gain[row - 1]);
            // The mean over a row in which the slider goes on evenly.
            let half = 0.5 * per_travel * (x - before);
            let mean = if half.abs() < 1e-6 { 1.0 } else { half.sin() / half };
            let angle = per_travel * (0.5 * (x + before) - self.x[0]);
            sum += Complex::cis(angle) * (height * gain * mean * (self.time_s[row] - self.time_s[row - 1]));
            wave.push(sum);
        }
        filtered(&wave, memory)
    }
}

/// A series with the rows that stand out of seven replaced by their median: what a spike leaves would ring on.
fn without_spikes(series: &[f64]) -> Vec<f64> {
    /// Rows to each side.
    const AROUND: usize = 3;
    let level =
        |row: usize| median(&mut series[row.saturating_sub(AROUND)..(row + AROUND + 1).min(series.len())].to_vec());
    let levels: Vec<f64> = (0..series.len()).map(level).collect();
    let apart: Vec<f64> = series.iter().zip(&levels).map(|(value, level)| (value - level).abs()).collect();
    let limit = 6.0 * usual(apart.iter().map(|apart| apart * apart).collect()).sqrt();
    let kept = |((value, level), apart): ((&f64, &f64), &f64)| if *apart > limit { *level } else { *value };
    series.iter().zip(&levels).zip(&apart).map(kept).collect()
}

/// The strokes of a slider in which it is not at rest nor the valve closed, cut into blocks.
fn blocks(time_s: &[f64], x: &[f64], gain: &[f64]) -> Vec<Block> {
    /// Rows to each side that a direction is taken over.
    const AROUND: usize = 2;
    /// Less than so much in a row, of full travel, is none.
    const RESTS: f64 = 1e-6;
    /// Least rows of a block.
    const FEWEST: usize = 6;
    /// Least share of them in which the rod moves.
    const MOVES: f64 = 0.3;
    /// Least travel of a block.
    const LEAST_TRAVEL: f64 = 1e-4;
    let rows = x.len();
    let direction = |row: usize| {
        let (from, to) = (row.saturating_sub(AROUND), (row + AROUND).min(rows - 1));
        let step = (x[to] - x[from]) / (to - from) as f64;
        if step.abs() < RESTS {
            0
        } else if step > 0.0 {
            1
        } else {
            -1
        }
    };
    let directions: Vec<i32> = (0..rows).map(direction).collect();
    let mut blocks = Vec::new();
    let mut first = 0;
    for end in 1..=rows {
        if end < rows && directions[end] == directions[first] {
            continue;
        }
        let duration_s = time_s[end - 1] - time_s[first];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let parts = ((duration_s / BLOCK_S).round() as usize).max(1);
        for part in 0..parts {
            let (from, to) = (first + (end - first) * part / parts, first + (end - first) * (part + 1) / parts);
            let moving = gain[from..to].iter().filter(|gain| **gain > 0.0).count() as f64;
            if to < from + FEWEST || moving < MOVES * (to - from) as f64 {
                continue;
            }
            let travel = (x[to - 1] - x[from]).abs();
            if travel > LEAST_TRAVEL {
                let speed = travel / (time_s[to - 1] - time_s[from]);
                blocks.push(Block { first: from, end: to, rises: directions[first] > 0, travel, speed });
            }
        }
        first = end;
    }
    blocks
}

/// Log-likelihood that a recording gains by jumps of a length and a height, averaged over all courses of their phase.
///
/// At a turn and after a rest the phase is open. Along a stroke it strays: a jump goes as far as the free slider has come at the end of a row,
/// and further the faster that is.
fn along(chain: &[Heard<'_>], length: f64, height: usize, glides: f64) -> f64 {
    /// Variance of the phase, in turns², for each length of a jump that the slider goes.
    const STRAYS: f64 = 0.002;
    /// What a change of speed adds to a jump, s.
    const LATE_S: f64 = 1e-3;
    let open = [1.0 / PHASES as f64; PHASES];
    let mut phases = open;
    let mut last: Option<&Block> = None;
    let mut sum = 0.0;
    for Heard { block, gains } in chain.iter().filter(|heard| heard.block.speed < glides) {
        phases = match last {
            Some(last) if last.end == block.first && last.rises == block.rises => {
                let travel = 0.5 * (last.travel + block.travel) / length;
                let late = LATE_S * (block.speed - last.speed) / length;
                strayed(&phases, STRAYS * travel + late * late)
            }
            _ => open,
        };
        let gains = &gains[height];
        let most = gains.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for (phase, gain) in phases.iter_mut().zip(gains) {
            *phase *= (gain - most).exp();
        }
        let total: f64 = phases.iter().sum();
        for phase in &mut phases {
            *phase /= total;
        }
        sum += most + total.ln();
        last = Some(block);
    }
    sum
}

/// Phases after they have strayed with a variance, in turns²: convolved with a normal distribution that is wrapped around.
fn strayed(phases: &[f64; PHASES], variance: f64) -> [f64; PHASES] {
    /// Probability that is left where none would be: no number is so small that it cannot come back.
    const LEAST: f64 = 1e-12;
    let mut kernel: [f64; PHASES] = std::array::from_fn(|step| {
        let turns = step as f64 / PHASES as f64;
        (-2..=2).map(|whole| (-0.5 * (turns + f64::from(whole)).powi(2) / variance.max(1e-6)).exp()).sum()
    });
    let total: f64 = kernel.iter().sum();
    for share in &mut kernel {
        *share /= total;
    }
    std::array::from_fn(|to| {
        let from = |from: usize| phases[from] * kernel[(to + PHASES - from) % PHASES];
        (0..PHASES).map(from).sum::<f64>().max(LEAST)
    })
}

/// Makes what is missed white, by one autoregression of all recordings; its filter, of the row itself first. `None` where there are too
/// few rows.
fn whitened(tracks: &mut [Track]) -> Option<Vec<f64>> {
    /// Least and most rows that the autoregression looks back.
    const ORDERS: (usize, usize) = (8, 40);
    /// Rounds in which rows where much is left lose their weight.
    const ROUNDS: usize = 3;
    /// A row weighs as much as noise of this share of the usual variance, at most.
    const LEAST_VARIANCE: f64 = 0.3;
    /// A squared row counts as so many times the median, at most.
    const MOST_SQUARE: f64 = 25.0;
    /// Beyond so many standard deviations a white row is cut off.
    const CUT: f64 = 6.0;
    let rows = tracks.iter().map(Track::rows).min()?;
    if rows < 4 * ORDERS.1 {
        return None;
    }
    let interval_s = tracks[0].interval_s();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
    let order = ((MEMORY_S / interval_s).round() as usize).clamp(ORDERS.0, ORDERS.1);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
    let around = ((0.5 * BLOCK_S / interval_s).round() as usize).max(1);
    let noise = tracks.iter().map(|track| track.noise_m.powi(2)).sum::<f64>() / tracks.len() as f64;
    let mut weights: Vec<Vec<f64>> = tracks.iter().map(|track| vec![1.0; track.rows()]).collect();
    let mut memory = vec![1.0];
    for _ in 0..ROUNDS {
        memory = autoregression(tracks, &weights, order, noise)?;
        for (track, weights) in tracks.iter().zip(&mut weights) {
            let left = filtered(&track.missed_m, &memory);
            let squares: Vec<f64> = left.iter().map(|value| value * value).collect();
            let usual = usual(squares.clone());
            let most = MOST_SQUARE * median(&mut squares.clone());
            let sums: Vec<f64> = std::iter::once(0.0)
                .chain(squares.iter().scan(0.0, |sum, square| {
                    *sum += square.min(most);
                    Some(*sum)
                }))
                .collect();
            for (row, weight) in weights.iter_mut().enumerate() {
                let (from, to) = (row.saturating_sub(around), (row + around + 1).min(squares.len()));
                let here = (sums[to] - sums[from]) / (to - from) as f64;
                *weight = 1.0 / here.max(LEAST_VARIANCE * usual).max(f64::MIN_POSITIVE);
            }
        }
        let (sum, count) =
            weights.iter().flatten().fold((0.0, 0.0), |(sum, count), weight| (sum + weight, count + 1.0));
        for weight in weights.iter_mut().flatten() {
            *weight *= count / sum;
        }
    }
    for track in tracks {
        let mut white = filtered(&track.missed_m, &memory);
        let limit = CUT * usual(white.iter().map(|value| value * value).collect()).sqrt();
        for value in &mut white {
            *value = value.clamp(-limit, limit);
        }
        // Before the first rows nothing is known.
        white[..=order].fill(0.0);
        track.missed_m = white;
    }
    Some(memory)
}

/// The filter that leaves least of what is missed, by weighted least squares; a ridge of the sensor's noise keeps it from what that hides.
fn autoregression(tracks: &[Track], weights: &[Vec<f64>], order: usize, noise: f64) -> Option<Vec<f64>> {
    const RIDGE: f64 = 1e-3;
    let mut normal = DMatrix::<f64>::zeros(order, order);
    let mut target = DVector::<f64>::zeros(order);
    let mut weighed = 0.0;
    for (track, weights) in tracks.iter().zip(weights) {
        for (window, &weight) in track.missed_m.windows(order + 1).zip(&weights[order..]) {
            let before = DVector::from_iterator(order, window[..order].iter().rev().copied());
            normal.syger(weight, &before, &before, 1.0);
            target.axpy(weight * window[order], &before, 1.0);
            weighed += weight;
        }
    }
    let ridge = RIDGE * weighed * noise + 1e-9 * normal.trace() / order as f64;
    normal += DMatrix::identity(order, order) * ridge;
    let solution = normal.cholesky()?.solve(&target);
    Some(std::iter::once(1.0).chain(solution.iter().map(|share| -share)).collect())
}

/// A series through a filter of its present and past rows.
fn filtered<T>(series: &[T], memory: &[f64]) -> Vec<T>
where
    T: Copy + std::ops::Mul<f64, Output = T> + std::iter::Sum,
{
    let at =
        |row: usize| memory.iter().take(row + 1).enumerate().map(|(back, share)| series[row - back] * *share).sum();
    (0..series.len()).map(at).collect()
}

#[cfg(test)]
mod tests;
