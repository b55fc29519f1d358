//! ```text
//! Qa = Qsa + Qha                     Qb = Qsb + Qhb                      (1), (2)
//! Aa = A                             Ab = α·A                            (5)
//! Qha = A·dy/dt                      Qhb = α·A·dy/dt                     (6)
//! Qsa = Va/E0·dpa/dt                 Qsb = −Vb/E0·dpb/dt                 (7)
//! Qa − Qha = Qsa = Va/E0·dpa/dt                                          (9)
//! Qa − A·dy/dt = Qsa = Va/E0·dpa/dt                                      (10)
//! dpa/dt = E0/Va·(Qa − A·dy/dt)      dpb/dt = E0/Vb·(α·A·dy/dt − Qb)     (11)
//! ```
//!
//! The chambers link: flows and velocity → pressures. As computed, with the mean flows and the mean velocity v of a tick h:
//!
//! ```text
//! pa' = pa + ca·(qa − v)             ca = h·(E0/Va)·Aa·(velocity base)/(pressure base)
//! pb' = pb + cb·(α·v − qb)           cb = h·(E0/Vb)·Aa·(velocity base)/(pressure base)
//! ```
//!
//! Formats: pressures are signals, 1 being the supply pressure; flows are signals, scaled so that 1 is what the piston's side A displaces at
//! velocity 1; ca, cb and α are gains (below 4). The rounding remainder of a pressure is carried to the next tick, so that no flow is lost.
//!
//! Signs: flow a > 0 fills A, flow b > 0 empties B; v > 0 extends, which makes room in A and reduces the room in B.
//!
//! With entrained air or volumes that follow the piston, ca and cb are those of the tick, see `capacity`.

pub(crate) mod capacity;
pub mod cavitation;

use capacity::Capacity;
use cavitation::{Cavitation, Content, Crossing, Voids};

use crate::effects::{AnyEffect, Keeps, Knows, LinkEffects};
use crate::number::Number;
use crate::ports::{ChamberState, Filling, Flows, Linearised};

/// Coefficients of both chambers at one tick, with those of their effects.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(bound = "N: crate::number::Written, E: serde::Serialize")
)]
pub struct Chambers<N: Number, E = ChamberEffects<N>> {
    /// ca: pressure rise in A over a tick at flow 1; where the capacity varies, at the least capacity.
    #[doc(hidden)]
    pub stiffness_a: N::Gain,
    /// cb: pressure rise in B over a tick at flow −1.
    #[doc(hidden)]
    pub stiffness_b: N::Gain,
    /// γ·ca and γ·cb as signals, for the diagonal of the implicit step.
    #[doc(hidden)]
    pub implicit: Flows<N>,
    /// γ·ca and −γ·α·cb: force on the rod by the pressure rise of a stage, per net oil of each chamber.
    #[doc(hidden)]
    pub ahead: [N::Gain; 2],
    /// α = Ab/Aa. (5)
    #[doc(hidden)]
    pub ratio: N::Gain,
    /// 1, as a slope.
    #[doc(hidden)]
    pub unity: N::Steep,
    #[doc(hidden)]
    pub effects: E,
}

/// Coefficients of the chambers' effects.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
pub struct ChamberEffects<N: Number> {
    /// Internal leakage: flow per pressure difference, in the thinnest oil. 0 is neutral.
    #[doc(hidden)]
    pub leakage: N,
    /// Whether leakage equalises the pressures within a few ticks, so that its mean flow must be the solved one.
    #[doc(hidden)]
    pub leaks_fast: bool,
    /// Leakage to tank.
    #[doc(hidden)]
    pub external: Option<ExternalLeakage<N>>,
    /// Effects that make the chambers softer than these coefficients.
    #[doc(hidden)]
    pub capacity: Option<Capacity<N>>,
    /// Cavitation, which keeps the pressures above a floor.
    #[doc(hidden)]
    pub cavitation: Option<Cavitation<N>>,
}

/// Laminar leakage out of both chambers: flow per pressure above tank, in the thinnest oil.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[doc(hidden)]
pub struct ExternalLeakage<N> {
    pub a: N,
    pub b: N,
    /// Pressure of the tank.
    pub tank: N,
}

/// Leakage of both chambers in a tick, in the oil of that tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaks<N> {
    /// Past the piston: flow per pressure difference.
    past: N,
    external: Option<ExternalLeakage<N>>,
}

/// Effect of each chamber's net oil on the rod within a stage, as far as the chamber yields.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pushing<N: Number> {
    /// Force on the rod per flow that would stay in A, and in B.
    pub(crate) force: [N::Gain; 2],
    /// Force that the rod meets per velocity.
    pub(crate) stiffness: N,
}

impl<N: Number, E> Chambers<N, E> {
    /// The same chambers with these effects.
    #[inline]
    pub(crate) fn with<F>(&self, effects: F) -> Chambers<N, F> {
        let &Self { stiffness_a, stiffness_b, implicit, ahead, ratio, unity, .. } = self;
        Chambers { stiffness_a, stiffness_b, implicit, ahead, ratio, unity, effects }
    }
}

impl<N: Number> LinkEffects for ChamberEffects<N> {}

impl<N: Number> ChamberEffects<N> {
    /// Whether no effect is on.
    pub(crate) fn are_off(&self) -> bool {
        self.leakage == N::ZERO
            && !self.leaks_fast
            && self.external.is_none()
            && self.capacity.is_none()
            && self.cavitation.is_none()
    }
}

impl<N: Number> Chambers<N> {
    /// One tick with the mean flows (net of leakage), the mean velocity of that tick, the pressures halfway through it (see
    /// [`Interfaces`](crate::drive::Interfaces)), and the position at its start in strokes. Exact: the volume balance (11), at the capacity there.
    ///
    /// `rest` is the rounding remainder of both pressures, for [`Number::accumulated`]: with it, a flow that raises a pressure by less than
    /// half a step of the format per tick still fills the chamber. `voids` grow where oil would have to pull, with `cavitation`.
    #[inline]
    pub fn step(
        &self,
        state: &mut ChamberState<N>,
        rest: &mut ChamberState<N>,
        voids: &mut Voids<N>,
        flows: Flows<N>,
        velocity: N,
        (midway, position): (ChamberState<N>, N),
    ) {
        if let Some(cavitation) = &self.effects.cavitation {
            self.take::<AnyEffect>(cavitation, state, rest, voids, (flows, velocity, midway, position));
            return;
        }
        match &self.effects.capacity {
            None => self.fill(state, rest, flows, velocity),
            Some(capacity) => self.filled(capacity, midway, position).fill(state, rest, flows, velocity),
        }
    }

    /// The same for chambers that may cavitate; returns for each whether it emptied or filled in the tick.
    pub(crate) fn take<V: Knows<ChamberEffects<N>>>(
        &self,
        cavitation: &Cavitation<N>,
        state: &mut ChamberState<N>,
        rest: &mut ChamberState<N>,
        voids: &mut Voids<N>,
        (flows, velocity, midway, position): (Flows<N>, N, ChamberState<N>, N),
    ) -> Flows<Crossing<N>> {
        let capacity = V::its(&self.effects).capacity.as_ref();
        let filled = capacity.map(|capacity| self.filled(capacity, midway, position));
        let Self { stiffness_a, stiffness_b, .. } = *filled.as_ref().unwrap_or(self);
        let net = self.net(flows, velocity);
        let take = |stiffness, pressure: &mut N, rest: &mut N, void: &mut N::Travel, net| {
            let mut content = Content { pressure: *pressure, rest: *rest, void: *void };
            let crossing = cavitation.take(stiffness, &mut content, net);
            (*pressure, *rest, *void) = (content.pressure, content.rest, content.void);
            crossing
        };
        Flows {
            a: take(stiffness_a, &mut state.a, &mut rest.a, &mut voids.a, net.a),
            b: take(stiffness_b, &mut state.b, &mut rest.b, &mut voids.b, net.b),
        }
    }
}

impl<N: Number, E: Keeps<ChamberEffects<N>>> Chambers<N, E> {
    /// The chambers at these pressures, with the piston at this position (strokes), where these make a difference.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn at<V: Knows<ChamberEffects<N>>>(&self, pressures: ChamberState<N>, position: N) -> Option<Self> {
        let capacity = V::of(self.effects.kept())?.capacity.as_ref()?;
        Some(self.filled(capacity, pressures, position))
    }

    /// The leakage in oil of this thinness; `None` is that of the machine's values.
    #[inline]
    pub(crate) fn leaks<V: Knows<ChamberEffects<N>>>(&self, thinness: Option<N>) -> Leaks<N> {
        let Some(effects) = V::of(self.effects.kept()) else { return Leaks { past: N::ZERO, external: None } };
        let thinned = |flow: N| thinness.map_or(flow, |thinness| flow.times(thinness));
        Leaks {
            past: thinned(effects.leakage),
            external: effects.external.map(|out| ExternalLeakage { a: thinned(out.a), b: thinned(out.b), ..out }),
        }
    }

    /// The leakage past the piston, where there may be any.
    #[inline]
    fn past<V: Knows<ChamberEffects<N>>>(effects: &ChamberEffects<N>, leaks: &Leaks<N>) -> Option<N> {
        if V::is_off(effects.leakage) { None } else { Some(leaks.past) }
    }

    /// The leakage out of both chambers, where there is any.
    #[inline]
    fn out<V: Knows<ChamberEffects<N>>>(effects: &ChamberEffects<N>, leaks: &Leaks<N>) -> Option<ExternalLeakage<N>> {
        if V::KNOWN && effects.external.is_none() { None } else { leaks.external }
    }

    /// Pressures halfway through a tick that starts at these with these flows at the ports, for chambers whose capacity depends on the
    /// pressures; as implicit as the step, so that a stiff chamber does not overshoot where it is filled to.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn midway<V: Knows<ChamberEffects<N>>>(
        &self,
        pressures: ChamberState<N>,
        velocity: N,
        ports: Flows<N>,
        flows: &Flows<Linearised<N>>,
        leaks: &Leaks<N>,
    ) -> Option<ChamberState<N>> {
        let capacity = V::of(self.effects.kept())?.capacity.as_ref()?;
        if !capacity.is_airy {
            return None;
        }
        let (net, yielding) = (self.net(ports, velocity), self.yielding::<V>(flows, leaks));
        let rise = self.rise(Flows { a: yielding.a.of(net.a), b: yielding.b.of(net.b) });
        Some(ChamberState { a: pressures.a + rise.a.halved(), b: pressures.b + rise.b.halved() })
    }

    #[inline]
    fn filled(&self, capacity: &Capacity<N>, pressures: ChamberState<N>, position: N) -> Self {
        self.softened(capacity.shares(pressures, position))
    }

    /// The chambers with shares, 0..1, of their stiffness.
    #[inline]
    pub(crate) fn softened(&self, shares: Flows<N>) -> Self {
        let [ahead_a, ahead_b] = self.ahead;
        Self {
            stiffness_a: N::scaled(self.stiffness_a, shares.a),
            stiffness_b: N::scaled(self.stiffness_b, shares.b),
            implicit: Flows { a: shares.a.of(self.implicit.a), b: shares.b.of(self.implicit.b) },
            ahead: [N::scaled(ahead_a, shares.a), N::scaled(ahead_b, shares.b)],
            ..*self
        }
    }

    /// Takes in a tick's mean flows.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call with everything in memory is half of what it computes")]
    pub(crate) fn fill(&self, state: &mut ChamberState<N>, rest: &mut ChamberState<N>, flows: Flows<N>, velocity: N) {
        let net = self.net(flows, velocity);
        (state.a, rest.a) = state.a.accumulated(rest.a, [self.stiffness_a], [net.a]);
        (state.b, rest.b) = state.b.accumulated(rest.b, [self.stiffness_b], [net.b]);
    }

    /// Oil that stays in each chamber.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as `fill`")]
    fn net(&self, flows: Flows<N>, velocity: N) -> Flows<N> {
        Flows { a: flows.a - velocity, b: self.displaced_b(velocity) - flows.b }
    }

    /// Mean flows of a tick at the ports, corrected for the velocity `beyond` that a stop took from the rod: each chamber takes its yielding share.
    #[inline]
    pub(crate) fn stopped(&self, flows: Flows<N>, beyond: N, yielding: &Flows<N>) -> Flows<N> {
        let beyond_b = self.displaced_b(beyond);
        Flows { a: flows.a - (beyond - yielding.a.of(beyond)), b: flows.b - (beyond_b - yielding.b.of(beyond_b)) }
    }

    /// Pressure rise over a tick for the net oil that stays in each chamber.
    #[inline]
    pub(crate) fn rise(&self, net: Flows<N>) -> ChamberState<N> {
        ChamberState { a: N::dot([self.stiffness_a], [net.a]), b: N::dot([self.stiffness_b], [net.b]) }
    }

    /// How a tick fills both chambers while a rod at this velocity makes room; `beside` are flows into A and out of B in addition to the feed's.
    #[inline]
    pub(crate) fn filling(&self, velocity: N, beside: Flows<N>) -> Flows<Filling<N>> {
        Flows {
            a: Filling { stiffness: self.stiffness_a, room: velocity - beside.a },
            b: Filling { stiffness: self.stiffness_b, room: self.displaced_b(velocity) - beside.b },
        }
    }

    /// Effect of the oil on the rod within a stage, in chambers that yield this far.
    #[inline]
    pub(crate) fn pushing(&self, yielding: &Flows<N>) -> Pushing<N> {
        let [a, b] = self.ahead;
        let (a, b) = (N::scaled(a, yielding.a), N::scaled(b, yielding.b));
        Pushing { force: [a, b], stiffness: N::of_gain(a) - self.displaced_b(N::of_gain(b)) }
    }

    /// Net flows that remain in the chambers when the rod moves faster by `velocity`.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn beside_rod(&self, net: Flows<N>, velocity: N) -> Flows<N> {
        Flows { a: net.a - velocity, b: net.b + self.displaced_b(velocity) }
    }

    /// Flow that the rod side displaces. (6)
    #[inline]
    pub(crate) fn displaced_b(&self, velocity: N) -> N {
        N::dot([self.ratio], [velocity])
    }

    /// Flow into A and out of B with the leakage past the piston and out of both chambers.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn inflow<V: Knows<ChamberEffects<N>>>(
        &self,
        flows: Flows<N>,
        pressures: ChamberState<N>,
        leaks: &Leaks<N>,
    ) -> Flows<N> {
        let Some(effects) = V::of(self.effects.kept()) else { return flows };
        let inner = match Self::past::<V>(effects, leaks) {
            Some(past) => {
                let leaked = past.times(pressures.a - pressures.b);
                Flows { a: flows.a - leaked, b: flows.b - leaked }
            }
            None => flows,
        };
        let Some(ExternalLeakage { a, b, tank }) = Self::out::<V>(effects, leaks) else { return inner };
        Flows { a: inner.a - a.times(pressures.a - tank), b: inner.b + b.times(pressures.b - tank) }
    }

    /// Mean flow of a tick at one port: the solved one, where it depends on the pressure and there is a solution; else the mean of start and end.
    ///
    /// With the mean of start and end, leakage out of one chamber equals leakage into the other to the bit, and rounding creates no oil.
    #[inline]
    pub(crate) fn mean<V: Knows<ChamberEffects<N>>>(
        &self,
        side: &Linearised<N>,
        from: N,
        to: N,
        solved: Option<N>,
    ) -> N {
        let of_its_ends = || (from + to).halved();
        match solved {
            None => of_its_ends(),
            Some(solved) if V::of(self.effects.kept()).is_some_and(|effects| effects.leaks_fast) => solved,
            Some(solved) => N::choose(side.opening.equals(N::ZERO), of_its_ends, || solved),
        }
    }

    /// How far each chamber yields in the implicit step: 1/(1 − γ·h·∂f/∂p).
    ///
    /// Leakage couples the chambers; on the diagonal it counts twice, which over-damps that coupling.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn yielding<V: Knows<ChamberEffects<N>>>(
        &self,
        flows: &Flows<Linearised<N>>,
        leaks: &Leaks<N>,
    ) -> Flows<N> {
        let tight = || {
            let side = |implicit: N, side: &Linearised<N>| {
                let yields = || N::inverse_one_plus([implicit.times(side.opening)], [side.slope]);
                if !N::SHORTCUTS {
                    return yields();
                }
                N::choose(side.opening.is_nothing(), || N::ONE, yields)
            };
            Flows { a: side(self.implicit.a, &flows.a), b: side(self.implicit.b, &flows.b) }
        };
        let Some(effects) = V::of(self.effects.kept()) else { return tight() };
        let (past, out) = (Self::past::<V>(effects, leaks), Self::out::<V>(effects, leaks));
        if past.is_none() && out.is_none() {
            return tight();
        }
        let twice = past.map_or(N::ZERO, |past| past + past);
        let [out_a, out_b] = out.map_or([twice; 2], |out| [twice + out.a, twice + out.b]);
        let side = |implicit: N, side: &Linearised<N>, leakage: N| {
            let weights = || [implicit.times(side.opening), implicit.times(leakage)];
            let yields = || N::inverse_one_plus(weights(), [side.slope, self.unity]);
            if !N::SHORTCUTS {
                return yields();
            }
            N::choose(side.opening.is_nothing() & leakage.is_nothing(), || N::ONE, yields)
        };
        Flows { a: side(self.implicit.a, &flows.a, out_a), b: side(self.implicit.b, &flows.b, out_b) }
    }
}
