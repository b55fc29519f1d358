//! The number a model is computed in.
//!
//! The equations of this crate are written once, over [`Number`]. Several kinds of number run them:
//! [`PerUnit`](crate::fixed_point::PerUnit) on the controller; `f64`, dual numbers, and vectors with the signals of several drives on
//! the desktop. `f64` and dual numbers are [`Real`]s, which are also what coefficients are computed in before a run. A number that
//! is one signal of one drive is a [`Scalar`].

#![expect(clippy::float_arithmetic, reason = "this file is the real arithmetic that coefficients and desktop runs use")]

use core::fmt::Debug;
use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// Real arithmetic for the computation of coefficients, and for runs on the desktop.
pub trait Real:
    Copy
    + Debug
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// 0
    const ZERO: Self;
    /// 1
    const ONE: Self;

    /// The constant `value`.
    fn constant(value: f64) -> Self;

    /// The value without derivatives.
    fn value(self) -> f64;

    /// Whether it is 0, and would be for any parameter: a dual number of value 0 that has a derivative is not nil.
    fn is_nil(self) -> bool;

    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Exponential.
    #[must_use]
    fn exp(self) -> Self;

    /// Cosine; the argument in rad.
    #[must_use]
    fn cos(self) -> Self;

    /// Inverse cosine in rad, in 0..π.
    #[must_use]
    fn acos(self) -> Self;

    /// The number without derivatives that are too small to count, if it has any.
    #[must_use]
    #[inline]
    fn noted(self) -> Self {
        self
    }
}

/// Less than a fixed-point number can hold is nothing: its share would have slopes without bound.
const NOTHING: f64 = 1.0 / (1_u64 << 31) as f64;

/// What a comparison of two numbers says: `bool`, or one for each of several that are computed abreast.
pub trait Mask:
    Copy + Debug + PartialEq + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self> + Not<Output = Self>
{
    /// Of none.
    const NONE: Self;

    /// Whether it says so of all.
    fn all(self) -> bool;

    /// Whether it says so of any.
    fn any(self) -> bool;

    /// `yes` where it says so, else `no`; where it says so of some only, both of them `merged`.
    #[inline]
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
    #[inline]
    fn branch<T>(self, yes: impl FnOnce() -> T, no: impl FnOnce() -> T, _: impl FnOnce(T, T) -> T) -> T {
        if self { yes() } else { no() }
    }
}

/// A scaled signal, with the few operations the model's step is made of.
///
/// Sums and differences saturate where the type has a range. A product rounds to nearest. What the step decides by a signal it
/// decides by a [`Mask`], so that a type may hold several signals of as many drives.
pub trait Number: Copy + Debug + PartialEq + Add<Output = Self> + Sub<Output = Self> + Neg<Output = Self> {
    /// What coefficients are computed in before they become gains.
    type Real: Real;
    /// A coefficient of magnitude below 4.
    type Gain: Copy + Debug + PartialEq;
    /// A positive coefficient or slope that may be large, at lower relative precision.
    type Steep: Copy + Debug + PartialEq;
    /// The position: an accumulator that loses nothing of what is added to it.
    type Travel: Copy + Debug + PartialEq;
    /// What a comparison says.
    type Mask: Mask;

    /// Whether steps of drives without effects are worth code of their own: on a controller, where each question after one counts.
    const LEAN: bool = false;

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

    /// Whether it is above another.
    fn above(self, other: Self) -> Self::Mask;

    /// Whether it equals another.
    fn equals(self, other: Self) -> Self::Mask;

    /// One of two signals.
    #[must_use]
    fn pick(of: Self::Mask, yes: Self, no: Self) -> Self;

    /// One of two positions.
    #[must_use]
    fn pick_travel(of: Self::Mask, yes: Self::Travel, no: Self::Travel) -> Self::Travel;

    /// One of two signals, of which only the one that is needed is computed.
    #[must_use]
    #[inline]
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

    /// Sum of up to four signals, each with its gain, rounded once.
    fn dot<const K: usize>(gains: [Self::Gain; K], signals: [Self; K]) -> Self;

    /// This signal and Σ gain·signal more, where `by_steps` is the same sum taken step by step.
    ///
    /// In fixed point it is rounded once, and costs one product each. In real arithmetic it is `by_steps`: what is mathematically the
    /// same is not so in the last bit, and a diagnosis is to give tomorrow what it gives today.
    #[must_use]
    fn and_more<const K: usize>(
        self,
        gains: [Self::Gain; K],
        signals: [Self; K],
        by_steps: impl FnOnce() -> Self,
    ) -> Self;

    /// 3/2 of this signal and 1/2 of another: the weights of both stages in a tick.
    #[must_use]
    fn weighed(self, second: Self) -> Self;

    /// This signal after Σ gain·signal more, and what its rounding leaves for the next time, in units of 2⁻²⁸; `rest` is what
    /// was left last time. So nothing is lost of what is added, however little it is.
    #[must_use]
    fn accumulated<const K: usize>(self, rest: Self, gains: [Self::Gain; K], signals: [Self; K]) -> (Self, Self);

    /// This signal times a steep coefficient.
    #[must_use]
    fn amplified(self, by: Self::Steep) -> Self;

    /// Whether the signal is held at an end of its range, where it says only that the true value lies beyond.
    fn is_held(self) -> bool {
        false
    }

    /// Half of the signal.
    #[must_use]
    fn halved(self) -> Self;

    /// The root characteristic of an orifice that is laminar near Δp = 0,
    /// g(Δ) = Δ / (Δ² + pt²)^¼, and the slope of its chord to Δ = 0, g(Δ)/Δ, for the Jacobian; pt is `transition`.
    fn orifice_root(self, transition: Self) -> (Self, Self::Steep);

    /// 1 / (1 + Σ wᵢ·sᵢ) for weights wᵢ that are not negative.
    fn inverse_one_plus<const K: usize>(weights: [Self; K], steep: [Self::Steep; K]) -> Self;

    /// part / (part + Σ wᵢ·sᵢ) for a part and weights wᵢ that are not negative; no part of nothing.
    fn share<const K: usize>(part: Self, weights: [Self; K], steep: [Self::Steep; K]) -> Self;

    /// This signal as a gain, held at the ends of a gain's range.
    fn as_gain(self) -> Self::Gain;

    /// The larger of two.
    #[must_use]
    #[inline]
    fn max(self, other: Self) -> Self {
        Self::pick(other.above(self), other, self)
    }

    /// The smaller of two.
    #[must_use]
    #[inline]
    fn min(self, other: Self) -> Self {
        Self::pick(self.above(other), other, self)
    }

    /// Held within ±`limit`.
    #[must_use]
    #[inline]
    fn limited(self, limit: Self) -> Self {
        self.min(limit).max(-limit)
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

    /// The position after Σ gain·signal strokes more; nothing is rounded away.
    fn travelled<const K: usize>(from: Self::Travel, gains: [Self::Gain; K], signals: [Self; K]) -> Self::Travel;

    /// The position as a signal, in strokes, rounded down to the signal's step and held at the ends of its range.
    fn of_travel(travel: Self::Travel) -> Self;
}

/// A number that is one signal of one drive: it has an order and a value.
pub trait Scalar: Number<Mask = bool> + PartialOrd {
    /// The value of a signal without derivatives.
    fn to_f64(self) -> f64;

    /// The value of a signal with its derivatives.
    fn to_real(self) -> Self::Real;

    /// The position in strokes.
    fn strokes(travel: Self::Travel) -> Self::Real;
}

/// Real arithmetic of one signal, or of several at once, each as if it were alone: what a [`Number`] on the desktop is made of.
pub trait Field:
    Copy
    + Debug
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// What coefficients are computed in.
    type Real: Real;
    /// What a comparison says.
    type Mask: Mask;

    /// 0
    const NIL: Self;
    /// 1
    const UNIT: Self;

    /// The constant `value`, the same for all.
    fn constant(value: f64) -> Self;

    /// A coefficient, the same for all.
    fn coefficient(value: Self::Real) -> Self;

    /// Square root.
    #[must_use]
    fn root(self) -> Self;

    /// Whether it is above another.
    fn is_above(self, other: Self) -> Self::Mask;

    /// Whether it equals another.
    fn is_equal(self, other: Self) -> Self::Mask;

    /// One of two.
    #[must_use]
    fn either(of: Self::Mask, yes: Self, no: Self) -> Self;

    /// The larger of two; the first where both are equal.
    #[must_use]
    #[inline]
    fn larger(self, other: Self) -> Self {
        Self::either(other.is_above(self), other, self)
    }

    /// The smaller of two; the first where both are equal.
    #[must_use]
    #[inline]
    fn smaller(self, other: Self) -> Self {
        Self::either(self.is_above(other), other, self)
    }

    /// Without derivatives that are too small to count, if it has any.
    #[must_use]
    #[inline]
    fn kept(self) -> Self {
        self
    }
}

impl<R: Real> Field for R {
    type Real = R;
    type Mask = bool;

    const NIL: Self = R::ZERO;
    const UNIT: Self = R::ONE;

    #[inline]
    fn constant(value: f64) -> Self {
        <R as Real>::constant(value)
    }
    #[inline]
    fn coefficient(value: R) -> Self {
        value
    }
    #[inline]
    fn root(self) -> Self {
        self.sqrt()
    }
    #[inline]
    fn is_above(self, other: Self) -> bool {
        self > other
    }
    #[inline]
    fn is_equal(self, other: Self) -> bool {
        self == other
    }
    #[inline]
    fn either(of: bool, yes: Self, no: Self) -> Self {
        if of { yes } else { no }
    }
    #[inline]
    fn kept(self) -> Self {
        self.noted()
    }
}

impl<F: Field> Number for F {
    type Real = F::Real;
    type Gain = F;
    type Steep = F;
    type Travel = F;
    type Mask = F::Mask;

    const ZERO: Self = F::NIL;
    const ONE: Self = F::UNIT;

    #[inline]
    fn signal(value: F::Real) -> Option<Self> {
        value.value().is_finite().then(|| F::coefficient(value))
    }
    #[inline]
    fn saturated(value: f64) -> Self {
        F::constant(if value.is_nan() { 0.0 } else { value.clamp(f64::MIN, f64::MAX) })
    }
    fn counted(counts: i32) -> Self {
        F::constant(f64::from(counts) / 65536.0)
    }
    #[inline]
    fn above(self, other: Self) -> F::Mask {
        self.is_above(other)
    }
    #[inline]
    fn equals(self, other: Self) -> F::Mask {
        self.is_equal(other)
    }
    #[inline]
    fn pick(of: F::Mask, yes: Self, no: Self) -> Self {
        F::either(of, yes, no)
    }
    #[inline]
    fn pick_travel(of: F::Mask, yes: F, no: F) -> F {
        F::either(of, yes, no)
    }
    #[inline]
    fn max(self, other: Self) -> Self {
        self.larger(other)
    }
    #[inline]
    fn min(self, other: Self) -> Self {
        self.smaller(other)
    }
    #[inline]
    fn gain(value: F::Real) -> Option<F> {
        Self::signal(value)
    }
    #[inline]
    fn steep(value: F::Real) -> Option<F> {
        if value.value() >= 0.0 { Self::signal(value) } else { None }
    }
    #[inline]
    fn times(self, other: Self) -> Self {
        self * other
    }
    #[inline]
    fn of(self, signal: Self) -> Self {
        self * signal
    }
    #[inline]
    fn part(self, of: F) -> Self {
        sum([of], [self])
    }
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as `sum`")]
    fn dot<const K: usize>(gains: [F; K], signals: [Self; K]) -> Self {
        sum(gains, signals)
    }
    #[inline]
    fn and_more<const K: usize>(self, _: [F; K], _: [Self; K], by_steps: impl FnOnce() -> Self) -> Self {
        by_steps()
    }
    #[inline]
    fn weighed(self, second: Self) -> Self {
        sum([F::constant(1.5), F::constant(0.5)], [self, second])
    }
    #[inline]
    fn accumulated<const K: usize>(self, rest: Self, gains: [F; K], signals: [Self; K]) -> (Self, Self) {
        (self + sum(gains, signals), rest)
    }
    #[inline]
    fn amplified(self, by: F) -> Self {
        self * by
    }
    #[inline]
    fn halved(self) -> Self {
        self * F::constant(0.5)
    }
    #[inline]
    fn orifice_root(self, transition: Self) -> (Self, F) {
        let hypotenuse = (self * self + transition * transition).root();
        let chord = F::UNIT / hypotenuse.root();
        (self * chord, chord)
    }
    #[inline]
    fn inverse_one_plus<const K: usize>(weights: [Self; K], steep: [F; K]) -> Self {
        F::UNIT / (F::UNIT + sum(weights, steep))
    }
    #[inline]
    fn share<const K: usize>(part: Self, weights: [Self; K], steep: [F; K]) -> Self {
        let whole = part + sum(weights, steep);
        Self::choose(whole.is_above(F::constant(NOTHING)), || part / whole, || F::NIL)
    }
    #[inline]
    fn as_gain(self) -> F {
        self
    }
    #[inline]
    fn travel(strokes: F::Real) -> F {
        F::coefficient(strokes)
    }
    #[inline]
    fn as_travel(self) -> F {
        self
    }
    #[inline]
    fn travelled<const K: usize>(from: F, gains: [F; K], signals: [Self; K]) -> F {
        from + sum(gains, signals)
    }
    #[inline]
    fn of_travel(travel: F) -> F {
        travel
    }
}

impl<R: Real> Scalar for R {
    #[inline]
    fn to_f64(self) -> f64 {
        self.value()
    }
    #[inline]
    fn to_real(self) -> R {
        self
    }
    #[inline]
    fn strokes(travel: R) -> R {
        travel
    }
}

/// By reference: a dual number is too large to be moved through an iterator. What fades in a step, fades through here.
#[inline(always)]
#[expect(clippy::inline_always, reason = "the arrays of a call are half of what it computes on dual numbers")]
fn sum<F: Field, const K: usize>(gains: [F; K], signals: [F; K]) -> F {
    let mut total = F::NIL;
    for (gain, signal) in gains.iter().zip(&signals) {
        total = total + *gain * *signal;
    }
    total.kept()
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    #[inline]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline]
    fn value(self) -> f64 {
        self
    }
    #[inline]
    fn is_nil(self) -> bool {
        self == 0.0
    }
    #[inline]
    fn sqrt(self) -> Self {
        // Correctly rounded both ways, so the feature does not change a result.
        #[cfg(feature = "std")]
        return f64::sqrt(self);
        #[cfg(not(feature = "std"))]
        return libm::sqrt(self);
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
