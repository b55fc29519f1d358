//! What one recording tells of the free parameters: the normal equations of its residuals, gathered row by row while it is
//! simulated, so that an hour of recording needs no more memory than a second.

use model_core::machine::{Machine, MachineError};
use nalgebra::{DMatrix, DVector};

use super::residuals::{missed, soft};
use super::start::{StartState, needs_level};
use crate::dual::{Dual, single};
use crate::prepare::Prepared;
use crate::recording::Signal;
use crate::simulate::{StartOffset, run};

/// Normal equations of one recording, by the free parameters and then the level and the shift of its start.
#[derive(Clone, Debug, PartialEq)]
pub struct Information {
    /// `JᵀJ`
    pub matrix: DMatrix<f64>,
    /// `Jᵀr`
    pub gradient: DVector<f64>,
    /// `rᵀr`
    pub square: f64,
    /// Rows counted.
    pub rows: f64,
}

/// Coordinates of a recording's start.
pub(crate) const OF_START: usize = 2;

impl Information {
    /// Runs a recording on dual numbers whose first `count` slots are the free parameters.
    pub(super) fn of<const P: usize>(
        machine: &Machine<Dual<P>>,
        count: usize,
        start: StartState,
        case: &Prepared,
    ) -> Result<Self, MachineError> {
        let size = count + OF_START;
        let mut level = Dual::<P>::constant_of(start.level_on(machine));
        if needs_level(case) {
            level.partials[count] = single(start.level_slope(machine));
        }
        let shift_m = Dual::constant_of(start.shift * case.start_sigma_m);
        let mut sums = Sums::<P>::new();
        run::<Dual<P>>(machine, &case.stimulus, StartOffset { level: Some(level), shift_m }, |row, sample| {
            for channel in &case.channels {
                let Some(simulated) = sample.signal(channel.signal) else { continue };
                if channel.failed[row] {
                    continue;
                }
                let (residual, slope) = soft(missed(channel, row, Some(simulated.value)), channel.tolerance);
                let scale = single(-slope / channel.noise);
                let shift = if channel.signal == Signal::Position { single(case.start_sigma_m) * scale } else { 0.0 };
                sums.add(residual, &simulated.partials.map(|by| by * scale), shift);
            }
        })?;
        let mut matrix = DMatrix::zeros(size, size);
        let mut gradient = DVector::zeros(size);
        for row in 0..=count {
            for column in 0..=count {
                matrix[(row, column)] = sums.matrix[row][column];
            }
            matrix[(row, count + 1)] = sums.by_shift[row];
            matrix[(count + 1, row)] = sums.by_shift[row];
            gradient[row] = sums.gradient[row];
        }
        matrix[(count + 1, count + 1)] = sums.shift_square;
        gradient[count + 1] = sums.shift_gradient;
        Ok(Self { matrix, gradient, square: sums.square, rows: sums.rows })
    }

    /// Normal equations of all recordings together, by the free parameters and then each recording's start; every coordinate
    /// has a unit normal prior.
    pub(crate) fn assembled(all: &[Information], coordinates: &DVector<f64>) -> (DMatrix<f64>, DVector<f64>, f64) {
        let size = coordinates.len();
        let count = size - OF_START * all.len();
        let mut matrix = DMatrix::identity(size, size);
        let mut gradient = coordinates.clone();
        let mut square = gradient.norm_squared();
        for (index, one) in all.iter().enumerate() {
            let at = |slot: usize| if slot < count { slot } else { slot + OF_START * index };
            for row in 0..count + OF_START {
                gradient[at(row)] += one.gradient[row];
                for column in 0..count + OF_START {
                    matrix[(at(row), at(column))] += one.matrix[(row, column)];
                }
            }
            square += one.square;
        }
        (matrix, gradient, square)
    }

    /// The free parameters' own equations once the start's two coordinates are eliminated; the start's priors are in.
    fn reduced(&self) -> (DMatrix<f64>, DVector<f64>) {
        let count = self.gradient.len() - OF_START;
        let own = self.matrix.view((0, 0), (count, count)).into_owned();
        let across = self.matrix.view((0, count), (count, OF_START)).into_owned();
        let start =
            self.matrix.view((count, count), (OF_START, OF_START)).into_owned() + DMatrix::identity(OF_START, OF_START);
        let Some(inverse) = start.try_inverse() else { return (own, self.gradient.rows(0, count).into_owned()) };
        (own - &across * inverse * across.transpose(), self.gradient.rows(0, count).into_owned())
    }

    /// Standard deviation of each coordinate, prior included. The residuals are correlated in time, so what the recordings tell is
    /// divided by their mean square and by how many neighbours tell the same; the priors keep theirs.
    #[must_use]
    pub fn deviations(all: &[Information], inflation: f64) -> Vec<f64> {
        let Some(first) = all.first() else { return Vec::new() };
        let count = first.gradient.len() - OF_START;
        let (square, rows) = all.iter().fold((0.0, 0.0), |sum, one| (sum.0 + one.square, sum.1 + one.rows));
        let scale = (square / rows.max(1.0)).max(1.0) * inflation.max(1.0);
        let mut matrix = DMatrix::identity(count, count);
        for one in all {
            matrix += one.reduced().0 / scale;
        }
        matrix.cholesky().map_or(vec![f64::NAN; count], |factor| {
            factor.inverse().diagonal().iter().map(|variance| variance.sqrt()).collect()
        })
    }

    /// The Newton step from the common solution to that without one recording.
    pub(super) fn step_without(all: &[Information], without: usize, coordinates: &[f64]) -> Vec<f64> {
        let count = coordinates.len();
        let mut matrix = DMatrix::identity(count, count);
        let mut gradient = DVector::from_column_slice(coordinates);
        for (_, one) in all.iter().enumerate().filter(|(index, _)| *index != without) {
            let (own, by) = one.reduced();
            matrix += own;
            gradient += by;
        }
        matrix.cholesky().map_or(vec![0.0; count], |factor| (-factor.solve(&gradient)).iter().copied().collect())
    }
}

/// Sums over rows. In double: what single precision rounds away of two nearly equal columns is more than any prior.
struct Sums<const P: usize> {
    matrix: [[f64; P]; P],
    gradient: [f64; P],
    by_shift: [f64; P],
    shift_square: f64,
    shift_gradient: f64,
    square: f64,
    rows: f64,
}

impl<const P: usize> Sums<P> {
    fn new() -> Self {
        Self {
            matrix: [[0.0; P]; P],
            gradient: [0.0; P],
            by_shift: [0.0; P],
            shift_square: 0.0,
            shift_gradient: 0.0,
            square: 0.0,
            rows: 0.0,
        }
    }

    #[inline]
    fn add(&mut self, residual: f64, slopes: &[f32; P], shift: f32) {
        let (slopes, shift) = (slopes.map(f64::from), f64::from(shift));
        for (row, by) in self.matrix.iter_mut().zip(&slopes) {
            for (sum, slope) in row.iter_mut().zip(&slopes) {
                *sum += by * slope;
            }
        }
        for (index, by) in slopes.iter().enumerate() {
            self.gradient[index] += by * residual;
            self.by_shift[index] += by * shift;
        }
        self.shift_square += shift * shift;
        self.shift_gradient += shift * residual;
        self.square += residual * residual;
        self.rows += 1.0;
    }
}
