//! The sensing link: the sensors' readings of the rod's position, the pressures and the spool. §2, §3 of the paper.
//!
//! [`Linkage`] and [`Lvdt`] turn counts into per-unit signals and back; [`Sensors`] have the errors that a real sensor adds.

mod linkage;
pub(crate) mod sensors;

pub use linkage::{Linkage, LinkageError, Lvdt, SERIES_TOLERANCE};
pub use sensors::{Sensed, SensedState, Sensors};
