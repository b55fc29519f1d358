//! TODO.

pub(crate) mod input;
