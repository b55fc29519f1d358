//! Why a recording cannot be watched.

use firmware::monitor::MonitorError;
use identification::compare::CompareError;
use model_core::machine::MachineError;

/// Why a recording cannot be watched, or why no band is found.
#[derive(Debug, thiserror::Error)]
pub enum WatchError {
    /// The machine file holds no band.
    #[error("the machine file has no table [watch]")]
    NoBand,
    /// Too few recordings of a healthy drive.
    #[error(
        "{found} recordings of the healthy drive; expected at least {least}, of several days where there are: they show how much it differs from one to the next"
    )]
    FewHealthy {
        /// How many there are.
        found: usize,
        /// How many it takes.
        least: usize,
    },
    /// Of the signals of the band none is recorded.
    #[error("{recording}: none of the signals that are watched is recorded: {expected}")]
    NothingWatched {
        /// The recording.
        recording: String,
        /// The signals of the band.
        expected: String,
    },
    /// The recording does not drive the model, or cannot be compared with it.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// The controller's step does not compute the machine.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// The band or the share of false alarms makes no monitor.
    #[error("{recording}: {cause}")]
    Monitor {
        /// The recording.
        recording: String,
        /// Why.
        cause: MonitorError,
    },
}
