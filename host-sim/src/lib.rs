//! Simulates, compares and diagnoses hydraulic drives against recordings.
#![forbid(unsafe_code)]

pub mod atomic;
pub mod diagnostic;
pub mod machine_file;
pub mod recording;
pub mod testbed;
