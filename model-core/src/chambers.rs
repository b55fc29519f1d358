//! The chambers link: flows and velocity → pressures. (1), (2), (5)–(7), (9)–(11) of the paper.
//!
//! Flows are scaled so that 1 is what the piston's side A displaces at velocity 1. Then
//! dpa = ca·(qa − v) and dpb = cb·(α·v − qb) over a tick, with α = Ab/Aa and c = h·(E0/V)·A·(velocity base)/(pressure base).

use crate::flow::{Flows, Linearised};
use crate::number::Number;

/// Coefficients of both chambers at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chambers<N: Number> {
    /// ca: pressure rise in A over a tick at flow 1.
    pub(crate) stiffness_a: N::Gain,
    /// cb: pressure rise in B over a tick at flow −1.
    pub(crate) stiffness_b: N::Gain,
    /// γ·ca and γ·cb as signals, for the diagonal of the implicit step.
    pub(crate) implicit: Flows<N>,
    /// α = Ab/Aa. (5)
    pub(crate) ratio: N::Gain,
    /// Internal leakage: flow per pressure difference. 0 is neutral.
    pub(crate) leakage: N,
    /// Whether leakage evens the pressures within a few ticks, so that its mean flow has to be the solved one.
    pub(crate) leaks_fast: bool,
    /// 1, as a slope.
    pub(crate) unity: N::Steep,
}

/// Pressures of both chambers, per unit of supply pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ChamberState<N> {
    /// Chamber A.
    pub a: N,
    /// Chamber B.
    pub b: N,
}

impl<N: Number> Chambers<N> {
    /// One tick with the mean flows (net of leakage) and the mean velocity of that tick. Exact: the volume balance (11).
    ///
    /// `rest` is what rounding left of both pressures, for [`Number::accumulated`]: a flow that raises a pressure by less than
    /// half a step a tick still fills the chamber.
    #[inline]
    pub fn step(&self, state: &mut ChamberState<N>, rest: &mut ChamberState<N>, flows: Flows<N>, velocity: N) {
        let net = Flows { a: flows.a - velocity, b: self.displaced_b(velocity) - flows.b };
        (state.a, rest.a) = state.a.accumulated(rest.a, [self.stiffness_a], [net.a]);
        (state.b, rest.b) = state.b.accumulated(rest.b, [self.stiffness_b], [net.b]);
    }

    /// Pressure rise over a tick for the net oil that stays in each chamber.
    #[inline]
    pub(crate) fn rise(&self, net: Flows<N>) -> ChamberState<N> {
        ChamberState { a: N::dot([self.stiffness_a], [net.a]), b: N::dot([self.stiffness_b], [net.b]) }
    }

    /// Flow that the rod side displaces. (6)
    #[inline]
    pub(crate) fn displaced_b(&self, velocity: N) -> N {
        N::dot([self.ratio], [velocity])
    }

    /// Flow past the piston, from A to B.
    #[inline]
    pub(crate) fn leaked(&self, pressures: ChamberState<N>) -> N {
        self.leakage.times(pressures.a - pressures.b)
    }

    /// Mean flow of a tick at one port: as solved, where it depends on the pressure and there is a solution; else that of its ends.
    ///
    /// Of its ends, leakage leaves one chamber with the very word that enters the other, and no oil comes from rounding.
    #[inline]
    pub(crate) fn mean(&self, side: &Linearised<N>, from: N, to: N, solved: Option<N>) -> N {
        let depends = side.opening != N::ZERO || self.leaks_fast;
        solved.filter(|_| depends).unwrap_or_else(|| (from + to).halved())
    }

    /// How far each chamber yields in the implicit step: 1/(1 − γ·h·∂f/∂p).
    ///
    /// Leakage couples the chambers; on the diagonal it counts twice, which over-damps that coupling.
    #[inline]
    pub(crate) fn yielding(&self, flows: &Flows<Linearised<N>>) -> Flows<N> {
        let twice = self.leakage + self.leakage;
        let side = |implicit: N, side: &Linearised<N>| {
            N::inverse_one_plus([implicit.times(side.opening), implicit.times(twice)], [side.slope, self.unity])
        };
        Flows { a: side(self.implicit.a, &flows.a), b: side(self.implicit.b, &flows.b) }
    }
}
