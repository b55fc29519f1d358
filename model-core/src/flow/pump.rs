//! A pump with a directional valve in place of the proportional valve.
//!
//! ```text
//! delivering side   Q = max(0, displacement·|n| − slip·(p − pt))
//! returning side    Q = K·√(p − pt)
//! ```
//!
//! Speed n in 50 revolutions per second, pressures p and pt (tank) per unit of supply pressure, flows per unit. The direction gives the signs, see
//! [`PumpDrive`]. The root is signed and finite near 0, as at the valve's edges.

use super::Lines;
use crate::number::Number;
use crate::ports::{Flows, Linearised};

/// Input of a pump-controlled drive over a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PumpDrive<N> {
    /// Speed, in 50 revolutions per second; only its magnitude counts, the directional valve gives the sign.
    pub speed: N,
    /// +1 leads the pump into A and B to tank, −1 the pump into B and A to tank, 0 closes all.
    pub direction: i8,
}

/// A pump with a directional valve. Neither delivers backwards: a check valve holds the load.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
pub struct Pump<N: Number> {
    /// Flow per speed into A.
    #[doc(hidden)]
    pub into_a: N::Gain,
    /// Flow per speed into B.
    #[doc(hidden)]
    pub into_b: N::Gain,
    /// Slip: flow lost per pressure difference.
    #[doc(hidden)]
    pub slip: N,
    /// Opening of the returning side.
    #[doc(hidden)]
    pub back: N,
    /// Pressure difference at which the root turns from laminar to turbulent.
    #[doc(hidden)]
    pub transition: N,
    #[doc(hidden)]
    pub lines: Lines<N>,
    /// 1, as a slope.
    #[doc(hidden)]
    pub unity: N::Steep,
}

impl<N: Number> Pump<N> {
    /// Flows for an input and two chamber pressures, with their slopes.
    #[inline]
    pub fn flow(&self, drive: PumpDrive<N>, pressure_a: N, pressure_b: N) -> Flows<Linearised<N>> {
        let (over_a, over_b) = (pressure_a - self.lines.tank, pressure_b - self.lines.tank);
        let negative = |side: Linearised<N>| Linearised { flow: -side.flow, ..side };
        match drive.direction {
            1.. => Flows { a: self.delivered(self.into_a, drive.speed, over_a), b: self.returned(over_b) },
            0 => Flows { a: self.blocked(), b: self.blocked() },
            _ => Flows {
                a: negative(self.returned(over_a)),
                b: negative(self.delivered(self.into_b, drive.speed, over_b)),
            },
        }
    }

    #[inline]
    fn delivered(&self, displacement: N::Gain, speed: N, over: N) -> Linearised<N> {
        let flow = N::dot([displacement], [speed.magnitude()]) - self.slip.times(over);
        let delivers = flow.above(N::ZERO);
        let only = |signal: N| N::pick(delivers, signal, N::ZERO);
        Linearised { flow: only(flow), opening: only(self.slip), slope: self.unity }
    }

    #[inline]
    fn returned(&self, over: N) -> Linearised<N> {
        let (root, slope) = over.orifice_root(self.transition);
        Linearised { flow: self.back.times(root), opening: self.back, slope }
    }

    #[inline]
    fn blocked(&self) -> Linearised<N> {
        Linearised { flow: N::ZERO, opening: N::ZERO, slope: self.unity }
    }
}
