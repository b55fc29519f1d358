//! Several signals, of as many drives, in one number: the core's own equations, run on the lanes of a processor's vectors.
//!
//! Every lane equals an f64 run to the last bit. What a step looks up in the machine (which effects are on, which
//! coefficients), it looks up once for all lanes; decisions that depend on a signal are made for each lane by a mask.

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

use wide::f64x4;

use model_core::number::{Compared, Field, Mask};

/// Number of lanes.
pub const LANES: usize = 4;

/// A signal in each lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes(f64x4);

/// Result of a comparison in each lane.
#[derive(Clone, Copy, Debug)]
pub struct LaneMask(f64x4);

impl Lanes {
    /// The same signal in each lane.
    #[inline(always)]
    #[must_use]
    pub fn new(values: [f64; LANES]) -> Self {
        Self(f64x4::new(values))
    }

    /// The values of all lanes.
    #[inline(always)]
    #[must_use]
    pub fn values(self) -> [f64; LANES] {
        self.0.to_array()
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}

impl Div for Lanes {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0)
    }
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl PartialEq for LaneMask {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_bitmask() == other.0.to_bitmask()
    }
}

impl BitAnd for LaneMask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for LaneMask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitXor for LaneMask {
    type Output = Self;
    #[inline(always)]
    fn bitxor(self, other: Self) -> Self {
        Self(self.0 ^ other.0)
    }
}

impl Not for LaneMask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl Mask for LaneMask {
    const NONE: Self = Self(f64x4::ZERO);

    #[inline(always)]
    fn all(self) -> bool {
        self.0.all()
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.any()
    }
}

impl Compared for Lanes {
    type Mask = LaneMask;

    #[inline(always)]
    fn above(self, other: Self) -> LaneMask {
        LaneMask(self.0.simd_gt(other.0))
    }
    #[inline(always)]
    fn equals(self, other: Self) -> LaneMask {
        LaneMask(self.0.simd_eq(other.0))
    }
    #[inline(always)]
    fn pick(of: LaneMask, yes: Self, no: Self) -> Self {
        Self(of.0.select(yes.0, no.0))
    }
    // One instruction each on that processor, with the same bits as `pick`: if both operands are equal or one is no number, the second.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self(other.0.fast_max(self.0))
    }
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        Self(other.0.fast_min(self.0))
    }
}

impl Field for Lanes {
    type Real = f64;

    const ZERO: Self = Self(f64x4::ZERO);
    const ONE: Self = Self(f64x4::ONE);

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self(f64x4::splat(value))
    }
    #[inline(always)]
    fn coefficient(value: f64) -> Self {
        Self::constant(value)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
}
