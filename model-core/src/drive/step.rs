//! One step of the links below the valve, solved together: flow, chambers and mechanics over one tick.
//!
//! ```text
//! dpa/dt = E0/Va·(Qa − A·v)        dpb/dt = E0/Vb·(α·A·v − Qb)      (11)
//! m·dv/dt = F + A·pa − α·A·pb − Dw·v                               (14)
//! ```
//!
//! Pressures and velocity form a stiff, coupled system. One tick solves it with the two-stage, L-stable, linearly implicit
//! Rosenbrock step ROS2 (Verwer, Spee, Blom, Hundsdorfer: *A second-order Rosenbrock method applied to photochemical dispersion
//! problems*, SIAM J. Sci. Comput. 20, 1999), γ = 1 − 1/√2:
//!
//! ```text
//! (1 − γhJ)·k1 = h·f(tₙ, zₙ)
//! (1 − γhJ)·k2 = h·f(tₙ₊₁, zₙ + k1) − 2·k1
//! zₙ₊₁ = zₙ + 3/2·k1 + 1/2·k2
//! ```
//!
//! k2 is computed through j = (3/2 − γ)·k1 + 1/2·k2. j is smaller the less the solution curves within a tick, and linear terms need not be
//! evaluated again. With f the flow that fills a chamber, or the force on the rod, and as γ² = 2γ − 1/2,
//!
//! ```text
//! (1 − γhJ)·j = (3/2 − γ)·h·f(tₙ, zₙ) + 1/2·h·f(tₙ₊₁, zₙ + k1) − k1
//! zₙ₊₁ = zₙ + γ·k1 + j
//! ```
//!
//! A chamber's share of this is (2 − γ)·n + 1/2·(change of its flow) − yielding·n − γ·jv, with n the flow that filled the chamber at the
//! start of the tick and yielding·n the part of n that stays. The rod's share is
//! jv = mobility·(γ·(force of j) + 1/2·(change of the other forces)) + (1 − γ)/(1 + γ·h·D/m)·v1.
//!
//! For an orifice, J takes the slope of the chord to Δp = 0, never the flatter tangent: with the tangent, a stiff chamber that
//! empties through its orifice overshoots within a stage to where the root is steep, and the two stages can cancel far from the true
//! steady state.
//!
//! The velocity couples to both pressures, and each pressure only to the velocity, so the system is reduced by hand to one
//! equation for the velocity. The method keeps its second order with any approximate Jacobian J.
//!
//! Both stages are written so that the links do the last part of the step themselves: the solution gives each tick's mean flows and
//! stage forces, from which [`Chambers`] and [`Mechanics`] alone reproduce the whole model bit for bit.

use crate::chambers::{ChamberEffects, Chambers};
use crate::correction_table::Unnamed;
use crate::drive::baked::KnowsLinks;
use crate::drive::feed::Feed;
use crate::drive::state::{DriveState, Interfaces, Load};
use crate::effects::Keeps;
use crate::flow::Started;
use crate::flow::supply::{ROUNDS_OF_STAGE, ROUNDS_OF_TICK};
use crate::mechanics::{MechanicalEffects, Mechanics};
use crate::number::Number;
use crate::oil::{Oil, Viscosity};
use crate::ports::{ChamberState, Flows, Forces, States, Surroundings};

/// Weights of a chamber's second stage.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct StageWeights<N: Number> {
    /// 1 − γ: weight of the flow that started to fill the chamber in the first stage.
    pub rest: N::Gain,
    /// ½: weight of the change of that flow.
    pub half: N::Gain,
}

/// The links of a drive below its valve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Links<'a, N: Number, C = ChamberEffects<N>, M = MechanicalEffects<N>> {
    pub(crate) chambers: &'a Chambers<N, C>,
    pub(crate) mechanics: &'a Mechanics<N, M>,
    pub(crate) weights: StageWeights<N>,
    pub(crate) viscosity: Option<&'a Viscosity<N>>,
    pub(crate) unnamed: Option<&'a Unnamed<N>>,
}

impl<N: Number, C: Keeps<ChamberEffects<N>>, M: Keeps<MechanicalEffects<N>>> Links<'_, N, C, M> {
    /// All links below the valve.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn step<V: KnowsLinks<N>, const DELAY: usize>(
        &self,
        state: &mut DriveState<N, DELAY>,
        feed: &impl Feed<N>,
        load: Load<N>,
    ) -> Interfaces<N> {
        let mechanics = self.mechanics;
        let pressures = state.chambers;
        let velocity = state.motion.velocity;
        let position = N::of_travel(state.motion.position);
        let oil = self.oil::<V, DELAY>(state);
        let leaks = self.chambers.leaks::<V>(oil.map(|oil| oil.thinness));
        let filled = self.chambers.at::<V>(pressures, position);
        let chambers = filled.as_ref().unwrap_or(self.chambers);
        let spool = feed.spool().map_or(N::ZERO, |spool| (spool.from + spool.to).halved());
        let around = self.surroundings::<V, DELAY>(state, spool, oil);
        let unnamed = if V::TABLED { self.unnamed } else { None };
        let added = unnamed.map(|unnamed| unnamed.flows(States::of(state, spool)));
        let with = |flows: Flows<N>| added.map_or(flows, |more| Flows { a: flows.a + more.a, b: flows.b + more.b });
        let equation = mechanics.equation::<V>(&state.motion, around);
        let constant = mechanics.load;

        let motion = &state.motion;
        let beside = with(chambers.inflow::<V>(Flows { a: N::ZERO, b: N::ZERO }, pressures, &leaks));
        let filling = chambers.filling(mechanics.making_room::<V>(motion), beside);
        let Started { flows, drawn, roots } = feed.start::<V>(pressures, state.supply.pressure, filling);
        let inflow1 = Flows { a: flows.a.flow, b: flows.b.flow };
        let inflow1 = if V::PLAIN { inflow1 } else { Flows { a: inflow1.a + beside.a, b: inflow1.b + beside.b } };
        // Air makes the capacity depend on the pressure: the tick takes the one that its middle will have. With that of its start an oscillating
        // chamber would lose oil from cycle to cycle.
        let midway = chambers.midway::<V>(pressures, velocity, inflow1, &flows, &leaks);
        let refilled = midway.and_then(|midway| self.chambers.at::<V>(midway, position));
        let chambers = refilled.as_ref().unwrap_or(chambers);
        let yielding = chambers.yielding::<V>(&flows, &leaks);
        let start = self.pressure_force(pressures) + load.from + constant;
        let contact = equation.contact(velocity, start);
        let pushing = chambers.pushing(&yielding);
        let spring = equation.on_spring(contact, pushing.stiffness);

        // First stage. First the flow into a chamber while the rod gains no velocity, then the flow that is left when it does.
        let net = Flows { a: inflow1.a - velocity, b: chambers.displaced_b(velocity) - inflow1.b };
        let stage = equation.first_stage(contact, velocity);
        let force = |before: N, net: Flows<N>| before + N::dot(pushing.force, [net.a, net.b]);
        let after = |ahead: N| force(start, chambers.beside_rod(net, ahead));
        let first = equation.first_force(&stage, force(start, net), &spring, after);
        let v1 = equation.first(&stage, first);
        let ahead1 = v1.velocity.small_part(mechanics.gamma);
        let net = chambers.beside_rod(net, ahead1);
        let net1 = Flows { a: yielding.a.of(net.a), b: yielding.b.of(net.b) };
        let k1 = chambers.rise(net1);

        // Second stage.
        let pressures2 = ChamberState { a: pressures.a + k1.a, b: pressures.b + k1.b };
        let supply2 = feed.supplied::<V, ROUNDS_OF_STAGE>(pressures2, state.supply, drawn, N::ZERO);
        let fed = feed.end::<V>(pressures2, supply2.supply.pressure, roots);
        let inflow2 = with(chambers.inflow::<V>(fed, pressures2, &leaks));
        let StageWeights { rest, half } = self.weights;
        // In this order no partial sum leaves the format before the other sums do.
        let left = |net: N, more: N, stays: N| N::dot([rest, half], [net, more]) + (net - stays);
        let net =
            Flows { a: left(net.a, inflow2.a - inflow1.a, net1.a), b: left(net.b, inflow1.b - inflow2.b, net1.b) };
        let stage = equation.second_stage(contact, &stage, v1.velocity);
        let more = (load.to - load.from).halved();
        let after = |ahead: N| force(more, chambers.beside_rod(net, ahead));
        let second = equation.second_force(&stage, &v1, force(more, net), &spring, after);
        let v2 = equation.second(&stage, &v1, second);
        let ahead2 = v2.small_part(mechanics.gamma);
        let net = chambers.beside_rod(net, ahead2);
        let net2 = Flows { a: yielding.a.of(net.a), b: yielding.b.of(net.b) };

        // The links take the step.
        let gained = [v1.velocity, v2];
        let moved = equation.finish(contact, &mut state.motion, gained, [ahead1, ahead2]);
        let mean = moved.solved;
        let kept =
            Flows { a: net1.a.small_part(mechanics.gamma) + net2.a, b: net1.b.small_part(mechanics.gamma) + net2.b };
        // A flow that does not depend on the pressure has the mean of start and end. So a closed valve passes exactly nothing: rounding of
        // the solved flow would pump the closed chambers up within hours.
        let solved = |flow: N| if moved.held { None } else { Some(flow) };
        let flows = Flows {
            a: chambers.mean::<V>(&flows.a, inflow1.a, inflow2.a, solved(kept.a + mean)),
            b: chambers.mean::<V>(&flows.b, inflow1.b, inflow2.b, solved(chambers.displaced_b(mean) - kept.b)),
        };
        let (flows, mean) = match moved.beyond {
            None => (flows, mean),
            Some(beyond) => (chambers.stopped(flows, beyond, &yielding), mean - beyond),
        };
        chambers.fill(&mut state.chambers, &mut state.rest, flows, mean);
        state.supply = feed.supplied::<V, ROUNDS_OF_TICK>(state.chambers, state.supply, drawn, supply2.moved).supply;
        Interfaces {
            spool: feed.spool(),
            flows,
            forces: Forces { start, first, second, around },
            velocity: mean,
            midway: midway.unwrap_or(pressures),
            position,
        }
    }

    /// The oil at the start of a tick, where it changes.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn oil<V: KnowsLinks<N>, const DELAY: usize>(&self, state: &DriveState<N, DELAY>) -> Option<Oil<N>> {
        let viscosity = if V::WARMS { self.viscosity } else { None };
        viscosity.map(|viscosity| viscosity.oil(state.warmth, state.oil_temperature))
    }

    /// What friction depends on, in addition to the motion.
    #[inline]
    pub(crate) fn surroundings<V: KnowsLinks<N>, const DELAY: usize>(
        &self,
        state: &DriveState<N, DELAY>,
        spool: N,
        oil: Option<Oil<N>>,
    ) -> Surroundings<N> {
        let pushed = V::of(self.mechanics.effects.kept()).is_some_and(|effects| effects.push.is_some());
        Surroundings {
            pressed: state.chambers.a.max(N::ZERO) + state.chambers.b.max(N::ZERO),
            viscosity: oil.map_or(N::ZERO, |oil| oil.excess),
            states: if pushed { States::of(state, spool) } else { States::NONE },
            sprung: N::ONE,
        }
    }

    /// pa − α·pb.
    #[inline]
    fn pressure_force(&self, pressures: ChamberState<N>) -> N {
        pressures.a - self.chambers.displaced_b(pressures.b)
    }
}
