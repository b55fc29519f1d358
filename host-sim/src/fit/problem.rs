//! The least-squares problem, as the optimiser wants it.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use model_core::machine::Machine;
use nalgebra::{DMatrix, DVector, Dyn, Owned};
use rayon::prelude::*;

use super::residuals::{Evaluation, effective_samples, soft};
use super::{Fit, Free, Freedom};
use crate::dual::Dual;
use crate::prepare::Prepared;

/// Standard deviation of the pressure level at rest, as a share of supply.
const LEVEL_SIGMA: f64 = 0.1;

/// Whether the level of pressure at rest is not recorded.
pub(super) fn needs_level(case: &Prepared) -> bool {
    case.stimulus.start.pressures_pa.is_none()
}

pub(super) struct Problem<'a> {
    base: &'a Machine<f64>,
    free: &'a [Free],
    cases: &'a [&'a Prepared],
    /// Free parameters, then one level for each recording that needs it.
    pub(super) coordinates: DVector<f64>,
    jacobian: Option<DMatrix<f64>>,
}

impl<'a> Problem<'a> {
    pub(super) fn new(base: &'a Machine<f64>, free: &'a [Free], cases: &'a [&'a Prepared], from: Option<&Fit>) -> Self {
        let levels = cases.iter().filter(|case| needs_level(case)).count();
        let mut coordinates = DVector::zeros(free.len() + levels);
        if let Some(from) = from {
            for (free, coordinate) in free.iter().zip(coordinates.iter_mut()) {
                let known = from
                    .estimates
                    .iter()
                    .zip(&from.coordinates)
                    .find(|(estimate, _)| estimate.parameter == free.parameter);
                *coordinate = known.map_or(0.0, |(_, &coordinate)| coordinate);
            }
            // The same model on other recordings: their levels are known as well. Another model may have bent them.
            if free.iter().map(|free| free.parameter).eq(from.estimates.iter().map(|estimate| estimate.parameter)) {
                let needing = cases.iter().filter(|case| needs_level(case));
                for (case, coordinate) in needing.zip(coordinates.iter_mut().skip(free.len())) {
                    let known = from.level_coordinates.iter().find(|(name, _)| *name == case.name);
                    *coordinate = known.map_or(0.0, |(_, coordinate)| *coordinate);
                }
            }
        }
        Self { base, free, cases, coordinates, jacobian: None }
    }

    /// Index of a case's level among the coordinates.
    fn level_index(&self, case: usize) -> Option<usize> {
        needs_level(self.cases[case])
            .then(|| self.free.len() + self.cases[..case].iter().filter(|case| needs_level(case)).count())
    }

    pub(super) fn levels(&self) -> Vec<f64> {
        (0..self.cases.len())
            .map(|case| self.level_index(case).map_or(0.5, |index| level(self.coordinates[index])))
            .collect()
    }

    pub(super) fn machine(&self) -> Machine<f64> {
        let mut machine = *self.base;
        for (free, &coordinate) in self.free.iter().zip(self.coordinates.iter()) {
            machine.set(free.parameter, free.value(coordinate));
        }
        machine
    }

    fn dual_machine<const P: usize>(&self) -> Machine<Dual<P>> {
        let mut machine = self.base.map(model_core::number::Real::constant);
        for (index, (free, &coordinate)) in self.free.iter().zip(self.coordinates.iter()).enumerate() {
            let mut value = Dual::<P>::variable(free.value(coordinate), index);
            value.partials[index] = free.slope(coordinate);
            machine.set(free.parameter, value);
        }
        machine
    }

    fn rows(&self) -> usize {
        self.cases.iter().map(|case| case.channels.len() * case.time_s.len()).sum::<usize>() + self.coordinates.len()
    }

    /// Minimises with `P` partial derivatives a run, and keeps the derivatives at the solution if asked.
    pub(super) fn minimise<const P: usize>(&mut self, precision: f64, derivatives: bool) -> Minimum {
        let solver = LevenbergMarquardt::new()
            .with_ftol(precision)
            .with_xtol(1e-5)
            .with_gtol(0.0)
            .with_patience(20)
            .with_stepbound(10.0);
        let start = Slots::<'_, '_, P> { problem: self };
        let (_, report) = solver.minimize(start);
        if derivatives {
            let jacobian = Slots::<'_, '_, P> { problem: self }.jacobian();
            self.jacobian = jacobian;
        }
        Minimum { converged: report.termination.was_successful(), loss: report.objective_function }
    }

    /// Standard deviation of each coordinate; NaN where the recordings and priors do not determine it.
    ///
    /// The residuals are correlated in time, so their information `JᵀJ` is divided by their mean square and by how many
    /// neighbours tell the same; the priors keep theirs.
    pub(super) fn deviations(&self) -> Vec<f64> {
        let undetermined = vec![f64::NAN; self.coordinates.len()];
        let Some(jacobian) = &self.jacobian else { return undetermined };
        let Ok(residuals) = Evaluation::values(&self.machine(), &self.levels(), self.cases) else {
            return undetermined;
        };
        let (mut square, mut rows, mut effective) = (0.0, 0.0, 0.0);
        for (case, residuals) in self.cases.iter().zip(&residuals) {
            let count = case.channels.len();
            for channel in 0..count {
                let series: Vec<f64> = residuals.iter().skip(channel).step_by(count).copied().collect();
                square += series.iter().map(|value| soft(*value).0.powi(2)).sum::<f64>();
                rows += series.len() as f64;
                effective += effective_samples(&series);
            }
        }
        let scale = (square / rows).max(1.0) * (rows / effective.max(1.0));
        let measured = self.rows() - self.coordinates.len();
        let data = jacobian.rows(0, measured);
        let priors = jacobian.rows(measured, self.coordinates.len());
        let mut information = data.tr_mul(&data) / scale + priors.tr_mul(&priors);
        // Scaled to a unit diagonal before it is inverted: strengths and priors differ by many powers of ten.
        let size: Vec<f64> = information.diagonal().iter().map(|value| value.max(0.0).sqrt()).collect();
        let mute = |index: usize| size[index] <= 0.0;
        for row in 0..size.len() {
            for column in 0..size.len() {
                let scaled = information[(row, column)] / (size[row] * size[column]);
                let own = if row == column { 1.0 } else { 0.0 };
                information[(row, column)] = if mute(row) || mute(column) { own } else { scaled };
            }
        }
        let Some(factor) = information.cholesky() else { return undetermined };
        let inverse = factor.inverse();
        (0..size.len())
            .map(|index| if mute(index) { f64::NAN } else { inverse[(index, index)].sqrt() / size[index] })
            .collect()
    }
}

/// How a search ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Minimum {
    /// Whether the optimiser met one of its criteria.
    pub(super) converged: bool,
    /// Half the sum of squares that it minimised, priors included.
    pub(super) loss: f64,
}

/// Level at rest from its coordinate, between 0 and 1: a hard bound would stop the search at it, with a slope that is not there.
fn level(coordinate: f64) -> f64 {
    1.0 / (1.0 + (-4.0 * LEVEL_SIGMA * coordinate).exp())
}

/// Derivative of the level by its coordinate.
fn level_slope(coordinate: f64) -> f64 {
    4.0 * LEVEL_SIGMA * level(coordinate) * (1.0 - level(coordinate))
}

/// The problem as the optimiser wants it, with `P` partials a run.
struct Slots<'p, 'a, const P: usize> {
    problem: &'p mut Problem<'a>,
}

impl<const P: usize> LeastSquaresProblem<f64, Dyn, Dyn> for Slots<'_, '_, P> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, coordinates: &DVector<f64>) {
        self.problem.coordinates.copy_from(coordinates);
    }

    fn params(&self) -> DVector<f64> {
        self.problem.coordinates.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let problem = &self.problem;
        let values = Evaluation::values(&problem.machine(), &problem.levels(), problem.cases).ok()?;
        let priors = problem
            .coordinates
            .iter()
            .enumerate()
            .map(|(index, &coordinate)| problem.free.get(index).map_or(coordinate, |free| free.prior(coordinate)));
        let softened = values.iter().flatten().map(|residual| soft(*residual).0);
        Some(DVector::from_iterator(problem.rows(), softened.chain(priors)))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let problem = &self.problem;
        let machine = problem.dual_machine::<P>();
        let level_slot = problem.free.len();
        let blocks = problem
            .cases
            .par_iter()
            .enumerate()
            .map(|(case, prepared)| {
                let level = problem.level_index(case).map_or(Dual::variable(0.5, P), |index| {
                    let mut dual = Dual::variable(level(problem.coordinates[index]), level_slot);
                    dual.partials[level_slot] = level_slope(problem.coordinates[index]);
                    dual
                });
                Evaluation::duals(&machine, level, prepared)
            })
            .collect::<Result<Vec<_>, _>>()
            .ok()?;
        let mut jacobian = DMatrix::zeros(problem.rows(), problem.coordinates.len());
        let mut row = 0;
        for (case, block) in blocks.iter().enumerate() {
            let level_column = problem.level_index(case);
            for (value, partials) in block {
                let slope = soft(*value).1;
                for column in 0..problem.free.len() {
                    jacobian[(row, column)] = slope * partials[column];
                }
                if let Some(column) = level_column {
                    jacobian[(row, column)] = slope * partials[level_slot];
                }
                row += 1;
            }
        }
        for column in 0..problem.coordinates.len() {
            let around = problem.free.get(column).is_none_or(|free| matches!(free.freedom, Freedom::Around { .. }));
            jacobian[(row + column, column)] = if around { 1.0 } else { 0.0 };
        }
        Some(jacobian)
    }
}
