//! What held-out recordings gain by one machine over another.

use identification::experiment::Prepared;
use identification::fit::residuals::counts_from;
use identification::fit::{loss, settle, softened, standardised};
use model_core::machine::MachineError;
use recording::Signal;

use super::candidate::Candidate;
use super::decision_rule::{
    AT_NOISE, FEW_RECORDINGS, FIT_ABOVE_PERCENT, MOSTLY_NOISE_PERCENT, ONE_GAINS_OF, PROMISE_KEPT, RECORDINGS_EXCUSED,
    SIGNAL_MAY_LOSE, SIGNAL_MAY_LOSE_SHARE,
};
use super::likelihood::gained;

/// What the held-out recordings say about a choice.
#[derive(Clone, Debug, PartialEq)]
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
    /// Share of the misfit above noise that the effects take away in training.
    pub promised: f64,
    /// The same of each held-out recording on which the base misses more than noise.
    pub explained: Vec<f64>,
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

    /// Whether they confirm it: they gain what was promised, and the model follows no signal worse than its mean would.
    #[must_use]
    pub fn confirms(&self) -> bool {
        self.gains_as_promised() && self.least_fit_percent > FIT_ABOVE_PERCENT
    }

    /// Whether they gain by it, and as much as was promised.
    #[must_use]
    pub fn gains_as_promised(&self) -> bool {
        self.gains() && self.keeps_promise()
    }

    /// Whether it explains there what it explains of the training recordings: on each recording that has something to explain, but one of many.
    #[must_use]
    pub fn keeps_promise(&self) -> bool {
        let broken = self.explained.iter().filter(|explained| **explained < PROMISE_KEPT * self.promised).count();
        broken <= if self.explained.len() > FEW_RECORDINGS { RECORDINGS_EXCUSED } else { 0 }
    }
}

/// Squares of the residuals over noise beyond those of noise alone, at least 0, of all signals; and whether any signal is above its noise.
fn above_noise(residuals: &[Vec<f64>]) -> (f64, bool) {
    let each =
        || residuals.iter().filter(|series| !series.is_empty()).map(|series| (loss(series), series.len() as f64));
    let is_above = each().any(|(square, rows)| square > AT_NOISE * AT_NOISE * rows);
    (each().map(|(square, rows)| (square - rows).max(0.0)).sum(), is_above)
}

/// The share of the misfit above noise that one model takes away from another; 0 where there is none.
fn explained(before: f64, after: f64) -> f64 {
    if before > 0.0 { 1.0 - after / before } else { 0.0 }
}

/// What a candidate model promises over one with fewer effects.
fn promised(without: &Candidate, with: &Candidate, training: &[&Prepared]) -> Result<f64, MachineError> {
    let left = |candidate: &Candidate| -> Result<f64, MachineError> {
        let cases = training.iter().zip(&candidate.fit.starts);
        let all = cases.map(|(case, start)| standardised(&candidate.fit.machine, case, *start));
        all.map(|residuals| Ok(above_noise(&residuals?).0)).sum()
    };
    Ok(explained(left(without)?, left(with)?))
}

/// Adds an amount to the sum of a signal.
pub(super) fn add(signals: &mut Vec<(Signal, f64)>, signal: Signal, amount: f64) {
    match signals.iter_mut().find(|(known, _)| *known == signal) {
        Some((_, sum)) => *sum += amount,
        None => signals.push((signal, amount)),
    }
}

/// What held-out recordings gain by a candidate model over one with fewer effects, both fitted to the training recordings.
pub fn confirm(
    without: &Candidate,
    with: &Candidate,
    training: &[&Prepared],
    held_out: &[&Prepared],
) -> Result<Confirmation, MachineError> {
    let (base, chosen) = (&without.fit.machine, &with.fit.machine);
    let mut improved = 0;
    let mut signals: Vec<(Signal, f64)> = Vec::new();
    let mut least_fit_percent = 100.0_f64;
    let mut shares = Vec::new();
    for case in held_out {
        let (from, start) = (settle(base, case)?, settle(chosen, case)?);
        let (missed_before, missed) = (standardised(base, case, from)?, standardised(chosen, case, start)?);
        let (before, after) = (softened(base, case, from)?, softened(chosen, case, start)?);
        let (misfit, is_above) = above_noise(&missed_before);
        if is_above {
            shares.push(explained(misfit, above_noise(&missed).0));
        }
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
        promised: promised(without, with, training)?,
        explained: shares,
    })
}
