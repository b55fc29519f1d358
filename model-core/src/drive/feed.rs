//! What feeds the chambers in a tick: the valve's edges, the pump, or flows that were measured.

use crate::effects::{Keeps, Knows};
use crate::flow::effects::EdgeEffects;
use crate::flow::supply::Supplied;
use crate::flow::{Edges, Opened, Poppets, Pump, PumpDrive, Root, Started, SupplyState};
use crate::number::Number;
use crate::ports::{ChamberState, Filling, Flows, Linearised, Spool};

/// A feed over one tick.
pub(crate) trait Feed<N: Number> {
    /// The spool, where there is one.
    fn spool(&self) -> Option<Spool<N>>;

    /// Flows at the start of the tick, with their slopes.
    fn start<V: Knows<EdgeEffects<N>>>(
        &self,
        pressures: ChamberState<N>,
        supply: N,
        filling: Flows<Filling<N>>,
    ) -> Started<N>;

    /// Flows at the end of a tick that started with these roots.
    fn end<V: Knows<EdgeEffects<N>>>(
        &self,
        pressures: ChamberState<N>,
        supply: N,
        started: Option<Flows<Root<N>>>,
    ) -> Flows<N>;

    /// The supply at the end of a tick that ends at these pressures; `drawn` is the flow at its start; in this many rounds, from a first guess of
    /// its change. It stays constant where nothing feeds from it.
    fn supplied<V: Knows<EdgeEffects<N>>, const ROUNDS: usize>(
        &self,
        pressures: ChamberState<N>,
        supply: SupplyState<N>,
        drawn: N,
        moved: N,
    ) -> Supplied<N>;
}

/// The valve's edges under a spool.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Metered<'a, N: Number, E = Option<EdgeEffects<N>>> {
    edges: &'a Edges<N, E>,
    spool: Spool<N>,
    /// Openings at the end of the tick.
    opened: Opened<N>,
}

impl<'a, N: Number, E: Keeps<EdgeEffects<N>>> Metered<'a, N, E> {
    /// The edges under a spool over one tick, with load-holding valves that are open this far.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn new<V: Knows<EdgeEffects<N>>>(edges: &'a Edges<N, E>, spool: Spool<N>, poppets: Poppets<N>) -> Self {
        Self { edges, spool, opened: edges.opened::<V>(spool.to, poppets) }
    }
}

impl<N: Number, E: Keeps<EdgeEffects<N>>> Feed<N> for Metered<'_, N, E> {
    #[inline]
    fn spool(&self) -> Option<Spool<N>> {
        Some(self.spool)
    }
    #[inline]
    fn start<V: Knows<EdgeEffects<N>>>(
        &self,
        pressures: ChamberState<N>,
        supply: N,
        filling: Flows<Filling<N>>,
    ) -> Started<N> {
        self.edges.linearised_with::<V>(self.spool, &self.opened, pressures, supply, filling)
    }
    #[inline]
    fn end<V: Knows<EdgeEffects<N>>>(
        &self,
        pressures: ChamberState<N>,
        supply: N,
        started: Option<Flows<Root<N>>>,
    ) -> Flows<N> {
        self.edges.flow_with::<V>(&self.opened, pressures, supply, started)
    }
    #[inline]
    fn supplied<V: Knows<EdgeEffects<N>>, const ROUNDS: usize>(
        &self,
        pressures: ChamberState<N>,
        supply: SupplyState<N>,
        drawn: N,
        moved: N,
    ) -> Supplied<N> {
        self.edges.supplied::<V, ROUNDS>(&self.opened, pressures, supply, drawn, moved)
    }
}

/// Any of them.
#[derive(Clone, Copy, Debug)]
pub(crate) enum AnyFeed<'a, N: Number> {
    Edges(Metered<'a, N>),
    Pump(&'a Pump<N>, PumpDrive<N>),
    Given {
        from: Flows<N>,
        to: Flows<N>,
        /// 1, as a slope.
        unity: N::Steep,
    },
}

impl<N: Number> Feed<N> for AnyFeed<'_, N> {
    #[inline]
    fn spool(&self) -> Option<Spool<N>> {
        if let AnyFeed::Edges(edges) = self { edges.spool() } else { None }
    }
    #[inline]
    fn start<V: Knows<EdgeEffects<N>>>(
        &self,
        pressures: ChamberState<N>,
        supply: N,
        filling: Flows<Filling<N>>,
    ) -> Started<N> {
        let without_roots = |flows: Flows<Linearised<N>>| Started { flows, drawn: N::ZERO, roots: None };
        let given = |from: Flows<N>, unity: N::Steep| {
            let given = |flow: N| Linearised { flow, opening: N::ZERO, slope: unity };
            without_roots(Flows { a: given(from.a), b: given(from.b) })
        };
        match self {
            AnyFeed::Edges(edges) if V::METERED => edges.start::<V>(pressures, supply, filling),
            &AnyFeed::Pump(pump, drive) if V::PUMPED => without_roots(pump.flow(drive, pressures.a, pressures.b)),
            &AnyFeed::Given { from, unity, .. } => given(from, unity),
            // Of another source than the drive's.
            AnyFeed::Edges(Metered { edges: Edges { unity, .. }, .. }) | AnyFeed::Pump(Pump { unity, .. }, _) => {
                given(Flows { a: N::ZERO, b: N::ZERO }, *unity)
            }
        }
    }
    #[inline]
    fn end<V: Knows<EdgeEffects<N>>>(
        &self,
        pressures: ChamberState<N>,
        supply: N,
        started: Option<Flows<Root<N>>>,
    ) -> Flows<N> {
        match self {
            AnyFeed::Edges(edges) if V::METERED => edges.end::<V>(pressures, supply, started),
            &AnyFeed::Pump(pump, drive) if V::PUMPED => {
                let flows = pump.flow(drive, pressures.a, pressures.b);
                Flows { a: flows.a.flow, b: flows.b.flow }
            }
            &AnyFeed::Given { to, .. } => to,
            AnyFeed::Edges(_) | AnyFeed::Pump(..) => Flows { a: N::ZERO, b: N::ZERO },
        }
    }
    #[inline]
    fn supplied<V: Knows<EdgeEffects<N>>, const ROUNDS: usize>(
        &self,
        pressures: ChamberState<N>,
        supply: SupplyState<N>,
        drawn: N,
        moved: N,
    ) -> Supplied<N> {
        match self {
            AnyFeed::Edges(edges) if V::METERED => edges.supplied::<V, ROUNDS>(pressures, supply, drawn, moved),
            _ => Supplied { supply, moved },
        }
    }
}
