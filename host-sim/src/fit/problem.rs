//! The least-squares problem, as the optimiser wants it.
//!
//! The optimiser sees the triangle of the normal equations instead of one line a row: the same minimum, the same steps, and a
//! few dozen numbers instead of a hundred thousand.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use model_core::machine::Machine;
use nalgebra::{DMatrix, DVector, Dyn, Owned};
use rayon::prelude::*;

use super::information::OF_START;
use super::slopes::At;
use super::{Free, From, Information, StartState};
use crate::prepare::Prepared;

/// What is told of an evaluated recording.
pub type Told<'a> = dyn Fn(&Prepared) + Sync + 'a;

/// A model that lacks an effect creeps along a valley: evaluations per coordinate, after which it is far enough.
const PATIENCE: usize = 3;

/// Most evaluations of a search over so many coordinates.
pub(super) const fn most_evaluations(coordinates: usize) -> usize {
    PATIENCE * (coordinates + 1)
}

pub(super) struct Problem<'a> {
    base: &'a Machine<f64>,
    free: &'a [Free],
    cases: &'a [&'a Prepared],
    /// Told after each evaluation of a recording.
    told: &'a Told<'a>,
    /// Free parameters, then level and shift of each recording's start.
    pub(super) coordinates: DVector<f64>,
    /// Of each recording, at the coordinates.
    pub(super) information: Vec<Information>,
}

impl<'a> Problem<'a> {
    pub(super) fn new(
        base: &'a Machine<f64>,
        free: &'a [Free],
        cases: &'a [&'a Prepared],
        from: &From<'_>,
        told: &'a Told<'a>,
    ) -> Self {
        let mut coordinates = DVector::zeros(free.len() + OF_START * cases.len());
        if let Some(known) = from.solution {
            let all =
                if from.moved.is_empty() { known.all_coordinates() } else { DVector::from_column_slice(from.moved) };
            let known_starts = all.rows(known.free.len(), all.len() - known.free.len());
            for (free, coordinate) in free.iter().zip(coordinates.iter_mut()) {
                let mut pairs = known.free.iter().zip(all.iter());
                let found = pairs.find(|(other, _)| other.parameter == free.parameter);
                *coordinate = found.map_or(0.0, |(_, coordinate)| *coordinate);
            }
            if known.starts.len() == cases.len() {
                coordinates.rows_mut(free.len(), known_starts.len()).copy_from(&known_starts);
            }
        }
        for (parameter, wanted) in from.coordinates {
            if let Some(index) = free.iter().position(|free| free.parameter == *parameter) {
                coordinates[index] = *wanted;
            }
        }
        Self { base, free, cases, told, coordinates, information: Vec::new() }
    }

    pub(super) fn starts(&self) -> Vec<StartState> {
        let of = |index: usize| {
            let at = self.free.len() + OF_START * index;
            StartState { level: self.coordinates[at], shift: self.coordinates[at + 1] }
        };
        (0..self.cases.len()).map(of).collect()
    }

    pub(super) fn machine(&self) -> Machine<f64> {
        let mut machine = *self.base;
        for (free, &coordinate) in self.free.iter().zip(self.coordinates.iter()) {
            machine.set(free.parameter, free.value(coordinate));
        }
        machine
    }

    /// Minimises.
    pub(super) fn minimise(&mut self, precision: f64) -> Minimum {
        let solver = LevenbergMarquardt::new()
            .with_ftol(precision)
            .with_xtol(1e-6)
            .with_gtol(0.0)
            .with_patience(PATIENCE)
            // Every coordinate is in standard deviations of its prior already: a first step of several of them is far.
            .with_scale_diag(false)
            .with_stepbound(5.0);
        let start = Slots::new(self);
        let (end, report) = solver.minimize(start);
        let information = end.here.information;
        self.information = information;
        Minimum { converged: report.termination.was_successful(), loss: report.objective_function }
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

/// The problem as the optimiser wants it: where it is and where it was.
struct Slots<'p, 'a> {
    problem: &'p mut Problem<'a>,
    /// Here, and where the search was before: a step that is not taken leads back there.
    here: Point,
    before: Point,
}

/// The triangle at some coordinates.
#[derive(Default)]
struct Point {
    at: Option<DVector<f64>>,
    information: Vec<Information>,
    /// Residuals and Jacobian; none where the machine does not become a drive.
    triangle: Option<(DVector<f64>, DMatrix<f64>)>,
}

impl<'p, 'a> Slots<'p, 'a> {
    fn new(problem: &'p mut Problem<'a>) -> Self {
        let coordinates = problem.coordinates.clone();
        let mut slots = Self { problem, here: Point::default(), before: Point::default() };
        slots.set_params(&coordinates);
        slots
    }

    fn assembled(&self, information: &[Information]) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let size = self.problem.coordinates.len();
        let (matrix, gradient, square) = Information::assembled(information, &self.problem.coordinates);
        if !square.is_finite() {
            return None;
        }
        let triangle = matrix.cholesky()?.l();
        let reached = triangle.solve_lower_triangular(&gradient)?;
        let mut residuals = DVector::zeros(size + 1);
        residuals.rows_mut(0, size).copy_from(&reached);
        residuals[size] = (square - reached.norm_squared()).max(0.0).sqrt();
        let mut jacobian = DMatrix::zeros(size + 1, size);
        jacobian.view_mut((0, 0), (size, size)).copy_from(&triangle.transpose());
        Some((residuals, jacobian))
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Slots<'_, '_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, coordinates: &DVector<f64>) {
        self.problem.coordinates.copy_from(coordinates);
        if self.here.at.as_ref() == Some(coordinates) {
            return;
        }
        std::mem::swap(&mut self.here, &mut self.before);
        if self.here.at.as_ref() == Some(coordinates) {
            return;
        }
        let Problem { base, free, cases, told, .. } = *self.problem;
        let at = At { base, free, coordinates: coordinates.as_slice() };
        let information: Result<Vec<_>, _> = cases
            .par_iter()
            .zip(self.problem.starts())
            .map(|(case, start)| {
                let information = Information::of(&at, start, case);
                told(case);
                information
            })
            .collect();
        let information = information.unwrap_or_default();
        let triangle = if information.is_empty() { None } else { self.assembled(&information) };
        // A step to where there is no drive is one that goes wrong: the search then takes a shorter one.
        let wrong = || self.before.triangle.as_ref().map(|(residuals, jacobian)| (residuals * 10.0, jacobian.clone()));
        let triangle = triangle.or_else(wrong);
        self.here = Point { at: Some(coordinates.clone()), information, triangle };
    }

    fn params(&self) -> DVector<f64> {
        self.problem.coordinates.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.here.triangle.as_ref().map(|(residuals, _)| residuals.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        self.here.triangle.as_ref().map(|(_, jacobian)| jacobian.clone())
    }
}
