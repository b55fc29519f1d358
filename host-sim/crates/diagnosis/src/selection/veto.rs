//! The held-out recordings, opened after the choice on the training recordings: they may remove an effect from the choice, or veto it, but never add
//! one.

use identification::experiment::Prepared;
use identification::fit::{FitError, settle, softened};
use model_core::machine::{Machine, MachineError};
use recording::Signal;

use super::candidate::Question;
use super::confirmation::{Confirmation, add, confirm};
use super::decision_rule::{OWN_SIDE_FROM, WORSE_BY_EQUATIONS};
use super::likelihood::{above_noise, accepts};
use super::outcome::Selection;
use super::round::enter;
use crate::catalogue::Hypothesis;
use crate::selection::valve::valve_first::gains_on_own_side;

impl Selection {
    /// Removes from a chosen candidate model with several effects every effect by which held-out recordings gain nothing beside the others, compared
    /// with a refit without it to the training recordings; the last added is tried first. A signal may get worse within the form error of the other
    /// effects: that is not the fault of the one in question. While the whole model is far off, an effect may also gain on its own side of the spool.
    /// What is left has to be acceptable by itself, else it is removed as well: a pair may have been accepted because neither effect was enough
    /// alone. Returns the removed effects.
    pub fn refused(
        &mut self,
        question: &Question<'_>,
        held_out: &[&Prepared],
    ) -> Result<Vec<&'static Hypothesis>, FitError> {
        let mut refused = Vec::new();
        if held_out.is_empty() {
            return Ok(refused);
        }
        refused.extend(self.without_unconfirmed_jumps(held_out)?);
        for index in (0..self.chosen.effects.len()).rev() {
            if self.chosen.effects.len() == 1 {
                break;
            }
            let (fewer, effect) = (self.chosen.without(question, index)?, self.chosen.effects[index].effect);
            let (without, with) = (&fewer.fit.machine, &self.chosen.fit.machine);
            let is_hidden = self.chosen.worst_over_noise(question) > OWN_SIDE_FROM;
            let told = confirm(&fewer, &self.chosen, question.training, held_out)?;
            let gains = told.gains()
                || (told.gains_in_all() && {
                    let left = |machine: &Machine<f64>| left(machine, held_out);
                    is_by_form(&left(&self.base.fit.machine)?, &left(without)?, &left(with)?)
                });
            let is_there = question.scene.held.iter().any(|held| held.name == effect.name);
            let gains = gains && (is_there || told.keeps_promise());
            let gains = gains || (is_hidden && gains_on_own_side(question, &self.chosen, effect, held_out)?);
            if !(gains || self.is_found_by_jumps(effect)) {
                refused.push(effect);
                self.chosen = fewer;
            }
        }
        if refused.is_empty() {
            return Ok(refused);
        }
        let is_found_by_jumps = self.chosen.effects.iter().any(|one| self.is_found_by_jumps(one.effect));
        let stands =
            || Ok::<_, FitError>(is_found_by_jumps || accepts(question, &self.base, &self.base, &self.chosen)?);
        if self.chosen.is_plausible(question) && stands()? {
            enter(question, &self.base, &mut self.rounds, &self.chosen);
        } else {
            refused.extend(self.chosen.effects.iter().map(|chosen| chosen.effect));
            self.chosen = self.base.clone();
        }
        Ok(refused)
    }
}

/// Whether held-out recordings gain by each effect of a choice on its own side of the recorded spool, where the spool itself is far off in them: what the
/// valve misses hides what the effects take away below it.
pub(crate) fn stands_on_own_sides(
    question: &Question<'_>,
    selection: &Selection,
    told: &Confirmation,
    held_out: &[&Prepared],
) -> Result<bool, FitError> {
    if told.spool <= OWN_SIDE_FROM || !told.gains_in_all() {
        return Ok(false);
    }
    for one in &selection.chosen.effects {
        if !gains_on_own_side(question, &selection.chosen, one.effect, held_out)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Misfit above noise of a machine on held-out recordings, by signal.
fn left(machine: &Machine<f64>, held_out: &[&Prepared]) -> Result<Vec<(Signal, f64)>, MachineError> {
    let mut signals = Vec::new();
    for case in held_out {
        let residuals = softened(machine, case, settle(machine, case)?)?;
        for (channel, series) in case.channels.iter().zip(&residuals) {
            add(&mut signals, channel.signal, above_noise(series));
        }
    }
    Ok(signals)
}

/// Whether no signal gets worse with the effect by more than the form error of the other effects, a share of what those explain of the signal over
/// the base.
fn is_by_form(base: &[(Signal, f64)], without: &[(Signal, f64)], with: &[(Signal, f64)]) -> bool {
    let signals = base.iter().zip(without).zip(with);
    signals
        .into_iter()
        .all(|(((_, base), (_, without)), (_, with))| with - without <= WORSE_BY_EQUATIONS * (base - without).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_may_get_worse_by_a_hundredth_of_what_the_other_effects_explain_of_it() {
        let sums = |supply, position| [(Signal::SupplyPressure, supply), (Signal::Position, position)];
        let (base, without) = (sums(540_000.0, 520_000.0), sums(8_000.0, 280_000.0));
        assert!(is_by_form(&base, &without, &sums(13_300.0, 107_000.0)));
        assert!(!is_by_form(&base, &without, &sums(13_400.0, 107_000.0)));
        // Where the others explain nothing, nothing may get worse.
        assert!(!is_by_form(&sums(8_000.0, 520_000.0), &without, &sums(8_001.0, 107_000.0)));
    }
}
