//! The shared library of an FMU that `host-sim export` writes: any drive, over the C interface of FMI 3.0.
//!
//! It knows no drive by itself: when a tool instantiates it, it reads the drive's machine file out of the FMU's resources,
//! builds the core's drive as `host-sim simulate` does, and steps that by the core's tick. What the interface asks is in
//! [`Instance`], in safe Rust; `functions` turns C's pointers into its arguments and back.

mod functions;
mod instance;
mod refusal;
mod snapshot;

pub use instance::{Instance, Mode};
pub use refusal::Refusal;
pub use snapshot::Snapshot;
