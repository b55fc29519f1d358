//! TODO.

pub(crate) mod edges;
pub(crate) mod orifice;
