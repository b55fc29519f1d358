//! The least-squares problem, in the form that the optimiser needs.
//!
//! The optimiser gets the triangular factor of the normal equations instead of one line per row: the same minimum, the
//! same steps, and a few dozen numbers instead of a hundred thousand.

use std::cell::Cell;
use std::sync::Arc;

use crate::parallel;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Owned};

use model_core::machine::{Machine, MachineError, Tick};
use simulation::is_carried;

use super::initial_state::StartState;
use super::jacobian::At;
use super::kept_jacobian::Jacobian;
use super::normal_equations::{NormalEquations, OF_START};
use super::{Free, From};
use crate::experiment::Prepared;

/// Called with each recording after its evaluation.
pub type Progress<'a> = dyn Fn(&Prepared) + Sync + 'a;

/// Largest number of evaluations per coordinate: a model that lacks an effect creeps along a valley, and is far enough then.
const PATIENCE: usize = 3;

/// The Jacobian is kept as long as the gain of a step equals the predicted gain within this share.
const FAITHFUL: f64 = 0.15;
/// A gain below a hundredth of a unit of log-likelihood is not worth a step.
const NEGLIGIBLE: f64 = 0.01;
/// A search of at least this precision ends with a newly computed Jacobian.
const FINE: f64 = 1e-5;
/// Largest number of times that the search is started.
const ROUNDS: usize = 3;

/// Largest number of evaluations of a search over this many coordinates.
pub(crate) const fn most_evaluations(coordinates: usize) -> usize {
    PATIENCE * (coordinates + 1)
}

pub(crate) struct Problem<'a> {
    base: &'a Machine<f64>,
    free: &'a [Free],
    cases: &'a [&'a Prepared],
    /// Called after each evaluation of a recording with its Jacobian.
    told: &'a Progress<'a>,
    /// Free parameters, then level and shift of each recording's start.
    pub(crate) coordinates: DVector<f64>,
    /// For each recording, at the coordinates.
    pub(crate) normal_equations: Vec<NormalEquations>,
}

impl<'a> Problem<'a> {
    pub(crate) fn new(
        base: &'a Machine<f64>,
        free: &'a [Free],
        cases: &'a [&'a Prepared],
        from: &From<'_>,
        told: &'a Progress<'a>,
    ) -> Self {
        let mut coordinates = DVector::zeros(free.len() + OF_START * cases.len());
        if let Some(known) = from.solution {
            let all =
                if from.moved.is_empty() { known.all_coordinates() } else { DVector::from_column_slice(from.moved) };
            let known_starts = all.rows(known.free.len(), all.len() - known.free.len());
            for (free, coordinate) in free.iter().zip(coordinates.iter_mut()) {
                let mut pairs = known.free.iter().zip(all.iter());
                let found = pairs.find(|(other, _)| other.parameter == free.parameter);
                *coordinate = found.map_or(0.0, |(other, &coordinate)| {
                    if other.freedom == free.freedom { coordinate } else { free.coordinate(other.value(coordinate)) }
                });
            }
            if known.starts.len() == cases.len() {
                coordinates.rows_mut(free.len(), known_starts.len()).copy_from(&known_starts);
                // A shift of the start stays as long in metres where a play lets the rod start further away than its sensor's resolution.
                let here = At { base, free, coordinates: coordinates.as_slice() }.machine();
                for (index, case) in cases.iter().enumerate() {
                    let (before, now) = (case.start_sigma_on(&known.machine), case.start_sigma_on(&here));
                    if now > 0.0 {
                        coordinates[free.len() + OF_START * index + 1] *= before / now;
                    }
                }
            }
        }
        for (parameter, wanted) in from.coordinates {
            if let Some(index) = free.iter().position(|free| free.parameter == *parameter) {
                coordinates[index] = *wanted;
            }
        }
        Self { base, free, cases, told, coordinates, normal_equations: Vec::new() }
    }

    pub(crate) fn starts(&self) -> Vec<StartState> {
        let of = |index: usize| {
            let at = self.free.len() + OF_START * index;
            StartState { level: self.coordinates[at], shift: self.coordinates[at + 1] }
        };
        (0..self.cases.len()).map(of).collect()
    }

    pub(crate) fn machine(&self) -> Machine<f64> {
        let Self { base, free, coordinates, .. } = self;
        At { base, free, coordinates: coordinates.as_slice() }.machine()
    }

    /// Whether the controller could carry the machine, at each recording's own tick: what is written to a file has to be taken by every command.
    fn fits_the_format(&self) -> bool {
        let machine = self.machine();
        let mut ticks: Vec<Tick> = self.cases.iter().map(|case| case.tick).collect();
        ticks.dedup();
        ticks.into_iter().all(|tick| is_carried(&machine, tick))
    }

    /// Minimises.
    pub(crate) fn minimise(&mut self, precision: f64) -> Minimum {
        let solver = LevenbergMarquardt::new()
            .with_ftol(precision)
            .with_xtol(1e-6)
            .with_gtol(0.0)
            .with_patience(PATIENCE)
            // Every coordinate is already in standard deviations of its prior, so a first step of several of them is far.
            .with_scale_diag(false)
            .with_stepbound(5.0);
        let mut slots = Slots::new(self, precision);
        let mut rounds = 0;
        let converged = loop {
            let (end, report) = solver.minimize(slots);
            slots = end;
            rounds += 1;
            // Where the search ends by a kept Jacobian, a newly computed one has to confirm the end.
            if precision > FINE || !slots.here.is_by_kept_jacobian {
                break report.termination.was_successful();
            }
            slots.here = slots.evaluated(&slots.here.at);
            if slots.here.falls() <= precision * slots.here.loss() || rounds == ROUNDS {
                break report.termination.was_successful();
            }
        };
        let loss = slots.here.loss();
        self.normal_equations = slots.here.normal_equations;
        Minimum { converged, loss }
    }
}

/// How a search ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Minimum {
    /// Whether the optimiser met one of its criteria.
    pub(crate) converged: bool,
    /// Half the sum of squares that it minimised, priors included.
    pub(crate) loss: f64,
}

/// The problem in the form that the optimiser needs: the present point and the one before.
struct Slots<'p, 'a> {
    problem: &'p mut Problem<'a>,
    precision: f64,
    /// The present point, and the point before it, to which the search returns if it does not take the step.
    here: Point,
    before: Point,
    /// Whether the search has taken the step that led here.
    is_taken: Cell<bool>,
    /// Whether it began at a machine that the controller's format takes: then it ends at such a one.
    stays_in_format: bool,
}

/// The triangular factor at some coordinates.
#[derive(Clone, Default)]
struct Point {
    at: DVector<f64>,
    normal_equations: Vec<NormalEquations>,
    /// For each recording: computed here or, with `by_kept_jacobian`, at the point where the steps began.
    jacobian: Arc<Vec<Jacobian>>,
    is_by_kept_jacobian: bool,
    /// Whether every step tried from here gained what was predicted.
    holds: bool,
    /// Residuals and Jacobian; `None` where the machine does not become a drive.
    triangle: Option<(DVector<f64>, DMatrix<f64>)>,
}

impl Point {
    fn of(
        at: &DVector<f64>,
        normal_equations: Vec<NormalEquations>,
        jacobian: Arc<Vec<Jacobian>>,
        is_by_kept_jacobian: bool,
    ) -> Self {
        let triangle = if normal_equations.is_empty() { None } else { assembled(&normal_equations, at) };
        Self { at: at.clone(), normal_equations, jacobian, is_by_kept_jacobian, holds: true, triangle }
    }

    /// What is minimised.
    fn loss(&self) -> f64 {
        self.triangle.as_ref().map_or(f64::NAN, |(residuals, _)| 0.5 * residuals.norm_squared())
    }

    /// Fall of the loss by a step to `there`, if the residuals are linear with this Jacobian.
    fn predicted_gain(&self, there: &DVector<f64>) -> f64 {
        self.triangle.as_ref().map_or(f64::NAN, |(residuals, jacobian)| {
            0.5 * (residuals.norm_squared() - (residuals + jacobian * (there - &self.at)).norm_squared())
        })
    }

    /// The same for the best possible step.
    fn falls(&self) -> f64 {
        let reached = |residuals: &DVector<f64>| residuals.rows(0, residuals.len() - 1).norm_squared();
        self.triangle.as_ref().map_or(f64::NAN, |(residuals, _)| 0.5 * reached(residuals))
    }

    /// A fall of the loss that is not worth a step: a negligible gain of log-likelihood, with noise as large as the misfit here.
    fn negligible(&self) -> f64 {
        let rows: f64 = self.normal_equations.iter().map(|one| one.rows).sum();
        NEGLIGIBLE * (2.0 * self.loss() / rows.max(1.0)).max(1.0)
    }
}

impl<'p, 'a> Slots<'p, 'a> {
    fn new(problem: &'p mut Problem<'a>, precision: f64) -> Self {
        let coordinates = problem.coordinates.clone();
        let (here, before) = (Point::default(), Point::default());
        let stays_in_format = problem.fits_the_format();
        let mut slots = Self { problem, precision, here, before, is_taken: Cell::new(false), stays_in_format };
        slots.here = slots.evaluated(&coordinates);
        slots
    }

    /// A point with its own, newly computed Jacobian.
    fn evaluated(&self, coordinates: &DVector<f64>) -> Point {
        let Problem { base, free, cases, told, .. } = *self.problem;
        let at = At { base, free, coordinates: coordinates.as_slice() };
        let all = parallel::try_each(cases.iter().zip(self.problem.starts()), |(case, start)| {
            let mut jacobian = Jacobian::new(free.len(), case);
            let normal_equations = NormalEquations::of(&at, start, case, &mut jacobian);
            told(case);
            Ok::<_, MachineError>((normal_equations?, jacobian))
        });
        let (normal_equations, jacobian): (Vec<_>, Vec<_>) = all.unwrap_or_default().into_iter().unzip();
        Point::of(coordinates, normal_equations, Arc::new(jacobian), false)
    }

    /// A point with the Jacobian of the previous point; `None` where that is not kept or the machine does not become a drive.
    fn by_kept_jacobian(&self, coordinates: &DVector<f64>) -> Option<Point> {
        let cases = self.problem.cases;
        let machine = self.problem.machine();
        let known = &self.before;
        let starts = self.problem.starts();
        let normal_equations =
            NormalEquations::by_kept_jacobian(&known.normal_equations, &known.jacobian, &machine, cases, &starts);
        let normal_equations = normal_equations.ok().flatten()?;
        let point = Point::of(coordinates, normal_equations, Arc::clone(&known.jacobian), true);
        point.triangle.is_some().then_some(point)
    }

    /// The result of a step. A step whose predicted gain is too small is not simulated: the search ends there.
    fn tried(&mut self, coordinates: &DVector<f64>) -> Point {
        if self.stays_in_format && !self.problem.fits_the_format() {
            return Point { at: coordinates.clone(), ..Point::default() };
        }
        let predicted = self.before.predicted_gain(coordinates);
        if predicted <= (self.precision * self.before.loss()).min(self.before.negligible()) {
            return Point { at: coordinates.clone(), ..self.before.clone() };
        }
        if let Some(by_kept_jacobian) = self.by_kept_jacobian(coordinates) {
            let gained = self.before.loss() - by_kept_jacobian.loss();
            // A step without a gain is not taken, and a step that gains what was predicted shows that the Jacobian still holds.
            let holds = (gained - predicted).abs() <= FAITHFUL * predicted;
            if gained <= 0.0 || (holds && self.before.holds) {
                self.before.holds = holds;
                return by_kept_jacobian;
            }
        }
        self.evaluated(coordinates)
    }
}

/// The triangular factor of the normal equations, as residuals and Jacobian.
fn assembled(normal_equations: &[NormalEquations], coordinates: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let size = coordinates.len();
    let (matrix, gradient, square) = NormalEquations::assembled(normal_equations, coordinates);
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

impl LeastSquaresProblem<f64, Dyn, Dyn> for Slots<'_, '_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, coordinates: &DVector<f64>) {
        self.problem.coordinates.copy_from(coordinates);
        if self.here.at == *coordinates {
            return;
        }
        if self.is_taken.replace(false) || self.before.at == *coordinates {
            std::mem::swap(&mut self.here, &mut self.before);
        }
        if self.here.at == *coordinates {
            return;
        }
        self.here = self.tried(coordinates);
        if self.here.triangle.is_none() {
            // A step to where there is no drive is reported as a bad step, so that the search takes a shorter one.
            let wrong = |(residuals, jacobian): &(DVector<f64>, DMatrix<f64>)| (residuals * 10.0, jacobian.clone());
            self.here.triangle = self.before.triangle.as_ref().map(wrong);
        }
    }

    fn params(&self) -> DVector<f64> {
        self.problem.coordinates.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.here.triangle.as_ref().map(|(residuals, _)| residuals.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        // The optimiser requests the Jacobian only at points from which the search goes on.
        self.is_taken.set(true);
        self.here.triangle.as_ref().map(|(_, jacobian)| jacobian.clone())
    }
}

#[cfg(test)]
mod tests {
    use machine_file::LoadSource;
    use model_core::machine::Parameter::FlowCoefficient;
    use test_press::{extending, press};

    use super::*;
    use crate::fit::{Freedom, fit};

    #[test]
    fn a_search_ends_at_a_machine_that_the_controller_can_carry() {
        let machine = press(&[]);
        let nominal = machine.get(FlowCoefficient);
        let carried = |machine: &Machine<f64>| is_carried(machine, Tick::OneMillisecond);
        // What was recorded asks for a valve that is far too large for the format.
        let fast = press(&[(FlowCoefficient, 300.0 * nominal)]);
        assert!(carried(&machine) && !carried(&fast));
        let case = Prepared::new(&extending(&fast), &machine, LoadSource::Constant, None).unwrap();
        let free = Free { parameter: FlowCoefficient, freedom: Freedom::Roughly { least: 0.0, nominal, spread: 1.0 } };
        let found = fit(&machine, &[free], &[&case], &From::default(), 1e-6).unwrap();
        assert!(carried(&found.machine) && found.machine.get(FlowCoefficient) > 2.0 * nominal, "{found:?}");
    }
}
