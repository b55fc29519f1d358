//! Which effects are claimed, decided on the training recordings alone, then confirmed or vetoed on the held-out ones.
//!
//! Every effect is screened; the most promising are refitted in the chain; the best few are each tried with a second one, and so
//! on, so that a pair is found even where neither of it is best alone. Sets are compared by a log-likelihood in which each
//! signal's noise level is unknown: ½·n·ln(loss), with n the number of *independent* samples in the residual (neighbouring samples
//! of a mismatch tell the same), less a Bayesian information penalty for the strengths, plus what the ordinary parameters gain by coming
//! back to their nominal values. A claim must also gain on recordings that
//! were left out, on all but one of them (what happens once is a disturbance), and take away at least half of what is above the
//! noise: an effect that does less is a stand-in for something else. So is a set that another of its size is likelier than, by more
//! than chance, even if that one cannot be claimed.

use rayon::prelude::*;

use identification::fit::{CHANCE, Fit, FitError};
use model_core::machine::Machine;

use super::candidate::{Candidate, Chosen, Question};
use super::inflated_noise::Tempered;
use super::likelihood::{FORM, accepts, excess, is_earned, prefer_plain, ranked};
use super::search::{enriched, is_hopeful, least_above, of_each, refined, widened};
use crate::catalogue::Hypothesis;
use crate::selection::valve::unmeasured_spool::Heard;
use crate::selection::valve::valve_first::Side;

/// Most effects claimed at once.
pub(crate) const MOST_EFFECTS: usize = 3;
/// Effects that are refitted in a round, the most promising by the screening.
const REFITTED: usize = 7;
/// Sets of a round that are refitted to the end.
const FINISHED: usize = 4;
/// Sets that the next round starts from.
const BEAM: usize = 2;
/// Effects that are refitted beside each of those.
const BESIDE: usize = 4;
/// A set whose worst signal is this close to its noise is not searched further.
pub(crate) const AT_NOISE: f64 = 1.03;
/// A model is far off where the worst signal is this many times its noise: then the links are looked at apart, and below a recorded
/// slider searched down to that.
pub(crate) const FAR: f64 = 2.0;

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

impl Trial {
    /// Whether its effects are those of a set.
    pub(crate) fn is_of(&self, set: &Candidate) -> bool {
        self.effects.len() == set.effects.len() && self.effects.iter().all(|own| set.has(own))
    }

    /// The effect that it has in the place of one of the chosen ones; `None` where it has that one too, or lacks or has another.
    pub fn instead_of(&self, effect: &Hypothesis, chosen: &[Chosen]) -> Option<&'static Hypothesis> {
        let is_chosen = |own: &Hypothesis| chosen.iter().any(|one| one.effect.name == own.name);
        let stays = |one: &Chosen| self.has_any(&[one.effect]) != (one.effect.name == effect.name);
        let mut others = self.effects.iter().copied().filter(|own| !is_chosen(own));
        if self.effects.len() == chosen.len() && chosen.iter().all(stays) { others.next() } else { None }
    }

    /// Whether any of these effects is in it.
    pub fn has_any(&self, effects: &[&Hypothesis]) -> bool {
        self.effects.iter().any(|own| effects.iter().any(|effect| effect.name == own.name))
    }
}

/// The outcome of the selection: on training recordings, and what held-out ones left of it.
#[derive(Clone, Debug)]
pub struct Selection {
    /// The machine file's model, refitted.
    pub base: Candidate,
    /// The chosen set; the base again if nothing is claimed.
    pub chosen: Candidate,
    /// Every set that was refitted, round by round, the best first.
    pub rounds: Vec<Vec<Trial>>,
    /// The plainest of several effects that were found with the links apart: the chain only had to accept them all together.
    pub joined: Vec<&'static str>,
    /// The jumps of a slider that no sensor sees, where the chosen set has them from the position.
    pub heard: Option<Heard>,
}

impl Selection {
    /// The effect alone that the training recordings make likelier than none by more than chance does, where nothing is claimed.
    #[must_use]
    pub fn suspected(&self) -> Option<&'static Hypothesis> {
        let best = self.rounds.first()?.first()?;
        (self.chosen.effects.is_empty() && best.net > CHANCE).then_some(best.effect)
    }
}

/// How far a selection has come.
pub(crate) struct Course {
    /// The machine file's model, refitted to recordings that are believed only as far as it follows them.
    tempered: Tempered,
    /// The machine file's model, refitted.
    pub(crate) base: Candidate,
    /// The chosen set; the base while nothing is claimed.
    pub(crate) chosen: Candidate,
    /// Sets that the next round starts from.
    pub(crate) beam: Vec<Candidate>,
    /// The plainest of effects that were found with the links apart.
    pub(crate) joined: Vec<&'static str>,
    /// Sides of the recorded slider that explain themselves by what was found with the links apart.
    pub(crate) explained: Vec<Side>,
    /// Sets of as many effects that were nearly as likely as the chosen one when it was chosen.
    pub(crate) rivals: Vec<Candidate>,
    /// Every set that was refitted, round by round, the best first.
    pub(crate) rounds: Vec<Vec<Trial>>,
}

/// Chooses the effects. `near` is a first refit of the machine file's model; `done` is told after each refit.
///
/// Where the slider is recorded and the model is far off, effects are looked for with the links apart first. The chain as a whole
/// then has to accept what was found, and is searched on.
pub fn select(question: &Question<'_>, near: &Fit, done: &(impl Fn(&str) + Sync)) -> Result<Selection, FitError> {
    let mut course = Course::of(question, near)?;
    if course.base.worst_over_noise(question) > FAR {
        course.join(question, done)?;
    }
    done("refit");
    course.forward(question, AT_NOISE, done)?;
    let Course { base, chosen, rounds, joined, .. } = course;
    Ok(Selection { base, chosen, rounds, joined, heard: None })
}

impl Course {
    /// Nothing chosen yet.
    pub(crate) fn of(question: &Question<'_>, near: &Fit) -> Result<Self, FitError> {
        let tempered = Tempered::of(question)?;
        let base = Candidate::base(question, near, &tempered.base.fit)?;
        Ok(Self {
            tempered,
            chosen: base.clone(),
            beam: vec![base.clone()],
            joined: Vec::new(),
            explained: Vec::new(),
            rivals: Vec::new(),
            rounds: Vec::new(),
            base,
        })
    }

    /// Takes a better base, while nothing is chosen.
    pub(crate) fn rebase(&mut self, better: Candidate) {
        self.chosen = better.clone();
        self.beam = vec![better.clone()];
        self.base = better;
    }

    /// Adds effects round by round, until the best set is within `near` times the noise or nothing more is worth it.
    pub(crate) fn forward(
        &mut self,
        question: &Question<'_>,
        near: f64,
        done: &(impl Fn(&str) + Sync),
    ) -> Result<(), FitError> {
        for round in self.chosen.effects.len()..MOST_EFFECTS {
            if !self.chosen.effects.is_empty() && self.is_enough(question, near) {
                break;
            }
            let open = self.open(question);
            if open.is_empty() {
                break;
            }
            let most = if round == 0 { REFITTED } else { BESIDE };
            let asked = Question { hypotheses: &open, ..*question };
            let found = widened(&asked, &self.tempered, &self.beam, most, done)?;
            let ranked = self.refined(question, finished(question, &self.base, found)?, near, done)?;
            let ranked = if round == 0 { self.played(question, ranked)? } else { ranked };
            let ranked = self.extended(question, ranked, near, done)?;
            self.rounds.push(trials(&ranked));
            self.beam = ranked.iter().take(BEAM).map(|(candidate, _)| candidate.clone()).collect();
            if let Some(better) = self.claimed(question)? {
                self.chosen = better;
                if let Some(rivals) = rivals(&self.chosen, ranked) {
                    self.rivals = rivals;
                }
            }
            // Two that go together may each be nothing alone, but a third is only looked for beside what was found.
            if self.is_enough(question, near) || (round > 0 && self.chosen.effects.len() <= round) {
                break;
            }
        }
        Ok(())
    }

    /// A ranked round with what refines its finished sets that are not `near` their noise.
    fn refined(
        &self,
        question: &Question<'_>,
        ranked: Vec<(Candidate, f64)>,
        near: f64,
        done: &(impl Fn(&str) + Sync),
    ) -> Result<Vec<(Candidate, f64)>, FitError> {
        let far = |set: &Candidate| set.is_finished && set.worst_over_noise(question) > near;
        let sets: Vec<&Candidate> = ranked.iter().map(|(set, _)| set).filter(|set| far(set)).collect();
        let finer = of_each(&sets, |set| refined(question, set, done))?;
        if finer.is_empty() {
            return Ok(ranked);
        }
        finished(question, &self.base, candidates(ranked).into_iter().chain(finer).collect())
    }

    /// A ranked round with the extensions of what the best set of it had before its newest effect, where that is not `near` its noise: alone,
    /// what is missing beside it may have hidden what an extension has more.
    fn extended(
        &self,
        question: &Question<'_>,
        ranked: Vec<(Candidate, f64)>,
        near: f64,
        done: &(impl Fn(&str) + Sync),
    ) -> Result<Vec<(Candidate, f64)>, FitError> {
        let best = ranked.first().filter(|(best, _)| best.worst_over_noise(question) > near);
        let richer = best.map_or(Ok(Vec::new()), |(best, _)| enriched(question, best, done))?;
        if richer.is_empty() {
            return Ok(ranked);
        }
        let richer =
            candidates(super::likelihood::ranked(question, &self.base, richer)).into_iter().take(BEAM).collect();
        let all = candidates(ranked).into_iter().chain(to_the_end(question, richer)?).collect();
        finished(question, &self.base, all)
    }

    /// What may be claimed of the first set of the beam of which anything may; where nothing may, of the best one without an effect that only
    /// showed the way.
    fn claimed(&mut self, question: &Question<'_>) -> Result<Option<Candidate>, FitError> {
        let over = self.base.clone();
        for candidate in self.beam.clone() {
            if let Some(claim) = self.claim(question, &over, candidate)? {
                return Ok(Some(claim));
            }
        }
        let Some(best) = self.beam.first().filter(|best| best.effects.len() > 1).cloned() else { return Ok(None) };
        for index in 0..best.effects.len() {
            if let Some(claim) = self.claim(question, &over, best.without(question, index)?)? {
                enter(question, &over, &mut self.rounds, &claim);
                return Ok(Some(claim));
            }
        }
        Ok(None)
    }

    /// What of a set may be claimed: it, but for every effect that the others make superfluous. `None` where it may not be claimed, or what is
    /// left may not. `over` is the base that the rounds were ranked over.
    fn claim(
        &mut self,
        question: &Question<'_>,
        over: &Candidate,
        set: Candidate,
    ) -> Result<Option<Candidate>, FitError> {
        if !self.is_likely(question, over, &set) || !self.claims(question, &set)? {
            return Ok(None);
        }
        let effects = set.effects.len();
        let Some(rest) = reduced(question, &self.base, set, &self.joined)? else { return Ok(None) };
        if rest.effects.len() < effects {
            if !self.is_likely(question, over, &rest) || !self.stands(question, &rest)? {
                return Ok(None);
            }
            enter(question, over, &mut self.rounds, &rest);
        }
        Ok(Some(rest))
    }

    /// Whether no other set of as many effects is likelier by more than chance. What cannot be claimed may still be what it
    /// is, and nothing less likely stands in for it; an extension only says more of the same.
    fn is_likely(&self, question: &Question<'_>, over: &Candidate, set: &Candidate) -> bool {
        let Some(round) = self.rounds.get(set.effects.len() - 1) else { return true };
        let now = ranked(question, over, vec![set.clone()]);
        is_likeliest(set, now.first().map(|(_, net)| *net), round)
    }

    /// Whether a set may be claimed over what is chosen: each of its effects is one that can be, and they are worth their
    /// strengths.
    pub(crate) fn claims(&mut self, question: &Question<'_>, set: &Candidate) -> Result<bool, FitError> {
        if !set.is_plausible(question.scene) || !accepts(question, &self.base, &self.chosen, set)? {
            return Ok(false);
        }
        if self.chosen.effects.is_empty() { self.stands(question, set) } else { Ok(true) }
    }

    /// Whether what is worth its strengths over nothing is so twice: its effects may only have led the ordinary parameters to where those do as
    /// well alone.
    fn stands(&mut self, question: &Question<'_>, set: &Candidate) -> Result<bool, FitError> {
        let Some(plain) = Candidate::below(question, &set.fit, self.base.fit.loss)? else { return Ok(true) };
        self.base = plain;
        // What was chosen has to be worth its strengths over that as well.
        if self.chosen.effects.is_empty() || !accepts(question, &self.base, &self.base, &self.chosen)? {
            self.chosen = self.base.clone();
        }
        accepts(question, &self.base, &self.base, set)
    }

    /// Whether the best set explains enough.
    pub(crate) fn is_enough(&self, question: &Question<'_>, near: f64) -> bool {
        self.beam.first().is_none_or(|best| explains_enough(question, &self.base, best, near))
    }
}

/// Whether no other set of a round is likelier by more than chance than one that gains so much `now`, or what it gained in that round.
pub(crate) fn is_likeliest(set: &Candidate, now: Option<f64>, round: &[Trial]) -> bool {
    let plainest = |effects: &mut dyn Iterator<Item = &'static Hypothesis>| {
        let mut names: Vec<&str> = effects.map(Hypothesis::plainest).collect();
        names.sort_unstable();
        names
    };
    let of_set = plainest(&mut set.effects.iter().map(|chosen| chosen.effect));
    let (same, others): (Vec<&Trial>, Vec<&Trial>) =
        round.iter().partition(|trial| plainest(&mut trial.effects.iter().copied()) == of_set);
    let nets = |trials: Vec<&Trial>| trials.into_iter().map(|trial| trial.net).fold(f64::NEG_INFINITY, f64::max);
    now.into_iter().fold(nets(same), f64::max) > nets(others) - CHANCE
}

/// Enters a set into the round of its size, unless a better fit of the same effects is there.
pub(crate) fn enter(question: &Question<'_>, base: &Candidate, rounds: &mut [Vec<Trial>], candidate: &Candidate) {
    let Some(round) = rounds.get_mut(candidate.effects.len() - 1) else { return };
    for (candidate, net) in ranked(question, base, vec![candidate.clone()]) {
        let is_better = |trial: &Trial| trial.is_of(&candidate) && trial.net >= net;
        if !round.iter().any(is_better) {
            round.retain(|trial| !trial.is_of(&candidate));
            round.push(trial(&candidate, net));
        }
    }
    round.sort_by(|a, b| b.net.total_cmp(&a.net));
}

/// A set without every effect that the others make superfluous, but for those of these plainest names. `None` where what is left is not worth
/// its strengths over nothing.
pub(crate) fn reduced(
    question: &Question<'_>,
    base: &Candidate,
    full: Candidate,
    stay: &[&str],
) -> Result<Option<Candidate>, FitError> {
    let (mut rest, mut is_claim) = (unrefined(question, full)?, true);
    while rest.effects.len() > 1 {
        let without = |index: usize| -> Result<Option<(bool, Candidate)>, FitError> {
            let without = rest.without(question, index)?;
            if !without.is_plausible(question.scene) || accepts(question, base, &without, &rest)? {
                return Ok(None);
            }
            Ok(Some((accepts(question, base, base, &without)?, without)))
        };
        let may_go = |&index: &usize| !stay.contains(&rest.effects[index].effect.plainest());
        let indices: Vec<usize> = (0..rest.effects.len()).filter(may_go).collect();
        let fewer: Vec<Option<(bool, Candidate)>> = indices.into_par_iter().map(without).collect::<Result<_, _>>()?;
        // Of two that each make the other superfluous, the one that is a claim stays, or the one that leaves less.
        let best = fewer
            .into_iter()
            .flatten()
            .min_by(|(one, a), (other, b)| other.cmp(one).then_with(|| a.fit.loss.total_cmp(&b.fit.loss)));
        let Some(best) = best else { break };
        (is_claim, rest) = best;
    }
    Ok(is_claim.then_some(rest))
}

/// A set with the plain form of each refined one that no longer takes most of what that leaves, now that other effects are beside it.
fn unrefined(question: &Question<'_>, mut set: Candidate) -> Result<Candidate, FitError> {
    if set.effects.len() < 2 {
        return Ok(set);
    }
    for index in 0..set.effects.len() {
        let Chosen { effect, form } = set.effects[index];
        for form in effect.plain_of(form) {
            let plain = set.instead(question, index, Chosen { effect, form }, &[])?;
            if plain.is_possible(question.scene) && !is_earned(&plain, &set) {
                set = plain;
                break;
            }
        }
    }
    Ok(set)
}

/// Whether nothing is left that a further effect could explain: the ordinary parameters of the best set are where they were
/// said to be, and it is `near` its noise, or what it leaves would not be told from its own form's error.
pub(crate) fn explains_enough(question: &Question<'_>, base: &Candidate, best: &Candidate, near: f64) -> bool {
    let fits =
        || best.worst_over_noise(question) < near || excess(&best.residuals) < FORM * FORM * excess(&base.residuals);
    !best.is_bent(question) && fits()
}

/// Sets of a round that are nearly as likely as one of it: less so by no more than chance, or than its form's own error may gain.
/// `None` where it is not of the round.
fn rivals(set: &Candidate, ranked: Vec<(Candidate, f64)>) -> Option<Vec<Candidate>> {
    let names = set.names();
    let net = ranked.iter().find(|(other, _)| other.names() == names).map(|(_, net)| *net)?;
    let is_near = |other: &(Candidate, f64)| other.1 >= net - CHANCE.max(FORM * FORM * net) && other.0.names() != names;
    Some(candidates(ranked.into_iter().filter(is_near).take(FINISHED - 1).collect()))
}

/// Possible sets ranked, the best of them refitted to the end.
pub(crate) fn finished(
    question: &Question<'_>,
    base: &Candidate,
    found: Vec<Candidate>,
) -> Result<Vec<(Candidate, f64)>, FitError> {
    let can_be = |candidate: &Candidate| candidate.is_possible(question.scene);
    let only_possible = |found: Vec<Candidate>| -> Vec<Candidate> { found.into_iter().filter(can_be).collect() };
    let (possible, astray): (Vec<Candidate>, Vec<Candidate>) = found.into_iter().partition(can_be);
    let mut rough = candidates(ranked(question, base, possible));
    let least = least_above(&rough);
    let leading = rough.iter().take_while(|candidate| is_hopeful(candidate, least)).count();
    let rest = rough.split_off(leading.min(FINISHED).max(BEAM.min(rough.len())));
    // One that has gone beyond what can be, and beside which all that can be is hopeless, may come back from there.
    let astray = astray.into_iter().min_by(|a, b| a.fit.loss.total_cmp(&b.fit.loss));
    let beside_it = |least: f64| rough.iter().all(|candidate| !is_hopeful(candidate, least));
    let astray = astray.filter(|one| beside_it(excess(&one.residuals)));
    rough.extend(astray);
    let mut all = only_possible(to_the_end(question, rough)?);
    all.extend(rest);
    let mut simplified: Vec<Vec<&str>> = Vec::new();
    loop {
        let mut ranked = ranked(question, base, all);
        prefer_plain(base, &mut ranked);
        // A set that comes up only now is refitted to the end before it may be chosen.
        if !ranked.iter().take(BEAM).all(|(candidate, _)| candidate.is_finished) {
            let mut first = candidates(ranked);
            let rest = first.split_off(BEAM.min(first.len()));
            all = only_possible(to_the_end(question, first)?);
            all.extend(rest);
            continue;
        }
        // Nor is an extension, before what it extends was looked for where it has ended.
        let Some((best, _)) = ranked.first().filter(|(best, _)| !simplified.contains(&best.names())) else {
            return Ok(ranked);
        };
        simplified.push(best.names());
        let Some(plain) = best.with_plain(question)? else { return Ok(ranked) };
        all = candidates(ranked).into_iter().chain(only_possible(vec![plain])).collect();
    }
}

/// Ranked sets in their order.
pub(crate) fn candidates(ranked: Vec<(Candidate, f64)>) -> Vec<Candidate> {
    ranked.into_iter().map(|(candidate, _)| candidate).collect()
}

/// The sets in their order, each refitted to the end.
fn to_the_end(question: &Question<'_>, sets: Vec<Candidate>) -> Result<Vec<Candidate>, FitError> {
    let finished =
        |candidate: Candidate| if candidate.is_finished { Ok(candidate) } else { candidate.finished(question) };
    sets.into_par_iter().map(finished).collect()
}

pub(crate) fn trials(ranked: &[(Candidate, f64)]) -> Vec<Trial> {
    ranked.iter().map(|(candidate, net)| trial(candidate, *net)).collect()
}

pub(crate) fn trial(candidate: &Candidate, net: f64) -> Trial {
    let effects: Vec<_> = candidate.effects.iter().map(|chosen| chosen.effect).collect();
    Trial { effect: effects[effects.len() - 1], effects, net, machine: candidate.fit.machine }
}

#[cfg(test)]
mod tests;
