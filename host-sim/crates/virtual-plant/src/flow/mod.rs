//! Flow through the valve: one orifice, and the four edges with the lines before and behind them.

pub(crate) mod edges;
pub(crate) mod orifice;
