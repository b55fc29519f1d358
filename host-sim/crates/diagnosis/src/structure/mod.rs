//! Whether the structure of the model can be right at all: a linear model of second order on the same recordings is the yardstick.
//!
//! Such a model knows nothing of valves, pressures or cylinders. Where the machine's best model ends clearly below it, no value and no effect is to blame but
//! what the model is made of, and this module says what the recordings show of that ([`Shows`]).

mod uncommanded;

use identification::fit::loss;
use identification::yardstick::{Linear, Shape, Yardstick};
use model_core::machine::{Machine, Source};
use recording::Signal;
use simulation::InputPoint;

use crate::before_after::Shown;
use crate::selection::decision_rule::{BEYOND_PENALTY, LEAST_EXPLAINED};

pub use uncommanded::{SupplySag, Uncommanded};

/// The yardstick of the judged signals, and what speaks against the structure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Structure {
    /// Each signal's linear model.
    pub measured: Vec<Measured>,
    /// What drives the model; `None` without a recording.
    pub driven_by: Option<InputPoint>,
    /// What shows that the structure is wrong; empty where the machine's model does not end below a yardstick, or where nothing says why it does.
    pub shows: Vec<Shows>,
    /// Whether the supply pressure is recorded, or what other consumers take from it.
    pub knows_supply: bool,
}

/// The linear model of one signal beside the machine's.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Both linear models.
    pub yardstick: Yardstick,
    /// The one that follows the training recordings better.
    pub linear: Linear,
    /// Its NRMSE fit, mean over training recordings, %.
    pub training_percent: f64,
    /// The same over held-out recordings.
    pub held_out_percent: Option<f64>,
    /// Whether the machine's model ends clearly below it.
    pub is_better: bool,
}

/// What shows that the structure is wrong.
#[derive(Clone, Debug, PartialEq)]
pub enum Shows {
    /// The position follows what drives the model instead of integrating it.
    Follows {
        /// Where it comes to rest, m for one SI unit of the input.
        gain: f64,
        /// How long it takes to, s.
        settling_s: f64,
        /// Mean NRMSE fit of the linear model that follows, all recordings, %.
        follows_percent: f64,
        /// The same of the one that integrates.
        integrates_percent: f64,
    },
    /// The rod moves where the command does not open the valve, or against it.
    MovesUncommanded(Uncommanded),
    /// The supply pressure falls while the command is at neutral.
    SupplySags(SupplySag),
}

impl Structure {
    /// The linear models alone: where not every effect was tried, the structure is not blamed for what an effect may explain.
    pub(crate) fn unclaimed(self) -> Self {
        let measured = self.measured.into_iter().map(|measured| Measured { is_better: false, ..measured });
        Self { measured: measured.collect(), shows: Vec::new(), ..self }
    }

    /// The signal of which the machine's model ends clearly below the yardstick; the position first.
    #[must_use]
    pub fn below(&self) -> Option<&Measured> {
        self.measured.iter().find(|measured| measured.is_better)
    }

    /// Whether the position follows what drives the model.
    #[must_use]
    pub fn follows(&self) -> bool {
        self.shows.iter().any(|shows| matches!(shows, Shows::Follows { .. }))
    }
}

/// Compares the machine's model after the diagnosis with linear ones (of the training recordings, then the held-out ones), and looks for what shows a
/// wrong structure; `machine` is the nominal one, `supply_pa` each recording's supply pressure.
pub(crate) fn structure(
    linear: Vec<Yardstick>,
    shown: &[Shown],
    machine: &Machine<f64>,
    supply_pa: &[Option<&[f64]>],
) -> Structure {
    let training = shown.iter().take_while(|shown| !shown.held_out).count();
    let measured: Vec<Measured> =
        linear.into_iter().filter_map(|yardstick| measured(yardstick, shown, training)).collect();
    let driven_by = shown.first().map(|shown| shown.prepared.stimulus.input_point);
    // Only a valve's supply has a balance that they belong to.
    let takes_others = machine.source == Source::Valve;
    let knows_others = takes_others && shown.iter().any(|shown| shown.prepared.stimulus.knows_others());
    let knows_supply = knows_others || supply_pa.iter().any(Option::is_some);
    let mut shows = Vec::new();
    let below = measured.iter().find(|measured| measured.is_better && measured.yardstick.signal == Signal::Position);
    if let Some(measured) = below {
        shows.extend(follows(&measured.yardstick));
    }
    if driven_by == Some(InputPoint::Command) && (below.is_some() || is_hopeless(shown)) {
        // How late the rod is by a linear model, where that tells anything.
        let integrates = measured.iter().find_map(|measured| measured.yardstick.integrates.as_ref());
        let told = integrates.filter(|linear| linear.mean_fit_percent(0..training).unwrap_or(0.0) > LAG_TOLD_PERCENT);
        let lag_s = told.map_or(0.0, |linear| linear.shape.settling_s() + linear.delay_s);
        let (moves, sags) = uncommanded::look(shown, machine, lag_s, supply_pa);
        shows.extend(moves.map(Shows::MovesUncommanded));
        shows.extend(sags.map(Shows::SupplySags));
    }
    Structure { measured, driven_by, shows, knows_supply }
}

/// A linear model below this fit tells no lag: where the rod is moved by something else, it blames a lag for it. Chosen.
const LAG_TOLD_PERCENT: f64 = 80.0;
/// A model below this fit leaves more than half of a signal's variation (RMS): chosen.
const HOPELESS_PERCENT: f64 = 50.0;

/// Whether the machine's model leaves more than half of the position's variation (RMS) in recordings of either kind.
fn is_hopeless(shown: &[Shown]) -> bool {
    [false, true].into_iter().any(|held_out| {
        let of_kind = shown.iter().filter(|shown| shown.held_out == held_out);
        let fits: Vec<f64> = of_kind
            .flat_map(|shown| shown.fits(true))
            .filter(|fit| fit.signal == Signal::Position)
            .map(|fit| fit.nrmse_percent)
            .collect();
        !fits.is_empty() && fits.iter().sum::<f64>() / (fits.len() as f64) < HOPELESS_PERCENT
    })
}

fn measured(yardstick: Yardstick, shown: &[Shown], training: usize) -> Option<Measured> {
    let linear = yardstick.better(training).clone();
    let training_percent = linear.mean_fit_percent(0..training)?;
    let held_out_percent = linear.mean_fit_percent(training..shown.len());
    let pairs: Vec<Option<(Vec<f64>, Vec<f64>)>> = linear
        .runs
        .iter()
        .zip(shown)
        .map(|(run, shown)| {
            let run = run.as_ref()?;
            let channel = shown.prepared.channels.iter().find(|channel| channel.signal == yardstick.signal)?;
            let simulated = shown.after.signal(yardstick.signal)?;
            let missed = |&row: &usize| {
                if channel.failed[row] { 0.0 } else { channel.recorded[row] - simulated[row] }
            };
            Some(shares((run.rows.iter().map(missed).collect(), run.missed.clone()), run.spread))
        })
        .collect();
    let (trained, held) = pairs.split_at(training.min(pairs.len()));
    let kept = |pairs: &[Option<(Vec<f64>, Vec<f64>)>]| -> Vec<(Vec<f64>, Vec<f64>)> {
        pairs.iter().flatten().cloned().collect()
    };
    let (trained, held) = (kept(trained), kept(held));
    let all = [trained.as_slice(), &held].concat();
    let is_better =
        takes_half(&trained) && (held.is_empty() || takes_half(&held)) && log_likelihood(&all) > BEYOND_PENALTY;
    Some(Measured { yardstick, linear, training_percent, held_out_percent, is_better })
}

/// As shares of the recording's own variation, as an NRMSE fit has it: a recording in which the rod goes far counts no more than another.
fn shares((one, other): (Vec<f64>, Vec<f64>), spread: f64) -> (Vec<f64>, Vec<f64>) {
    let share = |missed: Vec<f64>| missed.into_iter().map(|missed| missed / spread).collect();
    (share(one), share(other))
}

/// What two models miss of the same rows, recording by recording: of one, and of the other that may be better.
type Pairs = [(Vec<f64>, Vec<f64>)];

/// Whether the other model leaves at most half of the square error of the one.
fn takes_half(pairs: &Pairs) -> bool {
    let (one, other) = squares(pairs);
    other < LEAST_EXPLAINED * one
}

fn squares(pairs: &Pairs) -> (f64, f64) {
    pairs.iter().fold((0.0, 0.0), |(one, other), pair| (one + loss(&pair.0), other + loss(&pair.1)))
}

/// Log-likelihood that the other model gains: half the logarithm of the ratio of mean squares, for each independent square.
fn log_likelihood(pairs: &Pairs) -> f64 {
    let (one, other) = squares(pairs);
    let independent: f64 = pairs.iter().map(|(one, _)| independent_squares(one)).sum();
    0.5 * independent * libm::log(one / other)
}

/// How many independent ones a mean square of a series is worth: squares of a series whose neighbours are correlated by r are correlated by r².
fn independent_squares(series: &[f64]) -> f64 {
    let lagged: f64 = series.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let square = loss(series);
    let count = series.len() as f64;
    let r = if square > 0.0 { (lagged / square).clamp(0.0, 1.0) } else { 0.0 };
    (count * (1.0 - r * r) / (1.0 + r * r)).max(1.0)
}

/// Whether the position follows what drives the model: the linear model that follows leaves at most half of the square error of the one that integrates, by
/// more than chance.
pub(crate) fn follows(yardstick: &Yardstick) -> Option<Shows> {
    let integrates = yardstick.integrates.as_ref()?;
    let follows = &yardstick.follows;
    let pairs: Vec<(Vec<f64>, Vec<f64>)> = integrates
        .runs
        .iter()
        .zip(&follows.runs)
        .filter_map(|(one, other)| {
            let (one, other) = (one.as_ref()?, other.as_ref()?);
            Some(shares((one.missed.clone(), other.missed.clone()), one.spread))
        })
        .collect();
    let (all, longest_s) = (0..follows.runs.len(), longest_s(follows));
    let settling_s = follows.shape.settling_s();
    // One more value: the time in which it comes to rest.
    let penalty = 0.5 * libm::log(pairs.iter().map(|(one, _)| independent_squares(one)).sum::<f64>()).max(0.0);
    let is_by_far = takes_half(&pairs) && log_likelihood(&pairs) > penalty + BEYOND_PENALTY;
    // What comes to rest later than any recording lasts, integrates as far as these tell; or it rings by itself, whatever the command is.
    let rests = settling_s.max(follows.shape.decay_s()) <= longest_s;
    if !is_by_far || !matches!(follows.shape, Shape::Follows { .. }) || !rests {
        return None;
    }
    Some(Shows::Follows {
        gain: *follows.gains.first()?,
        settling_s,
        follows_percent: follows.mean_fit_percent(all.clone())?,
        integrates_percent: integrates.mean_fit_percent(all)?,
    })
}

/// The longest of the recordings that a linear model ran in, s.
fn longest_s(linear: &Linear) -> f64 {
    linear.runs.iter().flatten().map(|run| run.duration_s).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
