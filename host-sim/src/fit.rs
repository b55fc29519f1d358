//! Refit of parameters on all training recordings together.
//!
//! Levenberg-Marquardt (crate `levenberg-marquardt`, a port of MINPACK) over residuals divided by each channel's noise, with the
//! Jacobian from the core run on dual numbers. A pseudo-Huber loss keeps single spikes from steering. Nominal values with a
//! stated standard deviation enter as Gaussian priors; effects are fitted in the logarithm of their strength, so their sign
//! is given. Where no pressure is recorded, each recording's level of pressure at rest is free.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use model_core::machine::{Machine, MachineError};
use model_core::parameter::Parameter;
use nalgebra::{DMatrix, DVector, Dyn, Owned};
use rayon::prelude::*;

use crate::dual::Dual;
use crate::prepare::{Channel, Prepared};
use crate::simulate::{StartOffset, run};

/// Residuals beyond this many standard deviations of noise count linearly, not by their square.
const HUBER: f64 = 5.0;
/// Standard deviation of the pressure level at rest, as a share of supply.
const LEVEL_SIGMA: f64 = 0.1;
/// Most parameters of one fit.
pub const MOST_PARAMETERS: usize = 24;

/// How a free parameter moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Freedom {
    /// Around a nominal value, with a Gaussian prior of this standard deviation, in the parameter's unit.
    Around {
        /// Nominal value.
        nominal: f64,
        /// Its standard deviation.
        sigma: f64,
    },
    /// Positive and of unknown size: moves in its logarithm, from this value on.
    Strength {
        /// A typical value, to start from.
        typical: f64,
    },
}

/// A parameter that a fit may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// Which.
    pub parameter: Parameter,
    /// How.
    pub freedom: Freedom,
}

impl Free {
    /// The value at the fit's own coordinate, which is 0 at the start.
    fn value(&self, coordinate: f64) -> f64 {
        let description = self.parameter.description();
        let value = match self.freedom {
            Freedom::Around { nominal, sigma } => nominal + sigma * coordinate,
            Freedom::Strength { typical } => typical * coordinate.clamp(-23.0, 23.0).exp(),
        };
        value.clamp(description.min, description.max)
    }

    /// Derivative of the value by the coordinate; 0 where the value is held at an end of its range.
    fn slope(&self, coordinate: f64) -> f64 {
        let (description, value) = (self.parameter.description(), self.value(coordinate));
        if value <= description.min || value >= description.max {
            return 0.0;
        }
        match self.freedom {
            Freedom::Around { sigma, .. } => sigma,
            Freedom::Strength { .. } => value,
        }
    }

    /// The prior's residual.
    fn prior(&self, coordinate: f64) -> f64 {
        match self.freedom {
            Freedom::Around { .. } => coordinate,
            Freedom::Strength { .. } => 0.0,
        }
    }
}

/// A fitted parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Which.
    pub parameter: Parameter,
    /// The value it started from.
    pub before: f64,
    /// The fitted value, SI.
    pub value: f64,
    /// Its standard deviation, SI, with the correlation of the residuals in time counted in.
    pub std: f64,
}

/// The result of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The machine with fitted values.
    pub machine: Machine<f64>,
    /// Every free parameter.
    pub estimates: Vec<Estimate>,
    /// Level of pressure at rest per training recording, share of supply.
    pub levels: Vec<f64>,
    /// Coordinates of the solution, to start another fit from.
    coordinates: Vec<f64>,
    /// The same of each level, by the recording's name.
    level_coordinates: Vec<(String, f64)>,
    /// Whether the optimiser met one of its criteria.
    pub converged: bool,
}

/// Why a fit is not possible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Too many parameters are free.
    #[error("{count} parameters are free; expected at most {MOST_PARAMETERS}")]
    TooMany {
        /// How many.
        count: usize,
    },
    /// The starting values do not become a drive.
    #[error(transparent)]
    Machine(#[from] MachineError),
}

/// Fits `free` parameters of `machine` to the recordings, from a former solution's coordinates where one is given.
///
/// The search ends when the loss falls by less than `precision` of itself in a step.
pub fn fit(
    machine: &Machine<f64>,
    free: &[Free],
    cases: &[&Prepared],
    from: Option<&Fit>,
    precision: f64,
) -> Result<Fit, FitError> {
    let (problem, converged) = solve(machine, free, cases, from, precision, true)?;
    let covariance = problem.covariance();
    let estimates = free
        .iter()
        .zip(&problem.coordinates)
        .enumerate()
        .map(|(index, (free, &coordinate))| Estimate {
            parameter: free.parameter,
            before: free.value(0.0),
            value: free.value(coordinate),
            std: free.slope(coordinate).abs() * covariance.get(index).copied().unwrap_or(f64::NAN).max(0.0).sqrt(),
        })
        .collect();
    let needing = cases.iter().filter(|case| needs_level(case)).map(|case| case.name.clone());
    let level_coordinates = needing.zip(problem.coordinates.iter().skip(free.len()).copied()).collect();
    Ok(Fit {
        level_coordinates,
        machine: problem.machine(),
        estimates,
        levels: problem.levels(),
        coordinates: problem.coordinates.as_slice().to_vec(),
        converged,
    })
}

/// The machine of such a fit alone, without the derivatives at the solution that only standard deviations need.
pub fn fitted(
    machine: &Machine<f64>,
    free: &[Free],
    cases: &[&Prepared],
    from: Option<&Fit>,
    precision: f64,
) -> Result<Machine<f64>, FitError> {
    Ok(solve(machine, free, cases, from, precision, false)?.0.machine())
}

/// The problem at its solution, and whether the optimiser met one of its criteria.
fn solve<'a>(
    machine: &'a Machine<f64>,
    free: &'a [Free],
    cases: &'a [&'a Prepared],
    from: Option<&Fit>,
    precision: f64,
    derivatives: bool,
) -> Result<(Problem<'a>, bool), FitError> {
    let levels = cases.iter().any(|case| needs_level(case));
    let count = free.len() + usize::from(levels);
    let mut problem = Problem::new(machine, free, cases, from);
    // The optimiser has no way to report why residuals fail, so the start is tried first.
    Evaluation::values(&problem.machine(), &problem.levels(), cases)?;
    macro_rules! minimise {
        ($($slots:literal)*) => {
            match count {
                $(0..=$slots => problem.minimise::<$slots>(precision, derivatives),)*
                _ => return Err(FitError::TooMany { count }),
            }
        };
    }
    let converged = minimise!(4 8 10 12 16 24);
    Ok((problem, converged))
}

/// Residuals of a machine on one recording, each over its channel's noise: one series for each channel.
///
/// A recording without pressures starts from the pressure level given, as a share of supply.
pub fn standardised(machine: &Machine<f64>, case: &Prepared, level: f64) -> Result<Vec<Vec<f64>>, MachineError> {
    let rows = Evaluation::residuals(machine, level, case)?;
    let count = case.channels.len();
    Ok((0..count).map(|channel| rows.iter().skip(channel).step_by(count).copied().collect()).collect())
}

/// The pseudo-Huber loss of a series of residuals over noise: their square where they are small.
#[must_use]
pub fn loss(series: &[f64]) -> f64 {
    series.iter().map(|residual| soft(*residual).0.powi(2)).sum()
}

/// Whether the level of pressure at rest is not recorded.
fn needs_level(case: &Prepared) -> bool {
    case.stimulus.start.pressures_pa.is_none()
}

/// The residual whose square is the pseudo-Huber loss of `residual`, and its derivative.
fn soft(residual: f64) -> (f64, f64) {
    let root = (1.0 + (residual / HUBER).powi(2)).sqrt();
    let value = HUBER * (2.0 * (root - 1.0)).sqrt();
    if residual.abs() < 1e-6 {
        return (residual, 1.0);
    }
    (value.copysign(residual), residual.abs() / (root * value))
}

/// Runs of the core over cases.
struct Evaluation;

impl Evaluation {
    /// Residuals of all cases, each over its noise, without loss and prior.
    fn values(machine: &Machine<f64>, levels: &[f64], cases: &[&Prepared]) -> Result<Vec<Vec<f64>>, MachineError> {
        cases.par_iter().zip(levels).map(|(case, &level)| Self::residuals(machine, level, case)).collect()
    }

    fn residuals(machine: &Machine<f64>, level: f64, case: &Prepared) -> Result<Vec<f64>, MachineError> {
        let mut residuals = vec![0.0; case.channels.len() * case.time_s.len()];
        let offset = StartOffset { level };
        run::<f64>(machine, &case.stimulus, offset, |row, sample| {
            for (channel, residual) in case.channels.iter().zip(residuals.iter_mut().skip(row * case.channels.len())) {
                *residual = missed(channel, row, sample.signal(channel.signal));
            }
        })?;
        Ok(residuals)
    }

    /// Residuals with their derivatives by the slots' coordinates, row by row.
    fn duals<const P: usize>(
        machine: &Machine<Dual<P>>,
        level: Dual<P>,
        case: &Prepared,
    ) -> Result<Vec<(f64, [f64; P])>, MachineError> {
        let mut residuals = vec![(0.0, [0.0; P]); case.channels.len() * case.time_s.len()];
        run::<Dual<P>>(machine, &case.stimulus, StartOffset { level }, |row, sample| {
            for (channel, residual) in case.channels.iter().zip(residuals.iter_mut().skip(row * case.channels.len())) {
                if let Some(simulated) = sample.signal(channel.signal) {
                    residual.0 = missed(channel, row, Some(simulated.value));
                    residual.1 = simulated.partials.map(|partial| -partial / channel.noise);
                }
            }
        })?;
        Ok(residuals)
    }
}

/// Recorded minus simulated over noise.
fn missed(channel: &Channel, row: usize, simulated: Option<f64>) -> f64 {
    simulated.map_or(0.0, |simulated| (channel.recorded[row] - simulated) / channel.noise)
}

struct Problem<'a> {
    base: &'a Machine<f64>,
    free: &'a [Free],
    cases: &'a [&'a Prepared],
    /// Free parameters, then one level for each recording that needs it.
    coordinates: DVector<f64>,
    jacobian: Option<DMatrix<f64>>,
}

impl<'a> Problem<'a> {
    fn new(base: &'a Machine<f64>, free: &'a [Free], cases: &'a [&'a Prepared], from: Option<&Fit>) -> Self {
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

    fn levels(&self) -> Vec<f64> {
        (0..self.cases.len())
            .map(|case| self.level_index(case).map_or(0.5, |index| level(self.coordinates[index])))
            .collect()
    }

    fn machine(&self) -> Machine<f64> {
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

    /// Minimises with `P` partial derivatives a run, and keeps the derivatives at the solution if asked; whether it converged.
    fn minimise<const P: usize>(&mut self, precision: f64, derivatives: bool) -> bool {
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
        report.termination.was_successful()
    }

    /// Diagonal of the covariance of the coordinates. The residuals are correlated in time, so the inverse of `JᵀJ` is
    /// scaled by their mean square and by how many neighbours tell the same.
    fn covariance(&self) -> Vec<f64> {
        let Some(jacobian) = &self.jacobian else { return Vec::new() };
        let Ok(residuals) = Evaluation::values(&self.machine(), &self.levels(), self.cases) else { return Vec::new() };
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
        let normal = jacobian.tr_mul(jacobian);
        normal
            .try_inverse()
            .map_or_else(Vec::new, |inverse| inverse.diagonal().iter().map(|value| value * scale).collect())
    }
}

/// How many independent samples a correlated series is worth: n·(1 − r)/(1 + r) with r its correlation at lag one.
pub(crate) fn effective_samples(series: &[f64]) -> f64 {
    let square: f64 = series.iter().map(|value| value * value).sum();
    let lagged: f64 = series.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let r = if square > 0.0 { (lagged / square).clamp(0.0, 1.0 - 1.0 / series.len() as f64) } else { 0.0 };
    (series.len() as f64 * (1.0 - r) / (1.0 + r)).max(1.0)
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
