//! Why a recording cannot drive a simulation.

use model_core::machine::MachineError;
use recording::Signal;
use recording::files::source_error::{engineering, rounded};

/// Why a recording cannot drive a simulation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulateError {
    /// No signal that could drive the model.
    #[error("{recording}: nothing drives the model; expected a column {expected}")]
    NoInput {
        /// The recording.
        recording: String,
        /// Columns that would be sufficient.
        expected: &'static str,
    },
    /// A signal that the drive input or the load needs is missing.
    #[error("{recording}: no column `{signal}`; expected it because {reason}")]
    Missing {
        /// The recording.
        recording: String,
        /// The signal.
        signal: Signal,
        /// Why it is needed.
        reason: &'static str,
    },
    /// Chamber pressures are to be the force, and the machine file has no areas.
    #[error(
        "{recording}: no column `force`, and the machine file has no areas; expected either: with `cylinder.area_a_m2` and `cylinder.area_b_m2` both \
         chamber pressures are the force"
    )]
    NoAreas {
        /// The recording.
        recording: String,
    },
    /// The recording is longer than the grid can hold.
    #[error(
        "{recording}: {} s, more than the simulation takes at a tick of {} ms; expected at most {} s",
        engineering(rounded(*.duration_s)), 1e3 * .tick_s, engineering(rounded(*.limit as f64 * .tick_s))
    )]
    TooLong {
        /// The recording.
        recording: String,
        /// Its duration.
        duration_s: f64,
        /// The tick.
        tick_s: f64,
        /// Most ticks.
        limit: usize,
    },
    /// The machine does not become a drive.
    #[error(transparent)]
    Machine(#[from] MachineError),
}
