//! Where a model misses: which link of the drive, which signal, when, and in which states. It says how a mismatch looks, never which effect it is.
//! Start at [`locate()`].

pub mod balances;
mod case;
pub mod error_shape;
mod intervals;
mod lack_patterns;
mod link_evidence;
pub mod locate;
mod missing_link;
pub mod operating_region;
mod spool_behaviour;

pub use case::Case;
pub use intervals::Interval;
pub use locate::{Location, Miss, Sought, locate, misses};
pub use spool_behaviour::Habit;
