//! A load that depends on where the rod is: F = −(force + stiffness·e + bow·e²), e from mid-stroke; positive holds against extending.
//!
//! A stiffness above 0 is part of the implicit step; the rest is evaluated at both stages.

use crate::number::Number;

/// Coefficients of the load, per unit of force and strokes from mid-stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct PositionLoad<N: Number> {
    /// At mid-stroke.
    pub force: N,
    pub stiffness: Signed<N>,
    pub bow: Signed<N>,
    /// 2γ·stiffness where it is solved for: what the second stage takes back of the first stage's part.
    pub taken_back: N::Steep,
}

/// A coefficient that may be large, with its sign.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Signed<N: Number> {
    pub magnitude: N::Steep,
    pub negative: bool,
}

impl<N: Number> Signed<N> {
    #[inline]
    fn times(&self, signal: N) -> N {
        let product = signal.amplified(self.magnitude);
        if self.negative { -product } else { product }
    }
}

impl<N: Number> PositionLoad<N> {
    /// The force on the rod at a position.
    #[inline]
    pub(crate) fn at(&self, from_middle: N) -> N {
        -(self.force + self.stiffness.times(from_middle) + self.bow.times(from_middle.times(from_middle)))
    }

    /// The force of the second stage, after the rod moved by `moved` strokes.
    #[inline]
    pub(crate) fn second(&self, from_middle: N, moved: N) -> N {
        self.at(from_middle + moved) + moved.amplified(self.taken_back)
    }
}
