//! What one recording says about the free parameters: the normal equations of its residuals, gathered row by row during
//! the simulation, so that an hour of recording needs no more memory than a second.

use nalgebra::{DMatrix, DVector};

use model_core::machine::MachineError;
pub(crate) use simulation::OF_START;
use simulation::number::dual::single;

use super::initial_state::StartState;
use super::jacobian::At;
use super::kept_jacobian::Jacobian;
use super::residuals::{missed, soft};
use crate::experiment::Prepared;

/// Normal equations of one recording, for the free parameters and then the level and the shift of its initial state.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalEquations {
    /// `JᵀJ`
    pub matrix: DMatrix<f64>,
    /// `Jᵀr`
    pub gradient: DVector<f64>,
    /// `rᵀr`
    pub square: f64,
    /// Rows counted.
    pub rows: f64,
}

impl NormalEquations {
    /// Runs a recording with the derivatives of its residuals, which are stored in the `jacobian`.
    pub(crate) fn of(
        at: &At<'_>,
        start: StartState,
        case: &Prepared,
        jacobian: &mut Jacobian,
    ) -> Result<Self, MachineError> {
        let mut sums = Sums::new(at.free.len() + OF_START);
        at.each(start, case, &mut |judged| {
            let Some(simulated) = judged.simulated else { return };
            let channel = judged.channel;
            let (residual, slope) = soft(missed(channel, judged.row, Some(simulated)), channel.tolerance);
            jacobian.put(judged.jacobian.iter().copied(), single(-1.0 / channel.noise));
            let scale = single(-slope / channel.noise);
            sums.add(judged.jacobian.iter().map(|by| by * scale), residual);
        })?;
        Ok(sums.total())
    }

    /// Normal equations of all recordings together, for the free parameters and then each recording's initial state; every
    /// coordinate has a unit normal prior.
    pub(crate) fn assembled(all: &[NormalEquations], coordinates: &DVector<f64>) -> (DMatrix<f64>, DVector<f64>, f64) {
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

    /// The equations of the free parameters alone, after the initial state's two coordinates are eliminated; the priors of these two are included.
    fn reduced(&self) -> (DMatrix<f64>, DVector<f64>) {
        let count = self.gradient.len() - OF_START;
        let own = self.matrix.view((0, 0), (count, count)).into_owned();
        let across = self.matrix.view((0, count), (count, OF_START)).into_owned();
        let start =
            self.matrix.view((count, count), (OF_START, OF_START)).into_owned() + DMatrix::identity(OF_START, OF_START);
        let Some(inverse) = start.try_inverse() else { return (own, self.gradient.rows(0, count).into_owned()) };
        (own - &across * inverse * across.transpose(), self.gradient.rows(0, count).into_owned())
    }

    /// Covariance of the coordinates, prior included; `None` where the recordings and the priors do not determine them.
    pub(crate) fn covariance(all: &[NormalEquations], inflation: f64) -> Option<DMatrix<f64>> {
        Self::precision(all, inflation).cholesky().map(|factor| factor.inverse())
    }

    /// Inverse of the covariance; it includes the correlations between coordinates. The residuals are correlated in time, so the recordings' part
    /// is divided by the residuals' mean square and by the number of rows per independent sample; the priors are not divided.
    pub(crate) fn precision(all: &[NormalEquations], inflation: f64) -> DMatrix<f64> {
        let Some(first) = all.first() else { return DMatrix::zeros(0, 0) };
        let count = first.gradient.len() - OF_START;
        let (square, rows) = all.iter().fold((0.0, 0.0), |sum, one| (sum.0 + one.square, sum.1 + one.rows));
        let scale = (square / rows.max(1.0)).max(1.0) * inflation.max(1.0);
        let mut matrix = DMatrix::identity(count, count);
        for one in all {
            matrix += one.reduced().0 / scale;
        }
        matrix
    }

    /// The Newton step from the common solution to the solution without one recording.
    pub(crate) fn step_without(all: &[NormalEquations], without: usize, coordinates: &[f64]) -> Vec<f64> {
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

/// Number of rows that are summed at a time.
const ROWS: usize = 4;

/// Sums over rows, in double precision: with two nearly equal columns, the rounding error of single precision is larger than any prior.
struct Sums {
    /// Number of coordinates, plus one column for the residual.
    columns: usize,
    /// Rows that are not summed yet, one after the other.
    waiting: Vec<f64>,
    /// Lower triangle of the products of columns, column after column.
    products: Vec<f64>,
    rows: f64,
}

impl Sums {
    fn new(size: usize) -> Self {
        let columns = size + 1;
        Self { columns, waiting: Vec::with_capacity(ROWS * columns), products: vec![0.0; columns * columns], rows: 0.0 }
    }

    #[inline]
    fn add(&mut self, jacobian: impl Iterator<Item = f32>, residual: f64) {
        self.waiting.extend(jacobian.map(f64::from));
        self.waiting.push(residual);
        self.rows += 1.0;
        if self.waiting.len() == ROWS * self.columns {
            self.gather();
        }
    }

    /// Adds the products of the waiting rows, in their order.
    fn gather(&mut self) {
        self.waiting.resize(ROWS * self.columns, 0.0);
        let mut rows = self.waiting.chunks_exact(self.columns);
        if let [Some(a), Some(b), Some(c), Some(d)] = std::array::from_fn(|_| rows.next()) {
            for (index, sums) in self.products.chunks_exact_mut(self.columns).enumerate() {
                let by = [a[index], b[index], c[index], d[index]];
                // In most rows some derivatives are 0.
                if by.iter().all(|slope| *slope == 0.0) {
                    continue;
                }
                let columns = a.iter().zip(b).zip(c.iter().zip(d));
                for (sum, ((a, b), (c, d))) in sums[..=index].iter_mut().zip(columns) {
                    *sum = *sum + by[0] * a + by[1] * b + by[2] * c + by[3] * d;
                }
            }
        }
        self.waiting.clear();
    }

    fn total(mut self) -> NormalEquations {
        self.gather();
        let size = self.columns - 1;
        let product = |row: usize, column: usize| self.products[row.max(column) * self.columns + row.min(column)];
        NormalEquations {
            matrix: DMatrix::from_fn(size, size, product),
            gradient: DVector::from_fn(size, |row, _| product(size, row)),
            square: product(size, size),
            rows: self.rows,
        }
    }
}
