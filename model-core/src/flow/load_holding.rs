//! `counterbalance`: a load-holding valve between the valve and a chamber.
//!
//! Oil flows into the chamber freely, through a check valve. Out of it, it has to pass a poppet that the chamber's own pressure and, by the pilot
//! ratio, the other side's push open against a spring:
//!
//! ```text
//! τ·dc/dt = held((p_own + R·p_other − p_set)/span) − c         c in openings of a metering edge at full travel, held in 0..size
//! o → o·c/√(o² + c²)                                           for the edges of that chamber while oil leaves it
//! ```
//!
//! The poppet and the edge behind it are two orifices in series; the pressure between them is eliminated, as that of the return line is. The volume
//! between them is not modelled: while a port's edges are closed, its pilot line has the pressure of its chamber. Over a tick the poppet stands
//! where the pressures at the start of the tick move it to, so the flow's slope is that of two orifices of fixed size. Error: 6e-8 of an opening.
//!
//! Free flow one way, and a relief valve the other way whose setting the pilot lowers: Sun Hydraulics, data sheet of the counterbalance valve CBEA. That its
//! opening grows in proportion is chosen. Two orifices in series: Merritt 1967, ch. 3.

use crate::flow::opened::Four;
use crate::number::Number;
use crate::ports::ChamberState;

/// How far the poppets of both chambers are open, flow gain included. 0 and unused where there is none.
pub type Poppets<N> = ChamberState<N>;

/// Coefficients of `counterbalance`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct LoadHolding<N: Number> {
    /// Pressure that opens each chamber's valve without a pilot; `None` where the chamber has no such valve.
    pub settings: ChamberState<Option<N>>,
    /// ¼, and a quarter of the pilot ratio.
    pub quarters: [N::Gain; 2],
    /// Opening per quarter of a pressure beyond the setting.
    pub opening: N::Steep,
    /// Opening at the poppet's stop.
    pub widest: N,
    /// 1 − e^(−h/τ)
    pub share: N::Gain,
    /// 1, as a slope.
    pub unity: N::Steep,
}

impl<N: Number> LoadHolding<N> {
    /// Where the poppets come to rest at these pressures.
    #[inline]
    pub(crate) fn at_rest(&self, pressures: ChamberState<N>) -> Poppets<N> {
        let poppet = |setting: Option<N>, own: N, other: N| {
            setting.map_or(N::ZERO, |setting| {
                let beyond = N::dot(self.quarters, [own - setting, other]).max(N::ZERO);
                beyond.amplified(self.opening).min(self.widest)
            })
        };
        Poppets {
            a: poppet(self.settings.a, pressures.a, pressures.b),
            b: poppet(self.settings.b, pressures.b, pressures.a),
        }
    }

    /// The poppets a tick later.
    #[inline]
    pub(crate) fn step(&self, poppets: Poppets<N>, pressures: ChamberState<N>) -> Poppets<N> {
        let wanted = self.at_rest(pressures);
        let moved = |wanted: N, from: N| from + (wanted - from).part(self.share);
        Poppets { a: moved(wanted.a, poppets.a), b: moved(wanted.b, poppets.b) }
    }

    /// Openings of the edges with these poppets in series where oil leaves a chamber; `across` are the pressure differences over the edges.
    #[inline]
    pub(crate) fn held(&self, openings: &Four<N>, poppets: Poppets<N>, across: &Four<N>) -> Four<N> {
        let behind = |setting: Option<N>, poppet: N, edge: N, leaving: N| match setting {
            Some(_) => N::choose(leaving.above(N::ZERO) & !edge.is_nothing(), || self.in_series(edge, poppet), || edge),
            None => edge,
        };
        let ChamberState { a, b } = self.settings;
        Four {
            supply_a: behind(a, poppets.a, openings.supply_a, -across.supply_a),
            tank_a: behind(a, poppets.a, openings.tank_a, across.tank_a),
            supply_b: behind(b, poppets.b, openings.supply_b, -across.supply_b),
            tank_b: behind(b, poppets.b, openings.tank_b, across.tank_b),
        }
    }

    /// o·c/√(o² + c²)
    #[inline]
    fn in_series(&self, edge: N, poppet: N) -> N {
        let (narrow, wide) = (edge.min(poppet), edge.max(poppet));
        let ratio = N::share(narrow, [wide - narrow], [self.unity]);
        let square = ratio.times(ratio);
        // (1 + z)^-½ as √(1 + z)/(1 + z), with z up to 1.
        let (root, _) = (N::ONE + square).orifice_root(N::ZERO);
        root.times(N::inverse_one_plus([square], [self.unity])).min(N::ONE).of(narrow)
    }
}
