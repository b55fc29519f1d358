//! The recordings believed only as far as a model can that misses so much.
//!
//! A model that lacks an effect bends its base parameters, far beyond what is said of them, to make up for it; from there the
//! effect that it lacks does not look like the best addition. Inflated, every channel's noise is taken to be what the model
//! leaves, and as correlated: the priors keep the parameters where they can be, and what is left shows the effect.
//!
//! What it shows is weighed twice. Correlated, a bend against the priors gains nothing, and a weak effect stands out; but all the time
//! that a rod rests at a stop is one sample, and the stop explains less than a trifle does in a signal that is nearly noise. With
//! every sample independent it explains most.

use identification::experiment::Prepared;
use identification::fit::residuals::samples_by_blocks;
use identification::fit::{Fit, FitError, Residuals, StartState, effective_samples, loss, standardised_all};
use model_core::machine::{Machine, MachineError};

use super::candidate::{Candidate, Question, Weighing, noisier};

/// The noise that a refitted model asks for, and that model.
#[derive(Clone, Debug)]
pub(super) struct InflatedNoise {
    /// The noise of every channel what the model leaves, and as correlated.
    pub correlated: Weighing,
    /// The same with every sample independent.
    pub independent: Weighing,
    /// The machine file's model, refitted with the noise of every channel what it leaves, and as correlated.
    pub base: Candidate,
}

impl InflatedNoise {
    /// Each round takes the noise from what the round before left; the first from the machine file as it is.
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

/// The recordings believed as far as a set follows them: with the noise of every channel what it leaves, and as correlated.
pub(crate) fn as_far_as(question: &Question<'_>, set: &Candidate) -> Result<Vec<Prepared>, MachineError> {
    let left = left_by(question, &set.fit.machine, &set.fit.starts)?;
    Ok(noisy(question, &spread(&left, samples_by_blocks)))
}

/// What a machine leaves of every channel of each training recording, over its noise.
fn left_by(question: &Question<'_>, machine: &Machine<f64>, starts: &[StartState]) -> Result<Residuals, MachineError> {
    standardised_all(machine, question.training.iter().copied().zip(starts.iter().copied()))
}

/// The machine file's model, refitted with the noise that so much left asks for.
fn refitted(question: &Question<'_>, left: &Residuals, from: Option<&Fit>) -> Result<Candidate, FitError> {
    let cases = noisy(question, &spread(left, effective_samples));
    let references: Vec<&Prepared> = cases.iter().collect();
    Candidate::rough(&Question { training: &references, ..*question }, from)
}

/// The training recordings with so much more noise.
fn noisy(question: &Question<'_>, by: &Weighing) -> Vec<Prepared> {
    noisier(question.training.iter().map(|&case| case.clone()).collect(), by)
}

/// The noise if all that is left of a channel is noise, spread over so many samples.
fn spread(left: &Residuals, samples: fn(&[f64]) -> f64) -> Weighing {
    let each = |series: &Vec<f64>| (loss(series) / samples(series)).sqrt().max(1.0);
    left.iter().map(|case| case.iter().map(each).collect()).collect()
}
