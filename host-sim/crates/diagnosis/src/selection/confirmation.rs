//! What held-out recordings gain by one machine over another.

use identification::experiment::Prepared;
use identification::fit::residuals::counts_from;
use identification::fit::{Misfit, Residuals, misfits, misfits_of, settle, soften, standardised};
use model_core::machine::MachineError;
use recording::Signal;

use super::candidate::Candidate;
use super::decision_rule::{
    FIT_ABOVE_PERCENT, LOST_FROM, MISSED_FROM, MOSTLY_NOISE_PERCENT, ONE_GAINS_OF, PROMISE_KEPT, PROMISES_HALF,
    SIGNAL_MAY_LOSE, SIGNAL_MAY_LOSE_SHARE,
};
use super::likelihood::gained;

/// What the held-out recordings say about a choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Confirmation {
    /// Log-likelihood gained over the base on all held-out recordings.
    pub gain: f64,
    /// Of the signals that the model misses with the effects, the one that gained least, over all held-out recordings; infinite where it misses none.
    pub least_gain: f64,
    /// RMSE over noise of the spool with the effects; 0 where no sensor shows it.
    pub spool: f64,
    /// Lowest NRMSE fit of a signal with the effects, %.
    pub least_fit_percent: f64,
    /// Number of held-out recordings on which it gained.
    pub improved: usize,
    /// Number of held-out recordings.
    pub recordings: usize,
    /// How far the squared error falls in training by the effects: the mean over the signals of ln(before/after).
    pub promised: f64,
    /// The same on the held-out recordings.
    pub kept: f64,
    /// Of the signals that are far off on the held-out recordings with the effects, though training promised half of their error, the least share of
    /// that promise which half of the recordings keep; infinite where there is none.
    pub least_kept: f64,
}

impl Confirmation {
    /// Whether they gain by it: in all and on at least half of the recordings, and no signal that is missed then is clearly worse.
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

    /// Whether the error falls on them far enough, compared with training: in all signals together, and in each that is far off.
    #[must_use]
    pub fn keeps_promise(&self) -> bool {
        self.kept >= PROMISE_KEPT * self.promised && self.least_kept >= PROMISE_KEPT
    }
}

/// Squared error over noise² in each signal, over all recordings together, and no less than that of noise alone.
fn squares(misfits: &[Misfit]) -> Vec<f64> {
    misfits.iter().map(|misfit| misfit.mean_square().max(1.0)).collect()
}

/// How far the squared error falls from one model to another: mean of the signals' logarithmic ratios, so that no signal counts for more than another.
fn fall(before: &[f64], after: &[f64]) -> f64 {
    let ratios: f64 = before.iter().zip(after).map(|(before, after)| libm::log(before / after)).sum();
    ratios / before.len().max(1) as f64
}

/// What a candidate model leaves of each signal in training.
fn left_in(training: &[&Prepared], candidate: &Candidate) -> Result<Vec<Misfit>, MachineError> {
    let starts = candidate.fit.starts.iter().copied();
    misfits(&candidate.fit.machine, training.iter().copied().zip(starts))
}

/// Misfits without and with the effects.
type Falls<'a> = [&'a [Misfit]; 2];

/// [`Confirmation::least_kept`]: of what falls in training, what falls on held-out recordings, of which all together and each by itself are given.
///
/// Recordings are judged one by one, as by [`ONE_GAINS_OF`]: where a rod begins to stick and slip by itself, the right model may do so a moment too late, and
/// what follows is as large an error as no model would make.
fn least_kept(trained: Falls<'_>, with: &[Misfit], held_out: &[[Vec<Misfit>; 2]]) -> f64 {
    let of = |misfits: &[Misfit], signal| misfits.iter().find(|misfit| misfit.signal == signal).copied();
    let fallen = |before: Misfit, after: Misfit| fall(&squares(&[before]), &squares(&[after]));
    let is_far = |misfit: &Misfit| misfit.mean_square().sqrt() > LOST_FROM;
    let kept_of = |signal: Signal| {
        let promised = fallen(of(trained[0], signal)?, of(trained[1], signal)?);
        let shown = held_out.iter().filter_map(|[before, after]| Some((of(before, signal)?, of(after, signal)?)));
        let shown = shown.filter(|(before, after)| is_far(before) || is_far(after));
        let mut shares: Vec<f64> = shown.map(|(before, after)| fallen(before, after) / promised).collect();
        shares.sort_by(|one, other| other.total_cmp(one));
        let enough = shares.len().div_ceil(ONE_GAINS_OF).checked_sub(1)?;
        (promised > PROMISES_HALF).then_some(shares[enough])
    };
    with.iter()
        .filter(|misfit| is_far(misfit))
        .filter_map(|misfit| kept_of(misfit.signal))
        .fold(f64::INFINITY, f64::min)
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
    let missed = |candidate: &Candidate| -> Result<Residuals, MachineError> {
        let machine = &candidate.fit.machine;
        held_out.iter().map(|case| standardised(machine, case, settle(machine, case)?)).collect()
    };
    let (missed_without, missed_with) = (missed(without)?, missed(with)?);
    let mut improved = 0;
    let mut signals: Vec<(Signal, f64)> = Vec::new();
    let mut least_fit_percent = 100.0_f64;
    for (case, (before, missed)) in held_out.iter().zip(missed_without.iter().zip(&missed_with)) {
        let (mut before, mut after) = (before.clone(), missed.clone());
        soften(case, &mut before);
        soften(case, &mut after);
        let mut total = 0.0;
        for ((channel, missed), (before, after)) in case.channels.iter().zip(missed).zip(before.iter().zip(&after)) {
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
    let left = |missed: &Residuals| misfits_of(held_out.iter().copied(), missed);
    let (left_without, left_with) = (left(&missed_without), left(&missed_with));
    let each = |missed: &Residuals, index: usize| misfits_of([held_out[index]], &missed[index..=index].to_vec());
    let one_by_one = |index| [each(&missed_without, index), each(&missed_with, index)];
    let one_by_one: Vec<[Vec<Misfit>; 2]> = (0..held_out.len()).map(one_by_one).collect();
    let off = |misfit: &Misfit| misfit.mean_square().sqrt();
    let is_missed = |signal| left_with.iter().any(|misfit| misfit.signal == signal && off(misfit) > MISSED_FROM);
    let gains_of_missed = signals.iter().filter(|(signal, _)| is_missed(*signal)).map(|(_, gain)| *gain);
    let (trained_without, trained_with) = (left_in(training, without)?, left_in(training, with)?);
    Ok(Confirmation {
        gain: signals.iter().map(|(_, gain)| gain).sum(),
        least_gain: gains_of_missed.fold(f64::INFINITY, f64::min),
        spool: left_with.iter().filter(|misfit| misfit.signal == Signal::Spool).map(off).fold(0.0, f64::max),
        least_fit_percent,
        improved,
        recordings: held_out.len(),
        promised: fall(&squares(&trained_without), &squares(&trained_with)),
        kept: fall(&squares(&left_without), &squares(&left_with)),
        least_kept: least_kept([&trained_without, &trained_with], &left_with, &one_by_one),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Held-out recordings that gain, on which the squared error of one signal falls to these shares in training and there.
    fn falling_to(training: f64, held_out: f64) -> Confirmation {
        let fallen = |share: f64| fall(&[1.0], &[share]);
        Confirmation {
            gain: 50.0,
            least_gain: 50.0,
            spool: 0.0,
            least_fit_percent: 90.0,
            improved: 1,
            recordings: 2,
            promised: fallen(training),
            kept: fallen(held_out),
            least_kept: f64::INFINITY,
        }
    }

    #[test]
    fn what_gains_but_keeps_little_of_its_promise_is_not_confirmed() {
        // In training 60 % of the error is gone, on the held-out recordings 5 %.
        assert!(falling_to(0.4, 0.95).gains() && !falling_to(0.4, 0.95).confirms());
        assert!(falling_to(0.4, 0.7).confirms());
        // The signals together keep it, and the one that is far off does not.
        assert!(!Confirmation { least_kept: 0.1, ..falling_to(0.4, 0.7) }.confirms());
        // 654 times the noise become 620.
        assert!(!falling_to(0.4, (620.0_f64 / 654.0).powi(2)).confirms());
    }

    #[test]
    fn a_signal_that_is_far_off_keeps_its_own_promise() {
        let misfit = |signal, noises: f64| Misfit { signal, square: 100.0 * noises * noises, rows: 100.0 };
        let both = |pressure, position| [misfit(Signal::PressureA, pressure), misfit(Signal::Position, position)];
        let trained = [both(12.0, 14.0), both(2.0, 2.8)];
        let all = |each: &[[[Misfit; 2]; 2]]| {
            let each: Vec<[Vec<Misfit>; 2]> = each.iter().map(|one| one.map(Vec::from)).collect();
            let sum = |index: usize| each.iter().map(|one| one[1][index].square).sum::<f64>();
            let of_all =
                |index: usize| Misfit { square: sum(index), rows: 100.0 * each.len() as f64, ..each[0][1][index] };
            least_kept([&trained[0], &trained[1]], &[of_all(0), of_all(1)], &each)
        };
        let kept = |one: [[Misfit; 2]; 2]| all(&[one]);
        assert!(kept([both(11.0, 47.7), both(3.0, 47.8)]).abs() < 0.01, "the position keeps nothing");
        assert!((kept([both(11.0, 70.0), both(3.0, 14.0)]) - 1.0).abs() < 0.01);
        assert!(kept([both(11.0, 3.9), both(3.0, 3.9)]).is_infinite(), "nothing is far off");
        // One recording in which the rod sticks and slips at other moments, beside one that is followed: the promise is kept in half of them.
        let (follows, out_of_step) = ([both(11.0, 70.0), both(3.0, 14.0)], [both(11.0, 60.0), both(3.0, 55.0)]);
        assert!((all(&[follows, out_of_step]) - 1.0).abs() < 0.01);
        assert!(all(&[follows, out_of_step, out_of_step]) < 0.1, "one of three is not half of them");
        // A recording that hardly shows it says nothing for it.
        assert!(all(&[[both(3.0, 3.0), both(1.0, 1.0)], out_of_step]) < 0.1);
        // Nor does it excuse one that gets worse.
        assert!(all(&[[both(11.0, 2.0), both(3.0, 20.0)], out_of_step]) < 0.1);
    }
}
