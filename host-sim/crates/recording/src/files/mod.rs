//! TODO.

pub mod atomic;
pub mod source_error;
