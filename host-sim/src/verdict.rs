//! Which effects are claimed, decided on the training recordings alone, then confirmed or vetoed on the held-out ones.
//!
//! Every effect is screened; the most promising are refitted in the chain; the best few are each tried with a second one, and so
//! on, so that a pair is found even where neither of it is best alone. Sets are compared by a log-likelihood in which each
//! signal's noise level is unknown: ½·n·ln(loss), with n the number of *independent* samples in the residual (neighbouring samples
//! of a mismatch tell the same), less a Bayesian information penalty for the strengths, plus what the ordinary parameters gain by coming
//! back to their nominal values. A claim must also gain on recordings that
//! were left out, on all but one of them (what happens once is a disturbance), and take away at least half of what is above the
//! noise: an effect that does less is a stand-in for something else.

mod whole;

use model_core::machine::{Machine, MachineError};
use rayon::prelude::*;

pub use crate::candidate::{Candidate, Chosen, Question, Residuals};
use crate::fit::{FitError, effective_samples, loss, settle, softened};
use crate::hypothesis::{CATALOGUE, Hypothesis};
use crate::prepare::Prepared;
use crate::recording::Signal;
use crate::search::widened;
use crate::tempered::Tempered;
pub use whole::lengthened;

/// Most effects claimed at once.
const MOST_EFFECTS: usize = 3;
/// Effects that are refitted in a round, the most promising by the screening.
const REFITTED: usize = 7;
/// Sets of a round that are refitted to the end.
const FINISHED: usize = 4;
/// One that leaves so many times what the best does is not.
const HOPELESS: f64 = 10.0;
/// Sets that the next round starts from.
const BEAM: usize = 2;
/// Effects that are refitted beside each of those.
const BESIDE: usize = 4;
/// What an effect must take away of what is above the noise.
const LEAST_SHARE: f64 = 0.5;
/// How closely a real effect follows its textbook form, as a share of the error that it explains (RMS): a further effect that
/// explains less than this of what the first ones did cannot be told from their own form's error.
const FORM: f64 = 0.1;
/// An extension that explains less than that still earns its place by this share of what the plainer effect leaves.
const EARNED: f64 = 0.75;
/// What a gain must be beyond the information penalty: one in twenty by chance.
const CHANCE: f64 = 3.0;
/// A set whose worst signal is this close to its noise is not searched further.
const AT_NOISE: f64 = 1.03;
/// With the links apart the noise of the recorded slider adds to what is below it: effects are only looked for so while the
/// worst signal is this many times its noise.
const FAR: f64 = 2.0;

/// What one set gained over the one before it.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The effect that is new in it.
    pub effect: &'static Hypothesis,
    /// All its effects.
    pub effects: Vec<&'static Hypothesis>,
    /// Log-likelihood gained over the base, less the penalty.
    pub net: f64,
    /// The machine as refitted with them.
    pub machine: Machine<f64>,
}

/// The outcome of the selection on training recordings.
#[derive(Clone, Debug)]
pub struct Selection {
    /// The machine file's model, refitted.
    pub base: Candidate,
    /// The chosen set; the base again if nothing is claimed.
    pub chosen: Candidate,
    /// Every set that was refitted, round by round, the best first.
    pub rounds: Vec<Vec<Trial>>,
}

/// How far a selection has come.
struct Course {
    /// The machine file's model, refitted to recordings that are believed only as far as it follows them.
    tempered: Tempered,
    /// The machine file's model, refitted.
    base: Candidate,
    /// The chosen set; the base while nothing is claimed.
    chosen: Candidate,
    /// Sets that the next round starts from.
    beam: Vec<Candidate>,
    /// Every set that was refitted, round by round, the best first.
    rounds: Vec<Vec<Trial>>,
}

impl Course {
    /// Nothing chosen yet.
    fn of(question: &Question<'_>) -> Result<Self, FitError> {
        let tempered = Tempered::of(question)?;
        let base = Candidate::base(question, &tempered.base.fit)?;
        Ok(Self { tempered, chosen: base.clone(), beam: vec![base.clone()], rounds: Vec::new(), base })
    }

    /// Nothing chosen yet, with the better of two bases.
    fn with_base(self, other: Candidate) -> Self {
        if other.fit.loss < self.base.fit.loss {
            return Self { chosen: other.clone(), beam: vec![other.clone()], base: other, ..self };
        }
        self
    }
}

/// Chooses the effects. `done` is told after each refit.
///
/// Where the slider is recorded and the model is far off, large effects are looked for with the links apart first: the recorded
/// slider meters the oil beside the valve, so that what one link misses bends no other's parameters. The chain as a whole then
/// has to accept what was found, and is searched on.
pub fn select(question: &Question<'_>, done: &(impl Fn(&str) + Sync)) -> Result<Selection, FitError> {
    let mut start = Course::of(question)?;
    if start.base.worst_over_noise(question) > FAR
        && let Some(mut followed) = followed(question.training)
    {
        Candidate::tolerated(question.scene, question.ordinary, &mut followed)?;
        let references: Vec<&Prepared> = followed.iter().collect();
        start = joined(question, start, &Question { training: &references, ..*question }, done)?;
    }
    done("refit");
    let Course { base, chosen, rounds, .. } = forward(question, start, AT_NOISE, done)?;
    Ok(Selection { base, chosen, rounds })
}

/// The same recordings with the recorded slider metering the oil; `None` unless every one allows it.
fn followed(training: &[&Prepared]) -> Option<Vec<Prepared>> {
    training.iter().map(|case| case.following()).collect()
}

/// What the chain accepts of what was found with its links `apart`.
fn joined(
    question: &Question<'_>,
    start: Course,
    apart: &Question<'_>,
    done: &(impl Fn(&str) + Sync),
) -> Result<Course, FitError> {
    let parted = Course::of(apart)?;
    let mut course = start.with_base(Candidate::near(question, &parted.base.fit)?);
    let found = forward(apart, parted, FAR, done)?;
    if !found.chosen.effects.is_empty() {
        let joined = found.chosen.finished(question)?;
        if accepts(question, &course.base, &course.base, &joined)? {
            course.chosen = backward(question, &course.base, joined)?;
            course.beam = vec![course.chosen.clone()];
            course.rounds = found.rounds;
            course.rounds.truncate(course.chosen.effects.len());
        }
    }
    Ok(course)
}

/// Adds effects round by round, until the best set is within `near` times the noise or nothing more is worth it.
fn forward(
    question: &Question<'_>,
    from: Course,
    near: f64,
    done: &(impl Fn(&str) + Sync),
) -> Result<Course, FitError> {
    let Course { tempered, mut base, mut chosen, mut beam, mut rounds } = from;
    for round in chosen.effects.len()..MOST_EFFECTS {
        if !chosen.effects.is_empty() && beam.first().is_none_or(|best| is_enough(question, &base, best, near)) {
            break;
        }
        let found = widened(question, &tempered, &beam, if round == 0 { REFITTED } else { BESIDE }, done)?;
        // Only the best are worth an exact refit.
        let possible = found.into_iter().filter(|candidate| candidate.is_plausible(question.scene)).collect();
        let mut first = ranked(question, &base, possible);
        let least = first.iter().map(|(candidate, _)| excess(&candidate.residuals)).fold(f64::INFINITY, f64::min);
        let hopeful = |(candidate, _): &(Candidate, f64)| {
            0.5 * excess(&candidate.residuals) < HOPELESS * (0.5 * least).max(candidate.strengths() as f64)
        };
        let rest = first
            .split_off(first.iter().take_while(|one| hopeful(one)).count().min(FINISHED).max(BEAM.min(first.len())));
        let finished = first
            .par_iter()
            .map(|(candidate, _)| candidate.finished(question))
            .collect::<Result<Vec<_>, FitError>>()?;
        let finished = finished.into_iter().filter(|candidate| candidate.is_plausible(question.scene));
        let mut ranked =
            ranked(question, &base, finished.chain(rest.into_iter().map(|(candidate, _)| candidate)).collect());
        prefer_plain(&base, &mut ranked);
        rounds.push(ranked.iter().map(|(candidate, net)| trial(candidate, *net)).collect());
        let mut accepted = None;
        for (candidate, _) in ranked.iter().take(BEAM) {
            if accepts(question, &base, &chosen, candidate)? {
                accepted = Some(candidate.clone());
                break;
            }
        }
        beam = ranked.into_iter().take(BEAM).map(|(candidate, _)| candidate).collect();
        if let (None, Some(best)) = (&accepted, beam.first()) {
            accepted = one_alone(question, &base, &chosen, best)?;
            if let Some(alone) = &accepted {
                enter(question, &base, &mut rounds, alone);
            }
        }
        if let Some(better) = accepted {
            // An effect may only have led the ordinary parameters to where they do as well without it.
            if round == 0 {
                let plain = better.without(question, 0)?;
                if plain.fit.loss < base.fit.loss {
                    (base, chosen) = (plain.clone(), plain);
                }
            }
            if round > 0 || accepts(question, &base, &chosen, &better)? {
                chosen = backward(question, &base, better)?;
            }
        }
        // Two that go together may each be nothing alone, but a third is only looked for beside what was found.
        let enough = beam.first().is_none_or(|best| is_enough(question, &base, best, near));
        if enough || (round > 0 && chosen.effects.len() <= round) {
            break;
        }
    }
    Ok(Course { tempered, base, chosen, beam, rounds })
}

/// Enters a set into the round of its size, in the place of a worse fit of the same effects.
fn enter(question: &Question<'_>, base: &Candidate, rounds: &mut [Vec<Trial>], candidate: &Candidate) {
    let Some(round) = rounds.get_mut(candidate.effects.len() - 1) else { return };
    round.retain(|trial| {
        trial.effects.iter().any(|effect| candidate.effects.iter().all(|chosen| chosen.effect.name != effect.name))
    });
    let entered = ranked(question, base, vec![candidate.clone()]);
    round.extend(entered.iter().map(|(candidate, net)| trial(candidate, *net)));
    round.sort_by(|a, b| b.net.total_cmp(&a.net));
}

/// A set without one of its effects that is worth claiming where the set is not: the other may only have shown the way to it.
fn one_alone(
    question: &Question<'_>,
    base: &Candidate,
    chosen: &Candidate,
    set: &Candidate,
) -> Result<Option<Candidate>, FitError> {
    if set.effects.len() < 2 {
        return Ok(None);
    }
    for index in 0..set.effects.len() {
        let fewer = set.without(question, index)?;
        if fewer.is_plausible(question.scene) && accepts(question, base, chosen, &fewer)? {
            return Ok(Some(fewer));
        }
    }
    Ok(None)
}

/// Whether nothing is left that a further effect could explain: the ordinary parameters are where they were said to be, and the
/// set is `near` its noise, or what it leaves would not be told from its own form's error.
fn is_enough(question: &Question<'_>, base: &Candidate, best: &Candidate, near: f64) -> bool {
    let fits =
        || best.worst_over_noise(question) < near || excess(&best.residuals) < FORM * FORM * excess(&base.residuals);
    !is_bent(question, best) && fits()
}

/// Whether the ordinary parameters are further from their nominal values than their standard deviations allow in 999 of 1000
/// drives: by χ², its quantile after Wilson and Hilferty 1931.
fn is_bent(question: &Question<'_>, candidate: &Candidate) -> bool {
    const QUANTILE: f64 = 3.09;
    let count = question.ordinary.len() as f64;
    let share = 2.0 / (9.0 * count);
    count > 0.0 && 2.0 * candidate.bent(question) > count * (1.0 - share + QUANTILE * share.sqrt()).powi(3)
}

/// Best first by log-likelihood gained over the base less penalty; only the best form of the same effects stays.
fn ranked(question: &Question<'_>, base: &Candidate, found: Vec<Candidate>) -> Vec<(Candidate, f64)> {
    let Some(best) = found.iter().min_by(|a, b| a.fit.loss.total_cmp(&b.fit.loss)) else { return Vec::new() };
    // The independent samples of the best residuals, so that all are measured alike.
    let samples: Vec<f64> = best.residuals.iter().flatten().map(|series| effective_samples(series)).collect();
    let total: f64 = samples.iter().sum();
    let net = |candidate: &Candidate| {
        let series = base.residuals.iter().flatten().zip(candidate.residuals.iter().flatten());
        let gain: f64 = series
            .zip(&samples)
            .map(|((before, after), samples)| 0.5 * samples * (floored(before) / floored(after)).ln())
            .sum();
        gain + straightened(question, base, candidate) - 0.5 * candidate.strengths() as f64 * total.max(2.0).ln()
    };
    let mut ranked: Vec<(Candidate, f64)> = found
        .into_iter()
        .map(|candidate| (net(&candidate), candidate))
        .map(|(net, candidate)| (candidate, net))
        .collect();
    // Sets that are as likely as each other stay in the catalogue's order.
    ranked.sort_by(|a, b| b.1.round().total_cmp(&a.1.round()).then_with(|| order(&a.0).cmp(&order(&b.0))));
    let mut seen: Vec<Vec<&str>> = Vec::new();
    ranked.retain(|(candidate, _)| {
        let mut names: Vec<&str> = candidate.effects.iter().map(|chosen| chosen.effect.name).collect();
        names.sort_unstable();
        let new = !seen.contains(&names);
        seen.push(names);
        new
    });
    ranked
}

/// Places of a set's effects in the catalogue.
fn order(candidate: &Candidate) -> Vec<usize> {
    let place =
        |chosen: &Chosen| CATALOGUE.iter().position(|known| known.name == chosen.effect.name).unwrap_or(usize::MAX);
    candidate.effects.iter().map(place).collect()
}

/// Puts a set with the plainer effect before the one with its extension, where that does not earn what it has more.
fn prefer_plain(base: &Candidate, ranked: &mut Vec<(Candidate, f64)>) {
    let Some((best, best_net)) = ranked.first() else { return };
    let most = excess(&base.residuals);
    let plainer = ranked.iter().position(|(candidate, net)| {
        let extended = best.effects.iter().any(|chosen| {
            chosen.effect.extends.is_some_and(|extension| {
                let others = best.effects.iter().filter(|other| other.effect.name != chosen.effect.name);
                let mut wanted: Vec<&str> = others.map(|other| other.effect.name).chain([extension.plain]).collect();
                let mut names: Vec<&str> = candidate.effects.iter().map(|chosen| chosen.effect.name).collect();
                wanted.sort_unstable();
                names.sort_unstable();
                wanted == names
            })
        });
        let (left, leaves) = (excess(&candidate.residuals), excess(&best.residuals));
        let earned = best_net - net > CHANCE && (left - leaves > FORM * FORM * most || leaves < (1.0 - EARNED) * left);
        extended && !earned
    });
    if let Some(index) = plainer {
        let plain = ranked.remove(index);
        ranked.insert(0, plain);
    }
}

fn trial(candidate: &Candidate, net: f64) -> Trial {
    let effects: Vec<_> = candidate.effects.iter().map(|chosen| chosen.effect).collect();
    Trial { effect: effects[effects.len() - 1], effects, net, machine: candidate.fit.machine }
}

/// The loss of a series, or what pure noise would lose if that is more: nothing below it can be gained.
fn floored(series: &[f64]) -> f64 {
    let loss = loss(series);
    if loss.is_finite() { loss.max(series.len() as f64) } else { f64::INFINITY }
}

/// Log-likelihood gained on one signal. n are the independent samples of the residual that has fewer, so that a gain one way is
/// a loss the other.
fn gained(before: &[f64], after: &[f64]) -> f64 {
    0.5 * independent(before, after) * (floored(before) / floored(after)).ln()
}

fn independent(before: &[f64], after: &[f64]) -> f64 {
    effective_samples(before).min(effective_samples(after))
}

/// Log-likelihood gained as the ordinary parameters come back to where they were said to be: a model that lacks an effect bends
/// them.
fn straightened(question: &Question<'_>, without: &Candidate, with: &Candidate) -> f64 {
    without.bent(question) - with.bent(question)
}

/// What is above the noise.
fn excess(residuals: &Residuals) -> f64 {
    residuals.iter().flatten().map(|series| floored(series) - series.len() as f64).sum()
}

/// Whether `with` is worth its strengths over `without`.
fn accepts(question: &Question<'_>, base: &Candidate, without: &Candidate, with: &Candidate) -> Result<bool, FitError> {
    let (most, before, after) = (excess(&base.residuals), excess(&without.residuals), excess(&with.residuals));
    let told = before - after >= FORM * FORM * most || (is_bent(question, without) && !is_bent(question, with));
    if after > (1.0 - LEAST_SHARE) * before || (!without.effects.is_empty() && !told) {
        return Ok(false);
    }
    let (before, after) = (without.left_out(question)?, with.left_out(question)?);
    let mut samples = 0.0;
    let gains: Vec<f64> = before
        .iter()
        .zip(&after)
        .map(|(before, after)| {
            before
                .iter()
                .zip(after)
                .map(|(before, after)| {
                    samples += independent(before, after);
                    gained(before, after)
                })
                .sum()
        })
        .collect();
    let more = with.strengths().saturating_sub(without.strengths()) as f64;
    let penalty = 0.5 * more * f64::max(samples, 2.0).ln() + CHANCE;
    let improved = gains.iter().filter(|gain| **gain > 0.0).count();
    let needed = if gains.len() > 2 { gains.len() - 1 } else { gains.len() };
    // Parameters that come back may pay for the strengths, but the recordings themselves have to tell.
    let left_out: f64 = gains.iter().sum();
    Ok(left_out > CHANCE && left_out + straightened(question, without, with) > penalty && improved >= needed)
}

/// Drops every effect that the others make superfluous.
fn backward(question: &Question<'_>, base: &Candidate, mut full: Candidate) -> Result<Candidate, FitError> {
    while full.effects.len() > 1 {
        let mut dropped = None;
        for index in 0..full.effects.len() {
            let without = full.without(question, index)?;
            if !accepts(question, base, &without, &full)? {
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

/// What the held-out recordings say of a choice that they did not take part in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Confirmation {
    /// Log-likelihood gained over the base on all held-out recordings.
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

impl Confirmation {
    /// Whether they confirm it: a gain in all and on at least half of the recordings, no signal clearly worse, and none
    /// that the model follows worse than its mean would.
    #[must_use]
    pub fn confirms(&self) -> bool {
        self.recordings > 0
            && self.gain > 0.0
            && self.least_gain > -CHANCE.max(0.1 * self.gain)
            && self.least_fit_percent > 0.0
            && 2 * self.improved >= self.recordings
    }
}

/// NRMSE fit, %, that a perfect model would reach on a signal that is mostly noise.
const MOSTLY_NOISE: f64 = 50.0;

/// Opens the held-out recordings, once.
pub fn confirm(
    base: &Machine<f64>,
    chosen: &Machine<f64>,
    held_out: &[&Prepared],
) -> Result<Confirmation, MachineError> {
    let mut improved = 0;
    let mut signals: Vec<(Signal, f64)> = Vec::new();
    let mut least_fit_percent = 100.0_f64;
    for case in held_out {
        let before = softened(base, case, settle(base, case)?)?;
        let after = softened(chosen, case, settle(chosen, case)?)?;
        let mut total = 0.0;
        for (channel, (before, after)) in case.channels.iter().zip(before.iter().zip(&after)) {
            let gain = gained(before, after);
            total += gain;
            match signals.iter_mut().find(|(signal, _)| *signal == channel.signal) {
                Some((_, sum)) => *sum += gain,
                None => signals.push((channel.signal, gain)),
            }
            // A signal that is mostly noise fits no better than its mean, whatever the model.
            if channel.noise_floor_percent() > MOSTLY_NOISE {
                least_fit_percent = least_fit_percent.min(channel.fit_percent(after));
            }
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
