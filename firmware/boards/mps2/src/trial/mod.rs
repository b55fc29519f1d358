//! Trials: drives under inputs that host and target both run, so that their traces can be compared bit for bit.
//!
//! A [`Case`] is a machine with effects under an input; [`Case::run`] steps it and takes the fingerprint of every word of its
//! coefficients, state and outputs.

mod case;
mod effects;
mod fingerprint;
mod input;
mod machines;
mod traced;

/// What `host-sim export` wrote from `presets/press-63-40.toml`: the trials' press, whatever values the firmware is built with.
pub mod preset {
    include!("../../../../machine.rs");
}

pub use case::{Case, CaseError, Model, Sample, cases, run};
pub use effects::{SETS, Set, every_effect, forms};
pub use fingerprint::Fingerprint;
pub use input::{Input, Moment, RECORDED, steps_of};
pub use machines::{mass, press, pump};
pub use traced::Traced;

/// Delay line of the trials' states, ticks.
pub const DELAY: usize = 64;
