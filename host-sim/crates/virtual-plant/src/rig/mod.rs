//! TODO.

pub(crate) mod recorded;
pub(crate) mod run;
pub(crate) mod truth;
