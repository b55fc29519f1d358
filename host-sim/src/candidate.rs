//! A set of effects with its refit in the chain.

mod standing;

use model_core::machine::Machine;
use model_core::parameter::Parameter;
use rayon::prelude::*;

use crate::fit::{
    Estimate, Fit, FitError, Free, From, Sensitivity, StartState, effective_samples, fit, loss, set_tolerances, settle,
    softened,
};
use crate::hypothesis::{Form, Hypothesis, Kind, Scene, Strength, is_elastic};
use crate::prepare::Prepared;
use crate::screen::{Lead, extended, screen, with};

/// The question put to the training recordings.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// What is known of the drive before.
    pub scene: &'a Scene<'a>,
    /// Ordinary parameters that may move.
    pub ordinary: &'a [Free],
    /// Effects that these recordings can show.
    pub hypotheses: &'a [&'static Hypothesis],
    /// Training recordings.
    pub training: &'a [&'a Prepared],
}

/// An effect in one of its forms.
#[derive(Clone, Copy, Debug)]
pub struct Chosen {
    /// The effect.
    pub effect: &'static Hypothesis,
    /// The form.
    pub form: Form,
}

/// Standardised residuals: for each recording one series a channel.
pub type Residuals = Vec<Vec<Vec<f64>>>;

/// A set of effects with its fit.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The effects beyond the machine file's own.
    pub effects: Vec<Chosen>,
    /// Fitted on all training recordings.
    pub fit: Fit,
    /// Strengths that no slope leads to, as they were found.
    pub jumps: Vec<(Parameter, f64)>,
    /// Residuals on the training recordings.
    pub residuals: Residuals,
    /// Whether it was refitted to the end.
    pub is_finished: bool,
}

/// The search ends when the loss falls by less than this share in a step.
const PRECISION: f64 = 1e-5;
/// The same for what all sets are measured against: of twenty thousand samples a hundredth of a unit of log-likelihood.
const FINELY: f64 = 1e-6;
/// The same for one of several starts, the best of which is gone on with.
const NEARLY: f64 = 1e-4;
/// The same for a first look.
const ROUGHLY: f64 = 0.03;

/// Where a refit begins.
struct Beginning<'a> {
    fit: &'a Fit,
    /// Strengths that are new.
    values: &'a [(Parameter, f64)],
    /// Where the former fit's coordinates settle with them.
    settled: &'a [f64],
    precision: f64,
}

impl Candidate {
    /// The machine file's model, refitted from two solutions that are near.
    pub fn base(question: &Question<'_>, one: &Fit, other: &Fit) -> Result<Self, FitError> {
        let nearly = |near: &Fit| Self::ordinary(question, Some(near), NEARLY);
        let (one, other) = rayon::join(|| nearly(one), || nearly(other));
        let (one, other) = (one?, other?);
        Self::near(question, if other.loss < one.loss { &other } else { &one })
    }

    /// The machine file's model, refitted to the end from a solution that is near.
    pub fn near(question: &Question<'_>, solution: &Fit) -> Result<Self, FitError> {
        // Of residuals that are alike for so many rows, a fall of the loss says so many times less.
        let alike = inflation(&residuals(question, solution)?);
        let precision = (alike * FINELY).min(PRECISION);
        Self::of(question, Vec::new(), Self::ordinary(question, Some(solution), precision)?, Vec::new(), true)
    }

    /// The machine file's model, refitted from a solution where that ends below a loss: nearly first, to the end only where it does.
    pub fn below(question: &Question<'_>, solution: &Fit, loss: f64) -> Result<Option<Self>, FitError> {
        let nearly = Self::ordinary(question, Some(solution), NEARLY)?;
        if nearly.loss < loss { Self::near(question, &nearly).map(Some) } else { Ok(None) }
    }

    /// The machine file's model, roughly refitted.
    pub fn rough(question: &Question<'_>, from: Option<&Fit>) -> Result<Self, FitError> {
        Self::of(question, Vec::new(), Self::ordinary(question, from, 1e-3)?, Vec::new(), false)
    }

    /// A refit of the ordinary parameters alone.
    fn ordinary(question: &Question<'_>, solution: Option<&Fit>, precision: f64) -> Result<Fit, FitError> {
        let from = From { solution, ..From::default() };
        fit(question.scene.machine, question.ordinary, question.training, &from, precision)
    }

    /// The machine file's model refitted, after which every channel tolerates what that leaves: residuals far beyond count
    /// linearly in all that follows.
    /// That refit is returned.
    pub fn tolerated(scene: &Scene<'_>, ordinary: &[Free], training: &mut [Prepared]) -> Result<Fit, FitError> {
        let nominal = vec![StartState::default(); training.len()];
        set_tolerances(scene.machine, training, &nominal)?;
        let references: Vec<&Prepared> = training.iter().collect();
        let base = fit(scene.machine, ordinary, &references, &From::default(), 1e-3)?;
        set_tolerances(&base.machine, training, &base.starts)?;
        Ok(base)
    }

    /// A fit with its residuals.
    pub(crate) fn of(
        question: &Question<'_>,
        effects: Vec<Chosen>,
        fit: Fit,
        jumps: Vec<(Parameter, f64)>,
        is_finished: bool,
    ) -> Result<Self, FitError> {
        let residuals = residuals(question, &fit)?;
        Ok(Self { effects, fit, jumps, residuals, is_finished })
    }

    /// What could be added to it, the most promising first.
    pub fn leads(&self, question: &Question<'_>, hypotheses: &[&'static Hypothesis]) -> Result<Vec<Lead>, FitError> {
        let Some(sensitivity) = Sensitivity::at(&self.fit, question.training)? else { return Ok(Vec::new()) };
        Ok(screen(question.scene, &self.fit, &sensitivity, hypotheses)?)
    }

    /// Where extensions of its newest effect could start: of friction on bristles those on bristles, of rigid friction the others.
    pub fn extensions(&self, question: &Question<'_>, of: &[&'static Hypothesis]) -> Result<Vec<Lead>, FitError> {
        let Some(sensitivity) = Sensitivity::at(&self.fit, question.training)? else { return Ok(Vec::new()) };
        let mut found = Vec::new();
        for effect in of {
            found.extend(extended(question.scene, &self.fit, &sensitivity, effect)?);
        }
        let elastic = self.effects.last().is_some_and(|newest| is_elastic(newest.form));
        found.retain(|lead| is_elastic(lead.form) == elastic);
        Ok(found)
    }

    /// With an extension in the place of the effect that it extends.
    pub fn with_extension(&self, question: &Question<'_>, lead: &Lead) -> Result<Self, FitError> {
        let plain = lead.effect.extends.map_or("", |extension| extension.plain);
        let mut effects = self.effects.clone();
        effects.retain(|chosen| chosen.effect.name != plain);
        effects.push(Chosen { effect: lead.effect, form: lead.form });
        let from = Beginning { fit: &self.fit, values: &lead.values, settled: &lead.settled, precision: ROUGHLY };
        Self::refitted(question, effects, self.jumps.clone(), &from)
    }

    /// With the effect that its newest one extends in the place of that, refitted to the end from where that has ended: there the search
    /// with the plainer one may never have come. `None` where the newest extends none that these recordings can show.
    pub fn with_plain(&self, question: &Question<'_>) -> Result<Option<Self>, FitError> {
        let Some((newest, others)) = self.effects.split_last() else { return Ok(None) };
        let Some(extension) = newest.effect.extends else { return Ok(None) };
        let plain = question.hypotheses.iter().find(|effect| effect.name == extension.plain);
        let alike = |form: &Form| is_elastic(form) == is_elastic(newest.form);
        let form = plain.and_then(|effect| Some((*effect, effect.forms_in(question.scene).find(alike)?)));
        let Some((effect, form)) = form else { return Ok(None) };
        let taken = newest.form.iter().filter(|strength| extension.taken.contains(&strength.parameter));
        let taken: Vec<f64> = taken.map(|strength| self.fit.machine.get(strength.parameter)).collect();
        if taken.is_empty() {
            return Ok(None);
        }
        let values = [(extension.given, taken.iter().sum::<f64>() / taken.len() as f64)];
        let effects = others.iter().copied().chain([Chosen { effect, form }]).collect();
        let from = Beginning { fit: &self.fit, values: &values, settled: &[], precision: PRECISION };
        Self::refitted(question, effects, self.jumps.clone(), &from).map(Some)
    }

    /// With one more effect, roughly refitted from where the lead points; [`Candidate::finished`] does the rest.
    pub fn with(&self, question: &Question<'_>, lead: &Lead) -> Result<Self, FitError> {
        let mut effects = self.effects.clone();
        effects.push(Chosen { effect: lead.effect, form: lead.form });
        let mut jumps = self.jumps.clone();
        jumps.extend(lead.values.iter().filter(|(parameter, _)| is_jump(lead.form, *parameter)));
        let from = Beginning { fit: &self.fit, values: &lead.values, settled: &lead.settled, precision: ROUGHLY };
        Self::refitted(question, effects, jumps, &from)
    }

    /// Refitted to the end. An amount that vanished beside others has left no slope that leads back, nor has a strength at the end of
    /// what is admissible: the middle of its range is tried as well.
    pub fn finished(&self, question: &Question<'_>) -> Result<Self, FitError> {
        let to_the_end = |fit: &Fit, values: &[(Parameter, f64)]| {
            let from = Beginning { fit, values, settled: &[], precision: PRECISION };
            Self::refitted(question, self.effects.clone(), self.jumps.clone(), &from)
        };
        let found = to_the_end(&self.fit, &[])?;
        let lost: Vec<(Parameter, f64)> =
            found.vanished(question.scene).into_iter().chain(found.stranded(question.scene)).collect();
        if lost.is_empty() {
            return Ok(found);
        }
        let again = to_the_end(&found.fit, &lost)?;
        Ok(if again.fit.loss < found.fit.loss { again } else { found })
    }

    /// Without one of its effects.
    pub fn without(&self, question: &Question<'_>, index: usize) -> Result<Self, FitError> {
        let mut effects = self.effects.clone();
        let gone = effects.remove(index);
        let mut jumps = self.jumps.clone();
        jumps.retain(|(parameter, _)| !is_jump(gone.form, *parameter));
        let from = Beginning { fit: &self.fit, values: &[], settled: &[], precision: PRECISION };
        Self::refitted(question, effects, jumps, &from)
    }

    fn refitted(
        question: &Question<'_>,
        effects: Vec<Chosen>,
        mut jumps: Vec<(Parameter, f64)>,
        from: &Beginning<'_>,
    ) -> Result<Self, FitError> {
        let smooth = strengths(&effects).into_iter().filter(|strength| !matches!(strength.kind, Kind::Jump(_)));
        let free: Vec<Free> =
            question.ordinary.iter().copied().chain(smooth.map(|strength| strength.free(question.scene))).collect();
        let coordinates: Vec<(Parameter, f64)> = from
            .values
            .iter()
            .filter_map(|(parameter, value)| {
                let free = free.iter().find(|free| free.parameter == *parameter)?;
                Some((*parameter, free.coordinate(*value)))
            })
            .collect();
        let start = From { solution: Some(from.fit), coordinates: &coordinates, moved: from.settled };
        let mut found = fit(&with(question.scene.machine, &jumps), &free, question.training, &start, from.precision)?;
        for _ in 0..if jumps.is_empty() { 0 } else { 2 } {
            let Some(sensitivity) = Sensitivity::at(&found, question.training)? else { break };
            for (parameter, value) in &mut jumps {
                *value = nearby(&found.machine, &sensitivity, *parameter, *value)?;
            }
            drop(sensitivity);
            let again = From { solution: Some(&found), ..From::default() };
            found = fit(&with(question.scene.machine, &jumps), &free, question.training, &again, from.precision)?;
        }
        Self::of(question, effects, found, jumps, from.precision <= PRECISION)
    }

    /// Residuals on each training recording by a model that never saw it, from the start that suits that model.
    pub fn left_out(&self, question: &Question<'_>) -> Result<Residuals, FitError> {
        let training = question.training;
        training
            .par_iter()
            .enumerate()
            .map(|(index, case)| {
                let machine = if training.len() > 1 { self.fit.without(index) } else { self.fit.machine };
                Ok(softened(&machine, case, settle(&machine, case)?)?)
            })
            .collect()
    }

    /// Names of its effects, sorted.
    #[must_use]
    pub fn names(&self) -> Vec<&'static str> {
        let mut names: Vec<&str> = self.effects.iter().map(|chosen| chosen.effect.name).collect();
        names.sort_unstable();
        names
    }

    /// The effect that was added last and its form.
    pub(crate) fn newest(&self) -> Option<(&'static str, *const Strength)> {
        self.effects.last().map(|newest| (newest.effect.name, newest.form.as_ptr()))
    }

    /// Whether what was added last is what a lead points to.
    pub(crate) fn newest_is_like(&self, lead: &Lead) -> bool {
        self.newest() == Some((lead.effect.name, lead.form.as_ptr()))
    }

    /// How many strengths it has.
    #[must_use]
    pub fn strengths(&self) -> usize {
        strengths(&self.effects).len()
    }

    /// Fitted values of what was free, with the strengths that were found without a slope.
    #[must_use]
    pub fn estimates(&self) -> Vec<Estimate> {
        let mut estimates = self.fit.estimates(inflation(&self.residuals));
        estimates.extend(self.jumps.iter().map(|&(parameter, value)| Estimate {
            parameter,
            before: 0.0,
            value,
            std: value * NARROWEST,
            at_bound: false,
        }));
        estimates
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

/// Residuals of a fit on the training recordings.
fn residuals(question: &Question<'_>, fit: &Fit) -> Result<Residuals, FitError> {
    let training = question.training.par_iter().zip(&fit.starts);
    Ok(training.map(|(case, start)| softened(&fit.machine, case, *start)).collect::<Result<_, _>>()?)
}

/// How many times more rows there are than independent samples.
fn inflation(residuals: &Residuals) -> f64 {
    let (mut rows, mut independent) = (0.0, 0.0);
    for series in residuals.iter().flatten() {
        rows += series.len() as f64;
        independent += effective_samples(series);
    }
    rows / independent
}

/// The strengths of a set, one that effects share once.
fn strengths(effects: &[Chosen]) -> Vec<Strength> {
    let mut found: Vec<Strength> = Vec::new();
    for strength in effects.iter().flat_map(|chosen| chosen.form.iter()) {
        if found.iter().all(|known| known.parameter != strength.parameter) {
            found.push(*strength);
        }
    }
    found
}

fn is_jump(form: Form, parameter: Parameter) -> bool {
    form.iter().any(|strength| strength.parameter == parameter && matches!(strength.kind, Kind::Jump(_)))
}

/// A strength that no slope leads to is known to this share of itself.
const NARROWEST: f64 = 0.01;

/// A better value of such a strength near where it is.
fn nearby(
    machine: &Machine<f64>,
    sensitivity: &Sensitivity<'_>,
    parameter: Parameter,
    value: f64,
) -> Result<f64, FitError> {
    let gain = |value: f64| -> Result<f64, FitError> {
        Ok(sensitivity.settle(&sensitivity.change(&with(machine, &[(parameter, value)]))?).gain)
    };
    let (mut best, mut width) = ((value, gain(value)?), 0.16);
    while width > NARROWEST {
        let (mut moved, around) = (false, best.0);
        for there in [around * (1.0 - width), (around * (1.0 + width)).min(parameter.description().max)] {
            let found = gain(there)?;
            if found > best.1 {
                best = (there, found);
                moved = true;
            }
        }
        if !moved {
            width *= 0.5;
        }
    }
    Ok(best.0)
}
