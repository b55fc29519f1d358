//! The shared library of an FMU that `host-sim export` writes: any drive, over the C interfaces of FMI 2.0 and 3.0.
//!
//! It contains no drive itself: when a tool instantiates it, it reads the drive's machine file from the FMU's resources,
//! builds the core's drive as `host-sim simulate` does, and advances it by the core's tick. What the functions of both versions do is in
//! [`Instance`], in safe Rust; `functions` turns C's pointers into its arguments and back.
// A tool that loads it shows nothing of what it would print.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]

mod functions;
mod instance;
mod location;
mod refusal;
mod snapshot;

pub use instance::{Instance, Mode};
pub use refusal::Refusal;
pub use snapshot::Snapshot;
