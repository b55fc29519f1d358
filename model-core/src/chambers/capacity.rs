//! Capacity of the chambers where it is not constant: entrained air, and volumes that follow the piston.
//!
//! C = V/E0·(1 + E0·α·(p0/p)^(1/n)/(n·p)) + hose with p = max(pressure, 0) + p0, p0 that of the atmosphere, n = 4/3 (free gas, polytropic), and
//! V = V0 ± share·A·(y − stroke/2), not below 2 % of V0, nor so small that its pressure rise per tick at flow 1 leaves the format;
//! in fixed point at most 8·V0. Pressures and flows of a tick see one capacity: that of the position at its start, and of the pressures that its
//! start predicts for its middle.
//! Bubbles in a chamber whose pressure swings within tenths of a second exchange some heat with the oil: between n = 1, all of it, and 1.4, none.
//! Source: Merritt, *Hydraulic Control Systems*, 1967, 2.3; Yu, Chen, Lu, J. Dyn. Syst. Meas. Control 116, 1994, for the free gas.

use crate::number::Number;
use crate::ports::{ChamberState, Flows};

/// Least volume of a chamber, as a share of the one at mid-stroke.
pub(crate) const LEAST_VOLUME: f64 = 0.02;

/// Exponent n of the bubbles. (p0/p)^(1 + 1/n) is made of roots.
pub(crate) const POLYTROPIC: f64 = 4.0 / 3.0;

/// Coefficients of both capacities.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Capacity<N: Number> {
    pub a: ChamberCapacity<N>,
    pub b: ChamberCapacity<N>,
    /// Whether there is air, so that it depends on the pressures.
    pub is_airy: bool,
    /// Pressure base over that of the atmosphere.
    pub per_atmosphere: N::Steep,
}

/// Coefficients of one chamber's capacity. Capacities are relative to the least one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct ChamberCapacity<N: Number> {
    /// share·A·stroke/V0: what a stroke adds to the volume, in V0.
    pub reach: N::Steep,
    /// Least volume, in V0.
    pub least: N,
    /// Capacity of the oil in V0.
    pub oil: N::Steep,
    /// That of the air in V0 at atmospheric pressure, polytropic.
    pub air: N::Steep,
}

impl<N: Number> Capacity<N> {
    /// The least capacity over that at these pressures and this position (strokes), 0..1: the share of the stiffness that is left.
    /// Error 2e-8, and 1.1e-8 times the coefficient of the air.
    #[inline]
    pub(crate) fn shares(&self, pressures: ChamberState<N>, position: N) -> Flows<N> {
        let out = position - N::ONE.halved();
        let share = |side: &ChamberCapacity<N>, pressure: N, out: N| {
            let volume = (N::ONE + out.amplified(side.reach)).max(side.least);
            let air = if self.is_airy { volume.times(self.softness(pressure)) } else { N::ZERO };
            N::inverse_one_plus([volume - side.least, air], [side.oil, side.air])
        };
        Flows { a: share(&self.a, pressures.a, out), b: share(&self.b, pressures.b, -out) }
    }

    /// (p0/p)^(1 + 1/n), by a square root and a fourth one.
    #[inline]
    fn softness(&self, pressure: N) -> N {
        let thinned = N::inverse_one_plus([pressure.max(N::ZERO)], [self.per_atmosphere]);
        let (root, _) = thinned.orifice_root(N::ZERO);
        let (fourth, _) = root.orifice_root(N::ZERO);
        thinned.times(root.times(fourth))
    }
}
