//! How each residual changes with each free parameter at a solution: answers many questions about small changes at little cost.

use crate::parallel;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use model_core::machine::{Machine, MachineError};
use simulation::number::dual::single;
use simulation::{Run, Stimulus};

use super::initial_state::StartState;
use super::jacobian::At;
use super::normal_equations::{NormalEquations, OF_START};
use super::residuals::{missed, runs, simulated, soft};
use super::{Fit, MOST_PARAMETERS};
use crate::experiment::Prepared;

/// Largest number of rows that are kept. Of longer recordings every n-th row is kept and stands for those left out:
/// residuals and derivatives weigh as much as those of all rows.
const MOST_ROWS: usize = 60_000;

/// Runs of one task.
const RUNS_AT_ONCE: usize = 16;

/// Which rows are kept.
#[derive(Clone, Copy, Debug)]
struct Kept {
    /// n: every n-th row is kept.
    stride: usize,
    /// Root of the number of rows that each kept row stands for.
    weight: f64,
}

impl Kept {
    /// Which rows to keep out of this many.
    fn of(rows: usize) -> Self {
        let stride = rows.div_ceil(MOST_ROWS).max(1);
        Self { stride, weight: (stride as f64).sqrt() }
    }

    fn has(self, row: usize) -> bool {
        row.is_multiple_of(self.stride)
    }
}

/// Residuals of one recording at a solution, with their derivatives.
#[derive(Debug)]
struct Block {
    /// Softened residual, weighted, and the derivative of the softening, per kept row and channel.
    residuals: Vec<(f64, f64)>,
    /// Weighted derivative with respect to each coordinate of the recording (free parameters, level, shift), row by row.
    jacobian: Vec<f32>,
}

/// Residuals at a solution, linear in its free parameters.
#[derive(Debug)]
pub struct Sensitivity<'a> {
    cases: &'a [&'a Prepared],
    fit: &'a Fit,
    blocks: Vec<Block>,
    kept: Kept,
    factor: Cholesky<f64, Dyn>,
    gradient: DVector<f64>,
}

/// Every channel at the kept rows, row by row, SI; 0 where it is not simulated: one vector per recording.
pub type Simulated = Vec<Vec<f64>>;

/// A change of all residuals: one vector per recording.
pub type Change = Vec<Vec<f64>>;

/// Result of a linearised refit of the free parameters after a change of the residuals.
#[derive(Clone, Debug)]
pub struct Settled {
    /// Decrease of half the sum of squares.
    pub gain: f64,
    /// Half the sum of squares that remains.
    pub loss: f64,
    /// Values of the free parameters, and of each recording's initial state, after the refit.
    pub coordinates: Vec<f64>,
}

impl<'a> Sensitivity<'a> {
    /// Runs every recording once more at the solution.
    pub fn at(fit: &'a Fit, cases: &'a [&'a Prepared]) -> Result<Option<Self>, MachineError> {
        let kept = Kept::of(cases.iter().map(|case| case.rows()).sum());
        let count = fit.free.len();
        if count > MOST_PARAMETERS {
            return Ok(None);
        }
        let at = At { base: &fit.machine, free: &fit.free, coordinates: &fit.coordinates };
        let with_starts = cases.iter().zip(&fit.starts);
        let blocks = parallel::try_each(with_starts, |(case, start)| Block::at(&at, *start, case, kept))?;
        let normal_equations: Vec<NormalEquations> = blocks.iter().map(|block| block.normal_equations(count)).collect();
        let (matrix, gradient, _) = NormalEquations::assembled(&normal_equations, &fit.all_coordinates());
        Ok(matrix.cholesky().map(|factor| Self { cases, fit, blocks, kept, factor, gradient }))
    }

    /// What another machine simulates from the solution's initial states.
    pub fn simulated(&self, machine: &Machine<f64>) -> Result<Simulated, MachineError> {
        let cases = self.cases.iter().copied().zip(self.fit.starts.iter().copied());
        simulated(machine, &runs(machine, cases), |row| self.kept.has(row))
    }

    /// Half the sum of the squared residuals at the solution, without priors and without what noise leaves of it.
    #[must_use]
    pub fn misfit_above_noise(&self) -> f64 {
        let noise = self.kept.weight * self.kept.weight;
        let above = self.blocks.iter().flat_map(|block| &block.residuals).map(|(one, _)| 0.5 * (one * one - noise));
        above.sum::<f64>().max(0.0)
    }

    /// Half the sum of squares that a linearised refit of the free parameters leaves.
    #[must_use]
    pub fn settled_loss(&self) -> f64 {
        self.settle(&vec![Vec::new(); self.cases.len()]).loss
    }

    /// Power of each channel's residuals at each of these frequencies, Hz, over all recordings: what a wave of that frequency would explain of it.
    #[must_use]
    pub fn power_at(&self, hz: &[f64]) -> Vec<Vec<f64>> {
        let channels = self.cases.first().map_or(0, |case| case.channels.len());
        parallel::each(hz.iter().copied(), |hz| {
            let mut power = vec![0.0; channels];
            for (case, block) in self.cases.iter().zip(&self.blocks) {
                let mut sums = vec![(0.0, 0.0); case.channels.len()];
                for (row, residuals) in block.residuals.chunks_exact(case.channels.len()).enumerate() {
                    let time_s = case.time_s[row * self.kept.stride];
                    let (sine, cosine) = libm::sincos(std::f64::consts::TAU * hz * time_s);
                    for (sum, (residual, _)) in sums.iter_mut().zip(residuals) {
                        *sum = (sum.0 + residual * cosine, sum.1 + residual * sine);
                    }
                }
                let rows = (block.residuals.len() / case.channels.len().max(1)).max(1) as f64;
                for (power, (cosine, sine)) in power.iter_mut().zip(sums) {
                    *power += (cosine * cosine + sine * sine) / rows;
                }
            }
            power
        })
    }

    /// Index in the simulated values at which a row's channels begin; `None` where the row is left out.
    #[must_use]
    pub fn place_of(&self, row: usize) -> Option<usize> {
        self.kept.has(row).then_some(row / self.kept.stride)
    }

    /// Residuals of what another machine simulates, as they would enter the loss, less those of the solution.
    #[must_use]
    pub fn change(&self, simulated: &Simulated) -> Change {
        simulated.iter().enumerate().map(|(case, simulated)| self.change_of(case, simulated)).collect()
    }

    /// The same of one recording.
    fn change_of(&self, case: usize, simulated: &[f64]) -> Vec<f64> {
        let (channels, block) = (&self.cases[case].channels, &self.blocks[case]);
        let each = simulated.iter().zip(&block.residuals).enumerate();
        each.map(|(index, (there, (here, slope)))| {
            if *slope == 0.0 {
                return 0.0;
            }
            let (channel, row) = (&channels[index % channels.len()], index / channels.len() * self.kept.stride);
            let residual = soft(missed(channel, row, Some(*there)), channel.tolerance).0;
            self.kept.weight * residual - here
        })
        .collect()
    }

    /// Residuals of one recording under a further force on the rod (the recording's index, then N at the points of its grid), less those of the
    /// solution: one series for each of the forces.
    pub fn changes_by_force(&self, forces: &[(usize, Vec<f64>)]) -> Result<Vec<Vec<f64>>, MachineError> {
        let forced: Vec<Stimulus> =
            forces.iter().map(|(case, force_n)| self.cases[*case].stimulus.with_force(force_n)).collect();
        let with_starts = forces.iter().map(|&(case, _)| (self.cases[case], self.fit.starts[case]));
        let plain = runs(&self.fit.machine, with_starts);
        let runs: Vec<Run<'_>> =
            plain.into_iter().zip(&forced).map(|(run, stimulus)| Run { stimulus, ..run }).collect();
        // As many as run side by side: all of them at once would keep every row of every run.
        let parts =
            parallel::try_each(runs.chunks(RUNS_AT_ONCE).zip(forces.chunks(RUNS_AT_ONCE)), |(runs, forces)| {
                let there = simulated(&self.fit.machine, runs, |row| self.kept.has(row))?;
                let changes = forces.iter().zip(&there).map(|((case, _), there)| self.change_of(*case, there));
                Ok::<_, MachineError>(changes.collect::<Vec<_>>())
            })?;
        Ok(parts.into_iter().flatten().collect())
    }

    /// Derivatives with respect to every coordinate times a change.
    fn across(&self, change: &Change) -> DVector<f64> {
        let count = self.fit.free.len();
        let mut sum = DVector::zeros(self.gradient.len());
        for (index, (block, change)) in self.blocks.iter().zip(change).enumerate() {
            let mut own = vec![0.0_f64; count + OF_START];
            for (jacobian, change) in block.jacobian.chunks_exact(count + OF_START).zip(change) {
                for (sum, slope) in own.iter_mut().zip(jacobian) {
                    *sum += f64::from(*slope) * change;
                }
            }
            for (slot, value) in own.into_iter().enumerate() {
                sum[if slot < count { slot } else { slot + OF_START * index }] += value;
            }
        }
        sum
    }

    /// Linearised refit of the free parameters after this change of the residuals, with its gain.
    #[must_use]
    pub fn settle(&self, change: &Change) -> Settled {
        let mut by = 0.0;
        for (block, change) in self.blocks.iter().zip(change) {
            by += block
                .residuals
                .iter()
                .zip(change)
                .map(|((here, _), change)| change * (change + 2.0 * here))
                .sum::<f64>();
        }
        let unchanged = self.gradient.dot(&self.factor.solve(&self.gradient));
        let gradient = &self.gradient + self.across(change);
        let step = self.factor.solve(&gradient);
        let gain = 0.5 * (gradient.dot(&step) - unchanged - by);
        let here = self.fit.all_coordinates();
        Settled {
            gain,
            loss: self.fit.loss - 0.5 * unchanged - gain,
            coordinates: here.iter().zip(step.iter()).map(|(here, step)| here - step.clamp(-3.0, 3.0)).collect(),
        }
    }

    /// Amount of each direction that lowers the loss most after a linearised refit of the free parameters, at least 0 where
    /// `positive` is set; and the gain of all of them.
    #[must_use]
    pub fn amounts(&self, directions: &[Change], positive: &[bool]) -> (Vec<f64>, f64) {
        self.directed(directions).amounts(positive)
    }

    /// What directions change after a linearised refit of the free parameters.
    #[must_use]
    pub fn directed(&self, directions: &[Change]) -> Directed {
        let across: Vec<DVector<f64>> = directions.iter().map(|direction| self.across(direction)).collect();
        let settled: Vec<DVector<f64>> = across.iter().map(|across| self.factor.solve(across)).collect();
        let own = self.factor.solve(&self.gradient);
        let count = directions.len();
        let mut matrix = DMatrix::zeros(count, count);
        let mut right = DVector::zeros(count);
        for row in 0..count {
            let here = self.blocks.iter().zip(&directions[row]).map(|(block, direction)| {
                direction.iter().zip(&block.residuals).map(|(change, (residual, _))| change * residual).sum::<f64>()
            });
            right[row] = across[row].dot(&own) - here.sum::<f64>();
            for column in row..count {
                let cases = directions[row].iter().zip(&directions[column]);
                let plain: f64 = cases.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>()).sum();
                matrix[(row, column)] = plain - across[row].dot(&settled[column]);
                matrix[(column, row)] = matrix[(row, column)];
            }
        }
        // A direction that the free parameters can imitate has no effect.
        for index in 0..count {
            let size: f64 = matrix[(index, index)];
            matrix[(index, index)] = size * (1.0 + 1e-9) + 1e-6;
        }
        Directed { matrix, right }
    }
}

/// The loss over amounts of several directions, the free parameters refitted linearly for each of them.
#[derive(Clone, Debug)]
pub struct Directed {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
}

impl Directed {
    /// Amount of each direction that lowers the loss most, at least 0 where `positive` is set; and the gain of all of them.
    #[must_use]
    pub fn amounts(&self, positive: &[bool]) -> (Vec<f64>, f64) {
        let count = self.right.len();
        let mut active: Vec<usize> = (0..count).collect();
        while !active.is_empty() {
            let Some((solved, gain)) = self.solved(&active) else { break };
            let negative = (0..active.len()).filter(|&slot| positive[active[slot]] && solved[slot] <= 0.0);
            let Some(worst) = negative.min_by(|&a, &b| solved[a].total_cmp(&solved[b])) else {
                let mut amounts = vec![0.0; count];
                for (slot, &index) in active.iter().enumerate() {
                    amounts[index] = solved[slot];
                }
                return (amounts, gain);
            };
            active.remove(worst);
        }
        (vec![0.0; count], 0.0)
    }

    /// The gain of given amounts.
    #[must_use]
    pub fn gain_of(&self, amounts: &[f64]) -> f64 {
        let amounts = DVector::from_column_slice(amounts);
        self.right.dot(&amounts) - 0.5 * amounts.dot(&(&self.matrix * &amounts))
    }

    /// The same of some of the directions, the others left out.
    #[must_use]
    pub fn amounts_of(&self, directions: &[usize]) -> Option<(Vec<f64>, f64)> {
        self.solved(directions).map(|(solved, gain)| (solved.as_slice().to_vec(), gain))
    }

    fn solved(&self, active: &[usize]) -> Option<(DVector<f64>, f64)> {
        let size = active.len();
        let part = DMatrix::from_fn(size, size, |row, column| self.matrix[(active[row], active[column])]);
        let wanted = DVector::from_fn(size, |row, _| self.right[active[row]]);
        let solved = part.cholesky()?.solve(&wanted);
        let gain = 0.5 * solved.dot(&wanted);
        Some((solved, gain))
    }
}

impl Block {
    /// Runs a recording with the derivatives of its residuals, and keeps every n-th row.
    fn at(at: &At<'_>, start: StartState, case: &Prepared, kept: Kept) -> Result<Self, MachineError> {
        let mut block = Self { residuals: Vec::new(), jacobian: Vec::new() };
        at.each(start, case, &mut |judged| {
            if !kept.has(judged.row) {
                return;
            }
            let channel = judged.channel;
            let (residual, slope) = soft(missed(channel, judged.row, judged.simulated), channel.tolerance);
            let slope = if judged.simulated.is_some() { slope } else { 0.0 };
            block.residuals.push((kept.weight * residual, slope));
            let scale = single(kept.weight * -slope / channel.noise);
            if judged.simulated.is_some() {
                block.jacobian.extend(judged.jacobian.iter().map(|by| by * scale));
            } else {
                block.jacobian.extend(std::iter::repeat_n(0.0, at.free.len() + OF_START));
            }
        })?;
        Ok(block)
    }

    /// Normal equations of the kept rows.
    fn normal_equations(&self, count: usize) -> NormalEquations {
        let size = count + OF_START;
        let mut matrix = DMatrix::zeros(size, size);
        let mut gradient = DVector::zeros(size);
        let mut square = 0.0;
        for (jacobian, (residual, _)) in self.jacobian.chunks_exact(size).zip(&self.residuals) {
            for row in 0..size {
                let by = f64::from(jacobian[row]);
                gradient[row] += by * residual;
                for column in row..size {
                    matrix[(row, column)] += by * f64::from(jacobian[column]);
                }
            }
            square += residual * residual;
        }
        matrix.fill_lower_triangle_with_upper_triangle();
        NormalEquations { matrix, gradient, square, rows: self.residuals.len() as f64 }
    }
}
