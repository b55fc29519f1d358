//! Simulates, compares and diagnoses hydraulic drives against recordings.
#![forbid(unsafe_code)]
// What it has to say it returns, or tells its caller: what is printed is the program's.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]

pub mod atomic;
pub mod candidate;
pub mod cli;
pub mod clock;
pub mod compare;
pub mod data_sheet;
pub mod diagnose;
pub mod diagnostic;
pub mod dual;
pub mod evidence;
pub mod excerpt;
pub mod exhibits;
pub mod export;
pub mod failure;
pub mod fit;
pub mod fmu;
pub mod found;
pub mod hypothesis;
pub mod import;
mod inherited;
pub mod inspect;
pub mod judge;
pub mod lanes;
pub mod links;
pub mod locate;
pub mod machine_file;
pub mod missing_link;
mod noise;
pub mod paper;
pub mod patterns;
pub mod picture;
pub mod plan;
pub mod plot;
pub mod prepare;
pub mod presentation;
#[cfg(test)]
mod press;
pub mod processor;
mod random;
pub mod recording;
pub mod region;
pub mod report;
pub mod residual;
pub mod rhythm;
pub mod screen;
pub mod search;
pub mod sensor;
pub mod separate;
pub mod shape;
pub mod simulate;
mod slope;
pub mod spectrum;
pub mod standard_tests;
pub mod state_map;
pub mod statics;
pub mod tempered;
pub mod testbed;
pub mod timeline;
pub mod unnamed;
pub mod verdict;
pub mod waterfall;
pub mod weakest;
pub mod whiteness;
pub mod window;
