//! Neighbours of a candidate model: models with one more effect, screened and roughly refitted at twice the tick.

use identification::experiment::Prepared;
use identification::fit::{FitError, Sensitivity, coarse};

use super::refit::{Beginning, Goes};
use super::{Candidate, Chosen, Question, is_jump};
use crate::catalogue::{Hypothesis, is_elastic};
use crate::selection::extended;
use crate::selection::screen::{Lead, screen};

/// A candidate model from which others begin, with the training recordings at twice the tick around it.
#[derive(Debug)]
pub struct Reference<'a> {
    question: &'a Question<'a>,
    candidate: &'a Candidate,
    coarser: Vec<Prepared>,
}

/// Factors by which the noise of every channel of each training recording is multiplied.
pub type Weighing = Vec<Vec<f64>>;

impl<'a> Reference<'a> {
    /// A candidate model as the start of others.
    pub fn new(question: &'a Question<'a>, candidate: &'a Candidate) -> Result<Self, FitError> {
        let coarser = coarse(question.training, &candidate.fit.machine, &candidate.fit.starts)?;
        Ok(Self { question, candidate, coarser })
    }

    /// Effects that could be added to the candidate model, the most promising first.
    pub fn leads(&self, hypotheses: &[&'static Hypothesis]) -> Result<Vec<Lead>, FitError> {
        let coarser: Vec<&Prepared> = self.coarser.iter().collect();
        let Some(sensitivity) = Sensitivity::at(&self.candidate.fit, &coarser)? else { return Ok(Vec::new()) };
        let leads = screen(self.question.scene, &self.candidate.fit, &[sensitivity], hypotheses)?;
        Ok(leads.into_iter().flatten().collect())
    }

    /// The same with each of two weightings.
    pub fn leads_by(
        &self,
        weighings: [&Weighing; 2],
        hypotheses: &[&'static Hypothesis],
    ) -> Result<[Vec<Lead>; 2], FitError> {
        let weighed = weighings.map(|weighing| noisier(self.coarser.clone(), weighing));
        let [one, other] = weighed.each_ref().map(|cases| cases.iter().collect::<Vec<_>>());
        let at = |cases| Sensitivity::at(&self.candidate.fit, cases);
        let (Some(one), Some(other)) = (at(&one)?, at(&other)?) else { return Ok([Vec::new(), Vec::new()]) };
        let leads = screen(self.question.scene, &self.candidate.fit, &[one, other], hypotheses)?;
        let mut leads = leads.into_iter();
        Ok(std::array::from_fn(|_| leads.next().unwrap_or_default()))
    }

    /// Where extensions of one of its effects could start: with bristles those with bristles, for rigid friction the others.
    pub fn extensions(&self, of: &Chosen, by: &[&'static Hypothesis]) -> Result<Vec<Lead>, FitError> {
        let coarser: Vec<&Prepared> = self.coarser.iter().collect();
        let Some(sensitivity) = Sensitivity::at(&self.candidate.fit, &coarser)? else { return Ok(Vec::new()) };
        let mut found = Vec::new();
        for effect in by {
            found.extend(extended(self.question.scene, &self.candidate.fit, &sensitivity, effect)?);
        }
        found.retain(|lead| is_elastic(lead.form) == is_elastic(of.form));
        Ok(found)
    }

    /// The candidate model with one more effect, roughly refitted from the lead's values; [`Candidate::finished`] does the rest.
    pub fn with(&self, lead: &Lead) -> Result<Candidate, FitError> {
        self.beside(self.candidate.effects.clone(), lead)
    }

    /// The candidate model with an extension in the place of the effect that it extends.
    pub fn with_extension(&self, lead: &Lead) -> Result<Candidate, FitError> {
        let plain = lead.effect.extends.map_or("", |extension| extension.plain);
        let mut effects = self.candidate.effects.clone();
        effects.retain(|chosen| chosen.effect.name != plain);
        self.beside(effects, lead)
    }

    /// The lead's effect beside others, roughly refitted.
    fn beside(&self, mut effects: Vec<Chosen>, lead: &Lead) -> Result<Candidate, FitError> {
        effects.push(Chosen { effect: lead.effect, form: lead.form });
        let mut jumps = self.candidate.jumps.clone();
        jumps.extend(lead.values.iter().filter(|(parameter, _)| is_jump(lead.form, *parameter)));
        let Lead { values, settled, .. } = lead;
        let from = Beginning { fit: &self.candidate.fit, values, settled, goes: Goes::Roughly(&self.coarser) };
        Candidate::refitted(self.question, effects, jumps, &from)
    }
}

/// Recordings with more noise.
pub fn noisier(mut cases: Vec<Prepared>, by: &Weighing) -> Vec<Prepared> {
    for (channel, times) in cases.iter_mut().flat_map(|case| &mut case.channels).zip(by.iter().flatten()) {
        channel.noise *= times;
        channel.tolerance = 1.0;
    }
    cases
}
