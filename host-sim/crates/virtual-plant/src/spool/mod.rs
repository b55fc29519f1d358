//! TODO.

pub(crate) mod linear;
pub(crate) mod with_effects;
