//! The flow link: slider (or pump) and pressures → flow into A and out of B. (3), (4), §3 of the paper.
//!
//! Signs: slider > 0 opens P-A and B-T. Flow a > 0 goes into chamber A, flow b > 0 comes out of chamber B.
//! The roots are signed, so a chamber above supply pushes oil back.

use crate::chambers::{ChamberState, Filling};
use crate::edge_effects::EdgeEffects;
use crate::metering::Four;
use crate::number::{Mask, Number};
use crate::valve::{AcrossEdges, Slider};
use crate::vocabulary::{Effects, Keeps, Vocabulary};

/// One flow with what the implicit step needs of its slope against the pressure it works on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linearised<N: Number> {
    /// The flow, per unit.
    pub flow: N,
    /// Magnitude of the opening: the slope is −`opening`·`slope`, that of the chord to no pressure difference; 0 where the flow does not
    /// depend on the pressure.
    pub opening: N,
    /// Slope of the orifice's root: of its chord to zero pressure difference.
    pub slope: N::Steep,
}

/// The flows at the start of a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Started<N: Number> {
    pub(crate) flows: Flows<Linearised<N>>,
    /// Drawn from a supply that droops.
    pub(crate) drawn: N,
    /// Of an orifice each, from which the roots at the end may be taken.
    pub(crate) roots: Option<Flows<Root<N>>>,
}

/// Root of an orifice at the start of a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root<N: Number> {
    across: N,
    value: N,
    /// Of its chord.
    slope: N::Steep,
}

/// Flow into A and out of B.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
pub struct Flows<F> {
    /// Into chamber A.
    pub a: F,
    /// Out of chamber B.
    pub b: F,
}

/// Pressures that the flow link works between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lines<N> {
    /// Supply p0.
    pub supply: N,
    /// Tank.
    pub tank: N,
}

/// Slider travel from the centre that passes no oil, to either side; `dead-zone-asymmetry` lets the sides differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Overlap<N> {
    pub(crate) extending: N,
    pub(crate) retracting: N,
}

impl<N: Number> Overlap<N> {
    /// Travel beyond the overlap, signed like the slider; not renormalised.
    #[inline]
    pub(crate) fn beyond(&self, slider: N) -> N {
        (slider - self.extending).max(N::ZERO) + (slider + self.retracting).min(N::ZERO)
    }
}

/// How far the edges are open at a slider position, flow gain included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Opened<N> {
    /// Of two equal edges, signed like the slider.
    way: N,
    /// Of each, where an effect makes them differ.
    pub(crate) four: Option<Four<N>>,
}

/// The metering edges of a proportional valve: dead zone, square-root orifices, flow saturation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edges<N: Number, E = Option<EdgeEffects<N>>> {
    pub(crate) overlap: Overlap<N>,
    /// `K_Q`·√(pressure base) / flow base.
    pub(crate) gain: N::Gain,
    /// Largest flow, both signs.
    pub(crate) limit: N,
    /// 1, as a slope.
    pub(crate) unity: N::Steep,
    /// Pressure difference at which the root turns from laminar to turbulent, `laminar-transition` included.
    pub(crate) transition: N,
    /// 256 times that: from there on the root's slope is half of its chord's to 8e-6 of it.
    pub(crate) turbulent: N,
    pub(crate) lines: Lines<N>,
    /// What makes the four edges differ; `None` leaves two equal ones at a time.
    pub(crate) effects: E,
}

impl<N: Number, E> Edges<N, E> {
    /// The same edges with these effects.
    #[inline]
    pub(crate) fn with<F>(&self, effects: F) -> Edges<N, F> {
        let &Self { overlap, gain, limit, unity, transition, turbulent, lines, .. } = self;
        Edges { overlap, gain, limit, unity, transition, turbulent, lines, effects }
    }

    /// The opening whose chord is that of a limited flow: all of it, or where it would pass more than the limit the share that does not.
    #[inline]
    pub(crate) fn within_limit(&self, opening: N, flow: N, free: N) -> N {
        N::choose(flow.equals(free), || opening, || self.share_within_limit(free).of(opening))
    }

    /// The opening that a tick's slope is of: of a limited flow none, for no pressure moves it, unless the tick brings the pressures to where it
    /// is not limited; then that of the limit's chord.
    ///
    /// Without that one, a chamber that one tick at the limit overfills would rest between the lines, short of both. With it all the time, a
    /// rod on the oil's spring would swing up, as if the step's slope took from the swing what no flow does.
    #[inline]
    pub(crate) fn sloping(&self, opening: N, [flow, free]: [N; 2], across: N, filling: Filling<N>) -> N {
        N::choose(flow.equals(free), || opening, || self.sloping_at_limit(opening, [flow, free], across, filling))
    }

    /// Whether a tick at the limit takes the pressures past where the limit's chord begins: what it fills, with that chord's share of what is
    /// across, is more than what is across.
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
    /// Flows at a slider position, two chamber pressures, and that of a supply that droops.
    #[inline]
    pub fn flow(&self, slider: N, pressures: ChamberState<N>, supply: N) -> Flows<N> {
        self.flow_with::<Effects>(&self.opened::<Effects>(slider), pressures, supply, None)
    }
}

impl<N: Number, E: Keeps<EdgeEffects<N>>> Edges<N, E> {
    /// The openings at a slider position.
    #[inline]
    pub(crate) fn opened<V: Vocabulary>(&self, slider: N) -> Opened<N> {
        match V::on(self.effects.kept()) {
            Some(effects) => Opened { way: N::ZERO, four: Some(self.openings(effects, slider)) },
            None => Opened { way: self.opening(slider), four: None },
        }
    }

    /// Flows with the edges opened so, in a tick that started with these roots.
    #[inline]
    pub(crate) fn flow_with<V: Vocabulary>(
        &self,
        opened: &Opened<N>,
        pressures: ChamberState<N>,
        supply: N,
        started: Option<Flows<Root<N>>>,
    ) -> Flows<N> {
        if let (Some(effects), Some(four)) = (V::on(self.effects.kept()), &opened.four) {
            return self.flow_of_four(effects, four, pressures, supply);
        }
        let opening = opened.way;
        let across = self.across(opening, pressures);
        Flows {
            a: self.passing_edge(opening, across.a, started.map(|roots| roots.a)),
            b: self.passing_edge(opening, across.b, started.map(|roots| roots.b)),
        }
    }

    /// Flows at the start of a tick at whose end the edges are opened so.
    #[inline]
    pub(crate) fn linearised_with<V: Vocabulary>(
        &self,
        slider: Slider<N>,
        end: &Opened<N>,
        pressures: ChamberState<N>,
        supply: N,
        filling: Flows<Filling<N>>,
    ) -> Started<N> {
        if let (Some(effects), Some(four)) = (V::on(self.effects.kept()), &end.four) {
            let (flows, drawn) = self.linearised_of_four(effects, slider, four, pressures, supply, filling);
            return Started { flows, drawn, roots: None };
        }
        let (from, to) = (self.opening(slider.from), end.way);
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
    /// Where the tick moves what is across by less than 2⁻¹³ of it, half of the chord's slope leads there: to less than a step
    /// of the format, so that nobody sees which way it was computed.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call is half of what the shorter way computes")]
    fn root_after(&self, started: Root<N>, across: N) -> N {
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
        let flow = free.limited(self.limit);
        let opening = self.sloping(larger, [flow, free], across, filling);
        (Linearised { flow: N::pick(closed, N::ZERO, flow), opening, slope: root.slope }, root)
    }

    /// Pressure over both edges that either way of the slider opens, without sign.
    #[inline]
    pub(crate) fn across_open(&self, pressures: ChamberState<N>, supply: N) -> AcrossEdges<N> {
        let Lines { supply, tank } = self.lines_at(supply);
        let sum = |from: N, to: N| (supply - from).magnitude() + (to - tank).magnitude();
        AcrossEdges { extending: sum(pressures.a, pressures.b), retracting: sum(pressures.b, pressures.a) }
    }

    /// The lines, with the supply as it is now where it droops.
    #[inline]
    pub(crate) fn lines_at(&self, supply: N) -> Lines<N> {
        let droops = self.effects.kept().is_some_and(|effects| effects.droop.is_some());
        if droops { Lines { supply, ..self.lines } } else { self.lines }
    }

    /// Dead zone, times the flow gain.
    #[inline]
    fn opening(&self, slider: N) -> N {
        N::dot([self.gain], [self.overlap.beyond(slider)])
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

/// What a pump-controlled drive is driven with over a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PumpDrive<N> {
    /// Speed, in 50 revolutions per second; only its magnitude counts, the directional valve gives the sign.
    pub speed: N,
    /// +1 leads the pump into A and B to tank, −1 the pump into B and A to tank, 0 closes all.
    pub direction: i8,
}

/// A pump with a directional valve. Neither delivers backwards: a check valve holds the load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pump<N: Number> {
    /// Flow per speed into A.
    pub(crate) into_a: N::Gain,
    /// Flow per speed into B.
    pub(crate) into_b: N::Gain,
    /// Slip: flow lost per pressure difference.
    pub(crate) slip: N,
    /// Opening of the returning side.
    pub(crate) back: N,
    /// Pressure difference at which the root turns from laminar to turbulent.
    pub(crate) transition: N,
    pub(crate) lines: Lines<N>,
    /// 1, as a slope.
    pub(crate) unity: N::Steep,
}

impl<N: Number> Pump<N> {
    /// Flows at a drive and two chamber pressures, with their slopes.
    #[inline]
    pub fn flow(&self, drive: PumpDrive<N>, pressure_a: N, pressure_b: N) -> Flows<Linearised<N>> {
        let (over_a, over_b) = (pressure_a - self.lines.tank, pressure_b - self.lines.tank);
        let negative = |side: Linearised<N>| Linearised { flow: -side.flow, ..side };
        match drive.direction {
            1.. => Flows { a: self.delivered(self.into_a, drive.speed, over_a), b: self.returned(over_b) },
            0 => Flows { a: self.blocked(), b: self.blocked() },
            _ => Flows {
                a: negative(self.returned(over_a)),
                b: negative(self.delivered(self.into_b, drive.speed, over_b)),
            },
        }
    }

    #[inline]
    fn delivered(&self, displacement: N::Gain, speed: N, over: N) -> Linearised<N> {
        let flow = N::dot([displacement], [speed.magnitude()]) - self.slip.times(over);
        let delivers = flow.above(N::ZERO);
        let only = |signal: N| N::pick(delivers, signal, N::ZERO);
        Linearised { flow: only(flow), opening: only(self.slip), slope: self.unity }
    }

    #[inline]
    fn returned(&self, over: N) -> Linearised<N> {
        let (root, slope) = over.orifice_root(self.transition);
        Linearised { flow: self.back.times(root), opening: self.back, slope }
    }

    #[inline]
    fn blocked(&self) -> Linearised<N> {
        Linearised { flow: N::ZERO, opening: N::ZERO, slope: self.unity }
    }
}
