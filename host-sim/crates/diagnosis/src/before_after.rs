//! Every recording, simulated by the models before and after, for the report of the diagnosis.

use identification::parallel;

use identification::experiment::Prepared;
use identification::fit::{Fit, StartState, settle};
use model_core::machine::MachineError;
use simulation::{Trajectory, simulate_f64};

use crate::outcome::Shown;

/// A model with the recordings as it is driven by them: the training ones in the order of its starts.
pub(crate) struct Driven<'a> {
    pub(crate) fit: &'a Fit,
    pub(crate) trained: &'a [Prepared],
    pub(crate) held: &'a [Prepared],
}

impl<'a> Driven<'a> {
    /// Each recording with the state that it starts from; a held-out one from the state that suits the model best.
    fn all(&self) -> impl Iterator<Item = (&'a Prepared, Option<StartState>)> {
        let starts = self.fit.starts.iter().copied().map(Some);
        self.trained.iter().zip(starts).chain(self.held.iter().map(|case| (case, None)))
    }

    fn simulated(&self, (case, start): (&Prepared, Option<StartState>)) -> Result<Trajectory, MachineError> {
        let machine = &self.fit.machine;
        let start = start.map_or_else(|| settle(machine, case), Ok)?;
        simulate_f64(machine, &case.stimulus, start.offset(machine, case))
    }
}

/// All recordings, simulated by the models before and after.
pub(crate) fn show_all(before: &Driven<'_>, after: &Driven<'_>) -> Result<Vec<Shown>, MachineError> {
    parallel::try_each(before.all().zip(after.all()), |(of_before, of_after)| {
        Ok(Shown {
            held_out: of_before.1.is_none(),
            before: before.simulated(of_before)?,
            after: after.simulated(of_after)?,
            prepared: of_after.0.clone(),
        })
    })
}
