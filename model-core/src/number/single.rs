//! Single precision: a signal is one `f32`, for controllers whose FPU has nothing wider (Cortex-M4F, M7, M33).
//!
//! Only additions, products and quotients of IEEE 754, each rounded by itself: every processor gives the same bits, with an FPU or without one.
//! No square root (stable Rust has none without `std` that becomes the FPU's instruction): the orifice's needs w^-¼, which is found from the
//! exponent and two steps.
//!
//! | quantity | held in | range | error |
//! |---|---|---|---|
//! | signal ([`Single`]) | a word | ±8 where it enters and in the state | 2⁻²⁴ of the value (6.0e-8) an operation |
//! | gain, steep coefficient | a word | as in fixed point, so that both take the same machines | 2⁻²⁴ |
//! | position, sum of signals ([`SinglePair`]) | two words | ±128 | 2⁻²² of each part that is added, 2⁻⁴⁹ of the sum |
//! | pressure and its remainder | two words | ±8 | the same |
//!
//! A signal is finite whatever it is made of: a value beyond ±8 is held there as it enters, and NaN becomes 0. Within a tick sums and products
//! are not held. They cannot overflow either: a tick starts with words of at most 8, a gain is below 4 and a steep coefficient below 65536, and
//! a dozen products in a row are far below 3e38. What the tick leaves is held again: pressures ([`Number::accumulated`]), the position and
//! the velocity ([`Number::within_range`]); valve and sensors answer with means of what they were given. So nothing infinite and no NaN arises.
//!
//! Error bounds, asserted in this file's tests: `orifice_root` and its slope 3e-7 of the value; `inverse_one_plus` and `share` 3e-7 of the value.

#![expect(
    clippy::float_arithmetic,
    reason = "this file is the arithmetic of a processor with an FPU; `f64` is used before a run alone"
)]

use core::hash::{Hash, Hasher};
use core::ops::{Add, Neg, Sub};

use crate::number::pair::{SinglePair, added};
use crate::number::{Number, SUM_BITS};

/// A signal in single precision: per unit, within ±8 where it enters a drive, and always finite.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "Unchecked"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Single(f32);

/// A word that was read, of any value. It is called as what it becomes, since some formats write the name of a type; so does a baked drive.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(rename = "Single")]
struct Unchecked(f32);

#[cfg(feature = "serde")]
impl From<Unchecked> for Single {
    fn from(Unchecked(value): Unchecked) -> Self {
        Self::new(value)
    }
}

/// Largest magnitude of a signal.
const LARGEST: f32 = 8.0;
/// A gain's magnitude is below this.
const LARGEST_GAIN: f64 = 4.0;
/// A steep coefficient is below this.
const STEEPEST: f64 = 65536.0;

impl Single {
    /// The signal of this value, held within ±8. NaN becomes 0.
    #[must_use]
    #[inline]
    pub const fn new(value: f32) -> Self {
        Self(if value.is_nan() { 0.0 } else { value.clamp(-LARGEST, LARGEST) })
    }

    /// The value.
    #[must_use]
    #[inline]
    pub const fn value(self) -> f32 {
        self.0
    }

    /// The value; exact.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        f64::from(self.0)
    }

    /// The word of the value, IEEE 754.
    #[must_use]
    pub const fn to_bits(self) -> u32 {
        self.0.to_bits()
    }
}

impl From<f32> for Single {
    fn from(value: f32) -> Self {
        Self::new(value)
    }
}

impl From<Single> for f32 {
    fn from(signal: Single) -> Self {
        signal.value()
    }
}

impl Hash for Single {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.to_bits().hash(state);
    }
}

impl Add for Single {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for Single {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Neg for Single {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

/// The coefficient nearest to a value.
#[expect(clippy::cast_possible_truncation, reason = "rounded to nearest; its range was checked")]
fn word(value: f64) -> f32 {
    value as f32
}

/// Out of line, so that a signal within the limit stays where it is.
#[cold]
#[inline(never)]
fn at_limit(value: f32, limit: f32) -> f32 {
    if value < 0.0 { -limit } else { limit }
}

/// Σ a·b, from left to right.
#[inline]
fn products<const K: usize>(a: [f32; K], b: [Single; K]) -> f32 {
    let mut terms = a.into_iter().zip(b).map(|(a, b)| a * b.0);
    let first = terms.next().unwrap_or(0.0);
    terms.fold(first, |sum, term| sum + term)
}

/// w^-¼ of a positive number; error 2 steps (1.2e-7 of the value) from 2⁻¹²⁶ on. At 0 it is finite, 6e9, so that a root is 0 there.
///
/// A quarter of the exponent and of the digits, taken from a constant, is within 4 % (the constant and the first step's are those with the
/// smallest error after that step, 1.5e-3); the second step is of third order: z + z·(r/4 + 5·r²/32) with r = 1 − w·z⁴.
#[inline]
fn inverse_fourth_root(w: f32) -> f32 {
    const FROM: u32 = 0x4F54_0000;
    let z = f32::from_bits(FROM.wrapping_sub(w.to_bits() >> 2));
    let square = z * z;
    let z = z * (1.276 - 0.276 * w * square * square);
    let square = z * z;
    let rest = 1.0 - w * square * square;
    z + z * (rest * (0.25 + 0.156_25 * rest))
}

impl Number for Single {
    type Real = f64;
    type Value = f64;
    type Gain = f32;
    type Steep = f32;
    type Travel = SinglePair;

    const LEAN: bool = true;
    // A root has some twenty instructions, the check and the tangent ten; a reciprocal is one.
    const SHORTCUTS: bool = false;
    const ZERO: Self = Self(0.0);
    const ONE: Self = Self(1.0);

    fn signal(value: f64) -> Option<Self> {
        (value.abs() < f64::from(LARGEST)).then(|| Self(word(value)))
    }
    fn saturated(value: f64) -> Self {
        Self::new(word(value))
    }
    #[inline]
    fn counted(counts: i32) -> Self {
        Self::new(counts as f32 * (1.0 / 65536.0))
    }
    fn to_real(self) -> f64 {
        self.to_f64()
    }
    fn gain(value: f64) -> Option<f32> {
        (value.abs() < LARGEST_GAIN).then(|| word(value))
    }
    fn steep(value: f64) -> Option<f32> {
        (0.0..STEEPEST).contains(&value).then(|| word(value))
    }
    #[inline]
    fn times(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
    #[inline]
    fn of(self, signal: Self) -> Self {
        self.times(signal)
    }
    #[inline]
    fn part(self, of: f32) -> Self {
        Self(self.0 * of)
    }
    #[inline]
    fn dot<const K: usize>(gains: [f32; K], signals: [Self; K]) -> Self {
        Self(products(gains, signals))
    }
    #[inline]
    fn accumulated<const K: usize>(self, rest: Self, gains: [f32; K], signals: [Self; K]) -> (Self, Self) {
        let (sum, rest) = added(self.0, products(gains, signals) + rest.0);
        // A sum that is held has lost more than its remainder.
        if sum.abs() <= LARGEST { (Self(sum), Self(rest)) } else { (Self(at_limit(sum, LARGEST)), Self::ZERO) }
    }
    #[inline]
    fn amplified(self, by: f32) -> Self {
        Self(self.0 * by)
    }
    #[inline]
    fn within_range(self) -> Self {
        self.limited(Self(LARGEST))
    }
    #[inline]
    fn limited(self, limit: Self) -> Self {
        debug_assert!(limit >= Self::ZERO, "a limit is not negative: {limit:?}");
        if self.0.abs() <= limit.0 { self } else { Self(at_limit(self.0, limit.0)) }
    }
    #[inline]
    fn clipped(self, limit: Self) -> (Self, bool) {
        // A comparison with itself would be a second one, since the compiler has to think of NaN.
        if self.0.abs() <= limit.0 { (self, true) } else { (Self(at_limit(self.0, limit.0)), false) }
    }
    #[inline]
    fn magnitude(self) -> Self {
        Self(self.0.abs())
    }
    #[inline]
    fn halved(self) -> Self {
        Self(self.0 * 0.5)
    }
    #[inline]
    fn over_power(self, bits: u8) -> Self {
        Self(self.0 * (1.0 / (1_u64 << bits) as f32))
    }
    #[inline]
    fn orifice_root(self, transition: Self) -> (Self, f32) {
        let chord = inverse_fourth_root(self.0 * self.0 + transition.0 * transition.0);
        (Self(self.0 * chord), chord)
    }
    #[inline]
    fn over_root_of_one_plus(self, more: Self) -> Self {
        let whole = 1.0 + more.0;
        Self(self.0 * inverse_fourth_root(whole * whole))
    }
    #[inline]
    fn inverse_one_plus<const K: usize>(weights: [Self; K], steep: [f32; K]) -> Self {
        Self(1.0 / (1.0 + products(steep, weights)))
    }
    #[inline]
    fn inverse_one_plus_product(gain: f32, signal: Self) -> Self {
        Self(1.0 / (1.0 + gain * signal.0))
    }
    #[inline]
    fn share<const K: usize>(part: Self, weights: [Self; K], steep: [f32; K]) -> Self {
        if part.0 > 0.0 {
            let weights = weights.map(|weight| Number::max(weight, Self::ZERO));
            Self(part.0 / (part.0 + products(steep, weights)))
        } else {
            Self::ZERO
        }
    }
    #[inline]
    fn as_gain(self) -> f32 {
        self.0
    }
    #[inline]
    fn scaled(gain: f32, share: Self) -> f32 {
        gain * share.0
    }
    #[inline]
    fn of_gain(gain: f32) -> Self {
        Self(gain)
    }
    fn travel(strokes: f64) -> SinglePair {
        SinglePair::of(strokes)
    }
    #[inline]
    fn as_travel(self) -> SinglePair {
        SinglePair::exactly(self.0)
    }
    #[inline]
    fn travelled<const K: usize>(from: SinglePair, gains: [f32; K], signals: [Self; K]) -> SinglePair {
        from.plus(products(gains, signals))
    }
    #[inline]
    fn summed(sum: SinglePair, more: Self) -> SinglePair {
        sum.plus(more.over_power(SUM_BITS).0)
    }
    #[inline]
    fn of_sum(sum: SinglePair) -> Self {
        const UNIT: f32 = (1_u32 << SUM_BITS) as f32;
        Self(sum.rounded() * UNIT).within_range()
    }
    #[inline]
    fn of_travel(travel: SinglePair) -> Self {
        Self(travel.rounded())
    }
    fn strokes(travel: SinglePair) -> f64 {
        travel.to_f64()
    }
}

#[cfg(test)]
mod tests;
