//! TODO.

pub mod signals;
pub mod text;
