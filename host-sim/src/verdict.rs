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

/// Chooses the effects. `done` is told after each refit.
///
/// Where the slider is recorded and the model is far off, large effects are looked for with the links apart first: the recorded
/// slider meters the oil beside the valve, so that what one link misses bends no other's parameters. The chain as a whole then
/// has to accept what was found, and is searched on.
pub fn select(question: &Question<'_>, done: &(impl Fn(&str) + Sync)) -> Result<Selection, FitError> {
    let mut course = Course::of(question)?;
    if course.base.worst_over_noise(question) > FAR
        && let Some(mut followed) = followed(question.training)
    {
        Candidate::tolerated(question.scene, question.ordinary, &mut followed)?;
        let references: Vec<&Prepared> = followed.iter().collect();
        course.join(question, &Question { training: &references, ..*question }, done)?;
    }
    done("refit");
    course.forward(question, AT_NOISE, done)?;
    let Course { base, chosen, rounds, .. } = course;
    Ok(Selection { base, chosen, rounds })
}

/// The same recordings with the recorded slider metering the oil; `None` unless every one allows it.
fn followed(training: &[&Prepared]) -> Option<Vec<Prepared>> {
    training.iter().map(|case| case.following()).collect()
}

impl Course {
    /// Nothing chosen yet.
    fn of(question: &Question<'_>) -> Result<Self, FitError> {
        let tempered = Tempered::of(question)?;
        let base = Candidate::base(question, &tempered.base.fit)?;
        Ok(Self { tempered, chosen: base.clone(), beam: vec![base.clone()], rounds: Vec::new(), base })
    }

    /// Takes the better of two bases, while nothing is chosen.
    fn rebase(&mut self, other: Candidate) {
        if other.fit.loss < self.base.fit.loss {
            self.chosen = other.clone();
            self.beam = vec![other.clone()];
            self.base = other;
        }
    }

    /// Looks for effects with the links `apart`, and takes over what the chain as a whole accepts of what is found.
    fn join(
        &mut self,
        question: &Question<'_>,
        apart: &Question<'_>,
        done: &(impl Fn(&str) + Sync),
    ) -> Result<(), FitError> {
        let mut parted = Self::of(apart)?;
        self.rebase(Candidate::near(question, &parted.base.fit)?);
        parted.forward(apart, FAR, done)?;
        if parted.chosen.effects.is_empty() {
            return Ok(());
        }
        let joined = parted.chosen.finished(question)?;
        if self.claims(question, &joined)? {
            self.choose(question, joined)?;
            self.beam = vec![self.chosen.clone()];
            self.rounds = parted.rounds;
            self.rounds.truncate(self.chosen.effects.len());
        }
        Ok(())
    }

    /// Adds effects round by round, until the best set is within `near` times the noise or nothing more is worth it.
    fn forward(&mut self, question: &Question<'_>, near: f64, done: &(impl Fn(&str) + Sync)) -> Result<(), FitError> {
        for round in self.chosen.effects.len()..MOST_EFFECTS {
            if !self.chosen.effects.is_empty() && self.is_enough(question, near) {
                break;
            }
            let most = if round == 0 { REFITTED } else { BESIDE };
            let found = widened(question, &self.tempered, &self.beam, most, done)?;
            let ranked = finished(question, &self.base, found)?;
            self.rounds.push(ranked.iter().map(|(candidate, net)| trial(candidate, *net)).collect());
            self.beam = ranked.into_iter().take(BEAM).map(|(candidate, _)| candidate).collect();
            if let Some(better) = self.claimed(question)? {
                self.choose(question, better)?;
            }
            // Two that go together may each be nothing alone, but a third is only looked for beside what was found.
            if self.is_enough(question, near) || (round > 0 && self.chosen.effects.len() <= round) {
                break;
            }
        }
        Ok(())
    }

    /// The first set of the beam that may be claimed; where none may, the best one without an effect that only showed the way.
    fn claimed(&mut self, question: &Question<'_>) -> Result<Option<Candidate>, FitError> {
        for candidate in self.beam.clone() {
            if self.claims(question, &candidate)? {
                return Ok(Some(candidate));
            }
        }
        let Some(best) = self.beam.first().filter(|best| best.effects.len() > 1).cloned() else { return Ok(None) };
        for index in 0..best.effects.len() {
            let fewer = best.without(question, index)?;
            if self.claims(question, &fewer)? {
                self.enter(question, &fewer);
                return Ok(Some(fewer));
            }
        }
        Ok(None)
    }

    /// Whether a set may be claimed over what is chosen: each of its effects is one that can be, and they are worth their
    /// strengths. Over nothing they have to be so twice, for they may only have led the ordinary parameters to where
    /// those do as well alone.
    fn claims(&mut self, question: &Question<'_>, set: &Candidate) -> Result<bool, FitError> {
        if !set.is_plausible(question.scene) || !accepts(question, &self.base, &self.chosen, set)? {
            return Ok(false);
        }
        if !self.chosen.effects.is_empty() {
            return Ok(true);
        }
        let plain = set.plain(question)?;
        if plain.fit.loss >= self.base.fit.loss {
            return Ok(true);
        }
        (self.base, self.chosen) = (plain.clone(), plain);
        accepts(question, &self.base, &self.chosen, set)
    }

    /// Chooses a set, but for every effect that the others make superfluous.
    fn choose(&mut self, question: &Question<'_>, full: Candidate) -> Result<(), FitError> {
        self.chosen = reduced(question, &self.base, full)?;
        Ok(())
    }

    /// Whether the best set explains enough.
    fn is_enough(&self, question: &Question<'_>, near: f64) -> bool {
        self.beam.first().is_none_or(|best| explains_enough(question, &self.base, best, near))
    }

    /// Enters a set into the round of its size, in the place of a worse fit of the same effects.
    fn enter(&mut self, question: &Question<'_>, candidate: &Candidate) {
        let Some(round) = self.rounds.get_mut(candidate.effects.len() - 1) else { return };
        let same = |trial: &Trial| {
            candidate.effects.iter().all(|chosen| trial.effects.iter().any(|effect| effect.name == chosen.effect.name))
        };
        round.retain(|trial| !same(trial));
        let entered = ranked(question, &self.base, vec![candidate.clone()]);
        round.extend(entered.iter().map(|(candidate, net)| trial(candidate, *net)));
        round.sort_by(|a, b| b.net.total_cmp(&a.net));
    }
}

/// A set without every effect that the others make superfluous.
fn reduced(question: &Question<'_>, base: &Candidate, mut full: Candidate) -> Result<Candidate, FitError> {
    while full.effects.len() > 1 {
        let mut dropped = None;
        for index in 0..full.effects.len() {
            let without = full.without(question, index)?;
            if without.is_plausible(question.scene) && !accepts(question, base, &without, &full)? {
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

/// Whether nothing is left that a further effect could explain: the ordinary parameters of the best set are where they were
/// said to be, and it is `near` its noise, or what it leaves would not be told from its own form's error.
fn explains_enough(question: &Question<'_>, base: &Candidate, best: &Candidate, near: f64) -> bool {
    let fits =
        || best.worst_over_noise(question) < near || excess(&best.residuals) < FORM * FORM * excess(&base.residuals);
    !best.is_bent(question) && fits()
}

/// Plausible sets ranked, the best of them refitted to the end.
fn finished(
    question: &Question<'_>,
    base: &Candidate,
    found: Vec<Candidate>,
) -> Result<Vec<(Candidate, f64)>, FitError> {
    let plausible = |found: Vec<Candidate>| -> Vec<Candidate> {
        found.into_iter().filter(|candidate| candidate.is_plausible(question.scene)).collect()
    };
    let mut rough = ranked(question, base, plausible(found));
    let above = |candidate: &Candidate| excess(&candidate.residuals);
    let least = rough.iter().map(|(candidate, _)| above(candidate)).fold(f64::INFINITY, f64::min);
    let hopeful = |candidate: &Candidate| above(candidate) < HOPELESS * least.max(2.0 * candidate.strengths() as f64);
    let leading = rough.iter().take_while(|(candidate, _)| hopeful(candidate)).count();
    let rest = rough.split_off(leading.min(FINISHED).max(BEAM.min(rough.len())));
    let mut all = plausible(to_the_end(question, rough, FINISHED)?);
    all.extend(rest.into_iter().map(|(candidate, _)| candidate));
    loop {
        let mut ranked = ranked(question, base, all);
        prefer_plain(base, &mut ranked);
        // A set that comes up only now is refitted to the end before it may be chosen.
        if ranked.iter().take(BEAM).all(|(candidate, _)| candidate.is_finished) {
            return Ok(ranked);
        }
        all = plausible(to_the_end(question, ranked, BEAM)?);
    }
}

/// The sets in their order, the `first` refitted to the end.
fn to_the_end(
    question: &Question<'_>,
    ranked: Vec<(Candidate, f64)>,
    first: usize,
) -> Result<Vec<Candidate>, FitError> {
    let finished = |(place, (candidate, _)): (usize, (Candidate, f64))| {
        if place < first && !candidate.is_finished { candidate.finished(question) } else { Ok(candidate) }
    };
    ranked.into_par_iter().enumerate().map(finished).collect()
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
    let told = before - after >= FORM * FORM * most || (without.is_bent(question) && !with.is_bent(question));
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
