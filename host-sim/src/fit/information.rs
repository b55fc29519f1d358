//! What one recording tells of the free parameters: the normal equations of its residuals, gathered row by row while it is
//! simulated, so that an hour of recording needs no more memory than a second.

use model_core::machine::MachineError;
use nalgebra::{DMatrix, DVector};

use super::residuals::{missed_si, soft};
use super::slopes::{At, Judged};
use super::start::StartState;
use crate::dual::single;
use crate::prepare::Prepared;

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
    /// Runs a recording with the slopes of its residuals.
    pub(super) fn of(at: &At<'_>, start: StartState, case: &Prepared) -> Result<Self, MachineError> {
        let mut sums = Sums::new(at.free.len() + OF_START);
        let mut raw = Raw::new(at.free.len() + OF_START);
        at.each(start, case, &mut |judged| {
            if judged.simulated.is_some() && raw.add(judged) {
                raw.hand_on(&mut sums);
            }
        })?;
        raw.hand_on(&mut sums);
        Ok(sums.total())
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

/// Rows that are softened and summed up at a time.
const ROWS: usize = 4;

/// Rows that wait to be softened.
struct Raw {
    count: usize,
    /// Recorded minus simulated, SI.
    missed: [f64; ROWS],
    noise: [f64; ROWS],
    tolerance: [f64; ROWS],
    /// Coordinates.
    size: usize,
    /// Derivatives of the simulated signal, a row after the other.
    slopes: Vec<f32>,
}

impl Raw {
    fn new(size: usize) -> Self {
        let [missed, noise, tolerance] = [[0.0; ROWS]; 3];
        Self { count: 0, missed, noise, tolerance, size, slopes: vec![0.0; ROWS * size] }
    }

    /// Takes in a row; whether no other may follow before they are handed on.
    #[inline]
    fn add(&mut self, judged: &Judged<'_>) -> bool {
        let (index, channel) = (self.count, judged.channel);
        self.missed[index] = missed_si(channel, judged.row, judged.simulated);
        self.noise[index] = channel.noise;
        self.tolerance[index] = channel.tolerance;
        if let Some((by_shift, slopes)) = self.slopes[index * self.size..][..self.size].split_last_mut() {
            slopes.copy_from_slice(judged.slopes);
            *by_shift = single(judged.by_shift);
        }
        self.count += 1;
        self.count == ROWS
    }

    /// Hands the rows on as residuals with their slopes.
    fn hand_on(&mut self, sums: &mut Sums) {
        let softened: [(f64, f64); ROWS] =
            std::array::from_fn(|row| soft(self.missed[row] / self.noise[row], self.tolerance[row]));
        let scales: [f32; ROWS] = std::array::from_fn(|row| single(-softened[row].1 / self.noise[row]));
        let rows = self.slopes.chunks_exact(self.size).zip(softened.iter().zip(scales)).take(self.count);
        for (slopes, ((residual, _), scale)) in rows {
            sums.add(slopes.iter().map(|by| by * scale), *residual);
        }
        self.count = 0;
    }
}

/// Columns that are summed up at a time.
const COLUMNS: usize = 4;

/// Sums over rows. In double: what single precision rounds away of two nearly equal columns is more than any prior.
pub(super) struct Sums {
    /// Coordinates, and the residual as one more column.
    columns: usize,
    /// How many times [`COLUMNS`] that fills up to.
    blocks: usize,
    /// Rows that wait, a row after the other, each filled up with zeros.
    waiting: Vec<[f64; COLUMNS]>,
    /// How many.
    count: usize,
    /// Lower triangle of the products of columns, column after column, each filled up to the end of its block.
    products: Vec<[f64; COLUMNS]>,
    rows: f64,
}

impl Sums {
    /// Of rows of so many coordinates.
    pub(super) fn new(size: usize) -> Self {
        let columns = size + 1;
        let blocks = columns.div_ceil(COLUMNS);
        let [waiting, products] = [ROWS, columns].map(|rows| vec![[0.0; COLUMNS]; rows * blocks]);
        Self { columns, blocks, waiting, count: 0, products, rows: 0.0 }
    }

    /// Takes in a residual with its slopes by every coordinate.
    #[inline]
    pub(super) fn add(&mut self, slopes: impl Iterator<Item = f32>, residual: f64) {
        let row = self.waiting[self.count * self.blocks..][..self.blocks].as_flattened_mut();
        for (place, slope) in row.iter_mut().zip(slopes) {
            *place = f64::from(slope);
        }
        row[self.columns - 1] = residual;
        self.count += 1;
        self.rows += 1.0;
        if self.count == ROWS {
            self.gather();
        }
    }

    /// Adds the products of the rows that wait, in their order.
    fn gather(&mut self) {
        self.waiting[self.count * self.blocks..].fill([0.0; COLUMNS]);
        let mut rows = self.waiting.chunks_exact(self.blocks);
        if let [Some(a), Some(b), Some(c), Some(d)] = std::array::from_fn(|_| rows.next()) {
            for (index, sums) in self.products.chunks_exact_mut(self.blocks).enumerate() {
                let by = [a, b, c, d].map(|row| row[index / COLUMNS][index % COLUMNS]);
                // Most rows know nothing of some parameters.
                if by.iter().all(|slope| *slope == 0.0) {
                    continue;
                }
                let columns = a.iter().zip(b).zip(c.iter().zip(d));
                for (sums, ((a, b), (c, d))) in sums[..=index / COLUMNS].iter_mut().zip(columns) {
                    let (before, a, b, c, d) = (*sums, *a, *b, *c, *d);
                    *sums = std::array::from_fn(|column| {
                        before[column] + by[0] * a[column] + by[1] * b[column] + by[2] * c[column] + by[3] * d[column]
                    });
                }
            }
        }
        self.count = 0;
    }

    /// What all rows tell.
    pub(super) fn total(mut self) -> Information {
        self.gather();
        let size = self.columns - 1;
        let products = self.products.as_flattened();
        let product = |row: usize, column: usize| products[row.max(column) * self.blocks * COLUMNS + row.min(column)];
        Information {
            matrix: DMatrix::from_fn(size, size, product),
            gradient: DVector::from_fn(size, |row, _| product(size, row)),
            square: product(size, size),
            rows: self.rows,
        }
    }
}
