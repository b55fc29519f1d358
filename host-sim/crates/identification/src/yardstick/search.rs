//! The best shape: gains and initial states enter linearly and are solved for; lag, frequency, damping and delay are searched on a grid and refined.
//!
//! This is separable least squares (variable projection, Golub and Pereyra 1973). The grid makes the search deterministic and finds the right valley.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Owned};

use super::record::Record;
use super::shape::Shape;

/// A shape with its delay and its linear values.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    pub(super) shape: Shape,
    pub(super) delay_s: f64,
    /// The gain of each input.
    pub(super) gains: Vec<f64>,
    /// What is added to the input.
    pub(super) constant: f64,
    /// Sum of squares over all recordings, with the initial states that fit best.
    pub(super) square: f64,
}

/// Which of the two shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Integrates,
    Follows,
}

/// Starts of the refinement: the best points of the grid.
const STARTS: usize = 2;
/// Share of a column's square that is no more than rounding.
const NOTHING: f64 = 1e-8;

/// What is searched: the records, and the range of times that they show.
pub(super) struct Sought<'a> {
    records: &'a [Record],
    inputs: usize,
    kind: Kind,
    /// Between two rows, s.
    spacing_s: f64,
    /// The longest recording, s.
    longest_s: f64,
    /// The largest delay, s.
    most_delay_s: f64,
}

impl<'a> Sought<'a> {
    pub(super) fn new(records: &'a [Record], kind: Kind) -> Option<Self> {
        /// A delay of more than this share of the shortest recording is not looked for.
        const MOST_DELAY: f64 = 0.25;
        let inputs = records.iter().map(|record| record.inputs.len()).min()?;
        let durations = || records.iter().map(Record::duration_s);
        let rows: usize = records.iter().map(|record| record.rows.len()).sum();
        let spacing_s = durations().sum::<f64>() / rows as f64;
        let longest_s = durations().fold(0.0, f64::max);
        let most_delay_s = MOST_DELAY * durations().fold(f64::INFINITY, f64::min);
        Some(Self { records, inputs, kind, spacing_s, longest_s, most_delay_s })
    }

    /// The best of its kind; `None` where no input moves anything.
    pub(super) fn best(&self) -> Option<Solved> {
        let mut tried: Vec<(f64, Vec<f64>)> =
            self.grid().into_iter().filter_map(|at| Some((self.solved(&at)?.0.square, at))).collect();
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let refined = tried.into_iter().take(STARTS).filter_map(|(_, at)| self.solved(&self.refined(at)));
        refined.map(|(solved, _)| solved).min_by(|a, b| a.square.total_cmp(&b.square))
    }

    /// Points to begin from: logarithms of times and damping, and a delay in rows' intervals.
    fn grid(&self) -> Vec<Vec<f64>> {
        const TIMES: u32 = 10;
        let (least, most) = (0.3 * self.spacing_s, 0.5 * self.longest_s);
        let times = (0..TIMES).map(|step| least * libm::pow(most / least, f64::from(step) / f64::from(TIMES - 1)));
        let delays = [0.0, 2.0 * self.spacing_s, 0.2 * self.most_delay_s, 0.6 * self.most_delay_s];
        let dampings: &[f64] = match self.kind {
            Kind::Integrates => &[1.0],
            Kind::Follows => &[0.2, 0.8, 2.0, 6.0],
        };
        let mut grid = Vec::new();
        for time_s in times {
            for delay_s in delays {
                for damping in dampings {
                    let mut at = vec![delay_s / self.spacing_s, libm::log(time_s)];
                    at.extend((self.kind == Kind::Follows).then(|| libm::log(*damping)));
                    grid.push(at);
                }
            }
        }
        grid
    }

    /// The shape and the delay at these coordinates.
    fn shape(&self, at: &[f64]) -> (Shape, f64) {
        let time_s = libm::exp(at[1].clamp(libm::log(0.03 * self.spacing_s), libm::log(30.0 * self.longest_s)));
        let shape = match self.kind {
            Kind::Integrates => Shape::Integrates { lag_s: time_s },
            Kind::Follows => Shape::Follows { omega: 1.0 / time_s, damping: libm::exp(at[2].clamp(-4.0, 6.0)) },
        };
        (shape, (at[0] * self.spacing_s).clamp(0.0, self.most_delay_s))
    }

    /// The best linear values at these coordinates, and what is left in each row.
    fn solved(&self, at: &[f64]) -> Option<(Solved, Vec<f64>)> {
        let (shape, delay_s) = self.shape(at);
        let shared = self.inputs + 1;
        let (mut matrix, mut gradient) = (DMatrix::<f64>::zeros(shared, shared), DVector::<f64>::zeros(shared));
        let mut raw = DVector::<f64>::zeros(shared);
        let mut all: Vec<Vec<Vec<f64>>> = Vec::with_capacity(self.records.len());
        for record in self.records {
            let mut columns = record.columns(&shape, delay_s, self.inputs);
            columns.push(record.recorded.clone());
            for column in &mut columns {
                column.iter_mut().zip(&record.weight).for_each(|(value, weight)| *value *= weight);
            }
            for (index, column) in columns.iter().take(shared).enumerate() {
                raw[index] += dot(column, column);
            }
            // What the recording's own initial state explains is nobody else's.
            let rate = columns.remove(shared + 1);
            let value = columns.remove(shared);
            let value = unit(value, &[]);
            let rate = unit(rate, std::slice::from_ref(&value));
            for column in &mut columns {
                without(column, &value);
                without(column, &rate);
            }
            for one in 0..shared {
                for other in 0..=one {
                    let product = dot(&columns[one], &columns[other]);
                    matrix[(one, other)] += product;
                    if one != other {
                        matrix[(other, one)] += product;
                    }
                }
                gradient[one] += dot(&columns[one], &columns[shared]);
            }
            all.push(columns);
        }
        // An input that never changes does what the constant does.
        let constant = self.inputs;
        let beside_constant = |input: usize| {
            let shared = matrix[(input, constant)].powi(2) / matrix[(constant, constant)];
            matrix[(input, input)] - if shared.is_finite() { shared } else { 0.0 }
        };
        let is_moved = (0..self.inputs).any(|input| beside_constant(input) > NOTHING * raw[input]);
        if !is_moved {
            return None;
        }
        let values = least_squares(&matrix, &gradient, &raw)?;
        let left: Vec<f64> = all
            .iter()
            .flat_map(|columns| {
                (0..columns[shared].len()).map(|row| {
                    let modelled: f64 = (0..shared).map(|index| values[index] * columns[index][row]).sum();
                    columns[shared][row] - modelled
                })
            })
            .collect();
        let square = dot(&left, &left);
        let gains = values.iter().take(self.inputs).copied().collect();
        Some((Solved { shape, delay_s, gains, constant: values[self.inputs], square }, left))
    }

    /// The coordinates of the least sum of squares near these.
    fn refined(&self, at: Vec<f64>) -> Vec<f64> {
        let problem = Refined { sought: self, at: DVector::from_vec(at) };
        let (found, _) = LevenbergMarquardt::new().with_patience(8).with_tol(1e-5).minimize(problem);
        found.at.as_slice().to_vec()
    }
}

/// The refinement, in the form that the optimiser needs.
struct Refined<'s, 'a> {
    sought: &'s Sought<'a>,
    at: DVector<f64>,
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Refined<'_, '_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, at: &DVector<f64>) {
        self.at.copy_from(at);
    }

    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(DVector::from_vec(self.sought.solved(self.at.as_slice())?.1))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        const STEP: f64 = 1e-3;
        let here = self.residuals()?;
        let mut jacobian = DMatrix::zeros(here.len(), self.at.len());
        for index in 0..self.at.len() {
            let mut moved = self.at.clone();
            moved[index] += STEP;
            let there = DVector::from_vec(self.sought.solved(moved.as_slice())?.1);
            jacobian.set_column(index, &((there - &here) / STEP));
        }
        Some(jacobian)
    }
}

/// The solution of the normal equations; directions that the columns do not have stay 0.
fn least_squares(matrix: &DMatrix<f64>, gradient: &DVector<f64>, raw: &DVector<f64>) -> Option<DVector<f64>> {
    let scale = raw.map(|square| if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 });
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |row, column| {
        matrix[(row, column)] * scale[row] * scale[column]
    });
    let solution = scaled.svd(true, true).solve(&gradient.component_mul(&scale), NOTHING).ok()?;
    let values = solution.component_mul(&scale);
    values.iter().all(|value| value.is_finite()).then_some(values)
}

pub(super) fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

/// Takes away what a column has in the direction of a unit column.
fn without(column: &mut [f64], direction: &[f64]) {
    let along = dot(column, direction);
    column.iter_mut().zip(direction).for_each(|(value, direction)| *value -= along * direction);
}

/// A column of length 1 without what others have of it; nothing where that is all.
fn unit(mut column: Vec<f64>, others: &[Vec<f64>]) -> Vec<f64> {
    let whole = dot(&column, &column);
    for other in others {
        without(&mut column, other);
    }
    let left = dot(&column, &column);
    let scale = if left > NOTHING * whole { 1.0 / left.sqrt() } else { 0.0 };
    for value in &mut column {
        *value *= scale;
    }
    column
}
