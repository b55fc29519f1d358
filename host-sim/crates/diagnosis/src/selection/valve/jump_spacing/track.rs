//! A recording of the position with its simulation: how much faster the rod is per opening, the spool's strokes in blocks, and the evidence of each
//! block for jumps of a length.

use identification::parallel;
use nalgebra::Complex;

use identification::experiment::{JudgedSignal, Prepared};
use identification::fit::{StartState, settle};
use model_core::machine::{Machine, MachineError, Parameter};
use recording::Signal;
use simulation::signal::noise::quantile;
use simulation::{InputPoint, Run, run_in_lanes};

use super::whiten::{filtered, without_spikes};
use super::{BLOCK_S, HEIGHTS, PHASES};

/// Harmonics of the saw-tooth.
const HARMONICS: usize = 2;
/// Most rows that are evaluated: more would not change the result.
const MOST_ROWS: usize = 60_000;
/// Opening, of full travel, below which the gain of the valve is too inaccurate to use.
const LEAST_OPENING: f64 = 0.004;

/// A recording of the position, with its simulation.
pub(crate) struct Track {
    pub(crate) time_s: Vec<f64>,
    /// Position recorded less simulated, m; later made white, in the same unit.
    pub(crate) missed_m: Vec<f64>,
    /// Noise of the position's sensor, m.
    pub(crate) noise_m: f64,
    /// The simulated spool, of full travel.
    pub(crate) x: Vec<f64>,
    /// How much faster the rod is per opening, m/s.
    pub(crate) gain: Vec<f64>,
    pub(crate) blocks: Vec<Block>,
}

/// Rows of a stroke over which the phase is taken as constant.
pub(crate) struct Block {
    pub(crate) first: usize,
    pub(crate) end: usize,
    /// Whether the spool moves in the positive direction.
    pub(crate) rises: bool,
    /// How far it moves, of full travel.
    pub(crate) travel: f64,
    /// Its mean speed, 1/s.
    pub(crate) speed: f64,
}

/// Evidence of a block for jumps of a length: its log-likelihood relative to noise alone, for each height and phase.
pub(crate) struct BlockLikelihood<'a> {
    pub(crate) block: &'a Block,
    pub(crate) gains: [[f64; PHASES]; HEIGHTS.len()],
}

/// The recordings with their simulation. `None` unless all have a position and none the spool: a recorded spool shows its jumps itself.
pub(crate) fn tracks(machine: &Machine<f64>, cases: &[&Prepared]) -> Result<Option<Vec<Track>>, MachineError> {
    let of = |case: &'_ Prepared, signal| case.channels.iter().position(|channel| channel.signal == signal);
    let position = |case: &&Prepared| {
        let is_unseen = case.stimulus.input_point == InputPoint::Command && of(case, Signal::Spool).is_none();
        of(case, Signal::Position).filter(|_| is_unseen)
    };
    let positions: Option<Vec<usize>> = cases.iter().map(position).collect();
    let Some(positions) = positions.filter(|positions| !positions.is_empty()) else { return Ok(None) };
    let starts: Vec<StartState> = parallel::try_each(cases, |case| settle(machine, case))?;
    let signals = vec![Signal::Position, Signal::Spool, Signal::Velocity];
    let runs: Vec<Run<'_>> = cases
        .iter()
        .zip(&starts)
        .map(|(case, start)| Run {
            stimulus: &case.stimulus,
            offset: start.offset(machine, case),
            signals: signals.clone(),
        })
        .collect();
    let most = MOST_ROWS / cases.len();
    let mut simulated: Vec<[Vec<f64>; 3]> = cases.iter().map(|_| std::array::from_fn(|_| Vec::new())).collect();
    run_in_lanes(machine, &runs, &mut |run, row, values| {
        if row < most {
            simulated[run].iter_mut().zip(values).for_each(|(series, value)| series.push(*value));
        }
    })?;
    let dead_zone = machine.get(Parameter::DeadZone);
    let track = |((case, channel), [position, x, velocity]): ((&&Prepared, usize), [Vec<f64>; 3])| {
        Track::of(&case.time_s[..x.len()], &case.channels[channel], &position, x, &velocity, dead_zone)
    };
    Ok(Some(cases.iter().zip(positions).zip(simulated).map(track).collect()))
}

impl Track {
    fn of(
        time_s: &[f64],
        channel: &JudgedSignal,
        position: &[f64],
        x: Vec<f64>,
        velocity: &[f64],
        dead_zone: f64,
    ) -> Self {
        let missed: Vec<f64> =
            channel.bridged().iter().zip(position).map(|(recorded, simulated)| recorded - simulated).collect();
        let gain = |(x, velocity): (&f64, &f64)| {
            let opening = x.abs() - dead_zone;
            if opening > LEAST_OPENING { velocity.abs() / opening } else { 0.0 }
        };
        let mut gain: Vec<f64> = x.iter().zip(velocity).map(gain).collect();
        // Next to the dead zone one small number is divided by another.
        let most = quantile(gain.iter().copied().filter(|gain| *gain > 0.0).collect(), 0.9).unwrap_or(0.0);
        for gain in &mut gain {
            *gain = gain.min(1.5 * most);
        }
        let blocks = blocks(time_s, &x, &gain);
        Self { time_s: time_s.to_vec(), missed_m: without_spikes(&missed), noise_m: channel.noise, x, gain, blocks }
    }

    pub(crate) fn rows(&self) -> usize {
        self.x.len()
    }

    pub(crate) fn squares_while_moving(&self) -> impl Iterator<Item = f64> + '_ {
        let rows = self.missed_m.iter().zip(&self.gain);
        rows.filter(|(_, gain)| **gain > 0.0).map(|(missed, _)| missed * missed)
    }

    /// Evidence of each block for jumps of a length. `variance` is that of the noise, m²; `memory` is the filter that makes it white.
    pub(crate) fn likelihoods<'s>(&'s self, length: f64, memory: &[f64], variance: f64) -> Vec<BlockLikelihood<'s>> {
        /// Share of the rows that counts as independent: the noise of neighbouring rows is not quite independent.
        const INDEPENDENT: f64 = 0.8;
        /// The usual variance counts as this many rows, since the variance of a short block is inaccurate.
        const ROWS_BEFORE: f64 = 10.0;
        /// Least share of the residual that remains, however well a saw-tooth explains it.
        const LEAST_LEFT: f64 = 1e-3;
        let waves: [Vec<Complex<f64>>; HARMONICS] = std::array::from_fn(|index| self.wave(length, index + 1, memory));
        let of_block = |block: &'s Block| {
            let rows = block.first..block.end;
            let missed = &self.missed_m[rows.clone()];
            // Sine and cosine of each harmonic.
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
                        let (sine, cosine) = libm::sincos(harmonic as f64 * angle);
                        [sine, cosine]
                    })
                    .collect();
                let matched = product(&shares, &along);
                let own: f64 = between.iter().zip(&shares).map(|(row, share)| share * product(row, &shares)).sum();
                for (height, gains) in HEIGHTS.iter().zip(&mut gains) {
                    let left = 1.0 + (height * height * own - 2.0 * height * matched) / noise;
                    gains[phase] = -weight * libm::log(left.max(LEAST_LEFT));
                }
            }
            BlockLikelihood { block, gains }
        };
        self.blocks.iter().map(of_block).collect()
    }

    /// What a harmonic of the saw-tooth leaves in the position, m, filtered like the residual that was made white.
    fn wave(&self, length: f64, harmonic: usize, memory: &[f64]) -> Vec<Complex<f64>> {
        let per_travel = std::f64::consts::TAU * harmonic as f64 / length;
        let height = length / (std::f64::consts::PI * harmonic as f64);
        let mut sum = Complex::new(0.0, 0.0);
        let mut wave = vec![sum];
        for row in 1..self.rows() {
            let (x, before) = (self.x[row], self.x[row - 1]);
            let gain = 0.5 * (self.gain[row] + self.gain[row - 1]);
            // The mean over a row in which the spool moves at constant speed.
            let half = 0.5 * per_travel * (x - before);
            let mean = if half.abs() < 1e-6 { 1.0 } else { libm::sin(half) / half };
            let angle = per_travel * (0.5 * (x + before) - self.x[0]);
            sum += Complex::cis(angle) * (height * gain * mean * (self.time_s[row] - self.time_s[row - 1]));
            wave.push(sum);
        }
        filtered(&wave, memory)
    }
}

/// The strokes of a spool, cut into blocks; without those where the spool rests or the valve is closed.
fn blocks(time_s: &[f64], x: &[f64], gain: &[f64]) -> Vec<Block> {
    /// Rows to each side over which the direction is determined.
    const AROUND: usize = 2;
    /// A step per row below this, of full travel, counts as rest.
    const RESTS: f64 = 1e-6;
    /// Least rows of a block.
    const FEWEST: usize = 6;
    /// Least share of its rows in which the rod moves.
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
