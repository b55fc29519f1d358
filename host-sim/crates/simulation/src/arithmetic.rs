//! The number types in which a whole simulation can be run.

use model_core::machine::Machine;
use model_core::number::PerUnit;

use crate::error::SimulateError;
use crate::initial_state::StartOffset;
use crate::run::{Trajectory, simulate};
use crate::stimulus::Stimulus;

/// The number type of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Arithmetic {
    /// What the controller computes.
    #[default]
    Fixed,
    /// f64.
    Float,
}

impl Arithmetic {
    /// Simulates in this number type.
    pub fn simulate(
        self,
        machine: &Machine<f64>,
        stimulus: &Stimulus,
        offset: StartOffset,
    ) -> Result<Trajectory, SimulateError> {
        self.simulate_with_progress(machine, stimulus, offset, &|_| ())
    }

    /// The same, and reports how many more rows are done.
    pub fn simulate_with_progress(
        self,
        machine: &Machine<f64>,
        stimulus: &Stimulus,
        offset: StartOffset,
        told: &dyn Fn(usize),
    ) -> Result<Trajectory, SimulateError> {
        Ok(match self {
            Arithmetic::Fixed => simulate::<PerUnit>(machine, stimulus, offset, told)?,
            Arithmetic::Float => simulate::<f64>(machine, stimulus, offset, told)?,
        })
    }
}
