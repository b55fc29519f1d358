//! The held-out recordings, opened once the training recordings have chosen: they may take an effect out of the choice, or veto it,
//! and never put one in.

use identification::experiment::Prepared;
use identification::fit::residuals::counts_from;
use identification::fit::{CHANCE, FitError, settle, softened, standardised};
use model_core::machine::{Machine, MachineError};
use recording::Signal;

use super::candidate::Question;
use super::forward::{FAR, Selection, enter};
use super::likelihood::{FORM, above_noise, accepts, gained};
use crate::catalogue::Hypothesis;
use crate::selection::valve::valve_first::gains_apart;

/// What the held-out recordings say of what they left of a choice.
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
    /// Whether they gain by it: in all and on at least half of the recordings, and no signal is clearly worse.
    #[must_use]
    pub fn gains(&self) -> bool {
        self.gains_in_all() && self.least_gain > -CHANCE.max(0.1 * self.gain)
    }

    /// Whether they gain by it in all and on at least half of the recordings, whatever becomes of one signal.
    fn gains_in_all(&self) -> bool {
        self.recordings > 0 && self.gain > 0.0 && 2 * self.improved >= self.recordings
    }

    /// Whether they confirm it: they gain, and the model follows no signal worse than its mean would.
    #[must_use]
    pub fn confirms(&self) -> bool {
        self.gains() && self.least_fit_percent > 0.0
    }
}

impl Selection {
    /// Takes out of a set of several every effect that held-out recordings gain nothing by beside the others, refitted without it
    /// to the training recordings; the last added first. A signal may get worse by as little as the forms of the others may be off:
    /// that is not the fault of the one in question. While the chain is far off, one may also gain on its own side of the slider.
    /// What is left has to be a claim by itself, else it goes as well: a pair may have been claimed because neither was enough
    /// alone. Those that were taken out.
    pub fn refused(
        &mut self,
        question: &Question<'_>,
        held_out: &[&Prepared],
    ) -> Result<Vec<&'static Hypothesis>, FitError> {
        let mut refused = Vec::new();
        if held_out.is_empty() {
            return Ok(refused);
        }
        refused.extend(self.unheard(held_out)?);
        for index in (0..self.chosen.effects.len()).rev() {
            if self.chosen.effects.len() == 1 {
                break;
            }
            let (fewer, effect) = (self.chosen.without(question, index)?, self.chosen.effects[index].effect);
            let (without, with) = (&fewer.fit.machine, &self.chosen.fit.machine);
            let is_hidden = self.chosen.worst_over_noise(question) > FAR;
            let told = confirm(without, with, held_out)?;
            let gains = told.gains()
                || (told.gains_in_all() && {
                    let left = |machine: &Machine<f64>| left(machine, held_out);
                    is_by_form(&left(&self.base.fit.machine)?, &left(without)?, &left(with)?)
                });
            let gains = gains || (is_hidden && gains_apart(question, &self.chosen, effect, held_out)?);
            if !(gains || self.is_heard(effect)) {
                refused.push(effect);
                self.chosen = fewer;
            }
        }
        if refused.is_empty() {
            return Ok(refused);
        }
        let is_heard = self.chosen.effects.iter().any(|one| self.is_heard(one.effect));
        let stands = || Ok::<_, FitError>(is_heard || accepts(question, &self.base, &self.base, &self.chosen)?);
        if self.chosen.is_plausible(question.scene) && stands()? {
            enter(question, &self.base, &mut self.rounds, &self.chosen);
        } else {
            refused.extend(self.chosen.effects.iter().map(|chosen| chosen.effect));
            self.chosen = self.base.clone();
        }
        Ok(refused)
    }
}

/// What a machine leaves above the noise on held-out recordings, by signal.
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

/// Whether no signal is worse with an effect than without it by more than the form of the others is off by, of what those explain of it over
/// the base.
fn is_by_form(base: &[(Signal, f64)], without: &[(Signal, f64)], with: &[(Signal, f64)]) -> bool {
    let signals = base.iter().zip(without).zip(with);
    signals
        .into_iter()
        .all(|(((_, base), (_, without)), (_, with))| with - without <= FORM * FORM * (base - without).max(0.0))
}

/// Adds to the sum of a signal.
fn add(signals: &mut Vec<(Signal, f64)>, signal: Signal, amount: f64) {
    match signals.iter_mut().find(|(known, _)| *known == signal) {
        Some((_, sum)) => *sum += amount,
        None => signals.push((signal, amount)),
    }
}

/// NRMSE fit, %, that a perfect model would reach on a signal that is mostly noise.
const MOSTLY_NOISE: f64 = 50.0;

/// What held-out recordings gain by a machine over a base.
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
        let start = settle(chosen, case)?;
        let (after, missed) = (softened(chosen, case, start)?, standardised(chosen, case, start)?);
        let mut total = 0.0;
        for ((channel, missed), (before, after)) in case.channels.iter().zip(&missed).zip(before.iter().zip(&after)) {
            let gain = gained(before, after, counts_from(case.stimulus.entry));
            total += gain;
            add(&mut signals, channel.signal, gain);
            // A signal that is mostly noise fits no better than its mean, whatever the model.
            if channel.noise_floor_percent() > MOSTLY_NOISE {
                least_fit_percent = least_fit_percent.min(channel.fit_percent(missed));
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
