//! Which effects are accepted, decided on the training recordings alone, then confirmed or vetoed on the held-out ones.
//!
//! Every effect is screened; the most promising are refitted in the whole model; each of the best few is tried with a second one, and so on, so that
//! a pair is found even where neither of the two is best alone. Candidate models are compared by a log-likelihood in which each signal's noise level
//! is unknown: ½·n·ln(loss), with n the number of *independent* samples in the residual (neighbouring samples of a mismatch repeat each other), less
//! a Bayesian information penalty for the effect parameters, plus what the base parameters gain by coming back to their nominal values. What is
//! accepted must also gain on recordings that were left out, on all but one of them (what happens once is a disturbance), and take away at least half
//! of what is above the noise: an effect that does less is a stand-in for something else. A candidate model is also not accepted if another of its
//! size is likelier by more than chance, even if that other one cannot be accepted.

use identification::effort::Effort;
use identification::fit::{Fit, FitError};

use super::candidate::{Candidate, Question};
use super::decision_rule::{MOST_EFFECTS, SEARCHED_TO, VALVE_FIRST_FROM};
use super::inflated_noise::InflatedNoise;
use super::likelihood::{accepts, ranked};
use super::outcome::{Selection, Trial};
use super::round::{
    BEAM, candidates, enter, explains_enough, finished, is_likeliest, reduced, rivals, to_the_end, trials,
};
use super::search::{enriched, of_each, refined, widened};
use super::searched::{Clock, Searched, Stage};
use crate::catalogue::Hypothesis;
use crate::selection::valve::side::Side;

/// Effects that are refitted in a round, the most promising by the screening.
const REFITTED: usize = 7;
/// Effects that are refitted beside each of those.
const BESIDE: usize = 4;

/// What completes a round.
#[derive(Clone, Copy)]
enum Step {
    Refined,
    Played,
    Extended,
    Sticking,
}

/// About what a rough refit of a candidate model costs, s on two cores.
fn rough_refit_s(question: &Question<'_>) -> f64 {
    /// Simulations with derivatives that it takes, at twice the tick.
    const EVALUATIONS: f64 = 8.0;
    let ticks: usize = question.training.iter().map(|case| case.stimulus.ticks()).sum();
    0.5 * EVALUATIONS * Effort::of_derivatives_s(ticks, question.base_parameters.len())
}

/// How far a selection has come.
pub(crate) struct Course {
    /// The machine file's model, refitted with inflated noise: the noise of each channel is raised to the model's own misfit.
    inflated: InflatedNoise,
    /// The machine file's model, refitted.
    pub(crate) base: Candidate,
    /// The chosen candidate model; the base while nothing is accepted.
    pub(crate) chosen: Candidate,
    /// Candidate models from which the next round starts.
    pub(crate) beam: Vec<Candidate>,
    /// The plainest effects of those that were found by the valve-first search.
    pub(crate) joined: Vec<&'static str>,
    /// Sides of the recorded spool that are explained by what the valve-first search found.
    pub(crate) explained: Vec<Side>,
    /// Candidate models with as many effects as the chosen one that were nearly as likely when it was chosen.
    pub(crate) rivals: Vec<Candidate>,
    /// Every refitted candidate model, round by round, the best first.
    pub(crate) rounds: Vec<Vec<Trial>>,
    /// What its parts cost, and what a limit left out.
    pub(crate) searched: Searched,
}

/// Chooses the effects. `near` is a first refit of the machine file's model; `done` is called after each refit.
///
/// Where the spool is recorded and the model is far off, the valve-first search comes first. The whole model then has to accept what it found, and
/// the search goes on in the whole model.
pub fn select(question: &Question<'_>, near: &Fit, done: &(impl Fn(&str) + Sync)) -> Result<Selection, FitError> {
    let mut course = Course::of(question, near)?;
    if course.base.worst_over_noise(question) > VALVE_FIRST_FROM {
        let mut clock = Clock::of(question);
        course.join(question, done)?;
        course.searched.did(Stage::Sides, clock.lap_s());
    }
    done("refit");
    course.forward(question, SEARCHED_TO, done)?;
    let Course { base, inflated, chosen, rounds, joined, searched, .. } = course;
    Ok(Selection { base, inflated: inflated.base.fit, chosen, rounds, joined, jumps: None, searched })
}

impl Course {
    /// Nothing chosen yet.
    pub(crate) fn of(question: &Question<'_>, near: &Fit) -> Result<Self, FitError> {
        let mut clock = Clock::of(question);
        let inflated = InflatedNoise::of(question)?;
        let base = Candidate::base(question, near, &inflated.base.fit)?;
        let mut searched = Searched { limit_s: clock.effort().limit_s(), ..Searched::default() };
        searched.did(Stage::Base, clock.lap_s());
        Ok(Self {
            inflated,
            chosen: base.clone(),
            beam: vec![base.clone()],
            joined: Vec::new(),
            explained: Vec::new(),
            rivals: Vec::new(),
            rounds: Vec::new(),
            searched,
            base,
        })
    }

    /// Takes a better base, while nothing is chosen.
    pub(crate) fn rebase(&mut self, better: Candidate) {
        self.chosen = better.clone();
        self.beam = vec![better.clone()];
        self.base = better;
    }

    /// Adds effects round by round, until the best candidate model is within `near` times the noise or no further effect is worth its parameters.
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
            let Some(ranked) = self.round(question, &open, (round, near), done)? else { break };
            self.beam = ranked.iter().take(BEAM).map(|(candidate, _)| candidate.clone()).collect();
            if let Some(better) = self.first_accepted(question)? {
                self.chosen = better;
                if let Some(rivals) = rivals(&self.chosen, ranked) {
                    self.rivals = rivals;
                }
            }
            // Two effects may gain only together, so a second round follows even a round without a finding; a third effect is only looked for beside
            // accepted ones.
            if self.is_enough(question, near) || (round > 0 && self.chosen.effects.len() <= round) {
                break;
            }
        }
        Ok(())
    }

    /// The ranked candidate models with one more effect; `None` where the limit of the search ends it before all of them are tried. Those that were
    /// refitted by then are entered all the same.
    fn round(
        &mut self,
        question: &Question<'_>,
        open: &[&'static Hypothesis],
        (round, near): (usize, f64),
        done: &(impl Fn(&str) + Sync),
    ) -> Result<Option<Vec<(Candidate, f64)>>, FitError> {
        let (stage, mut clock) = (Stage::Effects(round + 1), Clock::of(question));
        let (most, is_whole) = self.affordable(question, if round == 0 { REFITTED } else { BESIDE });
        if !is_whole {
            self.searched.leave(stage);
        }
        if most == 0 {
            return Ok(None);
        }
        let asked = Question { hypotheses: open, ..*question };
        let found = widened(&asked, &self.inflated, &self.beam, most, done)?;
        let all = if clock.effort().is_used_up() {
            self.searched.leave(stage);
            ranked(question, &self.base, found)
        } else {
            let all = finished(question, &self.base, found)?;
            self.completed(question, all, (round, near), done)?
        };
        self.searched.did(stage, clock.lap_s());
        // Beside one effect that the drive is known to have, and may have more of by now, another one with values that no drive has is no rival.
        let asks_of_change = round == 0 && !question.scene.held.is_empty();
        let is_rival = |(candidate, _): &&(Candidate, f64)| !asks_of_change || candidate.is_plausible(question);
        self.rounds.push(trials(all.iter().filter(is_rival)));
        Ok(self.searched.is_finished().then_some(all))
    }

    /// A ranked round with refined forms, with a play where no sensor measures the spool, and with extensions, as far as the limit of the search lets it.
    fn completed(
        &mut self,
        question: &Question<'_>,
        mut all: Vec<(Candidate, f64)>,
        (round, near): (usize, f64),
        done: &(impl Fn(&str) + Sync),
    ) -> Result<Vec<(Candidate, f64)>, FitError> {
        let effort = question.effort();
        for step in [Step::Refined, Step::Played, Step::Extended, Step::Sticking] {
            if effort.is_used_up() {
                self.searched.leave(Stage::Effects(round + 1));
                break;
            }
            all = match step {
                Step::Refined => self.refined(question, all, near, done)?,
                Step::Played if round == 0 => self.played(question, all)?,
                Step::Played => all,
                Step::Extended => self.extended(question, all, near, done)?,
                Step::Sticking => self.sticking(question, all)?,
            };
        }
        Ok(all)
    }

    /// How many effects a round can refit within the limit of the search, at most this many, and whether these are all.
    fn affordable(&self, question: &Question<'_>, most: usize) -> (usize, bool) {
        /// Each effect takes about two forms.
        const FORMS: f64 = 2.0;
        let effort = question.effort();
        let Some(limit_s) = effort.limit_s() else { return (most, true) };
        let left_s = limit_s - effort.spent_s();
        let one_s = FORMS * self.beam.len() as f64 * rough_refit_s(question);
        let count = (1..=most).take_while(|count| *count as f64 * one_s <= left_s).count();
        (count, count == most)
    }

    /// A ranked round, with refined forms added for its finished candidate models that are not `near` their noise.
    fn refined(
        &self,
        question: &Question<'_>,
        ranked: Vec<(Candidate, f64)>,
        near: f64,
        done: &(impl Fn(&str) + Sync),
    ) -> Result<Vec<(Candidate, f64)>, FitError> {
        let far = |candidate: &Candidate| candidate.is_finished && candidate.worst_over_noise(question) > near;
        let above_noise: Vec<&Candidate> =
            ranked.iter().map(|(candidate, _)| candidate).filter(|candidate| far(candidate)).collect();
        let finer = of_each(&above_noise, |candidate| refined(question, candidate, done))?;
        if finer.is_empty() {
            return Ok(ranked);
        }
        finished(question, &self.base, candidates(ranked).into_iter().chain(finer).collect())
    }

    /// A ranked round, with extensions added for the effects that its best candidate model had before its newest one, where that model is not `near`
    /// its noise: without the newest effect, the misfit may have hidden what an extension gains.
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

    /// The acceptable part of the first candidate model of the beam that has one. Where none has, that of the best one without one of its effects,
    /// which may only have led the search there.
    fn first_accepted(&mut self, question: &Question<'_>) -> Result<Option<Candidate>, FitError> {
        let over = self.base.clone();
        for candidate in self.beam.clone() {
            if let Some(accepted) = self.accepted(question, &over, candidate)? {
                return Ok(Some(accepted));
            }
        }
        let Some(best) = self.beam.first().filter(|best| best.effects.len() > 1).cloned() else { return Ok(None) };
        for index in 0..best.effects.len() {
            let fewer = self.plainest(question, best.without(question, index)?)?;
            if let Some(accepted) = self.accepted(question, &over, fewer)? {
                enter(question, &over, &mut self.rounds, &accepted);
                return Ok(Some(accepted));
            }
        }
        Ok(None)
    }

    /// The acceptable part of a candidate model: the model without every effect that the others make superfluous. `None` where the model or this part
    /// may not be accepted. `over` is the base that the rounds were ranked over.
    fn accepted(
        &mut self,
        question: &Question<'_>,
        over: &Candidate,
        candidate: Candidate,
    ) -> Result<Option<Candidate>, FitError> {
        if !self.is_likely(question, over, &candidate) || !self.is_accepted(question, &candidate)? {
            return Ok(None);
        }
        let effects = candidate.effects.len();
        let Some(rest) = reduced(question, &self.base, candidate, &self.joined)? else { return Ok(None) };
        if rest.effects.len() == effects {
            return Ok(Some(rest));
        }
        let rest = self.plainest(question, rest)?;
        if !self.is_likely(question, over, &rest) || !self.stands(question, &rest)? {
            return Ok(None);
        }
        enter(question, over, &mut self.rounds, &rest);
        Ok(Some(rest))
    }

    /// A candidate model that lost effects, or the one with the plainer effect in the place of an extension that no longer earns its place.
    fn plainest(&self, question: &Question<'_>, rest: Candidate) -> Result<Candidate, FitError> {
        if rest.effects.last().is_none_or(|newest| newest.effect.extends.is_none()) {
            return Ok(rest);
        }
        let first = finished(question, &self.base, vec![rest.clone()])?.into_iter().next();
        Ok(first.map_or(rest, |(first, _)| first))
    }

    /// Whether no other candidate model of as many effects is likelier by more than chance. One that cannot be accepted may still be the true one, so
    /// nothing less likely is taken in its place; an extension and its plainer effect count as the same.
    fn is_likely(&self, question: &Question<'_>, over: &Candidate, candidate: &Candidate) -> bool {
        let Some(round) = self.rounds.get(candidate.effects.len() - 1) else { return true };
        let now = ranked(question, over, vec![candidate.clone()]);
        is_likeliest(candidate, now.first().map(|(_, net)| *net), round)
    }

    /// Whether a candidate model may be accepted over the chosen one: each of its effects is plausible, and they are worth their effect parameters.
    pub(crate) fn is_accepted(&mut self, question: &Question<'_>, candidate: &Candidate) -> Result<bool, FitError> {
        if !candidate.is_plausible(question) || !accepts(question, &self.base, &self.chosen, candidate)? {
            return Ok(false);
        }
        if self.chosen.effects.is_empty() { self.stands(question, candidate) } else { Ok(true) }
    }

    /// Whether a candidate model is still worth its effect parameters after the base was refitted from its solution: its effects may only have led
    /// the base parameters to values that do as well without them.
    fn stands(&mut self, question: &Question<'_>, candidate: &Candidate) -> Result<bool, FitError> {
        let Some(plain) = Candidate::below(question, &candidate.fit, self.base.fit.loss)? else { return Ok(true) };
        self.base = plain;
        // The chosen model has to be worth its effect parameters over the new base as well.
        if self.chosen.effects.is_empty() || !accepts(question, &self.base, &self.base, &self.chosen)? {
            self.chosen = self.base.clone();
        }
        accepts(question, &self.base, &self.base, candidate)
    }

    /// Whether the best candidate model explains enough.
    pub(crate) fn is_enough(&self, question: &Question<'_>, near: f64) -> bool {
        self.beam.first().is_none_or(|best| explains_enough(question, &self.base, best, near))
    }
}
