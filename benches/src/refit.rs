//! One refit of ten parameters on the training recordings of a case.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use identification::compare::CompareError;
use identification::experiment::Prepared;
use identification::fit::{Fit, FitError, Free, Freedom, From, fit_with_progress};
use machine_file::MachineFileError;
use model_core::machine::{Machine, Parameter as P};
use recording::{ChannelMap, RecordingError, Signal};

/// What is free, in the peers' order.
pub const FREE: [P; 10] = [
    P::ValveGain,
    P::ValveOffset,
    P::DeadZone,
    P::RateLimit,
    P::TimeConstant1,
    P::TimeConstant2,
    P::TransportDelay,
    P::FlowCoefficient,
    P::ViscousFriction,
    P::BulkModulus,
];

/// Standard deviation of the valve's offset, whose nominal value may be 0; for any other parameter it is the nominal value itself. Such a
/// wide prior has no weight beside a recording.
const OFFSET_SIGMA: f64 = 0.05;

/// The search ends when a step lowers the loss by less than this share, as by default in `scipy.optimize.least_squares`.
const PRECISION: f64 = 1e-8;

/// Number of rows from which the peers take the first position.
const ROWS_AT_REST: usize = 50;

/// A case that was read.
#[derive(Clone, Debug)]
pub struct Refit {
    machine: Machine<f64>,
    free: Vec<Free>,
    cases: Vec<Prepared>,
    /// Factor from our residuals to the peers', where the problem is the peers'.
    unit: Option<f64>,
}

/// Why there is nothing to refit.
#[derive(Debug, thiserror::Error)]
pub enum RefitError {
    /// The folder cannot be listed.
    #[error("{folder}: {cause}")]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// Why not.
        cause: std::io::Error,
    },
    /// The machine file is invalid.
    #[error(transparent)]
    Machine(#[from] Box<MachineFileError>),
    /// A recording is invalid.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A recording cannot be simulated.
    #[error(transparent)]
    Prepared(#[from] CompareError),
}

impl Refit {
    /// Reads `machine.toml` and every `train-*.csv` of a folder.
    pub fn read(folder: &Path) -> Result<Self, RefitError> {
        let file = machine_file::read(&folder.join("machine.toml")).map_err(Box::new)?;
        let listed = |cause| RefitError::Folder { folder: folder.to_owned(), cause };
        let mut training: Vec<PathBuf> = std::fs::read_dir(folder)
            .map_err(listed)?
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("train-")))
            .collect();
        training.sort();
        let prepare = |path: &PathBuf| {
            let recording = recording::read(path, &ChannelMap::default())?;
            Ok(Prepared::new(&recording, &file.machine, file.load_source, None)?)
        };
        let cases = training.iter().map(prepare).collect::<Result<_, RefitError>>()?;
        let around = |&parameter: &P| {
            let nominal = file.machine.get(parameter);
            let sigma = if parameter == P::ValveOffset { OFFSET_SIGMA } else { nominal.abs() };
            Free { parameter, freedom: Freedom::Around { nominal, sigma } }
        };
        Ok(Self { machine: file.machine, free: FREE.iter().map(around).collect(), cases, unit: None })
    }

    /// The same problem as the peers': plain squares, each channel scaled by its norm over all recordings, and initial states that are not free. The
    /// first channel's residuals are still divided by its noise, so that the priors have as little weight as before.
    #[must_use]
    pub fn as_the_peers(mut self) -> Self {
        let norms: Vec<f64> = (0..self.cases[0].channels.len())
            .map(|index| {
                let of_case = |case: &Prepared| {
                    let recorded = &case.channels[index].recorded;
                    let mean = recorded.iter().sum::<f64>() / recorded.len() as f64;
                    recorded.iter().map(|value| (value - mean).powi(2)).sum::<f64>().sqrt()
                };
                self.cases.iter().map(of_case).sum::<f64>() / self.cases.len() as f64
            })
            .collect();
        let unit = self.cases[0].channels[0].noise / norms[0];
        self.unit = Some(unit);
        for case in &mut self.cases {
            for (channel, norm) in case.channels.iter_mut().zip(&norms) {
                channel.noise = norm * unit;
                // A tolerance so large that residuals of any size are squared.
                channel.tolerance = 1e9;
            }
            let position = case.channels.iter().find(|channel| channel.signal == Signal::Position);
            let rest = position.map_or(&[][..], |channel| &channel.recorded[..ROWS_AT_REST]);
            let start = &mut case.stimulus.start;
            start.position_m = rest.iter().sum::<f64>() / ROWS_AT_REST as f64;
            start.pressures_pa = Some(at_rest(&self.machine));
            case.start_sigma_m = 0.0;
        }
        self
    }

    /// Rows of all recordings together.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.cases.iter().map(Prepared::rows).sum()
    }

    /// Half the sum of squares at the end of a fit, as the peers count it, where the problem is theirs; the priors, which have almost no
    /// weight, are included.
    #[must_use]
    pub fn cost(&self, fit: &Fit) -> Option<f64> {
        Some(fit.loss * self.unit?.powi(2))
    }

    /// Refits, from the nominal values; also how many times each recording was simulated with its derivatives.
    pub fn run(&self) -> Result<(Fit, usize), FitError> {
        let cases: Vec<&Prepared> = self.cases.iter().collect();
        let evaluated = AtomicUsize::new(0);
        let told = |_: &Prepared| {
            evaluated.fetch_add(1, Ordering::Relaxed);
        };
        let found = fit_with_progress(&self.machine, &self.free, &cases, &From::default(), PRECISION, &told)?;
        Ok((found, evaluated.into_inner() / cases.len().max(1)))
    }
}

/// Pressures in A and B at rest, Pa, as the peers set them: half the supply in B, and the balance of forces within 2 to 98 % of it.
fn at_rest(machine: &Machine<f64>) -> (f64, f64) {
    let [supply, area_a, area_b, force] =
        [P::SupplyPressure, P::AreaA, P::AreaB, P::LoadForce].map(|parameter| machine.get(parameter));
    let within = |pressure: f64| pressure.clamp(0.02 * supply, 0.98 * supply);
    let a = within((0.5 * supply * area_b - force) / area_a);
    (a, within((a * area_a + force) / area_b))
}
