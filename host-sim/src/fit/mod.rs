//! Refit of parameters on all training recordings together.
//!
//! Levenberg-Marquardt (crate `levenberg-marquardt`, a port of MINPACK) over residuals divided by each channel's noise, with the
//! Jacobian from the core run on dual numbers. A pseudo-Huber loss keeps single spikes from steering. Nominal values with a
//! stated standard deviation enter as Gaussian priors; effects are fitted in the logarithm of their strength, so their sign
//! is given. Where no pressure is recorded, each recording's level of pressure at rest is free.

mod problem;
mod residuals;

use model_core::machine::{Machine, MachineError};
use model_core::parameter::Parameter;

use crate::prepare::Prepared;
use problem::{Minimum, Problem, needs_level};
pub(crate) use residuals::effective_samples;
use residuals::{Evaluation, soft};

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

    /// Whether the value is held at an end of its range.
    fn at_bound(&self, coordinate: f64) -> bool {
        let (description, value) = (self.parameter.description(), self.value(coordinate));
        value <= description.min || value >= description.max
    }

    /// Derivative of the value by the coordinate; 0 where the value is held at an end of its range.
    fn slope(&self, coordinate: f64) -> f64 {
        match self.freedom {
            _ if self.at_bound(coordinate) => 0.0,
            Freedom::Around { sigma, .. } => sigma,
            Freedom::Strength { .. } => self.value(coordinate),
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
    /// Its standard deviation, SI, with the correlation of the residuals in time counted in; NaN where the recordings do
    /// not determine it.
    pub std: f64,
    /// Whether it ended at an end of its admissible range, and is no estimate then.
    pub at_bound: bool,
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
    /// Half the sum of squares that it minimised, priors included.
    pub loss: f64,
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
    let (problem, minimum) = solve(machine, free, cases, from, precision, true)?;
    let deviations = problem.deviations();
    let estimates = free
        .iter()
        .zip(problem.coordinates.iter().zip(&deviations))
        .map(|(free, (&coordinate, deviation))| Estimate {
            parameter: free.parameter,
            before: free.value(0.0),
            value: free.value(coordinate),
            std: if free.at_bound(coordinate) { f64::NAN } else { free.slope(coordinate).abs() * deviation },
            at_bound: free.at_bound(coordinate),
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
        converged: minimum.converged,
        loss: minimum.loss,
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

/// The problem at its solution, and how the search ended.
fn solve<'a>(
    machine: &'a Machine<f64>,
    free: &'a [Free],
    cases: &'a [&'a Prepared],
    from: Option<&Fit>,
    precision: f64,
    derivatives: bool,
) -> Result<(Problem<'a>, Minimum), FitError> {
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
    let minimum = minimise!(4 8 10 12 16 24);
    Ok((problem, minimum))
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
