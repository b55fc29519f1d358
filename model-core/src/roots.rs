//! Roots and reciprocals in integers: a table's seed and one Newton step each, without division but one of two words.

use fixed::types::U16F16;

use crate::fixed_point::{FRACTION, PerUnit};

/// Upper word of the product of two unsigned words.
#[inline]
fn upper(a: u32, b: u32) -> u32 {
    ((u64::from(a) * u64::from(b)) >> 32) as u32
}

impl PerUnit {
    /// Δ·w^-¼.
    #[inline]
    pub(crate) fn rooted(self, inverse: InverseFourthRoot) -> Self {
        // |Δ| ≤ √w < 2^(32 − s/2), so Δ may move up by s/2 − 1 and keep its sign bit; then the upper word keeps all its digits.
        let up = (inverse.zeros >> 1).saturating_sub(1);
        let wide = i64::from(self.to_bits() << up) * i64::from(inverse.mantissa);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "a product of two words shifted by 31 is below 2^31 as mantissa < 2^31 and the root is below 2^30·√8"
        )]
        let word = (wide >> 31) as i32;
        // `word` holds Δ·mantissa with 27 + up fractional bits; times 2^q and back to 28. As up ≈ s/2 and q ≈ s/4, `down` is 1 at least.
        let down = (up.cast_signed() - 1 - inverse.exponent()).unsigned_abs();
        Self::from_bits(word.saturating_add(1 << (down - 1)) >> down)
    }
}

/// w^-¼ for w = Δ² + pt², as `mantissa`·2^-30·2^((zeros − 8) div 4).
#[derive(Clone, Copy)]
pub(crate) struct InverseFourthRoot {
    /// In [1, 2), 30 fractional bits.
    mantissa: u32,
    /// Leading zeros of w in 64 bits with 56 fractional bits.
    zeros: u32,
}

/// μ^-¼ over [½, 1) in 32 intervals: value (F31) at the left end, and drop to the right end (F31).
const SEEDS: [(u32, u32); 32] = seeds();

/// 2^(r/4) with 31 fractional bits.
const QUARTER_OCTAVES: [u32; 4] = [2_147_483_648, 2_553_802_834, 3_037_000_500, 3_611_622_603];

impl InverseFourthRoot {
    #[inline]
    pub(crate) fn of(delta: PerUnit, transition: PerUnit) -> Self {
        let square = |signal: PerUnit| {
            let magnitude = u64::from(signal.to_bits().unsigned_abs());
            magnitude * magnitude
        };
        let w = (square(delta) + square(transition)).max(1);
        let zeros = w.leading_zeros();
        let mu = ((w << zeros) >> 32) as u32;
        #[expect(clippy::indexing_slicing, reason = "five bits index 32 seeds")]
        let (left, drop) = SEEDS[(mu >> 26) as usize & 31];
        let z = left - upper(drop, mu << 6);
        // One Newton step for z^-4 = μ: z + z·(1 − μz⁴)/4.
        let square = upper(z, z); // F30
        let fourth = upper(square, square); // F28
        let miss = (1 << FRACTION) - upper(mu, fourth).cast_signed(); // F28
        #[expect(clippy::cast_possible_truncation, reason = "|miss| < 2^-12, so the correction is far below z")]
        let correction = ((i64::from(z) * i64::from(miss)) >> 30) as i32;
        let z = z.wrapping_add_signed(correction);
        #[expect(clippy::indexing_slicing, reason = "two bits index four octaves")]
        let mantissa = upper(z, QUARTER_OCTAVES[(zeros & 3) as usize]);
        Self { mantissa, zeros }
    }

    /// Power of two of the value.
    #[inline]
    fn exponent(self) -> i32 {
        (self.zeros >> 2).cast_signed() - 2
    }

    /// The value.
    #[inline]
    pub(crate) fn value(self) -> U16F16 {
        U16F16::from_bits(self.mantissa >> (14 - self.exponent()).unsigned_abs())
    }
}

/// Table of [`SEEDS`], computed by the compiler in integers.
#[expect(clippy::indexing_slicing, reason = "evaluated by the compiler")]
const fn seeds() -> [(u32, u32); 32] {
    let mut table = [(0, 0); 32];
    let mut index = 0;
    while index < 32 {
        let left = inverse_fourth_root(32 + index as u128);
        table[index] = (left, left - inverse_fourth_root(33 + index as u128));
        index += 1;
    }
    table
}

/// (n/64)^-¼ with 31 fractional bits, of which 24 are computed, for n in 32..=64: the largest z with z⁴·n ≤ 64.
const fn inverse_fourth_root(n: u128) -> u32 {
    let (mut low, mut high) = (1_u32 << 24, 1_u32 << 25);
    while high - low > 1 {
        let middle = u32::midpoint(low, high);
        if (middle as u128).pow(4) * n <= 64 << 96 {
            low = middle;
        } else {
            high = middle;
        }
    }
    low << 7
}

/// 1 / (1 + sum) with 28 fractional bits, from a sum with 44.
#[inline]
pub(crate) fn reciprocal_of_one_plus(sum: u64) -> PerUnit {
    let (z, zeros) = reciprocal(sum.saturating_add(1 << 44));
    // z has 30 fractional bits: 28 wanted.
    PerUnit::from_bits((z >> 22_u32.saturating_sub(zeros)).min(1 << FRACTION).cast_signed())
}

/// part / (part + sum) with 28 fractional bits, from a part below 2³¹ with 28 and a sum with 44. No part of nothing.
#[inline]
pub(crate) fn share_of(part: u32, sum: u64) -> PerUnit {
    if part == 0 {
        return PerUnit::from_bits(0);
    }
    let (z, zeros) = reciprocal(sum.saturating_add(u64::from(part) << 16));
    // The product has 58 fractional bits and is below 2⁶³. The whole is 2¹⁶ at least, so there are 47 zeros at most.
    let share = (u64::from(part) * u64::from(z)) >> 50_u32.saturating_sub(zeros);
    let word = share.min(1 << FRACTION) as i32;
    PerUnit::from_bits(word)
}

/// z in [1, 2] with 30 fractional bits and the leading zeros, with 1/value = z·2^(zeros − 20), for a value of 44 that is not 0.
#[inline]
fn reciprocal(value: u64) -> (u32, u32) {
    let zeros = value.leading_zeros();
    let mu = ((value << zeros) >> 32) as u32; // F32, in [½, 1): value = μ·2^(32 − zeros + 32 − 44)
    let seed = u32::MAX / ((mu >> 16) + 1); // 1/μ, F16, just below
    let seed = seed << 14; // F30, in [1, 2]
    // One Newton step: z + z·(1 − μz).
    #[expect(clippy::cast_possible_wrap, reason = "μz is below 1 with 30 fractional bits")]
    let miss = (1 << 30) - upper(mu, seed) as i32; // F30
    #[expect(clippy::cast_possible_truncation, reason = "miss < 2^-14")]
    let correction = ((i64::from(seed) * i64::from(miss)) >> 30) as i32;
    (seed.wrapping_add_signed(correction), zeros)
}
