//! Refit of parameters on all training recordings together.
//!
//! Levenberg-Marquardt (crate `levenberg-marquardt`, a port of MINPACK) over residuals divided by each channel's noise,
//! with the derivatives from the core run on dual numbers. A pseudo-Huber loss keeps single spikes from steering the fit.
//! Every free value has a prior: a base parameter a nominal value with a stated standard deviation, an effect parameter
//! its usual range. Positive effect parameters move by their logarithm, and no effect parameter moves far out of its
//! usual range. The initial state of each recording is free as well, within what its sensors leave open.

pub mod coarse;
mod correlation;
mod first_search;
mod free;
mod initial_state;
mod jacobian;
mod kept_jacobian;
mod levenberg_marquardt;
mod normal_equations;
pub mod residuals;
mod sensitivity;
mod staged;
#[cfg(test)]
mod test_fit;
mod unsettled;

use levenberg_marquardt::{Minimum, Problem};
use nalgebra::{DMatrix, DVector};

use model_core::machine::{Machine, MachineError, Parameter, Tick};
use simulation::DELAY_LINE;

use crate::experiment::Prepared;

pub use coarse::coarse;
pub use correlation::{CORRELATED, Correlation};
pub use first_search::{OF_VALVE, STRUCTURES, first_search, moves_spool, other_structure, spool_alone};
pub use free::{Free, Freedom, REACH, REACH_SIGNED};
pub use initial_state::{StartState, level_at_rest, settle, settled};
pub use levenberg_marquardt::Progress;
pub use normal_equations::NormalEquations;
pub(crate) use normal_equations::OF_START;
pub use residuals::{
    Counts, Misfit, Residuals, effective_samples, inflation, loss, misfits, misfits_of, set_tolerances, soft, soften,
    softened, softened_all, standardised, standardised_all, with_channel_tolerances,
};
pub use sensitivity::{Change, Directed, Sensitivity, Settled, Simulated};
pub use staged::staged;
pub use unsettled::{Unrest, Unsettled};

/// Largest number of parameters in one fit.
pub const MOST_PARAMETERS: usize = simulation::MOST_PARAMETERS;

/// A fitted parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Which.
    pub parameter: Parameter,
    /// The value it started from.
    pub before: f64,
    /// The fitted value, SI.
    pub value: f64,
    /// Its standard deviation, SI, which accounts for the correlation of the residuals in time; NaN where the recordings do
    /// not determine it.
    pub std: f64,
    /// Whether it ended at an end of its admissible range; then it is no estimate.
    pub at_bound: bool,
}

/// Joint uncertainty of the fitted values.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncertainty {
    /// Parameters that recordings determine, each with its standard deviation, SI.
    pub steps: Vec<(Parameter, f64)>,
    /// Inverse of their covariance, in steps of one standard deviation towards larger values.
    pub precision: DMatrix<f64>,
}

/// The result of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The machine with fitted values.
    pub machine: Machine<f64>,
    /// What was free.
    pub free: Vec<Free>,
    /// Coordinates of the solution.
    pub coordinates: Vec<f64>,
    /// The state each recording starts from.
    pub starts: Vec<StartState>,
    /// What each recording says about the free parameters, at the solution.
    pub normal_equations: Vec<NormalEquations>,
    /// Whether the optimiser met one of its criteria.
    pub converged: bool,
    /// Half the sum of squares that it minimised, priors included.
    pub loss: f64,
}

impl Fit {
    /// A machine as it is, from these states of the recordings: nothing is free.
    #[must_use]
    pub fn of(machine: Machine<f64>, starts: Vec<StartState>) -> Self {
        let (free, coordinates, normal_equations) = (Vec::new(), Vec::new(), Vec::new());
        Self { machine, free, coordinates, starts, normal_equations, converged: true, loss: 0.0 }
    }

    /// Every free parameter with its standard deviation; `inflation` is how many times more rows there are than independent
    /// samples.
    #[must_use]
    pub fn estimates(&self, inflation: f64) -> Vec<Estimate> {
        let covariance = NormalEquations::covariance(&self.normal_equations, inflation);
        let deviation = |slot| covariance.as_ref().map_or(f64::NAN, |covariance| covariance[(slot, slot)].sqrt());
        self.free
            .iter()
            .zip(self.coordinates.iter().zip((0..).map(deviation)))
            .map(|(free, (&coordinate, deviation))| Estimate {
                parameter: free.parameter,
                before: free.value(0.0),
                value: free.value(coordinate),
                std: if free.at_bound(coordinate) { f64::NAN } else { free.slope(coordinate).abs() * deviation },
                at_bound: free.at_bound(coordinate),
            })
            .collect()
    }

    /// The joint uncertainty of the free parameters' values; see [`Self::estimates`].
    #[must_use]
    pub fn uncertainty(&self, inflation: f64) -> Uncertainty {
        let estimates = self.estimates(inflation);
        let precision = NormalEquations::precision(&self.normal_equations, inflation);
        let slope = |index: usize| self.free[index].slope(self.coordinates[index]).abs();
        let moves = |index: &usize| estimates[*index].std.is_finite() && estimates[*index].std > 0.0;
        let moving: Vec<usize> = (0..estimates.len().min(precision.nrows())).filter(moves).collect();
        let deviation = |index: usize| estimates[index].std / slope(index);
        let entry = |row: usize, column: usize| {
            let (row, column) = (moving[row], moving[column]);
            precision[(row, column)] * deviation(row) * deviation(column)
        };
        Uncertainty {
            steps: moving.iter().map(|&index| (estimates[index].parameter, estimates[index].std)).collect(),
            precision: DMatrix::from_fn(moving.len(), moving.len(), entry),
        }
    }

    /// Every coordinate: of the free parameters, then of each recording's start.
    pub(crate) fn all_coordinates(&self) -> DVector<f64> {
        let starts = self.starts.iter().flat_map(|start| [start.level, start.shift]);
        DVector::from_iterator(
            self.coordinates.len() + OF_START * self.starts.len(),
            self.coordinates.iter().copied().chain(starts),
        )
    }

    /// This solution together with that of other parameters, as the start of a search over all of them; the recordings start as in this one.
    #[must_use]
    pub fn beside(&self, other: &Self) -> Self {
        let mut both = self.clone();
        for (free, &coordinate) in other.free.iter().zip(&other.coordinates) {
            both.machine.set(free.parameter, free.value(coordinate));
            both.free.push(*free);
            both.coordinates.push(coordinate);
        }
        both
    }

    /// The machine that this fit would have ended at without one of its recordings: one Newton step away from the solution.
    #[must_use]
    pub fn without(&self, recording: usize) -> Machine<f64> {
        let step = NormalEquations::step_without(&self.normal_equations, recording, &self.coordinates);
        let mut machine = self.machine;
        for (free, (&coordinate, step)) in self.free.iter().zip(self.coordinates.iter().zip(&step)) {
            // A step far beyond the prior is not reliable, so it is limited.
            machine.set(free.parameter, free.value(coordinate + step.clamp(-2.0, 2.0)));
        }
        machine
    }
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

/// Where a search starts.
#[derive(Clone, Debug, Default)]
pub struct From<'a> {
    /// A former solution; parameters that it does not have start at the middle of their prior.
    pub solution: Option<&'a Fit>,
    /// Coordinates of single parameters, which take precedence over the former solution's.
    pub coordinates: &'a [(Parameter, f64)],
    /// Every coordinate of the former solution after a move; empty where the search starts at the former solution itself.
    pub moved: &'a [f64],
}

/// Fits `free` parameters of `machine` to the recordings.
///
/// The search ends when the loss falls by less than `precision` of itself in a step.
pub fn fit(
    machine: &Machine<f64>,
    free: &[Free],
    cases: &[&Prepared],
    from: &From<'_>,
    precision: f64,
) -> Result<Fit, FitError> {
    fit_with_progress(machine, free, cases, from, precision, &|_| ())
}

/// Largest number of times that [`fit`] evaluates each recording; usually it ends much earlier.
#[must_use]
pub const fn most_evaluations(free: usize, recordings: usize) -> usize {
    levenberg_marquardt::most_evaluations(free + OF_START * recordings)
}

/// As [`fit`], and reports each recording after each of its evaluations.
pub fn fit_with_progress(
    machine: &Machine<f64>,
    free: &[Free],
    cases: &[&Prepared],
    from: &From<'_>,
    precision: f64,
    told: &Progress<'_>,
) -> Result<Fit, FitError> {
    if free.len() > MOST_PARAMETERS {
        return Err(FitError::TooMany { count: free.len() });
    }
    let mut problem = Problem::new(machine, free, cases, from, told);
    // The optimiser cannot report why residuals fail, so the start is tried first.
    model_core::drive::Drive::<f64>::new::<DELAY_LINE>(
        &problem.machine(),
        cases.first().map_or(Tick::OneMillisecond, |case| case.stimulus.tick),
    )?;
    let Minimum { converged, loss } = problem.minimise(precision);
    Ok(Fit {
        machine: problem.machine(),
        free: free.to_vec(),
        starts: problem.starts(),
        coordinates: problem.coordinates.iter().take(free.len()).copied().collect(),
        normal_equations: problem.normal_equations,
        converged,
        // A start that does not become a drive, or whose derivatives are not finite, gives no fit.
        loss: if loss.is_finite() { loss } else { f64::INFINITY },
    })
}
