//! The measured work: one drive stepped over commands, its floor, and one refit. The comparison with others times it, a test counts its instructions.
#![forbid(unsafe_code)]

pub mod floor;
pub mod refit;
pub mod run;
