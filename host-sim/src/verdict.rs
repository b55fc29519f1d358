//! Which effects are claimed, decided on the training recordings alone, then confirmed or vetoed on the held-out ones.
//!
//! Every training recording is left out in turn; a candidate is refitted in the chain on the others and judged on the one it
//! never saw. The gain is a log-likelihood: ½·n·ln(loss before/loss after) per signal, with n the number of *independent*
//! samples in the residual (neighbouring samples of a mismatch tell the same). A candidate must gain more than a Bayesian
//! information penalty for its parameters, and in all left-out recordings but one: what happens once is a disturbance.
//! Forward selection, one effect at a time; then backward: an effect that the others make superfluous goes again.

use model_core::machine::MachineError;
use rayon::prelude::*;

use crate::fit::{Fit, FitError, Free, effective_samples, fit, fitted, loss, standardised};
use crate::hypothesis::Hypothesis;
use crate::prepare::Prepared;
use crate::recording::Signal;
use model_core::machine::Machine;

/// Most effects claimed at once.
const MOST_EFFECTS: usize = 3;
/// A claim must lower the left-out loss of some signal at least by this share: less is not worth a parameter in a controller.
const LEAST_SHARE: f64 = 0.02;

/// A set of effects with its fit.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The effects beyond the machine file's own.
    pub effects: Vec<&'static Hypothesis>,
    /// Fitted on all training recordings.
    pub fit: Fit,
    /// Standardised residuals on each training recording while it was left out, one series a channel.
    left_out: Vec<Vec<Vec<f64>>>,
}

/// What one more effect gained over a set without it, on recordings left out.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The effect tried.
    pub effect: &'static Hypothesis,
    /// Log-likelihood gained per left-out recording.
    pub gains: Vec<f64>,
    /// What it had to gain in all.
    pub penalty: f64,
    /// Whether it passed.
    pub accepted: bool,
}

impl Trial {
    /// Total gain less the penalty.
    #[must_use]
    pub fn net(&self) -> f64 {
        self.gains.iter().sum::<f64>() - self.penalty
    }
}

/// The outcome of the selection on training recordings.
#[derive(Clone, Debug)]
pub struct Selection {
    /// The machine file's model, refitted.
    pub base: Candidate,
    /// The chosen set; the base again if nothing is claimed.
    pub chosen: Candidate,
    /// Every trial, round by round.
    pub rounds: Vec<Vec<Trial>>,
}

/// The question put to the training recordings.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// The nominal machine.
    pub machine: &'a Machine<f64>,
    /// Ordinary parameters that may move.
    pub ordinary: &'a [Free],
    /// Effects that these recordings can show.
    pub hypotheses: &'a [&'static Hypothesis],
    /// Training recordings.
    pub training: &'a [&'a Prepared],
}

/// Chooses the effects. `done` is told after each candidate.
pub fn select(question: &Question<'_>, done: &(impl Fn(&str) + Sync)) -> Result<Selection, FitError> {
    let base = candidate(question, &[], None)?;
    done("refit");
    let mut chosen = base.clone();
    let mut rounds = Vec::new();
    while chosen.effects.len() < MOST_EFFECTS {
        let open: Vec<&'static Hypothesis> = question
            .hypotheses
            .iter()
            .copied()
            .filter(|hypothesis| chosen.effects.iter().all(|effect| effect.name != hypothesis.name))
            .collect();
        let tried: Vec<(Candidate, Trial)> = open
            .par_iter()
            .map(|&effect| {
                let effects: Vec<_> = chosen.effects.iter().copied().chain([effect]).collect();
                let candidate = candidate(question, &effects, Some(&chosen.fit))?;
                let trial = judge(question, effect, &chosen, &candidate);
                done(effect.name);
                Ok((candidate, trial))
            })
            .collect::<Result<_, FitError>>()?;
        rounds.push(tried.iter().map(|(_, trial)| trial.clone()).collect());
        let best =
            tried.into_iter().filter(|(_, trial)| trial.accepted).max_by(|(_, a), (_, b)| a.net().total_cmp(&b.net()));
        let Some((candidate, _)) = best else { break };
        chosen = backward(question, candidate)?;
    }
    Ok(Selection { base, chosen, rounds })
}

/// Drops every effect that the others make superfluous.
fn backward(question: &Question<'_>, mut full: Candidate) -> Result<Candidate, FitError> {
    while full.effects.len() > 1 {
        let mut dropped = None;
        for index in 0..full.effects.len() {
            let mut effects = full.effects.clone();
            let effect = effects.remove(index);
            let without = candidate(question, &effects, Some(&full.fit))?;
            if !judge(question, effect, &without, &full).accepted {
                dropped = Some(without);
                break;
            }
        }
        match dropped {
            Some(without) => full = without,
            None => break,
        }
    }
    Ok(full)
}

/// Fits a set of effects on all training recordings, and on all but each.
fn candidate(
    question: &Question<'_>,
    effects: &[&'static Hypothesis],
    from: Option<&Fit>,
) -> Result<Candidate, FitError> {
    let free: Vec<Free> = question
        .ordinary
        .iter()
        .copied()
        .chain(effects.iter().flat_map(|effect| effect.free(question.machine)))
        .collect();
    let mut all = fit(question.machine, &free, question.training, from, 1e-6)?;
    if from.is_some() {
        // The solution without the effect may have bent the ordinary parameters into another valley: the nominal ones start too.
        let nominal = fit(question.machine, &free, question.training, None, 1e-6)?;
        if nominal.loss < all.loss {
            all = nominal;
        }
    }
    let count = question.training.len();
    let left_out = (0..count)
        .into_par_iter()
        .map(|index| {
            let case = question.training[index];
            let level = all.levels[index];
            if count == 1 {
                return Ok(standardised(&all.machine, case, level)?);
            }
            let others: Vec<&Prepared> = question
                .training
                .iter()
                .enumerate()
                .filter(|(other, _)| *other != index)
                .map(|(_, case)| *case)
                .collect();
            // Close to the solution already: it moves by what one recording weighs.
            let fold = fitted(question.machine, &free, &others, Some(&all), 1e-4)?;
            Ok(standardised(&fold, case, level)?)
        })
        .collect::<Result<_, FitError>>()?;
    Ok(Candidate { effects: effects.to_vec(), fit: all, left_out })
}

/// Log-likelihood gained on one signal: ½·n·ln(loss before/loss after). A mean square of 1 is the noise itself: nothing below it
/// can be gained. n are the independent samples of the residual that has fewer, so that a gain one way is a loss the other.
fn gained(before: &[f64], after: &[f64]) -> f64 {
    let floor = before.len() as f64;
    0.5 * independent(before, after) * (loss(before).max(floor) / loss(after).max(floor)).ln()
}

fn independent(before: &[f64], after: &[f64]) -> f64 {
    effective_samples(before).min(effective_samples(after))
}

/// Whether `with` is worth its parameters over `without`, on recordings that were left out.
fn judge(question: &Question<'_>, effect: &'static Hypothesis, without: &Candidate, with: &Candidate) -> Trial {
    let (mut samples, mut reached, mut best_share) = (0.0, 0.0, 0.0_f64);
    let gains: Vec<f64> = question
        .training
        .iter()
        .zip(without.left_out.iter().zip(&with.left_out))
        .map(|(case, (before, after))| {
            let mut total = 0.0;
            for (channel, (before, after)) in case.channels.iter().zip(before.iter().zip(after)) {
                let gain = gained(before, after);
                samples += independent(before, after);
                total += gain;
                if effect.subsystem.reaches(channel.signal) {
                    let floor = before.len() as f64;
                    reached += gain;
                    best_share = best_share.max(1.0 - loss(after).max(floor) / loss(before).max(floor));
                }
            }
            total
        })
        .collect();
    let parameters = effect.strengths.len() as f64;
    let penalty = 0.5 * parameters * f64::max(samples, 2.0).ln() + 3.0;
    let improved = gains.iter().filter(|gain| **gain > 0.0).count();
    let needed = if gains.len() > 2 { gains.len() - 1 } else { gains.len() };
    // A strength at an end of its range, or one that the recordings do not determine, is no finding.
    let significant = effect.strengths.iter().all(|strength| {
        let estimate = with.fit.estimates.iter().find(|estimate| estimate.parameter == strength.parameter);
        estimate.is_some_and(|estimate| {
            !estimate.at_bound && estimate.std.is_finite() && estimate.value > 3.0 * estimate.std
        })
    });
    let accepted = gains.iter().sum::<f64>() > penalty
        && reached > 0.0
        && improved >= needed
        && significant
        && best_share > LEAST_SHARE;
    Trial { effect, gains, penalty, accepted }
}

/// What the held-out recordings say of a choice that they did not take part in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Confirmation {
    /// Log-likelihood gained over the base on all held-out recordings, on signals that the effects reach.
    pub gain: f64,
    /// The signal that gained least, over all held-out recordings.
    pub least_gain: f64,
    /// Lowest NRMSE fit of a signal with the effects, %.
    pub least_fit_percent: f64,
    /// Held-out recordings on which it gained.
    pub improved: usize,
    /// Held-out recordings.
    pub recordings: usize,
}

/// A loss of log-likelihood that chance makes rarely (one in twenty).
const CHANCE: f64 = 3.0;

impl Confirmation {
    /// Whether they confirm it: a gain in all and on at least half of the recordings, no signal clearly worse, and none
    /// that the model follows worse than its mean would.
    #[must_use]
    pub fn confirms(&self) -> bool {
        self.recordings > 0
            && self.gain > 0.0
            && self.least_gain > -CHANCE
            && self.least_fit_percent > 0.0
            && 2 * self.improved >= self.recordings
    }
}

/// Opens the held-out recordings, once.
pub fn confirm(
    base: &Machine<f64>,
    chosen: &Machine<f64>,
    effects: &[&Hypothesis],
    held_out: &[&Prepared],
) -> Result<Confirmation, MachineError> {
    let mut improved = 0;
    let mut signals: Vec<(Signal, f64)> = Vec::new();
    let mut least_fit_percent = 100.0_f64;
    for case in held_out {
        let (before, after) = (standardised(base, case, 0.5)?, standardised(chosen, case, 0.5)?);
        let mut total = 0.0;
        for (channel, (before, after)) in case.channels.iter().zip(before.iter().zip(&after)) {
            if !effects.iter().any(|effect| effect.subsystem.reaches(channel.signal)) {
                continue;
            }
            let gain = gained(before, after);
            total += gain;
            match signals.iter_mut().find(|(signal, _)| *signal == channel.signal) {
                Some((_, sum)) => *sum += gain,
                None => signals.push((channel.signal, gain)),
            }
            least_fit_percent = least_fit_percent.min(channel.fit_percent(after));
        }
        improved += usize::from(total > 0.0);
    }
    Ok(Confirmation {
        gain: signals.iter().map(|(_, gain)| gain).sum(),
        least_gain: signals.iter().map(|(_, gain)| *gain).fold(f64::INFINITY, f64::min),
        least_fit_percent,
        improved,
        recordings: held_out.len(),
    })
}
