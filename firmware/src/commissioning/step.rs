//! The steps by name, and what is said of them.

use super::reading::{Reading, Refusal};
use crate::set_point::SetPointError;

/// A step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Step {
    /// There is no oil.
    NoOil,
    /// The inputs' voltages are within their bands.
    Voltages,
    /// The output does what it is told.
    Output,
    /// The rod's place is known.
    Place,
    /// Every sign is right.
    Direction,
    /// The loops follow.
    Tuning,
    /// Everything is watched.
    Limits,
}

impl Step {
    /// Every step, in the order in which they are taken.
    pub const ALL: [Step; 7] =
        [Step::NoOil, Step::Voltages, Step::Output, Step::Place, Step::Direction, Step::Tuning, Step::Limits];

    /// Whether the rod is moved.
    #[must_use]
    pub const fn moves(self) -> bool {
        matches!(self, Step::Direction | Step::Tuning | Step::Limits)
    }
}

/// What the log is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Note {
    /// A step begins.
    #[error("{0:?}: begins")]
    Begun(Step),
    /// It has measured this, and it is as expected.
    #[error("{0:?}: {1}")]
    Measured(Step, Reading),
    /// It has passed.
    #[error("{0:?}: passed")]
    Passed(Step),
    /// It is refused.
    #[error("{0:?}: refused: {1}")]
    Refused(Step, Refusal),
}

/// Why a key has no effect.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CommissioningError {
    /// There is no such step.
    #[error("no step {found}: they are 1 to 7, and 0 leaves the commissioning")]
    NoStep {
        /// What was typed.
        found: u32,
    },
    /// A step before it has not been passed.
    #[error("step {asked} waits for step {next}")]
    Order {
        /// What was typed.
        asked: u32,
        /// The next step.
        next: u32,
    },
    /// A step is under way.
    #[error("a step is under way: s stops it")]
    Busy,
    /// The commissioning was begun and has not ended.
    #[error("the commissioning has not ended: 0c leaves it")]
    Unfinished,
    /// The valve is not neutral.
    #[error("the valve is not neutral")]
    NotNeutral,
    /// A fault is active.
    #[error("a fault has not been acknowledged")]
    Faulty,
    /// There is no valid small step from here.
    #[error(transparent)]
    SetPoint(#[from] SetPointError),
}
