//! ```text
//! x > 0:  Qa = K_Q·√(p0 − pa)·x      Qb = K_Q·√|pb|·x             (3)
//! x < 0:  Qa = K_Q·√|pa|·x           Qb = K_Q·√(p0 − pb)·x        (4)
//! ```
//!
//! The flow link: spool (or [pump](crate::flow::Pump)) and pressures → flow into A and out of B. As computed, with dead zone x0 and flow limit of §3:
//!
//! ```text
//! o  = max(0, x − x0) + min(0, x + x0)                           opening, signed like x, not renormalised
//! Qa = limited(K_Q·o·g(p0 − pa))   Qb = limited(K_Q·o·g(pb − pt))     o > 0
//! Qa = limited(K_Q·o·g(pa − pt))   Qb = limited(K_Q·o·g(p0 − pb))     o < 0
//! g(Δp) = Δp/(Δp² + p_t²)^¼                                      √ with its sign, finite near 0
//! ```
//!
//! Formats: spool, pressures and flows are signals (±8, step 3.7e-9), 1 being full travel, the supply pressure and [`Bases::flow_m3_per_s`]; `K_Q`
//! is a gain (below 4). Error of a flow: half a step, in addition to that of the root (2 steps + 6e-9 of the root).
//!
//! Signs: x > 0 opens P-A and B-T, x < 0 opens A-T and P-B. Flow a > 0 goes into chamber A, flow b > 0 comes out of chamber B. In (3) and (4)
//! the sign comes from x. The paper's |p| under the root loses the sign of the pressure difference; the root here keeps it, so that a chamber
//! above the supply pushes oil back.
//!
//! [`Bases::flow_m3_per_s`]: crate::machine::Bases::flow_m3_per_s

pub(crate) mod effects;
mod four_edges;
pub(crate) mod load_holding;
mod opened;
mod pump;
pub(crate) mod supply;

use effects::EdgeEffects;
use load_holding::LoadHolding;

use crate::effects::{AnyEffect, Keeps, Knows};
use crate::number::{Mask, Number};
use crate::ports::{AcrossEdges, ChamberState, Filling, Flows, Linearised, Overlap, Spool};

pub use load_holding::Poppets;
pub(crate) use opened::Opened;
pub use pump::{Pump, PumpDrive};
pub use supply::SupplyState;

/// The flows at the start of a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Started<N: Number> {
    pub(crate) flows: Flows<Linearised<N>>,
    /// Drawn from a supply that droops.
    pub(crate) drawn: N,
    /// The root of each orifice, from which the roots at the end may be derived.
    pub(crate) roots: Option<Flows<Root<N>>>,
}

/// Root of an orifice at the start of a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root<N: Number> {
    across: N,
    value: N,
    /// Slope of its chord.
    slope: N::Steep,
}

/// Pressures that the flow link works between.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Lines<N> {
    /// Supply p0.
    pub supply: N,
    /// Tank.
    pub tank: N,
}

/// The metering edges of a proportional valve: dead zone, square-root orifices, flow saturation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(bound = "N: crate::number::Written, E: serde::Serialize")
)]
pub struct Edges<N: Number, E = Option<EdgeEffects<N>>> {
    #[doc(hidden)]
    pub overlap: Overlap<N>,
    /// `K_Q`·√(pressure base) / flow base.
    #[doc(hidden)]
    pub gain: N::Gain,
    /// Largest flow, both signs.
    #[doc(hidden)]
    pub limit: N,
    /// 1, as a slope.
    #[doc(hidden)]
    pub unity: N::Steep,
    /// Pressure difference at which the root turns from laminar to turbulent, `laminar-transition` included.
    #[doc(hidden)]
    pub transition: N,
    /// 256 times that: above it the root's slope is half of its chord's slope, with an error of 8e-6 of it.
    #[doc(hidden)]
    pub turbulent: N,
    #[doc(hidden)]
    pub lines: Lines<N>,
    /// Effects that make the four edges differ; `None`: the two edges that are open at a time are equal.
    #[doc(hidden)]
    pub effects: E,
}

impl<N: Number, E> Edges<N, E> {
    /// The same edges with these effects.
    #[inline]
    pub(crate) fn with<F>(&self, effects: F) -> Edges<N, F> {
        let &Self { overlap, gain, limit, unity, transition, turbulent, lines, .. } = self;
        Edges { overlap, gain, limit, unity, transition, turbulent, lines, effects }
    }

    /// The opening whose chord is that of a limited flow: all of it, or, where the flow would exceed the limit, the share that just passes the limit.
    #[inline]
    pub(crate) fn within_limit(&self, opening: N, flow: N, free: N) -> N {
        N::choose(flow.equals(free), || opening, || self.share_within_limit(free).of(opening))
    }

    /// The opening for the pressure slope of a tick; `within` says whether the flow is within the limit. A saturated flow has slope 0, since no pressure changes it; only when the tick brings the
    /// pressures to where the flow is not limited does the step use the limit's chord.
    ///
    /// Without that chord, a chamber that a single tick at the limit overfills would rest between the lines, short of both. With the chord in every
    /// tick, a rod on the oil spring would build up an oscillation: the step's slope would assume a damping that the saturated flow does not give.
    #[inline]
    pub(crate) fn sloping(
        &self,
        within: N::Mask,
        opening: N,
        [flow, free]: [N; 2],
        across: N,
        filling: Filling<N>,
    ) -> N {
        // What the rare case needs is stored only where it occurs.
        if within.all() {
            return opening;
        }
        N::pick(within, opening, self.sloping_at_limit(opening, [flow, free], across, filling))
    }

    /// The chord's share of the opening if a tick at the limit takes the pressure difference past the point where the limit's chord begins (the
    /// tick's change of pressure plus the difference at that point exceeds the present difference); else 0.
    #[cold]
    #[inline(never)]
    fn sloping_at_limit(&self, opening: N, [flow, free]: [N; 2], across: N, filling: Filling<N>) -> N {
        let (share, across) = (self.share_within_limit(free), across.magnitude());
        let taken = N::dot([filling.stiffness], [flow - filling.room]);
        let taken = flow.select_positive(taken, -taken);
        N::pick((taken + share.of(share.of(across))).above(across), share.of(opening), N::ZERO)
    }

    #[cold]
    #[inline(never)]
    fn share_within_limit(&self, free: N) -> N {
        N::share(self.limit, [free.magnitude() - self.limit], [self.unity])
    }
}

impl<N: Number> Edges<N> {
    /// Flows at a spool position, two chamber pressures, and that of a supply that droops.
    #[inline]
    pub fn flow(&self, spool: N, pressures: ChamberState<N>, supply: N) -> Flows<N> {
        self.flow_behind(spool, pressures, supply, self.poppets::<AnyEffect>(pressures))
    }

    /// The same with load-holding valves that are open this far.
    #[inline]
    pub(crate) fn flow_behind(&self, spool: N, pressures: ChamberState<N>, supply: N, poppets: Poppets<N>) -> Flows<N> {
        self.flow_with::<AnyEffect>(&self.opened::<AnyEffect>(spool, poppets), pressures, supply, None)
    }

    /// Load-holding valves that rest at these pressures.
    #[inline]
    pub(crate) fn poppets<V: Knows<EdgeEffects<N>>>(&self, pressures: ChamberState<N>) -> Poppets<N> {
        let holding = self.holding::<V>();
        holding.map_or(Poppets { a: N::ZERO, b: N::ZERO }, |holding| holding.at_rest(pressures))
    }
}

impl<N: Number, E: Keeps<EdgeEffects<N>>> Edges<N, E> {
    /// Load-holding valves, where there are any.
    #[inline]
    pub(crate) fn holding<V: Knows<EdgeEffects<N>>>(&self) -> Option<&LoadHolding<N>> {
        V::of(self.effects.kept()).and_then(|effects| effects.holding.as_ref())
    }

    /// The openings at a spool position, with load-holding valves that are open this far.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn opened<V: Knows<EdgeEffects<N>>>(&self, spool: N, poppets: Poppets<N>) -> Opened<N> {
        match V::of(self.effects.kept()) {
            Some(effects) => Opened { way: N::ZERO, four: Some(self.openings::<V>(effects, spool)), poppets },
            None => Opened { way: self.opening(spool), four: None, poppets },
        }
    }

    /// Flows through edges with these openings, in a tick that started with these roots.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn flow_with<V: Knows<EdgeEffects<N>>>(
        &self,
        opened: &Opened<N>,
        pressures: ChamberState<N>,
        supply: N,
        started: Option<Flows<Root<N>>>,
    ) -> Flows<N> {
        if let (Some(effects), Some(four)) = (V::of(self.effects.kept()), &opened.four) {
            return self.flow_of_four::<V>(effects, (four, opened.poppets), pressures, supply);
        }
        let opening = opened.way;
        let across = self.across(opening, pressures);
        Flows {
            a: self.passing_edge(opening, across.a, started.map(|roots| roots.a)),
            b: self.passing_edge(opening, across.b, started.map(|roots| roots.b)),
        }
    }

    /// Flows at the start of a tick; `end` is how far the edges are open at its end.
    #[inline]
    pub(crate) fn linearised_with<V: Knows<EdgeEffects<N>>>(
        &self,
        spool: Spool<N>,
        end: &Opened<N>,
        pressures: ChamberState<N>,
        supply: N,
        filling: Flows<Filling<N>>,
    ) -> Started<N> {
        if let (Some(effects), Some(four)) = (V::of(self.effects.kept()), &end.four) {
            let end = (four, end.poppets);
            let (flows, drawn) = self.linearised_of_four::<V>(effects, spool, end, pressures, supply, filling);
            return Started { flows, drawn, roots: None };
        }
        let (from, to) = (self.opening(spool.from), end.way);
        // A closed valve that opens within the tick already works between the pressures it opens to.
        let across = self.across(N::pick(from.equals(N::ZERO), to, from), pressures);
        let larger = from.magnitude().max(to.magnitude());
        let closed = from.is_nothing() & to.is_nothing();
        let a = self.passing_linearised(closed, from, larger, across.a, filling.a);
        let b = self.passing_linearised(closed, from, larger, across.b, filling.b);
        Started { flows: Flows { a: a.0, b: b.0 }, drawn: N::ZERO, roots: Some(Flows { a: a.1, b: b.1 }) }
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as `root_after`")]
    fn root(&self, across: N) -> Root<N> {
        let (value, slope) = across.orifice_root(self.transition);
        Root { across, value, slope }
    }

    /// The root at the end of a tick that started with this one.
    ///
    /// Where the tick changes the pressure difference by less than 2⁻¹³ of it, half of the chord's slope gives the new root: its error is less than
    /// a step of the format, so that the result does not show which way it was computed. A number whose roots cost little more takes a new one.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call is half of what the shorter way computes")]
    fn root_after(&self, started: Root<N>, across: N) -> N {
        if !N::SHORTCUTS {
            return self.root(across).value;
        }
        let moved = across - started.across;
        let near = (started.across.magnitude() - self.turbulent).over_power(13).above(moved.magnitude());
        let on_tangent = || started.value + moved.amplified_within(started.slope).halved();
        if near.all() {
            return on_tangent();
        }
        let fresh = self.root(across).value;
        if near.any() { N::pick(near, on_tangent(), fresh) } else { fresh }
    }

    /// Flow through an edge at the end of a tick.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as `root_after`")]
    fn passing_edge(&self, opening: N, across: N, started: Option<Root<N>>) -> N {
        let closed = opening.is_nothing();
        if closed.all() {
            return N::ZERO;
        }
        let root = match started {
            Some(started) => self.root_after(started, across),
            None => self.root(across).value,
        };
        N::pick(closed, N::ZERO, opening.times(root).limited(self.limit))
    }

    /// Flow through an edge with its slope, at the `larger` opening of the tick.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call with its result in memory is half of what it computes")]
    fn passing_linearised(
        &self,
        closed: N::Mask,
        opening: N,
        larger: N,
        across: N,
        filling: Filling<N>,
    ) -> (Linearised<N>, Root<N>) {
        if closed.all() {
            let closed = Linearised { flow: N::ZERO, opening: N::ZERO, slope: self.unity };
            return (closed, Root { across, value: N::ZERO, slope: self.unity });
        }
        let root = self.root(across);
        let free = opening.times(root.value);
        let (flow, within) = free.clipped(self.limit);
        let opening = self.sloping(within, larger, [flow, free], across, filling);
        (Linearised { flow: N::pick(closed, N::ZERO, flow), opening, slope: root.slope }, root)
    }

    /// Sum of the pressure differences over the two open edges, for either direction of the spool, without sign.
    #[inline]
    pub(crate) fn across_open<V: Knows<EdgeEffects<N>>>(
        &self,
        pressures: ChamberState<N>,
        supply: N,
    ) -> AcrossEdges<N> {
        let Lines { supply, tank } = self.lines_at::<V>(supply);
        let sum = |from: N, to: N| (supply - from).magnitude() + (to - tank).magnitude();
        AcrossEdges { extending: sum(pressures.a, pressures.b), retracting: sum(pressures.b, pressures.a) }
    }

    /// The supply and tank pressures, with the supply as it is now where it droops.
    #[inline]
    pub(crate) fn lines_at<V: Knows<EdgeEffects<N>>>(&self, supply: N) -> Lines<N> {
        let droops = V::of(self.effects.kept()).is_some_and(|effects| effects.droop.is_some());
        if droops { Lines { supply, ..self.lines } } else { self.lines }
    }

    /// Spool travel beyond the dead zone, times the flow gain.
    #[inline]
    fn opening(&self, spool: N) -> N {
        N::dot([self.gain], [self.overlap.beyond(spool)])
    }

    /// Pressure differences over the edges that an opening of this sign connects.
    #[inline]
    fn across(&self, opening: N, pressures: ChamberState<N>) -> Flows<N> {
        let Lines { supply, tank } = self.lines;
        Flows {
            a: opening.select_positive(supply - pressures.a, pressures.a - tank),
            b: opening.select_positive(pressures.b - tank, supply - pressures.b),
        }
    }
}
