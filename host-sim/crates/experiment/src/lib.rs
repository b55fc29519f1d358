//! Which recordings tell effects apart: what one can test before it is fitted, and what to record next.
//!
//! A recording or a planned excitation and a machine go in; which effects they would show, and which would pass for each other, comes out. Start at
//! [`plan`] for an experiment still to be made, at [`inspect`] for a recording at hand, and at [`discriminate`] for the test that tells an accepted effect
//! from its alternatives. The thresholds are those of `diagnosis`. Nothing here fits or accepts an effect.
#![forbid(unsafe_code)]
// What there is to say is returned: nothing but the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]

pub mod discriminate;
pub mod inspect;
pub mod plan;
pub mod sensor;
pub mod standard_tests;
