//! Simulates, compares and diagnoses hydraulic drives against recordings.
#![forbid(unsafe_code)]

pub mod atomic;
pub mod candidate;
pub mod cli;
pub mod compare;
pub mod diagnose;
pub mod diagnostic;
pub mod dual;
pub mod evidence;
pub mod fit;
pub mod hypothesis;
pub mod judge;
pub mod links;
pub mod locate;
pub mod machine_file;
pub mod missing_link;
mod noise;
pub mod paper;
pub mod patterns;
pub mod plot;
pub mod prepare;
pub mod presentation;
pub mod recording;
pub mod region;
pub mod report;
pub mod residual;
pub mod screen;
pub mod search;
pub mod shape;
pub mod simulate;
pub mod spectrum;
pub mod statics;
pub mod testbed;
pub mod unnamed;
pub mod verdict;
pub mod weakest;
pub mod window;
