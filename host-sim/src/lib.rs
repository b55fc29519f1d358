//! The program `host-sim`: its command line, over the crates in `host-sim/crates`.
#![forbid(unsafe_code)]
// The library returns its texts, or passes them to its caller: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]

pub mod cli;
pub mod frames;
#[cfg(feature = "virtual-plant")]
pub mod paper;
pub mod played;
