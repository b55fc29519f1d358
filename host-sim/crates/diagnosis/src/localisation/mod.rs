//! TODO.

pub mod balances;
pub mod error_shape;
mod intervals;
mod lack_patterns;
mod link_evidence;
pub mod locate;
mod missing_link;
pub mod operating_region;
mod spool_behaviour;

pub use intervals::Interval;
pub use locate::{Case, Location, Miss, Sought, locate, misses};
pub use spool_behaviour::Habit;
