//! Refits of a candidate model: to the end at the recordings' own tick, rougher ones at twice the tick.

use identification::experiment::Prepared;
use identification::fit::{
    Fit, FitError, Free, From, Sensitivity, StartState, coarse, first_search, fit, loss, softened_all,
};
use model_core::machine::{Machine, Parameter};

use super::{Candidate, Chosen, Question, effect_parameters};
use crate::catalogue::{EffectParameter, covered_by};
use crate::selection::screen::with;

/// The search ends when the loss falls by less than this share in a step.
pub(crate) const PRECISION: f64 = 1e-5;
/// The same for the base, against which all candidate models are measured: with [so many](FINELY_OF) samples a hundredth of a unit of log-likelihood.
pub(crate) const FINELY: f64 = 1e-6;
/// Samples of some recordings of seconds at a high rate.
pub(crate) const FINELY_OF: f64 = 20_000.0;
/// The same for one of several starts; the search goes on from the best.
pub(crate) const NEARLY: f64 = 1e-4;
/// The same for a model from which another search begins.
pub(crate) const SETTLED: f64 = 1e-3;
/// The same for a first look.
const ROUGHLY: f64 = 0.03;
/// An effect parameter without a usable derivative is searched down to steps of this share of itself.
pub(crate) const NARROWEST: f64 = 0.01;

/// How far a refit goes.
#[derive(Clone, Copy)]
pub(crate) enum Goes<'a> {
    /// To the end: until the loss falls by less than this share in a step.
    ToTheEnd(f64),
    /// Only for a first look, on the training recordings at twice the tick around where it begins.
    Roughly(&'a [Prepared]),
    /// The same for one of several starts.
    Nearly(&'a [Prepared]),
}

/// Where a refit begins.
pub(crate) struct Beginning<'a> {
    pub(crate) fit: &'a Fit,
    /// Starting values of new effect parameters.
    pub(crate) values: &'a [(Parameter, f64)],
    /// Predicted coordinates of the former fit's values with them.
    pub(crate) settled: &'a [f64],
    pub(crate) goes: Goes<'a>,
}

impl Candidate {
    /// A fit with its residuals. A fit that was not searched to the end used twice the tick or more noise: its loss is computed again from the
    /// recordings as they are.
    pub(crate) fn of(
        question: &Question<'_>,
        effects: Vec<Chosen>,
        mut fit: Fit,
        jumps: Vec<(Parameter, f64)>,
        is_finished: bool,
    ) -> Result<Self, FitError> {
        let training = question.training.iter().copied().zip(fit.starts.iter().copied());
        let residuals = softened_all(&fit.machine, training)?;
        if !is_finished {
            let missed: f64 = residuals.iter().flatten().map(|series| loss(series)).sum();
            let missed_there: f64 = fit.normal_equations.iter().map(|one| one.square).sum();
            fit.loss += 0.5 * (missed - missed_there);
        }
        Ok(Self { effects, fit, jumps, residuals, is_finished, is_inflated: false, counts: question.counts() })
    }

    /// A refit of the base parameters alone.
    pub(crate) fn base_parameters(
        question: &Question<'_>,
        solution: Option<&Fit>,
        precision: f64,
    ) -> Result<Self, FitError> {
        let searched = |training: &[&Prepared]| {
            let (machine, free) = (question.scene.machine, question.base_parameters);
            let found = match solution {
                Some(_) => fit(machine, free, training, &From { solution, ..From::default() }, precision)?,
                None => first_search(machine, free, training, precision)?,
            };
            Self::of(question, Vec::new(), found, Vec::new(), precision <= PRECISION)
        };
        if precision <= PRECISION {
            return searched(question.training);
        }
        let nominal = vec![StartState::default(); question.training.len()];
        let (machine, starts) =
            solution.map_or((question.scene.machine, nominal.as_slice()), |known| (&known.machine, &known.starts));
        let coarser = coarse(question.training, machine, starts)?;
        searched(&coarser.iter().collect::<Vec<_>>())
    }

    /// A refit of a candidate model to the end, from given values of the parameters that no former solution has; effect parameters without a usable
    /// derivative keep the given values.
    pub(crate) fn given(
        question: &Question<'_>,
        effects: Vec<Chosen>,
        jumps: Vec<(Parameter, f64)>,
        solution: Option<&Fit>,
        values: &[(Parameter, f64)],
    ) -> Result<Self, FitError> {
        let free = free(question, &effects);
        let from = From { solution, coordinates: &coordinates(&free, values), moved: &[] };
        let found = fit(&with(question.scene.machine, &jumps), &free, question.training, &from, PRECISION)?;
        Self::of(question, effects, found, jumps, true)
    }

    /// A refit of a candidate model with all its free values.
    pub(crate) fn refitted(
        question: &Question<'_>,
        effects: Vec<Chosen>,
        mut jumps: Vec<(Parameter, f64)>,
        from: &Beginning<'_>,
    ) -> Result<Self, FitError> {
        let free = free(question, &effects);
        let coordinates = coordinates(&free, from.values);
        let (training, precision) = match from.goes {
            Goes::ToTheEnd(precision) => (question.training.to_vec(), precision),
            Goes::Roughly(coarser) => (coarser.iter().collect(), ROUGHLY),
            Goes::Nearly(coarser) => (coarser.iter().collect(), NEARLY),
        };
        let refit = |jumps: &[(Parameter, f64)], start: &From<'_>| {
            fit(&with(question.scene.machine, jumps), &free, &training, start, precision)
        };
        let mut found =
            refit(&jumps, &From { solution: Some(from.fit), coordinates: &coordinates, moved: from.settled })?;
        for _ in 0..if jumps.is_empty() { 0 } else { 2 } {
            let Some(sensitivity) = Sensitivity::at(&found, &training)? else { break };
            for (parameter, value) in &mut jumps {
                *value = better(&found.machine, &sensitivity, *parameter, *value)?;
            }
            drop(sensitivity);
            found = refit(&jumps, &From { solution: Some(&found), ..From::default() })?;
        }
        Self::of(question, effects, found, jumps, matches!(from.goes, Goes::ToTheEnd(_)))
    }

    /// Refitted to the end, from its own solution, to `others`, the same recordings with more noise; its residuals and loss are those on the
    /// recordings as they are.
    pub(crate) fn refitted_to(&self, question: &Question<'_>, others: &Question<'_>) -> Result<Self, FitError> {
        let found = self.finished(others)?;
        let told = Self::of(question, found.effects, found.fit, found.jumps, false)?;
        Ok(Self { is_finished: true, is_inflated: true, ..told })
    }

    /// The machine refitted without one of the recordings, which are at twice the tick.
    pub(crate) fn refitted_without(
        &self,
        question: &Question<'_>,
        coarser: &[Prepared],
        index: usize,
    ) -> Result<Machine<f64>, FitError> {
        let mut solution = self.fit.clone();
        solution.starts.remove(index);
        let others: Vec<&Prepared> =
            coarser.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, case)| case).collect();
        let machine = with(question.scene.machine, &self.jumps);
        let from = From { solution: Some(&solution), ..From::default() };
        Ok(fit(&machine, &self.fit.free, &others, &from, SETTLED)?.machine)
    }
}

/// What a fit moves: the base parameters, and every effect parameter with a usable derivative. An effect takes over what covers its own amounts
/// within a tolerance.
fn free(question: &Question<'_>, effects: &[Chosen]) -> Vec<Free> {
    let of_effects = effect_parameters(effects);
    let is_taken = |free: &&Free| {
        let covers = |own: &EffectParameter| [own.parameter, covered_by(own.parameter)].contains(&free.parameter);
        of_effects.iter().any(covers)
    };
    let smooth = of_effects.iter().filter(|effect_parameter| !effect_parameter.is_jump());
    question
        .base_parameters
        .iter()
        .filter(|free| !is_taken(free))
        .copied()
        .chain(smooth.map(|effect_parameter| effect_parameter.free(question.scene)))
        .collect()
}

/// Coordinates of the values that are free.
fn coordinates(free: &[Free], values: &[(Parameter, f64)]) -> Vec<(Parameter, f64)> {
    let of = |(parameter, value): &(Parameter, f64)| {
        let free = free.iter().find(|free| free.parameter == *parameter)?;
        Some((*parameter, free.coordinate(*value)))
    };
    values.iter().filter_map(of).collect()
}

/// A better value of an effect parameter without a usable derivative, near its present one.
fn better(
    machine: &Machine<f64>,
    sensitivity: &Sensitivity<'_>,
    parameter: Parameter,
    value: f64,
) -> Result<f64, FitError> {
    let gain = |value: f64| -> Result<f64, FitError> {
        let there = sensitivity.simulated(&with(machine, &[(parameter, value)]))?;
        Ok(sensitivity.settle(&sensitivity.change(&there)).gain)
    };
    let (mut best, mut width) = ((value, gain(value)?), 0.16);
    while width > NARROWEST {
        let (mut moved, around) = (false, best.0);
        for there in [around * (1.0 - width), (around * (1.0 + width)).min(parameter.description().max)] {
            // A value that gives no valid drive, such as a floor below vacuum, is not better.
            let found = gain(there).unwrap_or(f64::NEG_INFINITY);
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
