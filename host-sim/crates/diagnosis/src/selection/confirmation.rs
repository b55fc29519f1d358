//! What held-out recordings gain by one machine over another.

use identification::experiment::Prepared;
use identification::fit::residuals::counts_from;
use identification::fit::{settle, softened, standardised};
use model_core::machine::{Machine, MachineError};
use recording::Signal;

use super::decision_rule::{
    FIT_ABOVE_PERCENT, MOSTLY_NOISE_PERCENT, ONE_GAINS_OF, SIGNAL_MAY_LOSE, SIGNAL_MAY_LOSE_SHARE,
};
use super::likelihood::gained;

/// What the held-out recordings say about a choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Confirmation {
    /// Log-likelihood gained over the base on all held-out recordings.
    pub gain: f64,
    /// The signal that gained least, over all held-out recordings.
    pub least_gain: f64,
    /// Lowest NRMSE fit of a signal with the effects, %.
    pub least_fit_percent: f64,
    /// Number of held-out recordings on which it gained.
    pub improved: usize,
    /// Number of held-out recordings.
    pub recordings: usize,
}

impl Confirmation {
    /// Whether they gain by it: in all and on at least half of the recordings, and no signal is clearly worse.
    #[must_use]
    pub fn gains(&self) -> bool {
        self.gains_in_all() && self.least_gain > -SIGNAL_MAY_LOSE.max(SIGNAL_MAY_LOSE_SHARE * self.gain)
    }

    /// Whether they gain by it in all and on at least half of the recordings, even if a single signal gets worse.
    pub(super) fn gains_in_all(&self) -> bool {
        self.recordings > 0 && self.gain > 0.0 && ONE_GAINS_OF * self.improved >= self.recordings
    }

    /// Whether they confirm it: they gain, and the model follows no signal worse than its mean would.
    #[must_use]
    pub fn confirms(&self) -> bool {
        self.gains() && self.least_fit_percent > FIT_ABOVE_PERCENT
    }
}

/// Adds an amount to the sum of a signal.
pub(super) fn add(signals: &mut Vec<(Signal, f64)>, signal: Signal, amount: f64) {
    match signals.iter_mut().find(|(known, _)| *known == signal) {
        Some((_, sum)) => *sum += amount,
        None => signals.push((signal, amount)),
    }
}

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
            let gain = gained(before, after, counts_from(case.stimulus.input_point));
            total += gain;
            add(&mut signals, channel.signal, gain);
            // A signal that is mostly noise fits no better than its mean, whatever the model.
            if channel.noise_floor_percent() > MOSTLY_NOISE_PERCENT {
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
