//! Simulates, compares and diagnoses hydraulic drives against recordings.
#![forbid(unsafe_code)]

pub mod atomic;
pub mod candidate;
pub mod cli;
pub mod compare;
pub mod diagnose;
pub mod diagnostic;
pub mod dual;
pub mod fit;
pub mod hypothesis;
pub mod evidence;
pub mod links;
pub mod locate;
pub mod patterns;
pub mod machine_file;
mod noise;
pub mod paper;
pub mod plot;
pub mod prepare;
pub mod presentation;
pub mod recording;
pub mod report;
pub mod residual;
pub mod screen;
pub mod simulate;
pub mod testbed;
pub mod verdict;
pub mod weakest;
