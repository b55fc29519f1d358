//! Real arithmetic, in which coefficients are computed and of which the numbers on the desktop are made.

#![expect(clippy::float_arithmetic, reason = "this file is the real arithmetic that coefficients and desktop runs use")]

use core::fmt::Debug;
use core::ops::{Add, Div, Mul, Neg, Sub};

use super::{Compared, Number, SUM_BITS, SUM_UNIT};

/// A value that is too small for a fixed-point number counts as 0: the slopes of its share would be unbounded.
const NOTHING: f64 = 1.0 / (1_u64 << 31) as f64;

/// Real arithmetic of one signal, or of several at once, each as if it were alone: what a [`Number`] on the desktop is made of.
pub trait Field:
    Compared
    + Debug
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Type in which coefficients are computed.
    type Real: Real;

    /// 0
    const ZERO: Self;
    /// 1
    const ONE: Self;

    /// The constant `value`, the same for all.
    fn constant(value: f64) -> Self;

    /// A coefficient, the same for all.
    fn coefficient(value: Self::Real) -> Self;

    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Whether it is 0 for any parameter value: a dual number of value 0 that has a derivative is not.
    #[inline(always)]
    fn vanishes(self) -> Self::Mask {
        self.equals(Self::ZERO)
    }

    /// The number without derivatives that are too small to count, if it has any.
    #[must_use]
    #[inline(always)]
    fn noted(self) -> Self {
        self
    }
}

/// Real arithmetic for the computation of coefficients, and for runs on the desktop.
pub trait Real: Field<Real = Self, Mask = bool> + PartialOrd {
    /// The value without derivatives.
    fn value(self) -> f64;

    /// Whether it is 0 for any parameter value: a dual number of value 0 that has a derivative is not nil.
    fn is_nil(self) -> bool;

    /// Exponential.
    #[must_use]
    fn exp(self) -> Self;

    /// Cosine; the argument in rad.
    #[must_use]
    fn cos(self) -> Self;

    /// Inverse cosine in rad, in 0..π.
    #[must_use]
    fn acos(self) -> Self;
}

impl<F: Field> Number for F {
    type Real = F::Real;
    type Value = F;
    type Gain = F;
    type Steep = F;
    type Travel = F;

    const ZERO: Self = F::ZERO;
    const ONE: Self = F::ONE;

    #[inline(always)]
    fn signal(value: F::Real) -> Option<Self> {
        value.value().is_finite().then(|| F::coefficient(value))
    }
    #[inline(always)]
    fn saturated(value: f64) -> Self {
        F::constant(if value.is_nan() { 0.0 } else { value.clamp(f64::MIN, f64::MAX) })
    }
    fn counted(counts: i32) -> Self {
        F::constant(f64::from(counts) / 65536.0)
    }
    #[inline(always)]
    fn to_real(self) -> F {
        self
    }
    #[inline(always)]
    fn gain(value: F::Real) -> Option<F> {
        Self::signal(value)
    }
    #[inline(always)]
    fn steep(value: F::Real) -> Option<F> {
        if value.value() >= 0.0 { Self::signal(value) } else { None }
    }
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        self * other
    }
    #[inline(always)]
    fn of(self, signal: Self) -> Self {
        self * signal
    }
    #[inline(always)]
    fn part(self, of: F) -> Self {
        sum([of], [self])
    }
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as `sum`")]
    fn dot<const K: usize>(gains: [F; K], signals: [Self; K]) -> Self {
        sum(gains, signals)
    }
    #[inline(always)]
    fn accumulated<const K: usize>(self, rest: Self, gains: [F; K], signals: [Self; K]) -> (Self, Self) {
        (self + sum(gains, signals), rest)
    }
    #[inline(always)]
    fn amplified(self, by: F) -> Self {
        self * by
    }
    #[inline(always)]
    fn is_nothing(self) -> Self::Mask {
        self.vanishes()
    }
    #[inline(always)]
    fn halved(self) -> Self {
        self * F::constant(0.5)
    }
    #[inline(always)]
    fn over_power(self, bits: u8) -> Self {
        self * F::constant(1.0 / (1_u64 << bits) as f64)
    }
    #[inline(always)]
    fn orifice_root(self, transition: Self) -> (Self, F) {
        let hypotenuse = (self * self + transition * transition).sqrt();
        let chord = F::ONE / hypotenuse.sqrt();
        (self * chord, chord)
    }
    #[inline(always)]
    fn over_root_of_one_plus(self, more: Self) -> Self {
        self / (F::ONE + more).sqrt()
    }
    #[inline(always)]
    fn inverse_one_plus<const K: usize>(weights: [Self; K], steep: [F; K]) -> Self {
        F::ONE / (F::ONE + sum(weights, steep))
    }
    #[inline(always)]
    fn inverse_one_plus_product(gain: F, signal: Self) -> Self {
        F::ONE / (F::ONE + sum([gain], [signal]))
    }
    #[inline(always)]
    fn share<const K: usize>(part: Self, weights: [Self; K], steep: [F; K]) -> Self {
        let whole = part + sum(weights, steep);
        Self::choose(whole.above(F::constant(NOTHING)), || part / whole, || F::ZERO)
    }
    #[inline(always)]
    fn as_gain(self) -> F {
        self
    }
    #[inline(always)]
    fn scaled(gain: F, share: Self) -> F {
        sum([gain], [share])
    }
    #[inline(always)]
    fn of_gain(gain: F) -> Self {
        gain
    }
    #[inline(always)]
    fn travel(strokes: F::Real) -> F {
        F::coefficient(strokes)
    }
    #[inline(always)]
    fn as_travel(self) -> F {
        self
    }
    #[inline(always)]
    fn travelled<const K: usize>(from: F, gains: [F; K], signals: [Self; K]) -> F {
        from + sum(gains, signals)
    }
    #[inline(always)]
    fn summed(sum: F, more: Self) -> F {
        sum + more.over_power(SUM_BITS)
    }
    #[inline(always)]
    fn of_sum(sum: F) -> Self {
        sum * F::constant(SUM_UNIT)
    }
    #[inline(always)]
    fn of_travel(travel: F) -> F {
        travel
    }
    #[inline(always)]
    fn strokes(travel: F) -> F {
        travel
    }
}

/// By reference: a dual number is too large to be moved through an iterator. Derivatives that fade in a step pass through here.
#[inline(always)]
#[expect(clippy::inline_always, reason = "the arrays of a call are half of what it computes on dual numbers")]
fn sum<F: Field, const K: usize>(gains: [F; K], signals: [F; K]) -> F {
    let mut total = F::ZERO;
    for (gain, signal) in gains.iter().zip(&signals) {
        total = total + *gain * *signal;
    }
    total.noted()
}

impl Field for f64 {
    type Real = f64;

    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn coefficient(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // Correctly rounded both ways, so the feature does not change a result.
        #[cfg(feature = "std")]
        return f64::sqrt(self);
        #[cfg(not(feature = "std"))]
        return libm::sqrt(self);
    }
}

impl Real for f64 {
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
    #[inline(always)]
    fn is_nil(self) -> bool {
        self == 0.0
    }
    fn exp(self) -> Self {
        libm::exp(self)
    }
    fn cos(self) -> Self {
        libm::cos(self)
    }
    fn acos(self) -> Self {
        libm::acos(self)
    }
}
