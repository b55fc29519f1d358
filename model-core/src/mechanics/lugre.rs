//! Bristles: the elastic contact through which all dry friction acts before the rod slides (`LuGre`).
//!
//! ```text
//! dF/dt = stiffness·(v − |v|·F/g)     g: what all laws of dry friction add up to, in the direction of v, at v
//! ```
//!
//! and light damping of dF/dt. At steady speed F is g; at rest the rod is held by a spring. The state is F, as a share of a
//! reference that g rarely exceeds. With x = h·stiffness·|v|/g its own step is F ← F·e + g·(1 − e)·sgn v, e = 1/(1 + x + x²/2):
//! of second order, and bounded at any speed. For the velocity, the bristles are an implicit spring with the stiffness that they
//! still have in the direction of motion, q = (1 − sgn v·F/g)/(1 + γ·x), and a damper that fades with q/(1 + γ·x). Where bristles are
//! bent further than friction holds them, because the pressure fell, they slip back to that limit at once.
//!
//! The damping is not a parameter: it is the critical damping of the moving mass on its bristles, 2·√(stiffness·m), or the damping that
//! the step itself gives them, γ·h·stiffness, where that is less. Bristles whose bend is less than 1/60000 of a tick's travel at velocity 1
//! are computed with that bend: the force is unchanged.
//! Source: Canudas de Wit, Olsson, Åström, Lischinsky, *A new model for control of systems with friction*, IEEE TAC 40, 1995.

use crate::mechanics::friction::Level;
use crate::number::Number;

/// Coefficients of the bristles at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Bristles<N: Number> {
    /// Unit of the dry friction's levels and of the bristles' force.
    pub reference: N,
    /// h·(velocity base)·stiffness/reference.
    pub bend: Bend<N>,
    /// What the stiffness adds to the mass's own diagonal at q = 1.
    pub stiffness_weight: N::Steep,
    /// What the damping adds to that diagonal.
    pub damping_weight: N::Steep,
    /// Velocity at which the direction counts half.
    pub at_rest: N::Steep,
    /// 1
    pub unity: N::Steep,
}

/// Bend of a tick at velocity 1, over the bend at the reference, times the factors that the step needs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Bend<N: Number> {
    /// ½
    pub half: N::Steep,
    /// γ
    pub ahead: N::Steep,
    /// 1 − 2γ: the share of the first stage that is left in the second.
    pub second: N::Steep,
}

/// The bristles in one tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gripping<'a, N: Number> {
    law: &'a Bristles<N>,
    level: Level<N>,
    /// Their force at the start of the tick, in shares of the reference.
    bent: N,
    velocity: N,
    /// 1/(1 + γ·x)
    slow: N,
    /// sgn v·F/g, −1..1
    full: N,
}

impl<N: Number> Bristles<N> {
    /// The bristles for a state of any size, at a velocity, with friction of this level.
    #[inline]
    pub(crate) fn gripping(&self, state: N, velocity: N, level: Level<N>) -> Gripping<'_, N> {
        let bent = level.held(state);
        let most = level.against(velocity);
        let slow = N::share(most, [velocity.magnitude()], [self.bend.ahead]);
        let share = bent.magnitude().min(most);
        let share = N::share(share, [most - share], [self.unity]);
        // A rod that is nearly at rest may move either way.
        let going = N::share(velocity.magnitude(), [N::ONE], [self.at_rest]);
        let across = velocity.above(N::ZERO) ^ bent.above(N::ZERO);
        let full = share.times(N::pick(across, -going, going));
        Gripping { law: self, level, bent, velocity, slow, full }
    }
}

impl<N: Number> Gripping<'_, N> {
    /// q and q/(1 + γ·x): the shares of their weights with which stiffness and damping count.
    #[inline]
    pub(crate) fn yielding(&self) -> [N; 2] {
        let q = (N::ONE - self.full).times(self.slow);
        [q, q.times(self.slow)]
    }

    /// The weights.
    #[inline]
    pub(crate) fn weights(&self) -> [N::Steep; 2] {
        [self.law.stiffness_weight, self.law.damping_weight]
    }

    /// Force against extending at the first stage.
    #[inline]
    pub(crate) fn first(&self) -> N {
        self.law.reference.times(self.bent)
    }

    /// The same at the second stage, at the velocity `there`, after a first stage of mean velocity `ahead`.
    #[inline]
    pub(crate) fn second(&self, ahead: N, there: N) -> N {
        let [_, fading] = self.yielding();
        let bent = self.bent + fading.times(ahead).amplified(self.law.bend.second);
        // As far as the bristles slide, they follow the level at once.
        let sliding = self.full.times(N::ONE - self.slow);
        let change = self.level.change(self.velocity, there);
        self.law.reference.times(self.level.held(bent + sliding.times(change)))
    }

    /// Their force after a tick with this mean velocity, in shares of the reference. Error of rounding 5e-8.
    #[inline]
    pub(crate) fn after(&self, mean: N) -> N {
        let bent = || {
            let most = self.level.against(mean);
            let half = N::share(most, [mean.magnitude()], [self.law.bend.half]);
            let moved = N::ONE - half;
            // 1 + x + x²/2 = (1 + x/2)² + (x/2)²
            let still = half.times(half).times(N::inverse_one_plus([moved.times(moved)], [self.law.unity]));
            let slid = most.times(N::ONE - still);
            self.level.held(self.bent.times(still) + N::pick(N::ZERO.above(mean), -slid, slid))
        };
        N::choose(mean.equals(N::ZERO), || self.bent, bent)
    }

    /// Remainder of a velocity that has reversed within the tick: while they bend back, the bristles are stiffer by 2·F/g.
    #[inline]
    pub(crate) fn turned(&self) -> N {
        let stiffer = self.full.max(N::ZERO);
        N::inverse_one_plus([stiffer + stiffer; 2], self.weights())
    }

    /// Sum of the frictions of both directions.
    #[inline]
    pub(crate) fn both(&self) -> N {
        self.law.reference.times(self.level.both())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::number::PerUnit;

    fn bristles<N: Number<Real = f64>>(bend: f64) -> Bristles<N> {
        let steep = |value: f64| N::steep(value).unwrap();
        Bristles {
            reference: N::ONE,
            bend: Bend { half: steep(0.5 * bend), ahead: steep(0.3 * bend), second: steep(0.4 * bend) },
            stiffness_weight: steep(0.0),
            damping_weight: steep(0.0),
            at_rest: steep(1e-4),
            unity: steep(1.0),
        }
    }

    fn level<N: Number>(extending: f64, retracting: f64) -> Level<N> {
        Level::constant(N::saturated(extending), N::saturated(retracting))
    }

    #[test]
    fn straight_bristles_moved_by_their_full_bend_are_bent_by_three_fifths() {
        let law = bristles::<PerUnit>(10.0);
        let bent = law.gripping(PerUnit::ZERO, PerUnit::ZERO, level(1.0, 1.0)).after(PerUnit::saturated(0.1));
        assert!((bent.to_f64() - 0.6).abs() < 1e-7, "1 − 1/(1 + 1 + 1/2): {bent:?}");
    }

    #[test]
    fn bristles_slip_to_what_holds_them() {
        let law = bristles::<PerUnit>(10.0);
        let bent = |state: f64| {
            law.gripping(PerUnit::saturated(state), PerUnit::ZERO, level(0.5, 0.2)).after(PerUnit::ZERO).to_f64()
        };
        assert!((bent(0.9) - 0.5).abs() < 1e-8 && (bent(-0.9) + 0.2).abs() < 1e-8 && (bent(0.3) - 0.3).abs() < 1e-8);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(5000))]

        #[test]
        fn the_force_follows_its_formula(
            share in -1.0..1.0_f64, start in -2.0..2.0_f64, mean in -8.0..8.0_f64, small in 0_i32..25,
            bend in 1e-2..6e4_f64, most in 1e-3..1.0_f64,
        ) {
            let mean = PerUnit::saturated(mean * 0.5_f64.powi(small)).to_f64();
            let [bent, start] = [share * most, start];
            let fixed = bristles::<PerUnit>(bend);
            let real = bristles::<f64>(2.0 * fixed.bend.half.to_num::<f64>());
            let grip = fixed.gripping(PerUnit::saturated(bent), PerUnit::saturated(start), level(most, most));
            let x = real.bend.half * 2.0 * mean.abs() / most;
            let still = 1.0 / (1.0 + x + 0.5 * x * x);
            let exact = bent * still + most * (1.0 - still) * mean.signum();
            let found = grip.after(PerUnit::saturated(mean)).to_f64();
            prop_assert!((found - exact).abs() < 1e-7, "{found} {exact}");
            let grip = real.gripping(bent, start, level(most, most));
            prop_assert!((grip.after(mean) - exact).abs() < 1e-9);
        }

        #[test]
        fn bristles_never_bend_beyond_what_holds_them(
            words in prop::array::uniform6(any::<i32>()), bend in 1e-3..6e4_f64,
        ) {
            let [state, velocity, mean, there, extending, retracting] = words.map(PerUnit::from_bits);
            let [extending, retracting] = [extending, retracting].map(|level| Number::max(level, PerUnit::ZERO));
            let law = bristles::<PerUnit>(bend);
            let grip = law.gripping(state, velocity, Level::constant(extending, retracting));
            for force in [grip.first(), grip.second(mean, there), grip.after(mean)] {
                prop_assert!(-retracting <= force && force <= extending);
            }
            let [q, fading] = grip.yielding();
            prop_assert!(q >= PerUnit::ZERO && fading >= PerUnit::ZERO && q.to_f64() <= 2.0);
        }
    }
}
