//! The recordings believed only as far as a model can that misses so much.
//!
//! A model that lacks an effect bends its ordinary parameters, far beyond what is said of them, to make up for it; from there the
//! effect that it lacks does not look like the best addition. Tempered, every channel's noise is taken to be what the model
//! leaves, and as correlated: the priors keep the parameters where they can be, and what is left shows the effect.

use rayon::prelude::*;

use crate::candidate::{Candidate, Question};
use crate::fit::{FitError, StartState, effective_samples, loss, standardised};
use crate::prepare::Prepared;

/// Recordings with the noise that a refitted model asks for, and that model.
#[derive(Clone, Debug)]
pub struct Tempered {
    /// The training recordings.
    pub cases: Vec<Prepared>,
    /// The machine file's model, refitted to them.
    pub base: Candidate,
}

impl Tempered {
    /// Each round takes the noise from what the round before left; the first from the machine file as it is.
    pub fn of(question: &Question<'_>) -> Result<Self, FitError> {
        /// After three rounds the noise hardly changes.
        const ROUNDS: usize = 3;
        let mut found = Self::round(question, None)?;
        for _ in 1..ROUNDS {
            found = Self::round(question, Some(&found.base))?;
        }
        Ok(found)
    }

    fn round(question: &Question<'_>, from: Option<&Candidate>) -> Result<Self, FitError> {
        let machine = from.map_or(question.scene.machine, |from| &from.fit.machine);
        let cases = question
            .training
            .par_iter()
            .enumerate()
            .map(|(index, &case)| {
                let start = from.map_or(StartState::default(), |from| from.fit.starts[index]);
                let mut case = case.clone();
                let residuals = standardised(machine, &case, start)?;
                for (channel, series) in case.channels.iter_mut().zip(&residuals) {
                    channel.noise *= (loss(series) / effective_samples(series)).sqrt().max(1.0);
                    channel.tolerance = 1.0;
                }
                Ok(case)
            })
            .collect::<Result<Vec<_>, FitError>>()?;
        let references: Vec<&Prepared> = cases.iter().collect();
        let base = Candidate::rough(&Question { training: &references, ..*question }, from.map(|from| &from.fit))?;
        Ok(Self { cases, base })
    }
}
