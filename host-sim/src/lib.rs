//! Simulates, compares and diagnoses hydraulic drives against recordings.
#![forbid(unsafe_code)]

pub mod atomic;
pub mod compare;
pub mod diagnose;
pub mod diagnostic;
pub mod dual;
pub mod fit;
pub mod hypothesis;
pub mod locate;
pub mod machine_file;
pub mod prepare;
pub mod recording;
pub mod report;
pub mod residual;
pub mod simulate;
pub mod testbed;
pub mod verdict;
