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
    #[inline]
    pub fn step(&self, state: &mut ChamberState<N>, flows: Flows<N>, velocity: N) {
        let rise = self.rise(Flows { a: flows.a - velocity, b: self.displaced_b(velocity) - flows.b });
        *state = ChamberState { a: state.a + rise.a, b: state.b + rise.b };
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

    /// Mean flow of a tick at one port: of its two ends where it does not depend on the pressure, else as solved.
    #[inline]
    pub(crate) fn mean(&self, side: &Linearised<N>, from: N, to: N, solved: N) -> N {
        let given = side.opening == N::ZERO && self.leakage == N::ZERO;
        if given { (from + to).halved() } else { solved }
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
