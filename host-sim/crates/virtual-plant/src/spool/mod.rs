//! The valve's spool: in closed form where it is linear, in small steps where effects act on it.

pub(crate) mod linear;
pub(crate) mod with_effects;
