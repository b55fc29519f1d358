//! The opening that a velocity needs under a load: the inverse of the steady flow through both edges.
//!
//! With both edges of a direction equally open and the flows of the piston, Qb = α·Qa, both pressure drops follow from d, the drop over the
//! edge of A, and so does the force of the oil. So
//!
//! ```text
//! extending    d = (ps − α·pt − φ)/(1 + α³)       retracting    d = (φ + α·ps − pt)/(1 + α³)
//! opening = v/(K·√d)                              φ = pa − α·pb
//! ```
//!
//! per unit. Effects that make the edges differ are not included; the loops' gains have to correct them.

use crate::number::Scalar;
use crate::ports::ChamberState;

/// Coefficients of the inverse of the edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Orifice<N: Scalar> {
    /// α
    pub(super) ratio: N::Gain,
    /// 1/(1 + α³)
    pub(super) share: N::Gain,
    /// ps − α·pt
    pub(super) extending: N,
    /// α·ps − pt
    pub(super) retracting: N,
    /// 1/K
    pub(super) inverse_gain: N::Steep,
    /// Pressure drop below which the root becomes linear.
    pub(super) transition: N,
}

/// √d and 1/√d for one direction of the spool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Drop<N: Scalar> {
    pub(super) root: N,
    inverse: N::Steep,
}

impl<N: Scalar> Orifice<N> {
    /// Least pressure drop to compute with, 2⁻⁵ of the supply pressure: with less the opening would be unbounded.
    const LEAST: u8 = 5;

    /// φ, the force of the oil per unit.
    #[inline]
    pub(super) fn force(&self, pressures: ChamberState<N>) -> N {
        pressures.a - N::dot([self.ratio], [pressures.b])
    }

    /// Pressure drop over the edges that extend, or over those that retract.
    #[inline]
    pub(super) fn drop(&self, extends: bool, force: N) -> Drop<N> {
        let both = if extends { self.extending - force } else { self.retracting + force };
        let least = N::ONE.over_power(Self::LEAST);
        let (root, inverse) = N::dot([self.share], [both]).max(least).orifice_root(self.transition);
        Drop { root, inverse }
    }

    /// Opening for a velocity.
    #[inline]
    pub(super) fn opening(&self, velocity: N, drop: Drop<N>) -> N {
        velocity.amplified(self.inverse_gain).amplified(drop.inverse)
    }
}

impl<N: Scalar> Drop<N> {
    /// The opening that passes the same flow here as `opening` does at another drop.
    #[inline]
    pub(super) fn instead_of(self, other: Self, opening: N) -> N {
        opening.times(other.root).amplified(self.inverse)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::number::{Number, PerUnit};

    const RATIO: f64 = 0.6;
    const TANK: f64 = 0.05;

    fn orifice() -> Orifice<PerUnit> {
        Orifice {
            ratio: PerUnit::gain(RATIO).unwrap(),
            share: PerUnit::gain(1.0 / (1.0 + RATIO * RATIO * RATIO)).unwrap(),
            extending: PerUnit::saturated(1.0 - RATIO * TANK),
            retracting: PerUnit::saturated(RATIO - TANK),
            inverse_gain: PerUnit::steep(1.25).unwrap(),
            transition: PerUnit::from_bits(1 << 12),
        }
    }

    proptest! {
        /// Both edges carry the piston's flow at the pressures that the load leaves: the opening found is the one that passes it.
        #[test]
        fn the_opening_passes_the_velocity_through_both_edges(velocity in -0.9_f64..0.9, force in -0.25_f64..0.5) {
            prop_assume!(velocity.abs() > 1e-3);
            let orifice = orifice();
            let drop = orifice.drop(velocity > 0.0, PerUnit::saturated(force));
            let opening = orifice.opening(PerUnit::saturated(velocity), drop).to_f64();
            // The drop over the edge of A, and from it both pressures.
            let over_a = (velocity / (0.8 * opening)).powi(2);
            let over_b = RATIO * RATIO * over_a;
            let (a, b) = if velocity > 0.0 { (1.0 - over_a, TANK + over_b) } else { (TANK + over_a, 1.0 - over_b) };
            prop_assert!((a - RATIO * b - force).abs() < 2e-4, "{opening} {a} {b}");
        }
    }
}
