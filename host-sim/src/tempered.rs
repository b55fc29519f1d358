//! The recordings believed only as far as a model can that misses so much.
//!
//! A model that lacks an effect bends its ordinary parameters, far beyond what is said of them, to make up for it; from there the
//! effect that it lacks does not look like the best addition. Tempered, every channel's noise is taken to be what the model
//! leaves, and as correlated: the priors keep the parameters where they can be, and what is left shows the effect.
//!
//! What it shows is weighed twice. Correlated, a bend against the priors gains nothing, and a weak effect stands out; but all the time
//! that a rod rests at a stop is one sample, and the stop explains less than a trifle does in a signal that is nearly noise. With
//! every sample independent it explains most.

use model_core::machine::Machine;
use rayon::prelude::*;

use crate::candidate::{Candidate, Question};
use crate::fit::{Fit, FitError, StartState, effective_samples, loss, standardised};
use crate::prepare::Prepared;

/// Recordings with the noise that a refitted model asks for, and that model.
#[derive(Clone, Debug)]
pub struct Tempered {
    /// The training recordings, the noise of every channel what the model leaves, and as correlated.
    pub correlated: Vec<Prepared>,
    /// The same with every sample independent.
    pub independent: Vec<Prepared>,
    /// The machine file's model, refitted with the noise of every channel what it leaves, and as correlated.
    pub base: Candidate,
}

impl Tempered {
    /// Each round takes the noise from what the round before left; the first from the machine file as it is.
    pub fn of(question: &Question<'_>) -> Result<Self, FitError> {
        /// After three rounds the noise hardly changes.
        const ROUNDS: usize = 3;
        let nominal = vec![StartState::default(); question.training.len()];
        let mut base = refitted(question, question.scene.machine, &nominal, None)?;
        for _ in 1..ROUNDS {
            base = refitted(question, &base.fit.machine, &base.fit.starts, Some(&base.fit))?;
        }
        let Fit { machine, starts, .. } = &base.fit;
        let correlated = noisier(question, machine, starts, effective_samples)?;
        let independent = noisier(question, machine, starts, |series| series.len() as f64)?;
        Ok(Self { correlated, independent, base })
    }
}

/// The machine file's model, refitted with the noise that another machine asks for.
fn refitted(
    question: &Question<'_>,
    machine: &Machine<f64>,
    starts: &[StartState],
    from: Option<&Fit>,
) -> Result<Candidate, FitError> {
    let cases = noisier(question, machine, starts, effective_samples)?;
    let references: Vec<&Prepared> = cases.iter().collect();
    Candidate::rough(&Question { training: &references, ..*question }, from)
}

/// The training recordings as if the noise of every channel were all that a machine leaves, spread over so many samples.
fn noisier(
    question: &Question<'_>,
    machine: &Machine<f64>,
    starts: &[StartState],
    samples: fn(&[f64]) -> f64,
) -> Result<Vec<Prepared>, FitError> {
    let training = question.training.par_iter().zip(starts);
    let noisier = |(case, start): (&&Prepared, &StartState)| {
        let mut case = Prepared::clone(case);
        let residuals = standardised(machine, &case, *start)?;
        for (channel, series) in case.channels.iter_mut().zip(&residuals) {
            channel.noise *= (loss(series) / samples(series)).sqrt().max(1.0);
            channel.tolerance = 1.0;
        }
        Ok(case)
    };
    training.map(noisier).collect()
}
