//! Supervision: what can go wrong, what is allowed, and what the firmware then does with the valve.
//!
//! ```text
//! counts ─ sense ─ Measured ─ deviating ─ Fault ─ Response ─ Mode ─ what the valve gets
//!            ▲ Limits, Patience ▲                      └ Log: what is told of it
//! ```

pub(crate) mod deviating;
mod deviation;
mod fault;
mod limits;
mod log;
mod mode;
pub(crate) mod sense;
mod stuck_sensor;

pub use deviation::{Deviation, DeviationLimits, OFF, Reach};
pub use fault::{ActiveFaults, Device, Fault, Response};
pub use limits::{Allowed, Delay, Limits, LimitsError};
#[cfg(feature = "defmt")]
pub use log::Defmt;
pub(crate) use log::Findings;
pub use log::Log;
pub use mode::{Action, Command, Event, Mode, Transition};
pub use stuck_sensor::{Patience, Stillness};
