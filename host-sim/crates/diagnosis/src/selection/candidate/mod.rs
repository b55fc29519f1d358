//! A candidate model: a combination of effects with its refit in the whole model.

mod neighbours;
mod plausibility;
mod refit;
mod restart;
mod uncertainty;

use identification::parallel;
use refit::{FINELY, FINELY_OF, PRECISION};

use identification::effort::Effort;
use identification::experiment::Prepared;
use identification::fit::residuals::counts_from;
use identification::fit::{
    Counts, Fit, FitError, Free, Residuals, coarse, inflation, loss, settle, softened, staged, with_channel_tolerances,
};
use model_core::machine::{Machine, Parameter};

use super::decision_rule::{UNEXPLAINED_BY_SHEET_FROM, UNEXPLAINED_FROM};
use super::screen::Lead;
use crate::catalogue::{EffectParameter, Form, Hypothesis, Scene, is_elastic};

pub use neighbours::{Reference, Weighing, noisier};
pub(crate) use refit::{Beginning, Goes, NEARLY, SETTLED};

/// The question put to the training recordings.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// What is known of the drive beforehand.
    pub scene: &'a Scene<'a>,
    /// Base parameters that may move.
    pub base_parameters: &'a [Free],
    /// Effects that these recordings can show.
    pub hypotheses: &'a [&'static Hypothesis],
    /// Training recordings.
    pub training: &'a [&'a Prepared],
}

impl Question<'_> {
    /// Whether any base parameter is a tolerance, as of a drive that is known by its data sheet.
    pub(crate) fn has_tolerances(&self) -> bool {
        self.base_parameters.iter().any(|free| free.tolerance().is_some())
    }

    /// Whether the recordings are judged by what their signals gain, as of a drive that is entered at a measured force.
    pub(crate) fn is_whitened(&self) -> bool {
        self.training.iter().any(|case| case.stimulus.is_whitened())
    }

    /// Times its noise from which a model that no accepted effect mends is unexplained.
    pub(crate) fn unexplained_from(&self) -> f64 {
        if self.has_tolerances() { UNEXPLAINED_BY_SHEET_FROM } else { UNEXPLAINED_FROM }
    }

    /// The meter of its recordings.
    pub(crate) fn effort(&self) -> Effort {
        self.training.first().map(|case| case.effort.clone()).unwrap_or_default()
    }

    /// The base parameters with their nominal values.
    pub(crate) fn nominal(&self) -> Vec<(Parameter, f64)> {
        self.base_parameters.iter().map(|free| (free.parameter, free.value(0.0))).collect()
    }

    /// How the independent samples of its residuals are counted.
    pub(crate) fn counts(&self) -> Counts {
        counts_from(self.scene.input_point)
    }

    /// The first form of the effects that has all these effect parameters.
    pub(crate) fn form_with(&self, effect_parameters: &[Parameter]) -> Option<Chosen> {
        let forms = |effect: &'static Hypothesis| effect.forms_in(self.scene).map(move |form| Chosen { effect, form });
        let has_all = |chosen: &Chosen| effect_parameters.iter().all(|effect_parameter| chosen.has(*effect_parameter));
        self.hypotheses.iter().copied().flat_map(forms).find(has_all)
    }
}

/// An effect in one of its forms.
#[derive(Clone, Copy, Debug)]
pub struct Chosen {
    /// The effect.
    pub effect: &'static Hypothesis,
    /// The form.
    pub form: Form,
}

impl Chosen {
    /// Whether a parameter is one of its effect parameters.
    pub(crate) fn has(&self, parameter: Parameter) -> bool {
        self.form.iter().any(|effect_parameter| effect_parameter.parameter == parameter)
    }
}

/// A combination of effects with its fit.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The effects beyond the machine file's own.
    pub effects: Vec<Chosen>,
    /// Fitted on all training recordings.
    pub fit: Fit,
    /// Effect parameters without a usable derivative, with the values that were found for them.
    pub jumps: Vec<(Parameter, f64)>,
    /// Residuals on the training recordings.
    pub residuals: Residuals,
    /// Whether it was refitted to the end.
    pub is_finished: bool,
    /// Whether it was fitted with inflated noise, which already includes the correlation of neighbouring rows in the standard deviations.
    pub is_inflated: bool,
    /// How the independent samples of its residuals are counted.
    pub counts: Counts,
}

impl Candidate {
    /// The machine file's model, refitted from two nearby solutions.
    pub fn base(question: &Question<'_>, one: &Fit, other: &Fit) -> Result<Self, FitError> {
        let nearly = |near: &Fit| Self::base_parameters(question, Some(near), NEARLY);
        let (one, other) = rayon::join(|| nearly(one), || nearly(other));
        let (one, other) = (one?, other?);
        if other.fit.loss < one.fit.loss { &other } else { &one }.to_the_end(question)
    }

    /// The machine file's model, refitted from a solution; `None` unless it ends below a loss. It is refitted coarsely first, and to the end only if
    /// that is below the loss.
    pub fn below(question: &Question<'_>, solution: &Fit, loss: f64) -> Result<Option<Self>, FitError> {
        let nearly = Self::base_parameters(question, Some(solution), NEARLY)?;
        if nearly.fit.loss < loss { nearly.to_the_end(question).map(Some) } else { Ok(None) }
    }

    /// The machine file's model with the precision of the reference for all candidate models.
    fn to_the_end(&self, question: &Question<'_>) -> Result<Self, FitError> {
        Self::base_parameters(question, Some(&self.fit), self.negligible(question).min(PRECISION))
    }

    /// A share of the loss that is not worth a step: where residuals are correlated over n rows, a fall of the loss has n times less significance, and of
    /// sparse rows there are fewer altogether.
    fn negligible(&self, question: &Question<'_>) -> f64 {
        let samples: usize = self.residuals.iter().flatten().map(Vec::len).sum();
        let fewer = if question.scene.is_sparse { (FINELY_OF / samples.max(1) as f64).max(1.0) } else { 1.0 };
        let share = inflation(&self.residuals, self.counts) * FINELY * fewer;
        // Without residuals there is no such share.
        if share.is_finite() { share } else { FINELY }
    }

    /// The precision of a refit from here to the end: the more its residuals are correlated, the earlier a further step is worth nothing.
    pub(crate) fn precision(&self, question: &Question<'_>) -> f64 {
        self.negligible(question).clamp(PRECISION, SETTLED)
    }

    /// A refit from here to the end.
    fn to_its_end(&self, question: &Question<'_>) -> Goes<'static> {
        Goes::ToTheEnd(self.precision(question))
    }

    /// The machine file's model, roughly refitted.
    pub fn rough(question: &Question<'_>, from: Option<&Fit>) -> Result<Self, FitError> {
        Self::base_parameters(question, from, SETTLED)
    }

    /// Refits the machine file's model and sets the tolerance of every channel to the misfit of that refit: residuals far beyond it count linearly in
    /// all later fits. Returns that refit; of sparse rows it is searched in stages.
    pub fn tolerated(scene: &Scene<'_>, base_parameters: &[Free], training: &mut [Prepared]) -> Result<Fit, FitError> {
        with_channel_tolerances(scene.machine, training, |training| {
            if scene.is_sparse {
                return staged(scene.machine, base_parameters, training, SETTLED);
            }
            Ok(Self::rough(&Question { scene, base_parameters, hypotheses: &[], training }, None)?.fit)
        })
    }

    /// With the plainer effect in the place of the newest one, which extends it, refitted to the end from the extension's solution: the search with
    /// the plainer effect may never have reached that place. `None` where the newest effect extends none that these recordings can show.
    pub fn with_plain(&self, question: &Question<'_>) -> Result<Option<Self>, FitError> {
        let Some((newest, others)) = self.effects.split_last() else { return Ok(None) };
        let Some(extension) = newest.effect.extends else { return Ok(None) };
        let plain = question.hypotheses.iter().find(|effect| effect.name == extension.plain);
        let alike = |form: &Form| is_elastic(form) == is_elastic(newest.form);
        let form = plain.and_then(|effect| Some((*effect, effect.forms_in(question.scene).find(alike)?)));
        let Some((effect, form)) = form else { return Ok(None) };
        let taken = newest.form.iter().filter(|effect_parameter| extension.taken.contains(&effect_parameter.parameter));
        let taken: Vec<f64> = taken.map(|effect_parameter| self.fit.machine.get(effect_parameter.parameter)).collect();
        if taken.is_empty() {
            return Ok(None);
        }
        let values = [(extension.given, taken.iter().sum::<f64>() / taken.len() as f64)];
        let effects = others.iter().copied().chain([Chosen { effect, form }]).collect();
        let from = Beginning { fit: &self.fit, values: &values, settled: &[], goes: self.to_its_end(question) };
        Self::refitted(question, effects, self.jumps.clone(), &from).map(Some)
    }

    /// Refitted to the end.
    pub fn finished(&self, question: &Question<'_>) -> Result<Self, FitError> {
        self.again_from(question, &[])?.unstuck(question)?.or_with_more_or_less(question)
    }

    /// Refitted to the end from its own solution, except for these starting values.
    fn again_from(&self, question: &Question<'_>, values: &[(Parameter, f64)]) -> Result<Self, FitError> {
        let from = Beginning { fit: &self.fit, values, settled: &[], goes: self.to_its_end(question) };
        Self::refitted(question, self.effects.clone(), self.jumps.clone(), &from)
    }

    /// This candidate model together with one of other effects and other parameters, refitted to the end.
    pub fn beside(&self, question: &Question<'_>, other: &Self) -> Result<Self, FitError> {
        let effects = other.effects.iter().chain(&self.effects).copied().collect();
        let jumps = other.jumps.iter().chain(&self.jumps).copied().collect();
        let fit = self.fit.beside(&other.fit);
        let from = Beginning { fit: &fit, values: &[], settled: &[], goes: self.to_its_end(question) };
        Self::refitted(question, effects, jumps, &from)
    }

    /// With another effect in the place of one, refitted to the end from these values.
    pub fn instead(
        &self,
        question: &Question<'_>,
        index: usize,
        by: Chosen,
        values: &[(Parameter, f64)],
    ) -> Result<Self, FitError> {
        let mut effects = self.effects.clone();
        let gone = std::mem::replace(&mut effects[index], by);
        let mut jumps = self.jumps.clone();
        jumps.retain(|(parameter, _)| !is_jump(gone.form, *parameter));
        let from = Beginning { fit: &self.fit, values, settled: &[], goes: self.to_its_end(question) };
        Self::refitted(question, effects, jumps, &from)
    }

    /// With only some of its effects, refitted to the end to these recordings, which may judge by other signals.
    pub fn only(&self, question: &Question<'_>, keeps: impl Fn(&Hypothesis) -> bool) -> Result<Self, FitError> {
        let (kept, gone): (Vec<_>, Vec<_>) = self.effects.iter().copied().partition(|chosen| keeps(chosen.effect));
        self.left(question, kept, &gone)
    }

    /// Without one of its effects, refitted to the end.
    pub fn without(&self, question: &Question<'_>, index: usize) -> Result<Self, FitError> {
        let mut effects = self.effects.clone();
        let gone = effects.remove(index);
        self.left(question, effects, &[gone])
    }

    /// The candidate model without some of its effects. The share of a base parameter that those had is given back to it.
    fn left(&self, question: &Question<'_>, kept: Vec<Chosen>, gone: &[Chosen]) -> Result<Self, FitError> {
        let mut jumps = self.jumps.clone();
        jumps.retain(|(parameter, _)| gone.iter().all(|chosen| !is_jump(chosen.form, *parameter)));
        let fitted = |parameter| self.fit.machine.get(parameter);
        let left = |effect_parameter: &EffectParameter| {
            effect_parameter
                .negative_of()
                .map(|base_parameters| (base_parameters, fitted(base_parameters) - fitted(effect_parameter.parameter)))
        };
        let values: Vec<_> = gone.iter().flat_map(|chosen| chosen.form.iter()).filter_map(left).collect();
        let from = Beginning { fit: &self.fit, values: &values, settled: &[], goes: self.to_its_end(question) };
        Self::refitted(question, kept, jumps, &from)
    }

    /// Residuals on each training recording of a model that was fitted without it, by one Newton step, from the initial state that fits that model.
    pub fn left_out(&self, question: &Question<'_>) -> Result<Residuals, FitError> {
        self.left_out_by(question, |index| Ok(self.fit.without(index)))
    }

    /// The same with models that are refitted without the recording.
    pub fn left_out_refitted(&self, question: &Question<'_>) -> Result<Residuals, FitError> {
        let coarser = coarse(question.training, &self.fit.machine, &self.fit.starts)?;
        self.left_out_by(question, |index| self.refitted_without(question, &coarser, index))
    }

    fn left_out_by(
        &self,
        question: &Question<'_>,
        without: impl Fn(usize) -> Result<Machine<f64>, FitError> + Sync,
    ) -> Result<Residuals, FitError> {
        let training = question.training;
        let residuals = |(index, case): (usize, &&Prepared)| {
            let machine = if training.len() > 1 { without(index)? } else { self.fit.machine };
            Ok(softened(&machine, case, settle(&machine, case)?)?)
        };
        parallel::try_each(training.iter().enumerate(), residuals)
    }

    /// Names of its effects, sorted.
    #[must_use]
    pub fn names(&self) -> Vec<&'static str> {
        let mut names: Vec<&str> = self.effects.iter().map(|chosen| chosen.effect.name).collect();
        names.sort_unstable();
        names
    }

    /// Whether an effect is one of its own.
    pub(crate) fn has(&self, effect: &Hypothesis) -> bool {
        self.effects.iter().any(|chosen| chosen.effect.name == effect.name)
    }

    /// The effect that was added last and its form.
    pub(crate) fn newest(&self) -> Option<(&'static str, *const EffectParameter)> {
        self.effects.last().map(|newest| (newest.effect.name, newest.form.as_ptr()))
    }

    /// Whether the effect that was added last is the one of a lead.
    pub(crate) fn newest_is_like(&self, lead: &Lead) -> bool {
        self.newest() == Some((lead.effect.name, lead.form.as_ptr()))
    }

    /// How many values its effects bring with them: their parameters and, of a play, where in it the rod starts, in each recording.
    #[must_use]
    pub fn effect_parameters(&self) -> usize {
        self.brought(|_| true)
    }

    /// How many of them the model without effects does not have. Of an effect that may have changed it has what says how the effect acts.
    pub(crate) fn new_values(&self, question: &Question<'_>) -> usize {
        let is_free =
            |own: &EffectParameter| question.base_parameters.iter().any(|free| free.parameter == own.parameter);
        self.brought(|own| own.is_amount() || question.scene.shape_then(own).is_none() || !is_free(own))
    }

    fn brought(&self, counts: impl Fn(&EffectParameter) -> bool) -> usize {
        let has_play = self.effects.iter().any(|chosen| chosen.has(Parameter::BacklashPlay));
        let own = effect_parameters(&self.effects).into_iter().filter(|own| counts(own)).count();
        own + if has_play { self.fit.starts.len() } else { 0 }
    }

    /// Whether its worst channel is off by more than what counts as its noise.
    pub(crate) fn misses_by_more_than_noise(&self, question: &Question<'_>) -> bool {
        self.worst_over_noise(question) > question.unexplained_from()
    }

    /// RMSE over noise of the worst channel.
    #[must_use]
    pub fn worst_over_noise(&self, question: &Question<'_>) -> f64 {
        let channels = question.training.first().map_or(0, |case| case.channels.len());
        (0..channels)
            .map(|channel| {
                let (square, rows) = self.residuals.iter().fold((0.0, 0.0), |sum, case| {
                    (
                        sum.0 + case.get(channel).map_or(0.0, |series| loss(series)),
                        sum.1 + case.get(channel).map_or(0, Vec::len) as f64,
                    )
                });
                let over_noise = (square / f64::max(rows, 1.0)).sqrt();
                if over_noise.is_finite() { over_noise } else { f64::INFINITY }
            })
            .fold(0.0, f64::max)
    }
}

/// The effect parameters of these effects; one that several effects share is listed once.
fn effect_parameters(effects: &[Chosen]) -> Vec<EffectParameter> {
    let mut found: Vec<EffectParameter> = Vec::new();
    for effect_parameter in effects.iter().flat_map(|chosen| chosen.form.iter()) {
        if found.iter().all(|known| known.parameter != effect_parameter.parameter) {
            found.push(*effect_parameter);
        }
    }
    found
}

fn is_jump(form: Form, parameter: Parameter) -> bool {
    form.iter().any(|effect_parameter| effect_parameter.parameter == parameter && effect_parameter.is_jump())
}

#[cfg(test)]
mod tests;
