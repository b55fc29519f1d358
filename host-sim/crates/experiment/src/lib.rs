//! Which recordings distinguish effects: what a recording can test before it is fitted, and what to record next.
//!
//! The input is a recording or a planned excitation, and a machine; the result is which effects they would show, and which would be confused with
//! each other. Start at [`plan`] for an experiment still to be made, at [`inspect`] for a recording at hand, and at [`discriminate`] for the test
//! that distinguishes an accepted effect from its alternatives. The thresholds are those of `diagnosis`. Nothing here fits or accepts an effect.
#![forbid(unsafe_code)]
// Results are returned: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]
// No mathematics of the platform: its last bit differs from one to the next (clippy.toml).
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod at_hand;
pub mod discriminate;
pub mod inspect;
pub mod plan;
pub mod sensor;
pub mod standard_tests;
