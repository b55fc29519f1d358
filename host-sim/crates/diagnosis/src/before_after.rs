//! Every recording with its simulations, for whoever shows the diagnosis, and how closely they follow.

use std::collections::BTreeMap;

use rayon::prelude::*;

use identification::experiment::Prepared;
use identification::fit::{Fit, StartState, settle};
use model_core::machine::{Machine, MachineError};
use recording::Signal;
use simulation::figures_of_merit::SignalFit;
use simulation::{Trajectory, simulate_f64};

use crate::diagnose::Diagnosis;

/// Signals of one recording: recorded, and simulated before and after.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The recording, prepared.
    pub prepared: Prepared,
    /// Whether it was held out.
    pub held_out: bool,
    /// Simulated with refitted ordinary parameters.
    pub before: Trajectory,
    /// Simulated with the effects as well; the same as before if nothing is claimed.
    pub after: Trajectory,
}

/// Mean NRMSE fit of each signal over recordings, %.
pub type Fits = BTreeMap<&'static str, f64>;

/// All recordings by the models before and after, from the fitted starts; held-out ones have none.
pub(crate) fn show_all(
    trained: Vec<Prepared>,
    held: Vec<Prepared>,
    before: &Fit,
    after: &Fit,
) -> Result<Vec<Shown>, MachineError> {
    let starts = before.starts.iter().zip(&after.starts).map(|(&before, &after)| Some((before, after)));
    let together: Vec<_> = trained.into_iter().zip(starts).chain(held.into_iter().map(|case| (case, None))).collect();
    together.into_par_iter().map(|(prepared, starts)| show(prepared, starts, &before.machine, &after.machine)).collect()
}

/// Simulates before and after, from the fitted starts; a held-out recording has none and starts from what suits each best.
fn show(
    prepared: Prepared,
    starts: Option<(StartState, StartState)>,
    before: &Machine<f64>,
    after: &Machine<f64>,
) -> Result<Shown, MachineError> {
    let (from_before, from_after) = match starts {
        Some(starts) => starts,
        None => (settle(before, &prepared)?, settle(after, &prepared)?),
    };
    Ok(Shown {
        held_out: starts.is_none(),
        before: simulate_f64(before, &prepared.stimulus, from_before.offset(before, &prepared))?,
        after: simulate_f64(after, &prepared.stimulus, from_after.offset(after, &prepared))?,
        prepared,
    })
}

impl Shown {
    /// Fit of each judged signal before or after, but for the rows where its sensor failed.
    pub fn fits(&self, after: bool) -> impl Iterator<Item = SignalFit> + '_ {
        let trajectory = if after { &self.after } else { &self.before };
        self.prepared.channels.iter().filter_map(move |channel| {
            let simulated = trajectory.signal(channel.signal)?;
            let kept = |series: &[f64]| -> Vec<f64> {
                series.iter().zip(&channel.failed).filter(|(_, failed)| !**failed).map(|(value, _)| *value).collect()
            };
            let (time_s, recorded) = (kept(&self.prepared.time_s), kept(&channel.recorded));
            Some(SignalFit::of(channel.signal, &time_s, &recorded, &kept(simulated)))
        })
    }
}

impl Diagnosis {
    /// Mean NRMSE fit of each signal, before or after, on training or held-out recordings.
    #[must_use]
    pub fn mean_fits(&self, held_out: bool, after: bool) -> Fits {
        let fits = self.of(held_out).flat_map(|shown| shown.fits(after)).map(|fit| (fit.signal, fit.nrmse_percent));
        mean(fits)
    }

    /// Mean NRMSE fit that a perfect model would reach on held-out recordings.
    #[must_use]
    pub fn noise_floor(&self, held_out: bool) -> Fits {
        let channels = self.of(held_out).flat_map(|shown| &shown.prepared.channels);
        mean(channels.map(|channel| (channel.signal, channel.noise_floor_percent())))
    }

    fn of(&self, held_out: bool) -> impl Iterator<Item = &Shown> {
        self.shown.iter().filter(move |shown| shown.held_out == held_out)
    }

    /// Whether the model after is another one than before: with effects that are claimed, or with a table without a name.
    #[must_use]
    pub fn changes(&self) -> bool {
        !self.findings.is_empty() || self.unnamed.is_some()
    }

    /// What the model before is called: where none comes after, it is the model.
    pub fn before_is_called(&self) -> &'static str {
        if self.changes() { "before" } else { "refitted" }
    }

    /// The recording to show first: a held-out one where there is one.
    #[must_use]
    pub fn example(&self) -> Option<&Shown> {
        self.shown.iter().find(|shown| shown.held_out).or(self.shown.first())
    }
}

/// Mean of each signal's values.
fn mean(values: impl Iterator<Item = (Signal, f64)>) -> Fits {
    let mut sums: BTreeMap<&'static str, (f64, f64)> = BTreeMap::new();
    for (signal, value) in values {
        let entry = sums.entry(signal.name()).or_default();
        *entry = (entry.0 + value, entry.1 + 1.0);
    }
    sums.into_iter().map(|(name, (sum, count))| (name, sum / count)).collect()
}
