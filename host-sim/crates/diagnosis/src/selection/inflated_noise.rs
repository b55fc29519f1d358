//! Inflated noise (tempered likelihood): each channel's noise is raised to the model's own misfit.
//!
//! A model that lacks an effect pulls its base parameters far from their nominal values to make up for it; from there the missing effect does not
//! look like the best addition. With inflated noise, every channel's noise is taken to be as large and as correlated as the model's residual: the
//! priors keep the parameters where they can be, and the residual shows the effect.
//!
//! The residual is weighted in two ways. With correlated noise, pulling parameters against the priors gains nothing, and a weak effect stands out;
//! but the whole time that a rod rests at a stop counts as one sample, so that the stop explains less than a trifle does in a signal that is nearly
//! noise. With every sample independent, the stop explains most.

use identification::experiment::Prepared;
use identification::fit::residuals::samples_by_blocks;
use identification::fit::{Fit, FitError, Residuals, StartState, effective_samples, loss, standardised_all};
use model_core::machine::{Machine, MachineError};

use super::candidate::{Candidate, Question, Weighing, noisier};

/// The inflated noise of a refitted model, and that model.
#[derive(Clone, Debug)]
pub(super) struct InflatedNoise {
    /// Noise of every channel as large and as correlated as the model's residual.
    pub correlated: Weighing,
    /// The same with every sample independent.
    pub independent: Weighing,
    /// The machine file's model, refitted with noise of every channel as large and as correlated as its own residual.
    pub base: Candidate,
}

impl InflatedNoise {
    /// Each round takes the noise from the residual of the round before; the first from that of the machine file as it is.
    pub(super) fn of(question: &Question<'_>) -> Result<Self, FitError> {
        /// After three rounds the noise hardly changes.
        const ROUNDS: usize = 3;
        let nominal = vec![StartState::default(); question.training.len()];
        let mut base = refitted(question, &left_by(question, question.scene.machine, &nominal)?, None)?;
        let mut left = left_by(question, &base.fit.machine, &base.fit.starts)?;
        for _ in 1..ROUNDS {
            base = refitted(question, &left, Some(&base.fit))?;
            left = left_by(question, &base.fit.machine, &base.fit.starts)?;
        }
        let (correlated, independent) = (spread(&left, effective_samples), spread(&left, |series| series.len() as f64));
        Ok(Self { correlated, independent, base })
    }
}

/// The recordings with the noise inflated to a candidate model's misfit: in every channel as large and as correlated as its residual.
pub(crate) fn as_far_as(question: &Question<'_>, candidate: &Candidate) -> Result<Vec<Prepared>, MachineError> {
    let left = left_by(question, &candidate.fit.machine, &candidate.fit.starts)?;
    Ok(noisy(question, &spread(&left, samples_by_blocks)))
}

/// Residual of a machine in every channel of each training recording, over its noise.
fn left_by(question: &Question<'_>, machine: &Machine<f64>, starts: &[StartState]) -> Result<Residuals, MachineError> {
    standardised_all(machine, question.training.iter().copied().zip(starts.iter().copied()))
}

/// The machine file's model, refitted with the noise that belongs to this residual.
fn refitted(question: &Question<'_>, left: &Residuals, from: Option<&Fit>) -> Result<Candidate, FitError> {
    let cases = noisy(question, &spread(left, effective_samples));
    let references: Vec<&Prepared> = cases.iter().collect();
    Candidate::rough(&Question { training: &references, ..*question }, from)
}

/// The training recordings with their noise multiplied by these factors.
fn noisy(question: &Question<'_>, by: &Weighing) -> Vec<Prepared> {
    noisier(question.training.iter().map(|&case| case.clone()).collect(), by)
}

/// Factor for the noise of each channel if its whole residual is noise, spread over this number of independent samples.
fn spread(left: &Residuals, samples: fn(&[f64]) -> f64) -> Weighing {
    let each = |series: &Vec<f64>| (loss(series) / samples(series)).sqrt().max(1.0);
    left.iter().map(|case| case.iter().map(each).collect()).collect()
}
