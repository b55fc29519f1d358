//! Fixed point: formats, rounding and saturation, all of it.
//!
//! | quantity | format | range | step | why |
//! |---|---|---|---|---|
//! | signal ([`PerUnit`]) | `I4F28` | ±8 | 3.7e-9 | pressures reach several supplies under load; one 32-bit word |
//! | gain | `I4F28`, magnitude below 4 | ±4 | 3.7e-9 | four products of gain and signal fit 64 bits without a check |
//! | steep coefficient | `U16F16` | 0..65536 | 1.5e-5 | slope of the root near Δp = 0; only steers the Jacobian and the rate limiter's mean |
//! | position | `I8F56` | ±128 strokes | 1.4e-17 | products of gain and velocity are added exactly: no drift, no dead band |
//!
//! A product of two 32-bit words is one instruction with a 64-bit result on every target; [`Number::dot`] keeps that
//! result to the end and rounds once, to nearest, ties upward. A result beyond the range is held at its end; that of a product of two signals or
//! gains is held within 15 steps of the end. Integration over a run loses nothing: the position has enough digits, and a pressure carries its
//! rounding remainder ([`Number::accumulated`]).
//!
//! Error bounds, asserted in this file's tests: `times`, `dot` half a step (1.9e-9); `orifice_root` 2 steps + 6e-9
//! of the value; `inverse_one_plus` and `share` 2e-8; chords 2e-5 + 1e-6 of the value (a Rosenbrock step is of second order
//! for *any* Jacobian, so a slope needs no more).

use core::ops::{Add, Neg, Sub};

use fixed::types::{I4F28, I8F56, U16F16};

use crate::number::roots::{InverseFourthRoot, reciprocal_of_one_plus, reciprocal_of_one_plus_fine, share_of};
use crate::number::{Number, SUM_BITS};

/// A signal on the controller: per unit, `I4F28`, range ±8, step 2⁻²⁸. Sums saturate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PerUnit(#[doc(hidden)] pub I4F28);

/// Fractional bits of a signal.
pub(crate) const FRACTION: u32 = 28;

/// A gain stays below 4 after rounding to its format.
const LARGEST_GAIN: f64 = 3.999_999_99;

impl PerUnit {
    /// The signal whose raw word is `bits`.
    #[must_use]
    pub const fn from_bits(bits: i32) -> Self {
        Self(I4F28::from_bits(bits))
    }

    /// The raw word.
    #[must_use]
    pub const fn to_bits(self) -> i32 {
        self.0.to_bits()
    }

    /// A position as a signal, in strokes, rounded down to the signal's step and held at ±8.
    #[must_use]
    #[inline]
    pub fn of_travel(travel: I8F56) -> Self {
        Self(I4F28::saturating_from_num(travel))
    }

    /// The value.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        self.0.to_num()
    }

    /// A position in strokes.
    #[must_use]
    pub fn strokes(travel: I8F56) -> f64 {
        travel.to_num()
    }
}

impl Add for PerUnit {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl Sub for PerUnit {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl Neg for PerUnit {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self(I4F28::ZERO.saturating_sub(self.0))
    }
}

/// Upper and lower word.
#[inline]
fn words(wide: i64) -> (i32, u32) {
    let bits = wide.cast_unsigned();
    #[expect(clippy::cast_possible_truncation, reason = "the two words of it")]
    let (upper, lower) = ((bits >> 32) as u32, bits as u32);
    (upper.cast_signed(), lower)
}

/// A held word may lie this many steps from the end of the range, since a product keeps its lowest four digits.
const END: i32 = 15;

/// A 64-bit product or sum of products with 56 fractional bits, rounded to a signal; beyond the range within [`END`] of its end.
///
/// An Arm instruction saturates the upper word of the rounded value to 28 bits; these are the signal's upper bits.
#[inline]
fn rounded(wide: i64) -> PerUnit {
    const HALF: i64 = 1 << (FRACTION - 1);
    const LARGEST: i32 = (1 << (FRACTION - 1)) - 1;
    let (upper, lower) = words(wide.wrapping_add(HALF));
    PerUnit::from_bits(upper.clamp(-LARGEST - 1, LARGEST) << (32 - FRACTION) | (lower >> FRACTION).cast_signed())
}

/// The same for a value that is known to stay in the range.
#[inline]
fn rounded_within(wide: i64) -> PerUnit {
    #[expect(clippy::cast_possible_truncation, reason = "it is in the range")]
    let (word, below) = ((wide >> FRACTION) as i32, (wide >> (FRACTION - 1)) as i32 & 1);
    PerUnit::from_bits(word.wrapping_add(below))
}

/// A product with 44 fractional bits, rounded to a signal and held at the ends of the range.
#[inline]
fn rounded_steep(wide: i64) -> PerUnit {
    let (upper, lower) = words(wide.wrapping_add(1 << 15));
    let (word, sign) = (upper << 16 | (lower >> 16).cast_signed(), upper >> 31);
    PerUnit::from_bits(if upper >> 15 == sign { word } else { sign ^ i32::MAX })
}

/// The limit with the word's sign. Out of line: for a signal within the limit, the compiler then knows that it stays unchanged.
#[cold]
#[inline(never)]
fn at_limit(word: i32, limit: i32) -> PerUnit {
    PerUnit::from_bits(if word < 0 { -limit } else { limit })
}

/// Rounding remainder of `wide` as a signal: within half a step, in units of 2⁻⁵⁶.
#[inline]
fn left_by_rounding(wide: i64) -> i32 {
    const HALF: i32 = 1 << (FRACTION - 1);
    #[expect(clippy::cast_possible_truncation, reason = "only the digits below the step are wanted")]
    let word = wide as i32;
    (word.wrapping_add(HALF) & (2 * HALF - 1)) - HALF
}

/// Exact Σ gain·signal with 56 fractional bits. Each product is below 2⁶¹, so four of them fit.
#[inline]
fn products<const K: usize>(gains: [I4F28; K], signals: [PerUnit; K]) -> i64 {
    const { assert!(K <= 4, "more than four products may overflow 64 bits") };
    gains
        .into_iter()
        .zip(signals)
        .fold(0_i64, |sum, (gain, signal)| sum.wrapping_add(i64::from(gain.to_bits()) * i64::from(signal.to_bits())))
}

/// Σ weight·steep with 44 fractional bits, held at the end of the range.
#[inline]
fn weighed<const K: usize>(weights: [PerUnit; K], steep: [U16F16; K]) -> u64 {
    weights.into_iter().zip(steep).fold(0_u64, |sum, (weight, steep)| {
        let product = u64::from(weight.to_bits().max(0).cast_unsigned()) * u64::from(steep.to_bits());
        // A product is below 2⁶³, so two of them fit.
        if K > 2 { sum.saturating_add(product) } else { sum.wrapping_add(product) }
    })
}

impl Number for PerUnit {
    type Real = f64;
    type Value = f64;
    type Gain = I4F28;
    type Steep = U16F16;
    type Travel = I8F56;

    const LEAN: bool = true;
    const ZERO: Self = Self(I4F28::ZERO);
    const ONE: Self = Self(I4F28::ONE);

    fn signal(value: f64) -> Option<Self> {
        if value.is_finite() { I4F28::checked_from_num(value).map(Self) } else { None }
    }
    fn saturated(value: f64) -> Self {
        if value.is_nan() { Self::ZERO } else { Self(I4F28::saturating_from_num(value)) }
    }
    #[inline]
    fn counted(counts: i32) -> Self {
        Self::from_bits(counts.saturating_mul(1 << (FRACTION - 16)))
    }
    fn to_real(self) -> f64 {
        self.to_f64()
    }
    fn gain(value: f64) -> Option<I4F28> {
        let fits = value.is_finite() && value.abs() < LARGEST_GAIN;
        if fits { I4F28::checked_from_num(value) } else { None }
    }
    fn steep(value: f64) -> Option<U16F16> {
        if value.is_finite() { U16F16::checked_from_num(value) } else { None }
    }
    #[inline]
    fn times(self, other: Self) -> Self {
        rounded(i64::from(self.to_bits()) * i64::from(other.to_bits()))
    }
    #[inline]
    fn of(self, signal: Self) -> Self {
        debug_assert!(Self::ZERO <= self && self <= Self::ONE, "a share is in 0..1: {self:?}");
        rounded_within(i64::from(self.to_bits()) * i64::from(signal.to_bits()))
    }
    #[inline]
    fn part(self, of: I4F28) -> Self {
        debug_assert!((I4F28::ZERO..=I4F28::ONE).contains(&of), "a part is in 0..1: {of}");
        rounded_within(i64::from(of.to_bits()) * i64::from(self.to_bits()))
    }
    #[inline]
    fn small_part(self, of: I4F28) -> Self {
        debug_assert!((I4F28::ZERO..I4F28::ONE / 2).contains(&of), "a small part is in 0..1/2: {of}");
        // Bit for bit the result of `part`; the rounded upper word is one instruction on the M4.
        let wide = i64::from(of.to_bits() << (32 - FRACTION)) * i64::from(self.to_bits());
        let (nearest, _) = words(wide + (1 << 31));
        PerUnit::from_bits(nearest)
    }
    #[inline]
    fn dot<const K: usize>(gains: [I4F28; K], signals: [Self; K]) -> Self {
        rounded(products(gains, signals))
    }
    #[inline]
    fn accumulated<const K: usize>(self, rest: Self, gains: [I4F28; K], signals: [Self; K]) -> (Self, Self) {
        let wide = products(gains, signals).wrapping_add(i64::from(rest.to_bits()));
        (self + rounded(wide), Self::from_bits(left_by_rounding(wide)))
    }
    #[inline]
    fn amplified(self, by: U16F16) -> Self {
        rounded_steep(i64::from(self.to_bits()) * i64::from(by.to_bits()))
    }
    #[inline]
    fn amplified_within(self, by: U16F16) -> Self {
        let wide = i64::from(self.to_bits()) * i64::from(by.to_bits()) + (1 << 15);
        debug_assert!(wide >> 47 == wide >> 63, "{self:?} times {by} is in the range");
        #[expect(clippy::cast_possible_truncation, reason = "it is in the range")]
        let word = (wide >> 16) as i32;
        Self::from_bits(word)
    }
    #[inline]
    fn magnitude_amplified(self, by: U16F16) -> Self {
        // Bit for bit the result of the other two; without a sign the product has no correction for one.
        let wide = u64::from(self.to_bits().unsigned_abs()) * u64::from(by.to_bits()) + (1 << 15);
        debug_assert!(wide >> 47 == 0, "{self:?} times {by} is in the range");
        #[expect(clippy::cast_possible_truncation, reason = "it is in the range")]
        let word = (wide >> 16) as i32;
        Self::from_bits(word)
    }
    #[inline]
    fn limited(self, limit: Self) -> Self {
        debug_assert!(limit >= Self::ZERO, "a limit is not negative: {limit:?}");
        let (word, limit) = (self.to_bits(), limit.to_bits());
        if word.wrapping_add(limit).cast_unsigned() <= limit.cast_unsigned() << 1 {
            self
        } else {
            at_limit(word, limit)
        }
    }
    #[inline]
    fn magnitude(self) -> Self {
        Self::from_bits(self.to_bits().saturating_abs())
    }
    #[inline]
    fn is_held(self) -> bool {
        // From this word through the upper end, wrapping around, to the same distance from the lower end.
        self.to_bits().wrapping_sub(i32::MAX - END).cast_unsigned() <= (2 * END + 1).cast_unsigned()
    }
    #[inline]
    fn halved(self) -> Self {
        Self::from_bits(self.to_bits() >> 1)
    }
    #[inline]
    fn over_power(self, bits: u8) -> Self {
        Self::from_bits(self.to_bits() >> bits)
    }
    #[inline]
    fn orifice_root(self, transition: Self) -> (Self, U16F16) {
        let inverse = InverseFourthRoot::of(self, transition);
        (self.rooted(inverse), inverse.value())
    }
    #[inline]
    fn over_root_of_one_plus(self, more: Self) -> Self {
        debug_assert!(more >= Self::ZERO, "more than nothing: {more:?}");
        InverseFourthRoot::of(Self::ONE + more, Self::ZERO).of_one_or_more(self)
    }
    #[inline]
    fn inverse_one_plus<const K: usize>(weights: [Self; K], steep: [U16F16; K]) -> Self {
        reciprocal_of_one_plus(weighed(weights, steep))
    }
    #[inline]
    fn inverse_one_plus_product(gain: I4F28, signal: Self) -> Self {
        let product = i64::from(gain.to_bits()) * i64::from(signal.to_bits());
        debug_assert!(product >= 0, "a weight is not negative: {gain} of {signal:?}");
        reciprocal_of_one_plus_fine(product.cast_unsigned())
    }
    #[inline]
    fn share<const K: usize>(part: Self, weights: [Self; K], steep: [U16F16; K]) -> Self {
        share_of(part.to_bits().max(0).unsigned_abs(), weighed(weights, steep))
    }
    #[inline]
    fn as_gain(self) -> I4F28 {
        const LARGEST: i32 = (1 << 30) - 1;
        I4F28::from_bits(self.to_bits().clamp(-LARGEST, LARGEST))
    }
    #[inline]
    fn scaled(gain: I4F28, share: Self) -> I4F28 {
        share.of(Self(gain)).0
    }
    #[inline]
    fn of_gain(gain: I4F28) -> Self {
        Self(gain)
    }
    fn travel(strokes: f64) -> I8F56 {
        if strokes.is_nan() { I8F56::ZERO } else { I8F56::saturating_from_num(strokes) }
    }
    #[inline]
    fn as_travel(self) -> I8F56 {
        I8F56::from(self.0)
    }
    #[inline]
    fn travelled<const K: usize>(from: I8F56, gains: [I4F28; K], signals: [Self; K]) -> I8F56 {
        let ((upper, lower), (more, below)) = (words(from.to_bits()), words(products(gains, signals)));
        // Saturated by its upper word, within 2⁻²⁴ of a stroke of the ends.
        let (lower, carry) = lower.overflowing_add(below);
        let upper = upper.saturating_add(more.wrapping_add(i32::from(carry)));
        I8F56::from_bits(i64::from(upper) << 32 | i64::from(lower))
    }
    #[inline]
    fn summed(sum: I8F56, more: Self) -> I8F56 {
        const LESS: u32 = FRACTION - SUM_BITS as u32;
        I8F56::from_bits(sum.to_bits().saturating_add(i64::from(more.to_bits()) << LESS))
    }
    #[inline]
    fn of_sum(sum: I8F56) -> Self {
        const LESS: u32 = FRACTION - SUM_BITS as u32;
        let (least, most) = (i64::from(i32::MIN), i64::from(i32::MAX));
        #[expect(clippy::cast_possible_truncation, reason = "it is in the range")]
        let word = (sum.to_bits() >> LESS).clamp(least, most) as i32;
        Self::from_bits(word)
    }
    #[inline]
    fn of_travel(travel: I8F56) -> Self {
        Self::of_travel(travel)
    }
    fn strokes(travel: I8F56) -> f64 {
        Self::strokes(travel)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::number::SUM_UNIT;

    fn signal(bits: i32) -> (PerUnit, f64) {
        let signal = PerUnit::from_bits(bits);
        (signal, signal.to_f64())
    }

    const STEP: f64 = 1.0 / (1_u64 << 28) as f64;

    #[test]
    fn root_of_a_quarter_is_a_half() {
        let (root, slope) = PerUnit::saturated(0.25).orifice_root(PerUnit::from_bits(1 << 8));
        assert!((root.to_f64() - 0.5).abs() < 2e-8, "{root:?}");
        assert!((slope.to_num::<f64>() - 2.0).abs() < 1e-4, "{slope:?}");
    }

    #[test]
    fn half_is_the_inverse_of_one_plus_one() {
        let half = PerUnit::inverse_one_plus([PerUnit::ONE], [U16F16::ONE]);
        assert!((half.to_f64() - 0.5).abs() < 2e-8, "{half:?}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn root_and_slope_agree_with_the_formula(bits in any::<i32>(), small in 0_u32..31, pt in 1_i32..1 << 24) {
            let (delta, d) = signal(bits >> small);
            let (_, p) = signal(pt);
            let (root, slope) = delta.orifice_root(PerUnit::from_bits(pt));
            let w = d * d + p * p;
            let exact = d / w.powf(0.25);
            prop_assert!((root.to_f64() - exact).abs() <= 2.0 * STEP + 6e-9 * exact.abs(), "{} {exact}", root.to_f64());
            let exact = w.powf(-0.25);
            let slope: f64 = slope.to_num();
            prop_assert!((slope - exact).abs() <= 2e-5 + 1e-6 * exact, "{slope} {exact}");
        }

        #[test]
        fn root_is_odd(bits in -i32::MAX..=i32::MAX, pt in 1_i32..1 << 24) {
            let (delta, _) = signal(bits);
            let (up, _) = delta.orifice_root(PerUnit::from_bits(pt));
            let (down, _) = (-delta).orifice_root(PerUnit::from_bits(pt));
            prop_assert!((up.to_bits() + down.to_bits()).abs() <= 1);
        }

        #[test]
        fn inverse_agrees_with_the_formula(weight in 0_i32..=i32::MAX, small in 0_u32..31, steep in any::<u32>(), less in 0_u32..31) {
            let (weight, w) = signal(weight >> small);
            let steep = U16F16::from_bits(steep >> less);
            let exact = 1.0 / (1.0 + w * steep.to_num::<f64>());
            let inverse = PerUnit::inverse_one_plus([weight], [steep]).to_f64();
            prop_assert!((inverse - exact).abs() <= 2e-8, "{inverse} {exact}");
        }

        #[test]
        fn inverse_of_a_product_agrees_with_the_formula(
            gain in 0_i32..1 << 30, less in 0_u32..30, weight in 0_i32..=i32::MAX, small in 0_u32..31,
        ) {
            let ((gain, g), (weight, w)) = (signal(gain >> less), signal(weight >> small));
            let inverse = PerUnit::inverse_one_plus_product(gain.as_gain(), weight).to_f64();
            prop_assert!((inverse - 1.0 / (1.0 + g * w)).abs() <= 2e-8, "{inverse} {g} {w}");
        }

        #[test]
        fn steep_products_round_to_nearest_and_saturate(a in any::<i32>(), small in 0_u32..31, steep in any::<u32>(), less in 0_u32..31) {
            let ((a, x), steep) = (signal(a >> small), U16F16::from_bits(steep >> less));
            let exact = (x * steep.to_num::<f64>()).clamp(-8.0, 8.0 - STEP);
            prop_assert!((a.amplified(steep).to_f64() - exact).abs() <= 0.5 * STEP + 1e-14);
            let magnitude = a.magnitude();
            if !magnitude.amplified(steep).is_held() {
                prop_assert_eq!(a.magnitude_amplified(steep), magnitude.amplified(steep));
            }
        }

        #[test]
        fn a_signal_over_a_root_agrees_with_the_formula(a in any::<i32>(), small in 0_u32..31, more in 0_i32..=i32::MAX - (1 << 28), less in 0_u32..31) {
            let ((a, x), (more, z)) = (signal(a >> small), signal(more >> less));
            let exact = x / (1.0 + z).sqrt();
            let off = (a.over_root_of_one_plus(more).to_f64() - exact).abs();
            prop_assert!(off <= STEP + 1e-8 * exact.abs(), "{off} of {exact}");
        }

        #[test]
        fn share_agrees_with_the_formula(
            part in 0_i32..=i32::MAX, little in 0_u32..31, weight in 0_i32..=i32::MAX, small in 0_u32..31,
            steep in any::<u32>(), less in 0_u32..31,
        ) {
            let ((part, p), (weight, w)) = (signal(part >> little), signal(weight >> small));
            let steep = U16F16::from_bits(steep >> less);
            let exact = if p > 0.0 { p / (p + w * steep.to_num::<f64>()) } else { 0.0 };
            let share = PerUnit::share(part, [weight], [steep]).to_f64();
            prop_assert!((share - exact).abs() <= 2e-8, "{share} {exact}");
        }

        #[test]
        fn a_signal_is_a_position_to_the_bit(bits in any::<i32>()) {
            let (signal, strokes) = signal(bits);
            prop_assert_eq!(signal.as_travel(), PerUnit::travel(strokes));
            prop_assert_eq!(PerUnit::of_travel(signal.as_travel()), signal);
        }

        #[test]
        fn products_round_to_nearest_and_saturate(a in any::<i32>(), b in any::<i32>()) {
            let ((a, x), (b, y)) = (signal(a), signal(b));
            let exact = (x * y).clamp(-8.0, 8.0 - STEP);
            let off = (a.times(b).to_f64() - exact).abs();
            prop_assert!(off <= 0.5 * STEP + 1e-14 || (x * y).abs() > 8.0 - STEP && off <= 15.0 * STEP, "{off}");
        }

        #[test]
        fn products_with_a_share_round_to_nearest(share in 0..=1_i32 << 28, b in any::<i32>()) {
            let ((share, x), (b, y)) = (signal(share), signal(b));
            let exact = x * y;
            prop_assert!((share.of(b).to_f64() - exact).abs() <= 0.5 * STEP + 1e-14);
            prop_assert_eq!(b.part(share.as_gain()), share.of(b));
        }

        #[test]
        fn sum_of_four_products_is_exact_to_half_a_step(g in prop::array::uniform4(-(1_i32 << 30) + 1..1_i32 << 30), s in prop::array::uniform4(any::<i32>())) {
            let exact: i128 = g.iter().zip(&s).map(|(&g, &s)| i128::from(g) * i128::from(s)).sum();
            let nearest = (exact + (1 << 27)) >> 28;
            let held = nearest.clamp(i128::from(i32::MIN), i128::from(i32::MAX));
            let dot = PerUnit::dot(g.map(I4F28::from_bits), s.map(PerUnit::from_bits));
            let off = (i128::from(dot.to_bits()) - held).abs();
            prop_assert!(off <= if held == nearest { 0 } else { 15 }, "{off} from {nearest}");
            prop_assert!(held == nearest || dot.is_held());
            prop_assert!(!dot.is_held() || nearest.abs() >= i128::from(i32::MAX) - 15);
        }

        #[test]
        fn accumulating_loses_nothing(gain in -(1_i32 << 30) + 1..1_i32 << 30, signals in prop::collection::vec(-(1_i32 << 20)..1_i32 << 20, 1..200)) {
            let (mut sum, mut rest, mut exact) = (PerUnit::ZERO, PerUnit::ZERO, 0_i64);
            for bits in signals {
                (sum, rest) = sum.accumulated(rest, [I4F28::from_bits(gain)], [PerUnit::from_bits(bits)]);
                exact += i64::from(gain) * i64::from(bits);
                prop_assert_eq!((i64::from(sum.to_bits()) << 28) + i64::from(rest.to_bits()), exact);
                prop_assert!(rest.to_bits().unsigned_abs() <= 1 << 27);
            }
        }

        #[test]
        fn a_sum_of_signals_loses_nothing(words in prop::collection::vec(any::<i32>(), 1..200)) {
            let (mut sum, mut exact) = (I8F56::ZERO, 0_i64);
            for bits in words {
                sum = PerUnit::summed(sum, PerUnit::from_bits(bits));
                exact += i64::from(bits);
                let held = exact.clamp(i64::from(i32::MIN), i64::from(i32::MAX));
                prop_assert_eq!(i64::from(PerUnit::of_sum(sum).to_bits()), held);
                prop_assert!((PerUnit::strokes(sum) * SUM_UNIT - exact as f64 * STEP).abs() < 1e-9);
            }
        }

        #[test]
        fn travel_loses_nothing(gain in -(1_i32 << 30) + 1..1_i32 << 30, bits in any::<i32>(), start in -(1_i64 << 60)..1_i64 << 60) {
            let there = PerUnit::travelled(I8F56::from_bits(start), [I4F28::from_bits(gain)], [PerUnit::from_bits(bits)]);
            let back = PerUnit::travelled(there, [I4F28::from_bits(-gain)], [PerUnit::from_bits(bits)]);
            prop_assert_eq!(back.to_bits(), start);
        }
    }
}
