//! Flow through the valve: one orifice, and the four edges with the lines before and after them.

pub(crate) mod edges;
pub(crate) mod orifice;
