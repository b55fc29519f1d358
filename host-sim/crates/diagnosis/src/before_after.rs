//! Every recording, simulated by the models before and after, for the report of the diagnosis.

use identification::parallel;

use identification::experiment::Prepared;
use identification::fit::{Fit, StartState, settle};
use model_core::machine::{Machine, MachineError};
use simulation::figures_of_merit::SignalFit;
use simulation::{Trajectory, simulate_f64};

/// Signals of one recording: recorded, and simulated before and after.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The recording, prepared.
    pub prepared: Prepared,
    /// Whether it was held out.
    pub held_out: bool,
    /// Simulated with refitted base parameters.
    pub before: Trajectory,
    /// Simulated with the effects as well; the same as before if nothing is accepted.
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
