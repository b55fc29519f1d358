//! The supply: a pressure that falls with what is drawn, with an accumulator's memory (`supply-droop`).
//!
//! τ·dps/dt = p0 − R·Qs − ps, with Qs the flow from the supply into both ports (below 0 where a chamber pushes back). τ = R·C:
//! a pump of source resistance R beside an accumulator of capacity C (Merritt, *Hydraulic Control Systems*, 1967, ch. 11).
//!
//! Over a tick in which Qs goes straight from Q0 to Q1 the solution is exact:
//!
//! ```text
//! ps' = ps + (1 − e)·(p0 − ps) − R·(w0·Q0 + w1·Q1),   e = e^(−h/τ),  w1 = 1 − (1 − e)·τ/h,  w0 = 1 − e − w1
//! ```
//!
//! Q1 depends on ps' itself, the more the faster the supply is; it is taken along its chord, so that the step is divided by
//! 1 + R·w1·∂Q1/∂ps. With τ = 0 (w1 = 1) this is the static droop; as a chord is steeper than its root, by two at most, each tick
//! closes at least half of what the last one left, and never goes beyond.

use crate::number::Number;

/// State of the supply.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SupplyState<N> {
    /// Supply pressure at the valve, per unit: 1 is p0, where it stays without droop.
    pub pressure: N,
    /// What rounding left of it.
    rest: N,
}

impl<N: Number> SupplyState<N> {
    /// Nothing has been drawn for long.
    pub(crate) fn at_rest(pressure: N) -> Self {
        Self { pressure, rest: N::ZERO }
    }
}

/// Flow drawn from the supply, and its slope against the supply pressure over [`SLOPE_SCALE`](crate::edge_effects::SLOPE_SCALE).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Draw<N> {
    pub(crate) flow: N,
    pub(crate) steepness: N,
}

/// Coefficients of the droop at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Droop<N: Number> {
    /// 1 − e, −R·w0 and −R·w1, times the fineness.
    pub(crate) shares: [N::Gain; 3],
    /// 1 / fineness.
    pub(crate) fine: N::Gain,
    /// R·w1: what the supply pressure falls by at once per flow.
    pub(crate) at_once: N::Gain,
}

impl<N: Number> Droop<N> {
    /// The supply a tick later: `drawn` at its start, `draw` at its end if the supply pressure had not moved.
    #[inline]
    pub(crate) fn after(
        &self,
        supply: SupplyState<N>,
        unloaded: N,
        drawn: N,
        draw: Draw<N>,
        slope_scale: N::Steep,
    ) -> SupplyState<N> {
        let free = N::dot(self.shares, [unloaded - supply.pressure, drawn, draw.flow]);
        let (pressure, rest) = supply.pressure.accumulated(
            supply.rest,
            [self.fine],
            [free.times(self.gives(draw.steepness, slope_scale))],
        );
        SupplyState { pressure, rest }
    }

    /// 1/(1 + R·w1·∂Q/∂ps)
    #[inline]
    pub(crate) fn gives(&self, steepness: N, slope_scale: N::Steep) -> N {
        N::inverse_one_plus([N::dot([self.at_once], [steepness])], [slope_scale])
    }

    /// What is left of an edge's slope against its chamber's pressure as the supply gives way with it, where edges of `whole`
    /// steepness draw and this one has `own`: 1 − ρ·s/(1 + ρ·Σs).
    #[inline]
    pub(crate) fn softened(&self, own: N, whole: N, slope_scale: N::Steep) -> N {
        let given = own.times(self.gives(whole, slope_scale));
        own.times((N::ONE - N::dot([self.at_once], [given]).amplified(slope_scale)).max(N::ZERO))
    }
}
