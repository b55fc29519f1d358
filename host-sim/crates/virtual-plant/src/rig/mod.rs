//! A run on the test bed: the plant with its drive and its sensors, the recording that they make, and the truth that belongs to it.

pub(crate) mod recorded;
pub(crate) mod run;
pub(crate) mod truth;
