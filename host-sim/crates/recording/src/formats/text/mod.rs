//! TODO.

pub(crate) mod csv;
pub(crate) mod lines;
mod twincat;
