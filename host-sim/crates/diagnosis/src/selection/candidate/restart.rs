//! Refits from elsewhere: a search that has ended where none comes back begins again from other values, and the better end is taken.

use identification::fit::{FitError, coarse, other_structure};
use identification::parallel;
use model_core::machine::Parameter;
use recording::Signal;

use super::refit::{Beginning, Goes};
use super::{Candidate, Chosen, EffectParameter, Question, effect_parameters};
use crate::catalogue::{Form, Subsystem};

/// A refit at twice the tick may lose this many times what it loses once it is refitted to the end.
const MAY_COME_BELOW: f64 = 2.0;

impl Candidate {
    /// The candidate model after a refit to the end, refitted once more if that lowers the loss. An amount that vanished beside others has no
    /// derivative that leads back, nor has an effect parameter at an end of its admissible range: the middle of the range is tried.
    pub fn unstuck(self, question: &Question<'_>) -> Result<Self, FitError> {
        let lost: Vec<(Parameter, f64)> =
            self.vanished(question.scene).into_iter().chain(self.stranded(question.scene)).collect();
        let again = if lost.is_empty() { self } else { self.or_from(question, &lost)? };
        let again = again.or_of_other_valve(question)?;
        // Where much is free, a model without the effect leads the base parameters to places from which no search comes back.
        let astray = |candidate: &Self| candidate.is_pulled(question) && question.has_tolerances();
        if !astray(&again) {
            return Ok(again);
        }
        let found = again.or_from_nominal(question, again.effects.clone())?;
        if astray(&found) { found.or_elsewhere(question) } else { Ok(found) }
    }

    /// This candidate model, or the best one that a refit reaches from more or less of its effects, again and again while that lowers the loss. What a recording gains
    /// is mostly told by when the rod stops and turns, and derivatives do not show that another value would let it stop at another time.
    pub(super) fn or_with_more_or_less(self, question: &Question<'_>) -> Result<Self, FitError> {
        /// Further than neighbouring ends lie apart, and near enough to come back from.
        const BY: [f64; 4] = [0.6, 0.85, 1.18, 1.7];
        /// Falls of the loss below this share are not another end.
        const LESS: f64 = 1e-3;
        /// Rounds of it.
        const MOST: usize = 3;
        let rounds = if question.is_whitened() && !self.effects.is_empty() { MOST } else { 0 };
        let mut best = self;
        for _ in 0..rounds {
            let amounts = effect_parameters(&best.effects).into_iter().filter(EffectParameter::is_amount);
            let amounts: Vec<Parameter> = amounts.map(|one| one.parameter).collect();
            let from = |by: &f64| {
                // Where it is a dry friction, that and the viscous one brake as much together as before.
                let less = (Parameter::ViscousFriction, best.fit.machine.get(Parameter::ViscousFriction) / by);
                let values = amounts.iter().map(|&one| (one, by * best.fit.machine.get(one))).chain([less]);
                best.again_from(question, &values.collect::<Vec<_>>())
            };
            let found = parallel::try_each(&BY, from)?;
            let Some(found) = found.into_iter().min_by(|a, b| a.fit.loss.total_cmp(&b.fit.loss)) else { break };
            let is_another = found.fit.loss < (1.0 - LESS) * best.fit.loss;
            if found.fit.loss < best.fit.loss {
                best = found;
            }
            if !is_another {
                break;
            }
        }
        Ok(best)
    }

    /// This candidate model, or the one with another form of one of its effects that presses against the end of its tolerance beside it, if its loss is
    /// smaller: of two pressure sensors the wrong one was taken.
    fn or_elsewhere(self, question: &Question<'_>) -> Result<Self, FitError> {
        let mut best = self;
        for index in 0..best.effects.len() {
            let Some(&Chosen { effect, form }) = best.effects.get(index) else { continue };
            let others: Vec<Form> =
                effect.forms_in(question.scene).filter(|other| other.as_ptr() != form.as_ptr()).collect();
            for form in others {
                if best.presses(question, effect, form) {
                    let mut effects = best.effects.clone();
                    effects[index] = Chosen { effect, form };
                    best = best.or_from_nominal(question, effects)?;
                }
            }
        }
        Ok(best)
    }

    /// This candidate model, or the one with the other structure of the valve, if its loss is smaller. A spool that plays or sticks makes the structure
    /// look like the other one while it is not known to do so, and from there no search comes back.
    fn or_of_other_valve(self, question: &Question<'_>) -> Result<Self, FitError> {
        let is_of_valve = |chosen: &Chosen| chosen.effect.subsystem == Subsystem::Valve;
        let is_judged = question.scene.judged.contains(&Signal::Spool);
        if !is_judged || !self.effects.iter().any(is_of_valve) || !self.misses_by_more_than_noise(question) {
            return Ok(self);
        }
        let Some(other) = other_structure(&self.fit.machine, question.base_parameters) else { return Ok(self) };
        self.or_nearly_from(question, self.effects.clone(), &[other])
    }

    /// This candidate model, or the one that a refit with these effects from the nominal base parameters ends at, if its loss is smaller.
    fn or_from_nominal(&self, question: &Question<'_>, effects: Vec<Chosen>) -> Result<Self, FitError> {
        self.or_nearly_from(question, effects, &question.nominal())
    }

    /// This candidate model, or the one that a refit with these effects from these values ends at, if its loss is smaller. That refit goes to the end
    /// only where it comes near this one's loss.
    fn or_nearly_from(
        &self,
        question: &Question<'_>,
        effects: Vec<Chosen>,
        values: &[(Parameter, f64)],
    ) -> Result<Self, FitError> {
        let coarser = coarse(question.training, &self.fit.machine, &self.fit.starts)?;
        let from = Beginning { fit: &self.fit, values, settled: &[], goes: Goes::Nearly(&coarser) };
        let near = Self::refitted(question, effects, self.jumps.clone(), &from)?;
        if near.fit.loss >= MAY_COME_BELOW * self.fit.loss {
            return Ok(self.clone());
        }
        let again = near.again_from(question, &[])?;
        Ok(if again.fit.loss < self.fit.loss { again } else { self.clone() })
    }

    /// This candidate model, or the one that a refit from these values of some of its parameters ends at, if its loss is smaller.
    fn or_from(self, question: &Question<'_>, values: &[(Parameter, f64)]) -> Result<Self, FitError> {
        let again = self.again_from(question, values)?;
        Ok(if again.fit.loss < self.fit.loss { again } else { self })
    }
}
