//! The number types that a model is computed in.
//!
//! The equations of this crate are written once, over [`Number`]. Several kinds of number run them:
//! [`PerUnit`], fixed point, on any controller; [`Single`], an `f32`, on one whose FPU has single precision; `f64`, dual numbers, and vectors
//! with the signals of several drives on the desktop. `f64` and dual numbers are [`Real`]s; coefficients, too, are computed in these, before a
//! run. A number that holds one signal of one drive is a [`Scalar`].
//!
//! Fixed point is the default and the reference: it needs no FPU, and its rounding is 16 times finer than that of an `f32` near 1.

pub(crate) mod fixed_point;
mod pair;
mod real;
pub(crate) mod relaxation;
mod roots;
mod single;

use core::fmt::Debug;
use core::ops::{Add, BitAnd, BitOr, BitXor, Neg, Not, Sub};

pub use fixed_point::PerUnit;
pub use pair::SinglePair;
pub use real::{Field, Real};
pub use single::Single;

/// Result of a comparison of two numbers: `bool`, or one result for each SIMD lane.
pub trait Mask:
    Copy + Debug + PartialEq + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self> + Not<Output = Self>
{
    /// False in every lane.
    const NONE: Self;

    /// Whether it is true in all lanes.
    fn all(self) -> bool;

    /// Whether it is true in any lane.
    fn any(self) -> bool;

    /// `yes` where it is true in all lanes, `no` where it is true in none; otherwise both are computed and `merged`.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as `Number::choose`")]
    fn branch<T>(self, yes: impl FnOnce() -> T, no: impl FnOnce() -> T, merged: impl FnOnce(T, T) -> T) -> T {
        if self.all() {
            yes()
        } else if self.any() {
            merged(yes(), no())
        } else {
            no()
        }
    }
}

impl Mask for bool {
    const NONE: Self = false;

    #[inline]
    fn all(self) -> bool {
        self
    }
    #[inline]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as `Number::choose`")]
    fn branch<T>(self, yes: impl FnOnce() -> T, no: impl FnOnce() -> T, _: impl FnOnce(T, T) -> T) -> T {
        if self { yes() } else { no() }
    }
}

/// The signal value that 1 stands for in a sum of signals ([`Number::summed`]).
pub const SUM_UNIT: f64 = (1_u64 << SUM_BITS) as f64;
/// Its exponent, to base 2.
pub(crate) const SUM_BITS: u8 = 14;

/// Numbers that can be compared: a single one, or several at once, each with its counterpart.
pub trait Compared: Copy {
    /// Result of a comparison.
    type Mask: Mask;

    /// Whether it is above another.
    fn above(self, other: Self) -> Self::Mask;

    /// Whether it is equal to another.
    fn equals(self, other: Self) -> Self::Mask;

    /// `yes` where the mask is true, else `no`.
    #[must_use]
    fn pick(of: Self::Mask, yes: Self, no: Self) -> Self;

    /// The larger of two; the first where both are equal.
    #[must_use]
    #[inline]
    fn larger(self, other: Self) -> Self {
        Self::pick(other.above(self), other, self)
    }

    /// The smaller of two; the first where both are equal.
    #[must_use]
    #[inline]
    fn smaller(self, other: Self) -> Self {
        Self::pick(self.above(other), other, self)
    }
}

impl<T: Copy + PartialOrd> Compared for T {
    type Mask = bool;

    #[inline]
    fn above(self, other: Self) -> bool {
        self > other
    }
    #[inline]
    fn equals(self, other: Self) -> bool {
        self == other
    }
    #[inline]
    fn pick(of: bool, yes: Self, no: Self) -> Self {
        if of { yes } else { no }
    }
}

/// A scaled signal, with the few operations the model's step is made of.
///
/// Sums and differences saturate where the type has a range for them. A product rounds to nearest. Where a decision of the step depends on a signal,
/// it uses a [`Mask`], so that a type may hold one signal each of several drives. The only exception is [`Number::is_held`]; such a type must
/// therefore have no range limits.
pub trait Number: Compared + Debug + PartialEq + Add<Output = Self> + Sub<Output = Self> + Neg<Output = Self> {
    /// Type in which coefficients are computed before they become gains.
    type Real: Real;
    /// Type in which the value of a signal is returned.
    type Value: Field<Real = Self::Real>;
    /// A coefficient of magnitude below 4.
    type Gain: Copy + Debug + PartialEq;
    /// A positive coefficient or slope that may be large, at lower relative precision.
    type Steep: Copy + Debug + PartialEq;
    /// The position: an accumulator that loses nothing of what is added to it; in single precision no more than 2⁻²² of it.
    type Travel: Compared<Mask = Self::Mask> + Debug + PartialEq;

    /// Whether drives without effects get step code of their own: on a controller, where every check for an effect costs time.
    const LEAN: bool = false;

    /// Whether a step goes shorter ways around roots and reciprocals: a root that hardly changed within a tick is extended along its tangent,
    /// and 1/(1 + 0) is not computed. Not where the check costs as much as what it saves.
    const SHORTCUTS: bool = true;

    /// 0
    const ZERO: Self;
    /// 1
    const ONE: Self;

    /// A signal, or `None` if the value does not fit the format.
    fn signal(value: Self::Real) -> Option<Self>;

    /// A signal from a plain value, held at the end of the range if it does not fit. NaN becomes 0.
    fn saturated(value: f64) -> Self;

    /// A sensor's count, in units of 65536 counts, held at the end of the range.
    fn counted(counts: i32) -> Self;

    /// The value of a signal, with its derivatives if it has any.
    fn to_real(self) -> Self::Value;

    /// One of two signals, of which only the one that is needed is computed.
    #[must_use]
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call with what both capture in memory is half of what they compute")]
    fn choose(of: Self::Mask, yes: impl FnOnce() -> Self, no: impl FnOnce() -> Self) -> Self {
        of.branch(yes, no, |yes, no| Self::pick(of, yes, no))
    }

    /// A gain, or `None` if its magnitude is 4 or more.
    fn gain(value: Self::Real) -> Option<Self::Gain>;

    /// A steep coefficient, or `None` if it is negative or 65536 or more.
    fn steep(value: Self::Real) -> Option<Self::Steep>;

    /// Product of two signals.
    #[must_use]
    fn times(self, other: Self) -> Self;

    /// This share, 0..1, of a signal: a product that cannot leave the range.
    #[must_use]
    fn of(self, signal: Self) -> Self;

    /// A signal times a gain of 0..1: a product that cannot leave the range.
    #[must_use]
    fn part(self, of: Self::Gain) -> Self;

    /// A signal times a gain of 0..½.
    #[must_use]
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn small_part(self, of: Self::Gain) -> Self {
        self.part(of)
    }

    /// Sum of up to four signals, each with its gain, rounded once.
    fn dot<const K: usize>(gains: [Self::Gain; K], signals: [Self; K]) -> Self;

    /// This signal plus Σ gain·signal, and the remainder of its rounding for the next call, in fixed point in units of 2⁻²⁸; `rest` is the
    /// remainder of the last call. So nothing that is added is lost, however small it is (in single precision 2⁻²² of it).
    #[must_use]
    fn accumulated<const K: usize>(self, rest: Self, gains: [Self::Gain; K], signals: [Self; K]) -> (Self, Self);

    /// This signal times a steep coefficient.
    #[must_use]
    fn amplified(self, by: Self::Steep) -> Self;

    /// The same for a product that cannot leave the range.
    #[must_use]
    fn amplified_within(self, by: Self::Steep) -> Self {
        self.amplified(by)
    }

    /// The magnitude of the signal times a steep coefficient, for a product that cannot leave the range.
    #[must_use]
    fn magnitude_amplified(self, by: Self::Steep) -> Self {
        self.magnitude().amplified_within(by)
    }

    /// Whether the signal is held at an end of its range, or so near to the end that it may be a held one: all it shows then is that the true
    /// value lies beyond.
    fn is_held(self) -> bool {
        false
    }

    /// The signal as a state keeps it: held at the ends of the range by a type whose sums are not.
    #[must_use]
    #[inline(always)]
    fn within_range(self) -> Self {
        self
    }

    /// Whether it is 0 for any parameter value, not only for the present one.
    fn is_nothing(self) -> Self::Mask {
        self.equals(Self::ZERO)
    }

    /// Half of the signal.
    #[must_use]
    fn halved(self) -> Self;

    /// The signal over 2^`bits`.
    #[must_use]
    fn over_power(self, bits: u8) -> Self;

    /// The root characteristic of an orifice that is laminar near Δp = 0,
    /// g(Δ) = Δ / (Δ² + pt²)^¼, and the slope of its chord to Δ = 0, g(Δ)/Δ, for the Jacobian; pt is `transition`.
    fn orifice_root(self, transition: Self) -> (Self, Self::Steep);

    /// The signal over √(1 + `more`), for more than nothing.
    #[must_use]
    fn over_root_of_one_plus(self, more: Self) -> Self;

    /// 1 / (1 + Σ wᵢ·sᵢ) for weights wᵢ that are not negative.
    fn inverse_one_plus<const K: usize>(weights: [Self; K], steep: [Self::Steep; K]) -> Self;

    /// 1 / (1 + gain·signal) for a product that is not negative.
    fn inverse_one_plus_product(gain: Self::Gain, signal: Self) -> Self;

    /// part / (part + Σ wᵢ·sᵢ) for a part and weights wᵢ that are not negative; 0 for a part of 0.
    fn share<const K: usize>(part: Self, weights: [Self; K], steep: [Self::Steep; K]) -> Self;

    /// This signal as a gain, held at the ends of a gain's range.
    fn as_gain(self) -> Self::Gain;

    /// A gain times a share, 0..1.
    fn scaled(gain: Self::Gain, share: Self) -> Self::Gain;

    /// A gain as a signal.
    fn of_gain(gain: Self::Gain) -> Self;

    /// The larger of two.
    #[must_use]
    #[inline]
    fn max(self, other: Self) -> Self {
        self.larger(other)
    }

    /// The smaller of two.
    #[must_use]
    #[inline]
    fn min(self, other: Self) -> Self {
        self.smaller(other)
    }

    /// Held within ±`limit`.
    #[must_use]
    #[inline]
    fn limited(self, limit: Self) -> Self {
        self.min(limit).max(-limit)
    }

    /// Held within ±`limit`, and whether it lies within.
    #[must_use]
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as `Number::choose`")]
    fn clipped(self, limit: Self) -> (Self, Self::Mask) {
        let held = self.limited(limit);
        (held, held.equals(self))
    }

    /// `positive` where this signal is above zero, else `otherwise`.
    #[must_use]
    #[inline]
    fn select_positive(self, positive: Self, otherwise: Self) -> Self {
        Self::pick(self.above(Self::ZERO), positive, otherwise)
    }

    /// Magnitude.
    #[must_use]
    #[inline]
    fn magnitude(self) -> Self {
        self.max(-self)
    }

    /// A position from a plain value in strokes, held at the end of the range.
    fn travel(strokes: Self::Real) -> Self::Travel;

    /// The position that a signal gives in strokes; nothing is rounded away.
    fn as_travel(self) -> Self::Travel;

    /// The position plus Σ gain·signal strokes; nothing is rounded away (in single precision 2⁻²² of what is added).
    fn travelled<const K: usize>(from: Self::Travel, gains: [Self::Gain; K], signals: [Self; K]) -> Self::Travel;

    /// A sum of signals plus one more, in units of 2¹⁴ ([`SUM_UNIT`]); nothing is rounded away (as in [`Number::travelled`]), and beyond 2²¹ it is held.
    fn summed(sum: Self::Travel, more: Self) -> Self::Travel;

    /// Such a sum as a signal: exact to the bit (in single precision rounded to nearest), held at the ends of its range.
    fn of_sum(sum: Self::Travel) -> Self;

    /// The position as a signal, in strokes, rounded down to the signal's step (in single precision to nearest) and held at the ends of its range.
    fn of_travel(travel: Self::Travel) -> Self;

    /// The position in strokes.
    fn strokes(travel: Self::Travel) -> Self::Value;
}

/// A number that is one signal of one drive: it has an order and a value.
pub trait Scalar: Number<Mask = bool, Value = <Self as Number>::Real> + PartialOrd {
    /// The value of a signal without derivatives.
    fn to_f64(self) -> f64 {
        self.to_real().value()
    }
}

impl<N: Number<Mask = bool, Value = <N as Number>::Real> + PartialOrd> Scalar for N {}

/// A number whose coefficients can be written: as Rust source by `host-sim export --bake`.
#[cfg(feature = "serde")]
pub trait Written:
    Number<Gain: serde::Serialize, Steep: serde::Serialize, Travel: serde::Serialize> + serde::Serialize
{
}

#[cfg(feature = "serde")]
impl<N: Number<Gain: serde::Serialize, Steep: serde::Serialize, Travel: serde::Serialize> + serde::Serialize> Written
    for N
{
}
