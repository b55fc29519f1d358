//! What is measured: one drive stepped over commands, and one refit. The comparison with others times it, a test counts its instructions.
#![forbid(unsafe_code)]

pub mod refit;
pub mod run;
