//! How far the metering edges are open: two equal ones at a time, or each of the four by itself.

use crate::flow::Poppets;

/// How far the edges are open at a spool position, flow gain included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Opened<N> {
    /// Opening of two equal edges, signed like the spool.
    pub(super) way: N,
    /// Opening of each edge, where an effect makes them differ.
    pub(super) four: Option<Four<N>>,
    /// Load-holding valves behind the four.
    pub(super) poppets: Poppets<N>,
}

/// One of something for each metering edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Four<T> {
    /// P-A
    pub(super) supply_a: T,
    /// A-T
    pub(super) tank_a: T,
    /// P-B
    pub(super) supply_b: T,
    /// B-T
    pub(super) tank_b: T,
}

impl<T: Copy> Four<T> {
    #[inline]
    pub(super) fn each<U>(&self, of: impl Fn(T) -> U) -> Four<U> {
        Four {
            supply_a: of(self.supply_a),
            tank_a: of(self.tank_a),
            supply_b: of(self.supply_b),
            tank_b: of(self.tank_b),
        }
    }

    #[inline]
    pub(super) fn with<U: Copy, V>(&self, other: &Four<U>, each: impl Fn(T, U) -> V) -> Four<V> {
        Four {
            supply_a: each(self.supply_a, other.supply_a),
            tank_a: each(self.tank_a, other.tank_a),
            supply_b: each(self.supply_b, other.supply_b),
            tank_b: each(self.tank_b, other.tank_b),
        }
    }
}
