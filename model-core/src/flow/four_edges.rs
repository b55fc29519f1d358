//! The four metering edges one by one: how the flow link computes where an effect makes them differ.
//!
//! ```text
//! Qa = Q(P-A) − Q(A-T)      Qb = Q(B-T) − Q(P-B)      Qs = Q(P-A) + Q(P-B)
//! Q(edge) = K·opening·g(Δp), within the flow limit
//! ```
//!
//! With every effect at 0 this is the flow of [`Edges`] except for rounding: one edge of each port then has the opening of the paper's
//! valve, and the other is closed.

use crate::effects::{Keeps, Knows};
use crate::flow::effects::{EdgeEffects, EdgeSizes, behind_laminar_line};
use crate::flow::opened::{Four, Opened};
use crate::flow::supply::{Draw, Supplied, SupplyState};
use crate::flow::{Edges, Poppets};
use crate::number::{Mask, Number};
use crate::ports::{ChamberState, Filling, Flows, Linearised, Spool};

/// Flow through an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Passing<N: Number> {
    flow: N,
    /// The flow without the limit.
    free: N,
    /// Slope of the root's chord.
    slope: N::Steep,
}

impl<N: Number> Four<Passing<N>> {
    #[inline]
    fn ports(&self) -> Flows<N> {
        Flows { a: self.supply_a.flow - self.tank_a.flow, b: self.tank_b.flow - self.supply_b.flow }
    }

    #[inline]
    fn drawn(&self) -> N {
        self.supply_a.flow + self.supply_b.flow
    }
}

/// Openings of both edges of each kind.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Metered<N> {
    extending: N,
    retracting: N,
    leaking: N,
}

impl<N: Number, E: Keeps<EdgeEffects<N>>> Edges<N, E> {
    /// Flows with edges of these openings, at two chamber pressures and the supply's.
    #[inline]
    pub(crate) fn flow_of_four<V: Knows<EdgeEffects<N>>>(
        &self,
        effects: &EdgeEffects<N>,
        (openings, poppets): (&Four<N>, Poppets<N>),
        pressures: ChamberState<N>,
        supply: N,
    ) -> Flows<N> {
        let effects = V::its(effects);
        let across = self.across_each::<V>(pressures, supply);
        let openings = &effects.behind_holding(openings, poppets, &across);
        self.passing::<V>(effects, openings, &openings.each(N::is_nothing), &across).ports()
    }

    /// Flows at the start of a tick that ends with the openings `to`, with their slopes, and what is drawn from the supply.
    #[inline]
    pub(crate) fn linearised_of_four<V: Knows<EdgeEffects<N>>>(
        &self,
        effects: &EdgeEffects<N>,
        spool: Spool<N>,
        (to, poppets): (&Four<N>, Poppets<N>),
        pressures: ChamberState<N>,
        supply: N,
        filling: Flows<Filling<N>>,
    ) -> (Flows<Linearised<N>>, N) {
        let effects = V::its(effects);
        let across = self.across_each::<V>(pressures, supply);
        let held = |openings: &Four<N>| effects.behind_holding(openings, poppets, &across);
        let (from, to) = (held(&self.openings::<V>(effects, spool.from)), held(to));
        let started = self.way::<V>(effects, spool.from);
        let way = N::choose(started.equals(N::ZERO), || self.way::<V>(effects, spool.to), || started);
        let larger = larger(way, &from, &to);
        let ends = from.with(&to, |from, to| from.is_nothing() & to.is_nothing());
        let closed = ends.with(&larger, |ends, larger| ends & larger.is_nothing());
        let passing = self.passing::<V>(effects, &from, &closed, &across);
        // An edge fills the chamber with what the other edge of its port does not take away.
        let steep = |passing: Passing<N>, opening: N, across: N, filling: Filling<N>| {
            let opening =
                self.sloping(passing.flow.equals(passing.free), opening, [passing.flow, passing.free], across, filling);
            Self::steepness(effects, passing.slope, opening)
        };
        let steep = Four {
            supply_a: steep(passing.supply_a, larger.supply_a, across.supply_a, filling.a.against(passing.tank_a.flow)),
            tank_a: steep(
                passing.tank_a,
                larger.tank_a,
                across.tank_a,
                filling.a.reversed().against(passing.supply_a.flow),
            ),
            supply_b: steep(
                passing.supply_b,
                larger.supply_b,
                across.supply_b,
                filling.b.reversed().against(passing.tank_b.flow),
            ),
            tank_b: steep(passing.tank_b, larger.tank_b, across.tank_b, filling.b.against(passing.supply_b.flow)),
        };
        let supplied = steep.supply_a + steep.supply_b;
        let soft = |own: N| match &effects.droop {
            Some(droop) => droop.softened(own, supplied, effects.slope_scale),
            None => own,
        };
        let flows = passing.ports();
        let port = |flow, opening| Linearised { flow, opening, slope: effects.slope_scale };
        let linearised = Flows {
            a: port(flows.a, soft(steep.supply_a) + steep.tank_a),
            b: port(flows.b, soft(steep.supply_b) + steep.tank_b),
        };
        (linearised, passing.drawn())
    }

    /// The supply at the end of a tick that ends with these openings and pressures; `drawn` is the flow at its start; in this many rounds, from a first guess
    /// of its change.
    #[inline]
    pub(crate) fn supplied<V: Knows<EdgeEffects<N>>, const ROUNDS: usize>(
        &self,
        opened: &Opened<N>,
        pressures: ChamberState<N>,
        supply: SupplyState<N>,
        drawn: N,
        moved: N,
    ) -> Supplied<N> {
        let stays = Supplied { supply, moved };
        let Some(effects) = V::of(self.effects.kept()) else { return stays };
        let Some(droop) = &effects.droop else { return stays };
        let Some(openings) = &opened.four else { return stays };
        droop.after::<ROUNDS>(supply, self.lines.supply, drawn, moved, effects.slope_scale, |supply| {
            // What the tank edges pass does not come from the supply.
            let across = Four { tank_a: N::ZERO, tank_b: N::ZERO, ..self.across_each::<V>(pressures, supply) };
            let openings = effects.behind_holding(openings, opened.poppets, &across);
            let edge = |opening: N, across: N| {
                let closed = opening.is_nothing();
                let passing = || {
                    let passing = self.through(opening, across.orifice_root(self.transition));
                    let opening = self.within_limit(opening, passing.flow, passing.free);
                    (passing.flow, Self::steepness(effects, passing.slope, opening))
                };
                let each = |_, (flow, steep)| (N::pick(closed, N::ZERO, flow), N::pick(closed, N::ZERO, steep));
                closed.branch(|| (N::ZERO, N::ZERO), passing, each)
            };
            let (flow_a, steep_a) = edge(openings.supply_a, across.supply_a);
            let (flow_b, steep_b) = edge(openings.supply_b, across.supply_b);
            Draw { flow: flow_a + flow_b, steepness: steep_a + steep_b }
        })
    }

    /// The direction in which a spool meters, signed like it: 0 in the overlap of sharp edges, and in the middle of rounded ones, of which all are open.
    #[inline]
    fn way<V: Knows<EdgeEffects<N>>>(&self, effects: &EdgeEffects<N>, spool: N) -> N {
        if V::its(effects).rounding.is_some() {
            let [extending, retracting] = self.overlap.past_edges(spool);
            extending - retracting
        } else {
            self.overlap.beyond(spool)
        }
    }

    #[inline]
    fn metered<V: Knows<EdgeEffects<N>>>(&self, effects: &EdgeEffects<N>, spool: N) -> Metered<N> {
        let effects = V::its(effects);
        let [extending, retracting] = effects.metered(self.overlap.past_edges(spool));
        Metered { extending, retracting, leaking: effects.leaking(spool) }
    }

    /// Openings of the edges, flow gain included, none negative.
    #[inline]
    pub(crate) fn openings<V: Knows<EdgeEffects<N>>>(&self, effects: &EdgeEffects<N>, spool: N) -> Four<N> {
        let effects = V::its(effects);
        let Metered { extending, retracting, leaking } = self.metered::<V>(effects, spool);
        let opening = |beyond: N| N::dot([self.gain], [beyond]);
        let tank = |opened: N| opening(effects.behind_line(opened + leaking));
        let sizes = &effects.sizes;
        Four {
            supply_a: opening(extending + leaking),
            tank_a: tank(EdgeSizes::sized(sizes.tank_a, retracting)),
            supply_b: opening(EdgeSizes::sized(sizes.supply_b, retracting) + leaking),
            tank_b: tank(EdgeSizes::sized(sizes.tank_b, extending)),
        }
    }

    /// Flow through an edge of this opening and root.
    #[inline]
    fn through(&self, opening: N, (root, slope): (N, N::Steep)) -> Passing<N> {
        let free = opening.times(root);
        let flow = free.limited(self.limit);
        Passing { flow, free, slope }
    }

    /// Opening times slope, over the scale of slopes.
    #[inline]
    fn steepness(effects: &EdgeEffects<N>, slope: N::Steep, opening: N) -> N {
        opening.times(effects.slope_fraction).amplified(slope)
    }

    /// Pressure differences over the edges.
    #[inline]
    fn across_each<V: Knows<EdgeEffects<N>>>(&self, pressures: ChamberState<N>, supply: N) -> Four<N> {
        let lines = self.lines_at::<V>(supply);
        Four {
            supply_a: lines.supply - pressures.a,
            tank_a: pressures.a - lines.tank,
            supply_b: lines.supply - pressures.b,
            tank_b: pressures.b - lines.tank,
        }
    }

    /// Flows through edges of these openings; nothing is computed where they are `closed`.
    #[inline]
    fn passing<V: Knows<EdgeEffects<N>>>(
        &self,
        effects: &EdgeEffects<N>,
        openings: &Four<N>,
        closed: &Four<N::Mask>,
        across: &Four<N>,
    ) -> Four<Passing<N>> {
        let unless = |closed: N::Mask, passing: &dyn Fn() -> Passing<N>| {
            let nothing = || Passing { flow: N::ZERO, free: N::ZERO, slope: self.unity };
            closed.branch(nothing, passing, |_, passing: Passing<N>| Passing {
                flow: N::pick(closed, N::ZERO, passing.flow),
                free: N::pick(closed, N::ZERO, passing.free),
                ..passing
            })
        };
        let supply = |closed: N::Mask, opening: N, across: N| {
            unless(closed, &|| self.through(opening, across.orifice_root(self.transition)))
        };
        let tank = |closed: N::Mask, opening: N, across: N| match V::its(effects).half_laminar {
            Some(half) => unless(closed, &|| {
                self.through(opening, behind_laminar_line(across, N::dot([half], [opening]), self.transition))
            }),
            None => unless(closed, &|| self.through(opening, across.orifice_root(self.transition))),
        };
        Four {
            supply_a: supply(closed.supply_a, openings.supply_a, across.supply_a),
            tank_a: tank(closed.tank_a, openings.tank_a, across.tank_a),
            supply_b: supply(closed.supply_b, openings.supply_b, across.supply_b),
            tank_b: tank(closed.tank_b, openings.tank_b, across.tank_b),
        }
    }
}

/// The larger openings of a tick, for its slopes; `way` is the sign of the opening that the tick works over.
///
/// If the spool crosses the centre within the tick, the larger opening at its end counts for the edge where it started, as without effects.
#[inline]
fn larger<N: Number>(way: N, from: &Four<N>, to: &Four<N>) -> Four<N> {
    // (working, other) edge of a port at both ends.
    let port = |from: (N, N), to: (N, N)| (from.0.max(to.0.max(to.1)), from.1.max(to.0.min(to.1)));
    let extending = || {
        let (supply_a, tank_a) = port((from.supply_a, from.tank_a), (to.supply_a, to.tank_a));
        let (tank_b, supply_b) = port((from.tank_b, from.supply_b), (to.tank_b, to.supply_b));
        Four { supply_a, tank_a, supply_b, tank_b }
    };
    let retracting = || {
        let (tank_a, supply_a) = port((from.tank_a, from.supply_a), (to.tank_a, to.supply_a));
        let (supply_b, tank_b) = port((from.supply_b, from.tank_b), (to.supply_b, to.tank_b));
        Four { supply_a, tank_a, supply_b, tank_b }
    };
    let pick = |mask: N::Mask| move |yes: Four<N>, no: Four<N>| yes.with(&no, |yes, no| N::pick(mask, yes, no));
    let (extends, rests) = (way.above(N::ZERO), way.equals(N::ZERO));
    let moves = || extends.branch(extending, retracting, pick(extends));
    rests.branch(|| from.with(to, N::max), moves, pick(rests))
}
