//! Every recording, simulated by the models before and after, for the report of a diagnosis or of a refit.

use std::collections::BTreeMap;

use identification::parallel;

use identification::experiment::Prepared;
use identification::fit::{Fit, StartState, settle};
use model_core::machine::{Machine, MachineError};
use recording::Signal;
use simulation::figures_of_merit::SignalFit;
use simulation::{Trajectory, simulate_f64};

/// Mean NRMSE fit of each signal over recordings, %.
pub type Fits = BTreeMap<&'static str, f64>;

/// Signals of one recording: recorded, and simulated before and after.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The recording, prepared.
    pub prepared: Prepared,
    /// Whether it was held out.
    pub held_out: bool,
    /// Simulated before: in a diagnosis with refitted base parameters, in a refit with the machine file's values.
    pub before: Trajectory,
    /// Simulated after: in a diagnosis with the effects as well, the same as before if nothing is accepted; in a refit with the fitted values.
    pub after: Trajectory,
}

impl Shown {
    /// Fit of each judged signal before or after, without the rows where its sensor failed.
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

/// All recordings, simulated by the models before and after from the fitted initial states; held-out recordings have no fitted state. `plain` are the
/// same recordings without the force from outside that only the model after has as an input; empty where there is none.
pub(crate) fn show_all(
    trained: Vec<Prepared>,
    held: Vec<Prepared>,
    plain: &[&Prepared],
    before: &Fit,
    after: &Fit,
) -> Result<Vec<Shown>, MachineError> {
    let starts = before.starts.iter().zip(&after.starts).map(|(&before, &after)| Some((before, after)));
    let together: Vec<_> = trained.into_iter().zip(starts).chain(held.into_iter().map(|case| (case, None))).collect();
    parallel::try_each(together.into_iter().enumerate(), |(index, (prepared, starts))| {
        show(prepared, plain.get(index).copied(), starts, &before.machine, &after.machine)
    })
}

/// The recordings of a refit: those trained on start after it from their fitted initial states, all others from the state that suits the model best.
pub(crate) fn show_refit(
    trained: Vec<(Prepared, StartState)>,
    held: Vec<Prepared>,
    before: &Machine<f64>,
    after: &Machine<f64>,
) -> Result<Vec<Shown>, MachineError> {
    let trained = trained.into_iter().map(|(case, start)| (case, Some(start)));
    let together: Vec<_> = trained.chain(held.into_iter().map(|case| (case, None))).collect();
    parallel::try_each(together, |(prepared, start)| {
        let from_before = settle(before, &prepared)?;
        let from_after = start.map_or_else(|| settle(after, &prepared), Ok)?;
        Ok(Shown {
            held_out: start.is_none(),
            before: simulate_f64(before, &prepared.stimulus, from_before.offset(before, &prepared))?,
            after: simulate_f64(after, &prepared.stimulus, from_after.offset(after, &prepared))?,
            prepared,
        })
    })
}

/// Mean NRMSE fit of each signal, before or after, on training or held-out recordings.
#[must_use]
pub fn mean_fits(shown: &[Shown], held_out: bool, after: bool) -> Fits {
    let of = shown.iter().filter(|shown| shown.held_out == held_out);
    mean(of.flat_map(|shown| shown.fits(after)).map(|fit| (fit.signal, fit.nrmse_percent)))
}

/// Mean NRMSE fit of each signal that a perfect model would reach, on training or held-out recordings.
#[must_use]
pub fn mean_noise_floor(shown: &[Shown], held_out: bool) -> Fits {
    let channels = shown.iter().filter(|shown| shown.held_out == held_out).flat_map(|shown| &shown.prepared.channels);
    mean(channels.map(|channel| (channel.signal, channel.noise_floor_percent())))
}

/// A signal that a refit follows less well than the machine file does: its mean NRMSE fits on held-out recordings, %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fall {
    /// Its name.
    pub signal: &'static str,
    /// With the machine file's values.
    pub before: f64,
    /// With the fitted values.
    pub after: f64,
}

/// The signals that fell, largest first, where the fitted values are worse than the machine file's on held-out recordings; empty where they are not;
/// `None` where nothing was held out.
///
/// Worse: the errors of all signals together, as their geometric mean, are larger by a twentieth. An error below its noise counts as that noise.
#[must_use]
pub fn worse_held_out(shown: &[Shown]) -> Option<Vec<Fall>> {
    /// Chosen: what a refit gains or loses by chance where nothing is to be gained.
    const LARGER: f64 = 1.05;
    let (before, after) = (mean_fits(shown, true, false), mean_fits(shown, true, true));
    let floor = mean_noise_floor(shown, true);
    if before.is_empty() {
        return None;
    }
    let growth = |fall: &Fall| {
        let least = (100.0 - floor.get(fall.signal).copied().unwrap_or(100.0)).max(1e-3);
        libm::log((100.0 - fall.after).max(least) / (100.0 - fall.before).max(least))
    };
    let fall = |(&signal, &before): (&&'static str, &f64)| Some(Fall { signal, before, after: *after.get(signal)? });
    let mut grown: Vec<(f64, Fall)> = before.iter().filter_map(fall).map(|fall| (growth(&fall), fall)).collect();
    let mean = grown.iter().map(|(growth, _)| growth).sum::<f64>() / grown.len().max(1) as f64;
    if mean <= libm::log(LARGER) {
        return Some(Vec::new());
    }
    grown.retain(|(growth, _)| *growth > 0.0);
    grown.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    Some(grown.into_iter().map(|(_, fall)| fall).collect())
}

fn mean(values: impl Iterator<Item = (Signal, f64)>) -> Fits {
    let mut sums: BTreeMap<&'static str, (f64, f64)> = BTreeMap::new();
    for (signal, value) in values {
        let sum = sums.entry(signal.name()).or_default();
        *sum = (sum.0 + value, sum.1 + 1.0);
    }
    sums.into_iter().map(|(name, (sum, count))| (name, sum / count)).collect()
}

/// Simulates before and after from the fitted initial states; a held-out recording has none and starts from the state that suits each model best.
fn show(
    prepared: Prepared,
    plain: Option<&Prepared>,
    starts: Option<(StartState, StartState)>,
    before: &Machine<f64>,
    after: &Machine<f64>,
) -> Result<Shown, MachineError> {
    let plain = plain.unwrap_or(&prepared);
    let (from_before, from_after) = match starts {
        Some(starts) => starts,
        None => (settle(before, plain)?, settle(after, &prepared)?),
    };
    Ok(Shown {
        held_out: starts.is_none(),
        before: simulate_f64(before, &plain.stimulus, from_before.offset(before, plain))?,
        after: simulate_f64(after, &prepared.stimulus, from_after.offset(after, &prepared))?,
        prepared,
    })
}
