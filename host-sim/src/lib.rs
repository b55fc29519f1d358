//! The program `host-sim`: its command line, over the crates in `host-sim/crates`.
#![forbid(unsafe_code)]
// What it has to say it returns, or tells its caller: what is printed is the program's.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]

pub mod cli;
pub mod frames;
#[cfg(feature = "virtual-plant")]
pub mod paper;
