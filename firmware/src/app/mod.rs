//! The press's firmware, assembled over any devices: a [`Station`] that is stepped once a tick, with an [`Operator`] and a [`Desk`] around it.

mod desk;
mod operator;
pub mod press;
mod station;

pub use desk::{Desk, DeskError};
pub use operator::{Errand, Operator, OperatorError, OperatorState};
pub use station::{
    Assembly, BEFORE_S, Press, RING_BYTES, ROWS, Ring, Station, StationError, Wired, wired, wired_read_back,
};
