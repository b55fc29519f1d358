//! Why a recording cannot be compared or prepared for a fit.

use recording::RecordingError;
use simulation::SimulateError;

/// Why a comparison is not possible.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// The simulation is not possible.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// The recording cannot be judged.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Nothing measured is computed.
    #[error("{recording}: nothing to compare; expected a measured spool, pressure_a, pressure_b, position or velocity")]
    NothingMeasured {
        /// The recording.
        recording: String,
    },
}
