//! Which physics a model of a drive leaves out, and where: recordings and a machine file in, a [`Diagnosis`] out.
//!
//! The order of work: recordings are prepared, the base parameters refitted, the effects of the [`catalogue`] screened and combined into candidate
//! models ([`selection`]), the accepted one checked on recordings that took no part, and what is missing located in the drive ([`localisation`]).
//! Start at [`diagnose()`], which does all of that; what it takes to accept an effect stands in [`selection::decision_rule`]. Held-out recordings
//! only veto, and nothing here writes sentences of a report.
#![forbid(unsafe_code)]
// All results are returned: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]
// No mathematics of the platform: its last bit differs from one to the next (clippy.toml).
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod agreement;
mod asked;
mod base_parameters;
mod before_after;
pub mod catalogue;
pub mod correction_table;
mod decision;
mod diagnose;
mod ending;
mod finding;
mod gains;
pub mod localisation;
mod options;
mod outcome;
pub mod outside;
mod place;
mod pressure_zero;
mod refit;
pub mod selection;
mod settled_valve;
mod since;
pub mod structure;
#[cfg(test)]
mod test_scene;

pub use base_parameters::base_parameters;
pub use before_after::{Fall, Fits, Shown, mean_fits, mean_noise_floor, worse_held_out};
pub use diagnose::{DiagnoseError, Progress, diagnose, diagnose_since, diagnose_with, steps};
pub use finding::Finding;
pub use options::Options;
pub use outcome::{Diagnosis, Verdict};
pub use pressure_zero::{read_absolute, settle_pressure_zero};
pub use refit::{Refit, Refitting};
pub use since::OtherOil;
