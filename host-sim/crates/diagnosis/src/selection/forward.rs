//! Which effects are accepted, decided on the training recordings alone, then confirmed or vetoed on the held-out ones.
//!
//! Every effect is screened; the most promising are refitted in the chain; the best few are each tried with a second one, and so
//! on, so that a pair is found even where neither of it is best alone. Sets are compared by a log-likelihood in which each
//! signal's noise level is unknown: ½·n·ln(loss), with n the number of *independent* samples in the residual (neighbouring samples
//! of a mismatch tell the same), less a Bayesian information penalty for the effect parameters, plus what the base parameters gain by coming
//! back to their nominal values. What is accepted must also gain on recordings that
//! were left out, on all but one of them (what happens once is a disturbance), and take away at least half of what is above the
//! noise: an effect that does less is a stand-in for something else. So is a set that another of its size is likelier than, by more
//! than chance, even if that one cannot be accepted.

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
use crate::selection::valve::side::Side;

/// Effects that are refitted in a round, the most promising by the screening.
const REFITTED: usize = 7;
/// Effects that are refitted beside each of those.
const BESIDE: usize = 4;

/// How far a selection has come.
pub(crate) struct Course {
    /// The machine file's model, refitted to recordings that are believed only as far as it follows them.
    inflated: InflatedNoise,
    /// The machine file's model, refitted.
    pub(crate) base: Candidate,
    /// The chosen set; the base while nothing is accepted.
    pub(crate) chosen: Candidate,
    /// Sets that the next round starts from.
    pub(crate) beam: Vec<Candidate>,
    /// The plainest of effects that were found with the links apart.
    pub(crate) joined: Vec<&'static str>,
    /// Sides of the recorded spool that explain themselves by what was found with the links apart.
    pub(crate) explained: Vec<Side>,
    /// Sets of as many effects that were nearly as likely as the chosen one when it was chosen.
    pub(crate) rivals: Vec<Candidate>,
    /// Every set that was refitted, round by round, the best first.
    pub(crate) rounds: Vec<Vec<Trial>>,
}

/// Chooses the effects. `near` is a first refit of the machine file's model; `done` is told after each refit.
///
/// Where the spool is recorded and the model is far off, effects are looked for with the links apart first. The chain as a whole
/// then has to accept what was found, and is searched on.
pub fn select(question: &Question<'_>, near: &Fit, done: &(impl Fn(&str) + Sync)) -> Result<Selection, FitError> {
    let mut course = Course::of(question, near)?;
    if course.base.worst_over_noise(question) > VALVE_FIRST_FROM {
        course.join(question, done)?;
    }
    done("refit");
    course.forward(question, SEARCHED_TO, done)?;
    let Course { base, chosen, rounds, joined, .. } = course;
    Ok(Selection { base, chosen, rounds, joined, heard: None })
}

impl Course {
    /// Nothing chosen yet.
    pub(crate) fn of(question: &Question<'_>, near: &Fit) -> Result<Self, FitError> {
        let inflated = InflatedNoise::of(question)?;
        let base = Candidate::base(question, near, &inflated.base.fit)?;
        Ok(Self {
            inflated,
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
            let found = widened(&asked, &self.inflated, &self.beam, most, done)?;
            let ranked = self.refined(question, finished(question, &self.base, found)?, near, done)?;
            let ranked = if round == 0 { self.played(question, ranked)? } else { ranked };
            let ranked = self.extended(question, ranked, near, done)?;
            self.rounds.push(trials(&ranked));
            self.beam = ranked.iter().take(BEAM).map(|(candidate, _)| candidate.clone()).collect();
            if let Some(better) = self.first_accepted(question)? {
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

    /// What may be accepted of the first set of the beam of which anything may; where nothing may, of the best one without an effect that only
    /// showed the way.
    fn first_accepted(&mut self, question: &Question<'_>) -> Result<Option<Candidate>, FitError> {
        let over = self.base.clone();
        for candidate in self.beam.clone() {
            if let Some(accepted) = self.accepted(question, &over, candidate)? {
                return Ok(Some(accepted));
            }
        }
        let Some(best) = self.beam.first().filter(|best| best.effects.len() > 1).cloned() else { return Ok(None) };
        for index in 0..best.effects.len() {
            if let Some(accepted) = self.accepted(question, &over, best.without(question, index)?)? {
                enter(question, &over, &mut self.rounds, &accepted);
                return Ok(Some(accepted));
            }
        }
        Ok(None)
    }

    /// What of a set may be accepted: it, but for every effect that the others make superfluous. `None` where it may not be accepted, or what is
    /// left may not. `over` is the base that the rounds were ranked over.
    fn accepted(
        &mut self,
        question: &Question<'_>,
        over: &Candidate,
        set: Candidate,
    ) -> Result<Option<Candidate>, FitError> {
        if !self.is_likely(question, over, &set) || !self.is_accepted(question, &set)? {
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

    /// Whether no other set of as many effects is likelier by more than chance. What cannot be accepted may still be what it
    /// is, and nothing less likely stands in for it; an extension only says more of the same.
    fn is_likely(&self, question: &Question<'_>, over: &Candidate, set: &Candidate) -> bool {
        let Some(round) = self.rounds.get(set.effects.len() - 1) else { return true };
        let now = ranked(question, over, vec![set.clone()]);
        is_likeliest(set, now.first().map(|(_, net)| *net), round)
    }

    /// Whether a set may be accepted over what is chosen: each of its effects is one that can be, and they are worth their
    /// effect parameters.
    pub(crate) fn is_accepted(&mut self, question: &Question<'_>, set: &Candidate) -> Result<bool, FitError> {
        if !set.is_plausible(question.scene) || !accepts(question, &self.base, &self.chosen, set)? {
            return Ok(false);
        }
        if self.chosen.effects.is_empty() { self.stands(question, set) } else { Ok(true) }
    }

    /// Whether what is worth its effect parameters over nothing is so twice: its effects may only have led the base parameters to where those do as
    /// well alone.
    fn stands(&mut self, question: &Question<'_>, set: &Candidate) -> Result<bool, FitError> {
        let Some(plain) = Candidate::below(question, &set.fit, self.base.fit.loss)? else { return Ok(true) };
        self.base = plain;
        // What was chosen has to be worth its effect parameters over that as well.
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
