//! Valves whose spool no sensor measures: a play that the search missed, and stiction, found by what its jumps leave in the position.

use identification::parallel;

use identification::experiment::Prepared;
use identification::fit::residuals::samples_by_blocks;
use identification::fit::{FitError, loss, softened_all};
use model_core::machine::Parameter;
use recording::Signal;

use super::jump_spacing::JumpSpacing;
use crate::catalogue::Hypothesis;
use crate::selection::candidate::{Candidate, Chosen, Question};
use crate::selection::decision_rule::{MOST_EFFECTS, PLAY_SOUGHT_FROM, SPACING_SOUGHT_FROM, UNMEASURED_SPOOL_GAINS};
use crate::selection::forward::Course;
use crate::selection::inflated_noise::as_far_as;
use crate::selection::likelihood::ranked_by;
use crate::selection::outcome::{JumpEvidence, JumpsFound, Selection};
use crate::selection::round::{candidates, finished, trial};
use crate::selection::screen::with;
use crate::selection::searched::{Clock, Stage};

/// Widths of a play, of full travel, from which the search for a play starts.
const WIDTHS: [f64; 2] = [0.01, 0.03];
/// Jump lengths that are tried, as a multiple of the one found in the position: that one is accurate to about a fifth.
const LENGTHS: [f64; 5] = [0.85, 0.92, 1.0, 1.08, 1.18];
/// Kept shares that are tried for a stiction beside a play.
const KEPT: [f64; 4] = [0.0, 0.1, 0.2, 0.3];
/// Widths of the play to which the lag of a stiction alone is equal, as a multiple of the fitted play's width: where it turns, it is late by a jump
/// more or less.
const LAGS: [f64; 4] = [0.8, 0.9, 1.0, 1.1];
/// Number of the simulated candidates that are refitted.
const REFITTED: usize = 3;

/// Whether a sensor measures the spool.
fn is_seen(question: &Question<'_>) -> bool {
    question.training.iter().flat_map(|case| &case.channels).any(|channel| channel.signal == Signal::Spool)
}

/// A candidate model with a play added, refitted from several widths, both from its own solution and from the nominal machine: a play moves the end
/// of every stroke, so that derivatives at zero play say little about it. Empty where a sensor measures the spool, or the model already has a play.
fn played(question: &Question<'_>, candidate: &Candidate) -> Result<Vec<Candidate>, FitError> {
    let play = question.form_with(&[Parameter::HysteresisWidth, Parameter::HysteresisSpread]);
    let Some(play) = play.filter(|play| !is_seen(question) && !candidate.has(play.effect)) else {
        return Ok(Vec::new());
    };
    let effects = [candidate.effects.as_slice(), &[play]].concat();
    let refitted = |(near, width)| {
        let values = [(Parameter::HysteresisWidth, width)];
        Candidate::given(question, effects.clone(), candidate.jumps.clone(), near, &values)
    };
    let starts = [None, Some(&candidate.fit)].into_iter().flat_map(|near| WIDTHS.map(|width| (near, width)));
    parallel::try_each(starts, refitted)
}

impl Course {
    /// A first round, with a play added where no sensor measures the spool and the best candidate model is far off.
    pub(crate) fn played(
        &self,
        question: &Question<'_>,
        ranked: Vec<(Candidate, f64)>,
    ) -> Result<Vec<(Candidate, f64)>, FitError> {
        if ranked.first().is_some_and(|(best, _)| best.worst_over_noise(question) <= PLAY_SOUGHT_FROM) {
            return Ok(ranked);
        }
        let found = played(question, &self.base)?;
        if found.is_empty() {
            return Ok(ranked);
        }
        finished(question, &self.base, candidates(ranked).into_iter().chain(found).collect())
    }
}

/// A stiction beside a play of this width (0: stiction alone).
#[derive(Clone, Copy)]
struct Sticks {
    band: f64,
    kept: f64,
    width: f64,
}

impl Sticks {
    /// A stiction with jumps of this length and this kept share. It lags by ½·band·(1 + kept), as a play lags by half its width; the remainder of the
    /// `width` of a play that fits as well is given to the play beside it. `None` where nothing remains.
    fn beside(length: f64, kept: f64, width: f64) -> Option<Self> {
        let band = length / (1.0 - kept);
        let width = width - band * (1.0 + kept);
        (width > 0.0).then_some(Self { band, kept, width })
    }

    /// A stiction with jumps of this length that lags as a play of this width does, without a play beside it.
    fn alone(length: f64, width: f64) -> Self {
        let kept = ((width - length) / (width + length)).max(0.0);
        Self { band: length / (1.0 - kept), kept, width: 0.0 }
    }

    fn jumps(&self) -> [(Parameter, f64); 2] {
        [(Parameter::StictionBand, self.band), (Parameter::StictionKept, self.kept)]
    }
}

impl Selection {
    /// Takes a stiction into the chosen candidate model where no sensor measures the spool and the position shows its jumps.
    ///
    /// The jumps are looked for in the residual of a model with a play, since in a free run a sticking spool looks like a play; that model is fitted
    /// with inflated noise. Its lag and the jump length give the share of its band that a stiction alone would keep; where that is more than a real
    /// one keeps, there is a play beside it. The jumps do not show the kept share in that case: it is taken from the simulation with the smallest
    /// misfit.
    pub fn find_jumps(&mut self, question: &Question<'_>, done: &(impl Fn(&str) + Sync)) -> Result<(), FitError> {
        let Some(stiction) = question.form_with(&[Parameter::StictionBand, Parameter::StictionKept]) else {
            return Ok(());
        };
        // A jump lasts some tens of milliseconds: between rows that are further apart it leaves nothing.
        if is_seen(question) || question.scene.is_sparse {
            return Ok(());
        }
        let is_play = |one: &Chosen| one.has(Parameter::HysteresisWidth);
        let is_stiction = |one: &Chosen| one.has(Parameter::StictionBand);
        let has = |is: &dyn Fn(&Chosen) -> bool| self.chosen.effects.iter().any(is);
        if self.chosen.worst_over_noise(question) < SPACING_SOUGHT_FROM || (has(&is_play) && has(&is_stiction)) {
            return Ok(());
        }
        let mut clock = Clock::of(question);
        if clock.effort().is_used_up() {
            self.searched.leave(Stage::Jumps);
            return Ok(());
        }
        let found = self.sought_jumps(question, stiction, done);
        self.searched.did(Stage::Jumps, clock.lap_s());
        found
    }

    /// The same, where they may be found.
    fn sought_jumps(
        &mut self,
        question: &Question<'_>,
        stiction: Chosen,
        done: &(impl Fn(&str) + Sync),
    ) -> Result<(), FitError> {
        let is_play = |one: &Chosen| one.has(Parameter::HysteresisWidth);
        let is_stiction = |one: &Chosen| one.has(Parameter::StictionBand);
        let has = |is: &dyn Fn(&Chosen) -> bool| self.chosen.effects.iter().any(is);
        let following = if has(&is_play) {
            Some(self.chosen.clone())
        } else {
            let candidate = if has(&is_stiction) {
                &self.chosen.only(question, |effect| effect.name != stiction.effect.name)?
            } else {
                &self.chosen
            };
            played(question, candidate)?.into_iter().min_by(|a, b| a.fit.loss.total_cmp(&b.fit.loss))
        };
        let Some(following) = following else { return Ok(()) };
        // At the sensors' own noise, the residual of the jumps would pull the base parameters far from their nominal values.
        let inflated = as_far_as(question, &following)?;
        let inflated: Vec<&Prepared> = inflated.iter().collect();
        let less = Question { training: &inflated, ..*question };
        let following = following.refitted_to(question, &less)?;
        let Some(jump_spacing) = JumpSpacing::of(&following.fit.machine, question.training)? else { return Ok(()) };
        done(stiction.effect.name);

        let width = following.fit.machine.get(Parameter::HysteresisWidth);
        let found = JumpsFound { jump_spacing, kept_alone: Sticks::alone(jump_spacing.length, width).kept };
        let is_alone = found.is_alone();
        let lengths = LENGTHS.iter().map(|times| times * jump_spacing.length);
        let tries: Vec<Sticks> = if is_alone {
            lengths.flat_map(|length| LAGS.map(|times| Sticks::alone(length, times * width))).collect()
        } else {
            lengths.flat_map(|length| KEPT.map(|kept| Sticks::beside(length, kept, width))).flatten().collect()
        };
        let others = following.effects.iter().copied().filter(|one| !(is_alone && is_play(one)));
        let effects: Vec<Chosen> = others.chain([stiction]).collect();
        let candidates = nearest(question, &less, &following, &effects, &tries)?;
        let ranked = ranked_by(question, &self.base, candidates, samples_by_blocks);
        let may_be = |(candidate, net): &(Candidate, f64)| {
            *net > UNMEASURED_SPOOL_GAINS && candidate.effects.len() <= MOST_EFFECTS && candidate.is_plausible(question)
        };
        let Some((best, _)) = ranked.into_iter().find(may_be) else { return Ok(()) };
        let (chosen, rounds) = (self.chosen.clone(), self.rounds.clone());
        self.jumps = Some(JumpEvidence { found, following: following.fit.machine, chosen, rounds });
        self.rounds.truncate(best.effects.len());
        self.rounds.resize(best.effects.len(), Vec::new());
        if let Some(last) = self.rounds.last_mut() {
            last.retain(|candidate| !candidate.is_of(&best));
            // Its net gain is that of the best one without jumps in free run, plus the evidence for jumps in the position.
            let without = last.iter().map(|candidate| candidate.net).fold(0.0, f64::max);
            last.insert(0, trial(&best, without + jump_spacing.evidence));
        }
        self.chosen = best;
        Ok(())
    }

    /// Goes back to what was chosen before, where held-out recordings show no jumps of this length. Returns the stiction that is removed by this.
    pub(crate) fn without_unconfirmed_jumps(
        &mut self,
        held_out: &[&Prepared],
    ) -> Result<Option<&'static Hypothesis>, FitError> {
        let Some(jumps) = &self.jumps else { return Ok(None) };
        if jumps.found.jump_spacing.is_in(&jumps.following, held_out)? {
            return Ok(None);
        }
        let gone = self.chosen.effects.iter().find(|one| one.has(Parameter::StictionBand)).map(|one| one.effect);
        (self.chosen, self.rounds) = (jumps.chosen.clone(), jumps.rounds.clone());
        self.jumps = None;
        Ok(gone.filter(|gone| !self.chosen.has(gone)))
    }

    /// Whether an effect is the stiction whose jumps were found in the position.
    pub(crate) fn is_found_by_jumps(&self, effect: &Hypothesis) -> bool {
        let is_stiction = |one: &Chosen| one.effect.name == effect.name && one.has(Parameter::StictionBand);
        self.jumps.is_some() && self.chosen.effects.iter().any(is_stiction)
    }
}

/// The candidate models with a stiction that have the smallest misfit, refitted. They are selected by simulation alone: the instants of the jumps are
/// practically random, and what a refit gains is small compared with that.
fn nearest(
    question: &Question<'_>,
    less: &Question<'_>,
    following: &Candidate,
    effects: &[Chosen],
    tries: &[Sticks],
) -> Result<Vec<Candidate>, FitError> {
    let cases = || question.training.iter().copied().zip(following.fit.starts.iter().copied());
    let left = |sticks: &Sticks| {
        let values = [sticks.jumps().as_slice(), &[(Parameter::HysteresisWidth, sticks.width)]].concat();
        let residuals = softened_all(&with(&following.fit.machine, &values), cases())?;
        Ok::<_, FitError>((residuals.iter().flatten().map(|series| loss(series)).sum::<f64>(), *sticks))
    };
    let mut all: Vec<(f64, Sticks)> = parallel::try_each(tries, left)?;
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let refitted = |(_, sticks): &(f64, Sticks)| {
        let jumps = [following.jumps.as_slice(), &sticks.jumps()].concat();
        let values = [(Parameter::HysteresisWidth, sticks.width)];
        let Candidate { effects, fit, jumps, .. } =
            Candidate::given(less, effects.to_vec(), jumps, Some(&following.fit), &values)?;
        Candidate::of(question, effects, fit, jumps, false)
    };
    parallel::try_each(all.iter().take(REFITTED), refitted)
}

#[cfg(test)]
mod tests;
