//! The chain below the valve, solved together: one tick of flow, chambers and mechanics.
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
//! For an orifice J takes the slope of the chord to Δp = 0, never the flatter tangent: with the tangent a stiff chamber that
//! empties through its orifice overshoots within a stage to where the root is steep, and the two stages can cancel far from the true
//! steady state.
//!
//! The velocity couples to both pressures and each pressure to the velocity only, so the system is eliminated to one
//! equation for the velocity by hand. The method keeps its second order with any approximate Jacobian J.
//!
//! Both stages are written so that the links do the last step themselves: the solution yields each tick's mean flows and
//! stage forces, from which [`Chambers`] and [`Mechanics`] alone reproduce the chain bit for bit.

use crate::chambers::{ChamberEffects, ChamberState, Chambers};
use crate::drive::{DriveState, Interfaces, Load};
use crate::feed::Feed;
use crate::flow::Flows;
use crate::mechanics::{Forces, MechanicalEffects, Mechanics, Surroundings};
use crate::number::{Mask, Number};
use crate::temperature::{Oil, Viscosity};
use crate::unnamed::{States, Unnamed};
use crate::vocabulary::{Keeps, Vocabulary};

/// The links of a drive below its valve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chain<'a, N: Number, C = ChamberEffects<N>, M = MechanicalEffects<N>> {
    pub(crate) chambers: &'a Chambers<N, C>,
    pub(crate) mechanics: &'a Mechanics<N, M>,
    /// γ
    pub(crate) gamma: N::Gain,
    /// γ²·mobility·stiffness of each chamber: the oil springs in the eliminated equation.
    pub(crate) springs: [N::Steep; 2],
    pub(crate) viscosity: Option<&'a Viscosity<N>>,
    pub(crate) unnamed: Option<&'a Unnamed<N>>,
}

impl<N: Number, C: Keeps<ChamberEffects<N>>, M: Keeps<MechanicalEffects<N>>> Chain<'_, N, C, M> {
    /// All links below the valve.
    #[inline]
    pub(crate) fn step<V: Vocabulary, const DELAY: usize>(
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
        let filled = self.chambers.at::<V>(pressures, position, oil.map(|oil| oil.thinness));
        let chambers = filled.as_ref().map_or(self.chambers, |filled| &filled.chambers);
        let slider = feed.slider().map_or(N::ZERO, |slider| (slider.from + slider.to).halved());
        let around = self.surroundings::<V, DELAY>(state, slider, oil);
        let added = V::on(self.unnamed).map(|unnamed| unnamed.flows(States::of(state, slider)));
        let with = |flows: Flows<N>| added.map_or(flows, |more| Flows { a: flows.a + more.a, b: flows.b + more.b });
        let equation = mechanics.equation::<V>(&state.motion, around);
        let constant = mechanics.load;

        let motion = &state.motion;
        let filling = || {
            let beside = with(chambers.inflow::<V>(Flows { a: N::ZERO, b: N::ZERO }, pressures));
            chambers.filling(mechanics.making_room::<V>(motion), beside)
        };
        let (flows, drawn) = feed.start::<V>(pressures, state.supply.pressure, filling);
        let yielding = chambers.yielding::<V>(&flows);
        let start = self.pressure_force(pressures) + load.from + constant;
        let contact = equation.contact(velocity, start);
        // 1/(1 + γ²·mobility·(springs that yield)): the eliminated equation for the velocity.
        let weights = match filled.as_ref().and_then(|filled| filled.shares) {
            Some(shares) => [yielding.a.of(shares.a), yielding.b.of(shares.b)],
            None => [yielding.a, yielding.b],
        };
        let give = |share: Option<N>| {
            N::inverse_one_plus(share.map_or(weights, |share| weights.map(|weight| weight.times(share))), self.springs)
        };
        let gives = if contact.sticks.all() { None } else { Some(equation.gives(give)) };

        // First stage.
        let inflow1 = with(chambers.inflow::<V>(Flows { a: flows.a.flow, b: flows.b.flow }, pressures));
        let net = Flows { a: inflow1.a - velocity, b: chambers.displaced_b(velocity) - inflow1.b };
        let trial = Flows { a: yielding.a.of(net.a), b: yielding.b.of(net.b) };
        let force = self.force_after(chambers, pressures, start, trial, [load.from, constant]);
        let stage = equation.first_stage(contact, velocity);
        let guess = equation.first_increment(&stage, force, gives);
        let ahead = guess.part(self.gamma);
        let net1 = Flows { a: yielding.a.of(net.a - ahead), b: yielding.b.of(net.b + chambers.displaced_b(ahead)) };
        let k1 = chambers.rise(net1);
        let first = self.force_after(chambers, pressures, start, net1, [load.from, constant]);
        let v1 = equation.first_increment(&stage, first, None);

        // Second stage.
        let (pressures2, velocity2) = (ChamberState { a: pressures.a + k1.a, b: pressures.b + k1.b }, velocity + v1);
        let supply2 = feed.supplied::<V>(pressures2, state.supply, drawn);
        let inflow2 = with(chambers.inflow::<V>(feed.end::<V>(pressures2, supply2.pressure), pressures2));
        let net = Flows {
            a: inflow2.a - velocity2 - net1.a - net1.a,
            b: chambers.displaced_b(velocity2) - inflow2.b - net1.b - net1.b,
        };
        let trial = Flows { a: yielding.a.of(net.a), b: yielding.b.of(net.b) };
        let start2 = self.pressure_force(pressures2) + load.to + constant;
        let force = self.force_after(chambers, pressures2, start2, trial, [load.to, constant]);
        let stage = equation.second_stage(contact, velocity, v1);
        let guess = equation.second_increment(&stage, force, gives);
        let ahead = guess.part(self.gamma);
        let net2 = Flows { a: yielding.a.of(net.a - ahead), b: yielding.b.of(net.b + chambers.displaced_b(ahead)) };
        let second = self.force_after(chambers, pressures2, start2, net2, [load.to, constant]);
        let v2 = equation.second_increment(&stage, second, None);

        // The links take the step.
        let moved = equation.finish(contact, &mut state.motion, v1, v2);
        let mean = moved.solved;
        let kept = Flows { a: net1.a.weighed(net2.a), b: net1.b.weighed(net2.b) };
        // A flow that no pressure moves has the mean of its ends. Taken so, a closed valve passes exactly nothing: the solved
        // flow's rounding would pump the closed chambers up within hours.
        let solved = |flow: N| if Mechanics::<N>::is_held(v1, v2) { None } else { Some(flow) };
        let flows = Flows {
            a: chambers.mean::<V>(&flows.a, inflow1.a, inflow2.a, solved(kept.a + mean)),
            b: chambers.mean::<V>(&flows.b, inflow1.b, inflow2.b, solved(chambers.displaced_b(mean) - kept.b)),
        };
        let (flows, mean) = match moved.beyond {
            None => (flows, mean),
            Some(beyond) => (chambers.stopped(flows, beyond, &yielding), mean - beyond),
        };
        chambers.fill(&mut state.chambers, &mut state.rest, flows, mean);
        state.supply = feed.supplied::<V>(state.chambers, state.supply, drawn);
        Interfaces {
            slider: feed.slider(),
            flows,
            forces: Forces { start, first, second, around },
            velocity: mean,
            position,
        }
    }

    /// The oil at the start of a tick, where it changes.
    #[inline]
    pub(crate) fn oil<V: Vocabulary, const DELAY: usize>(&self, state: &DriveState<N, DELAY>) -> Option<Oil<N>> {
        V::on(self.viscosity).map(|viscosity| viscosity.oil(state.warmth, state.oil_temperature))
    }

    /// What friction depends on beside the motion.
    #[inline]
    pub(crate) fn surroundings<V: Vocabulary, const DELAY: usize>(
        &self,
        state: &DriveState<N, DELAY>,
        slider: N,
        oil: Option<Oil<N>>,
    ) -> Surroundings<N> {
        let pushed = V::on(self.mechanics.effects.kept()).is_some_and(|effects| effects.push.is_some());
        Surroundings {
            pressed: state.chambers.a.max(N::ZERO) + state.chambers.b.max(N::ZERO),
            viscosity: oil.map_or(N::ZERO, |oil| oil.excess),
            states: if pushed { States::of(state, slider) } else { States::NONE },
        }
    }

    /// pa − α·pb.
    #[inline]
    fn pressure_force(&self, pressures: ChamberState<N>) -> N {
        pressures.a - self.chambers.displaced_b(pressures.b)
    }

    /// Net force with γ of a stage's pressure rise ahead, for the oil `net` that stays in the chambers; `before` is the one at
    /// these pressures, `beside` what acts with them.
    #[inline]
    fn force_after(
        &self,
        chambers: &Chambers<N, C>,
        pressures: ChamberState<N>,
        before: N,
        net: Flows<N>,
        [load, constant]: [N; 2],
    ) -> N {
        before.and_more(chambers.ahead, [net.a, net.b], || {
            let rise = chambers.rise(net);
            let ahead = |pressure: N, rise: N| pressure + rise.part(self.gamma);
            let raised = ChamberState { a: ahead(pressures.a, rise.a), b: ahead(pressures.b, rise.b) };
            self.pressure_force(raised) + load + constant
        })
    }
}
