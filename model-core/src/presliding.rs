//! Presliding: bristles that bend before the rod slides (`LuGre`).
//!
//! dz/dt = v − |v|·z/Z with Z = force/stiffness, F = stiffness·z + damping·dz/dt. At steady speed F is the `force`, as Coulomb's.
//! The state is ζ = z/Z, in −1..1. Its own step is implicit in z, ζ ← (ζ + x)/(1 + |x|) with x = h·v/Z: bounded whatever the
//! speed. To the velocity the bristles are an implicit spring of the stiffness that they still have in the direction of motion,
//! q = (1 − ζ·sgn v)/(1 + γ·|x|), and a damper that fades with q/(1 + γ·|x|).
//!
//! The damping is not a parameter: it is the critical one of the moving mass on its bristles, 2·√(stiffness·m), or what the step
//! itself has on them, γ·h·stiffness, where that is less. Bristles that bend by less than 1/60000 of a tick's travel at velocity 1 are
//! taken to bend by that: the force stays.
//! Source: Canudas de Wit, Olsson, Åström, Lischinsky, *A new model for control of systems with friction*, IEEE TAC 40, 1995.

use crate::number::Number;

/// Coefficients of the bristles at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bristles<N: Number> {
    /// Force of the bent bristles.
    pub(crate) force: N,
    /// h·(velocity base)/Z.
    pub(crate) bend: N::Steep,
    /// γ of that.
    pub(crate) bend_ahead: N::Steep,
    /// (1 − 2γ) of that: what of the first stage is left in the second.
    pub(crate) bend_second: N::Steep,
    /// What the stiffness adds to the mass's own diagonal at q = 1.
    pub(crate) stiffness_weight: N::Steep,
    /// What the damping adds to it.
    pub(crate) damping_weight: N::Steep,
}

impl<N: Number> Bristles<N> {
    /// q, and q/(1 + γ·|x|), at the tick's start.
    #[inline]
    pub(crate) fn yielding(&self, bent: N, velocity: N) -> [N; 2] {
        let slow = N::inverse_one_plus([velocity.magnitude()], [self.bend_ahead]);
        let along = if velocity > N::ZERO {
            bent
        } else if velocity < N::ZERO {
            -bent
        } else {
            N::ZERO
        };
        let q = (N::ONE - along).times(slow);
        [q, q.times(slow)]
    }

    /// How far they are bent at the second stage, after `ahead` of velocity in the first.
    #[inline]
    pub(crate) fn second(&self, bent: N, q: N, ahead: N) -> N {
        (bent + q.times(ahead).amplified(self.bend_second)).limited(N::ONE)
    }

    /// ζ after a tick with this mean velocity. Error of rounding 4e-8.
    #[inline]
    pub(crate) fn bent(&self, bent: N, mean: N) -> N {
        let still = N::inverse_one_plus([mean.magnitude()], [self.bend]);
        let over = N::ONE - still;
        (bent.times(still) + if mean < N::ZERO { -over } else { over }).limited(N::ONE)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::fixed_point::PerUnit;

    fn bristles(bend: f64) -> Bristles<PerUnit> {
        let steep = |value: f64| PerUnit::steep(value).unwrap();
        Bristles {
            force: PerUnit::ONE,
            bend: steep(bend),
            bend_ahead: steep(0.3 * bend),
            bend_second: steep(0.4 * bend),
            stiffness_weight: steep(0.0),
            damping_weight: steep(0.0),
        }
    }

    #[test]
    fn straight_bristles_moved_by_their_full_bend_are_half_bent() {
        let bent = bristles(10.0).bent(PerUnit::ZERO, PerUnit::saturated(0.1));
        assert!((bent.to_f64() - 0.5).abs() < 1e-7, "{bent:?}");
    }

    proptest! {
        #[test]
        fn bristles_never_bend_beyond_their_end(bits in any::<i32>(), velocity in any::<i32>(), bend in 1e-3..6e4_f64) {
            let bent = PerUnit::from_bits(bits).limited(PerUnit::ONE);
            let (law, velocity) = (bristles(bend), PerUnit::from_bits(velocity));
            prop_assert!(law.bent(bent, velocity).magnitude() <= PerUnit::ONE);
            let [q, fading] = law.yielding(bent, velocity);
            prop_assert!(q >= PerUnit::ZERO && fading >= PerUnit::ZERO && q.to_f64() <= 2.0);
        }
    }
}
