//! Roots and reciprocals in integers: a seed from a table and one Newton step each, without any division except one of two words.

use fixed::types::U16F16;

use crate::number::PerUnit;
use crate::number::fixed_point::FRACTION;

/// Upper word of the product of two unsigned words.
#[inline]
fn upper(a: u32, b: u32) -> u32 {
    ((u64::from(a) * u64::from(b)) >> 32) as u32
}

/// Upper word of the product of two signed words: one instruction on the M4.
#[inline]
fn upper_signed(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 32) as i32
}

impl PerUnit {
    /// Δ·w^-¼.
    #[inline]
    pub(crate) fn rooted(self, inverse: InverseFourthRoot) -> Self {
        // |Δ| is below 2³¹ after the shift, so the upper word keeps all its digits.
        let wide = i64::from(self.to_bits() << inverse.up) * i64::from(inverse.mantissa.cast_signed());
        #[expect(
            clippy::cast_possible_truncation,
            reason = "a word below 2^31 times a mantissa of 2^30 at most, shifted by 30"
        )]
        let word = (wide >> 30) as i32;
        // `word` holds Δ·mantissa with 27 + up fractional bits; times 2^exponent and back to 28. As the exponent is about up/2, `down` is at least 0.
        let down = inverse.up - inverse.quarters;
        Self::from_bits((word >> down).wrapping_add(1) >> 1)
    }
}

/// w^-¼ for w = Δ² + pt², as `mantissa`·2^-29·2^(`quarters` − 2).
#[derive(Clone, Copy)]
pub(crate) struct InverseFourthRoot {
    /// In [1, 2], 29 fractional bits.
    mantissa: u32,
    /// A quarter of the leading zeros of w in 64 bits with 56 fractional bits, rounded down.
    quarters: u32,
    /// How far Δ and pt can be shifted up.
    up: u32,
}

/// Both tables behind one address.
struct Tables {
    /// μ^-¼ over [½, 1) in 32 intervals: value (F31) at the left end, and drop to the right end (F31).
    seeds: [(u32, u32); 32],
    /// 2^(r/4) with 30 fractional bits.
    quarter_octaves: [u32; 4],
}

static TABLES: Tables =
    Tables { seeds: seeds(), quarter_octaves: [1_073_741_824, 1_276_901_417, 1_518_500_250, 1_805_811_301] };

impl InverseFourthRoot {
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "with it the caller drops what it does not need")]
    pub(crate) fn of(delta: PerUnit, transition: PerUnit) -> Self {
        let (delta, transition) = (delta.to_bits().saturating_abs(), transition.to_bits().max(1));
        // Both are shifted up as far as the sum of their squares stays below 2⁶³; its upper word then holds at least 28 digits.
        let up = (delta | transition).leading_zeros() - 1;
        let square = |magnitude: i32| {
            let moved = u64::from(magnitude.cast_unsigned() << up);
            moved * moved
        };
        let w = ((square(delta) + square(transition)) >> 32) as u32;
        let more = w.leading_zeros();
        let (mu, zeros) = (w << more, 2 * up + more);
        #[expect(clippy::indexing_slicing, reason = "five bits index 32 seeds")]
        let (left, drop) = TABLES.seeds[(mu >> 26) as usize & 31];
        let z = left - upper(drop, mu << 6);
        // One Newton step for z^-4 = μ: z + z·(1 − μz⁴)/4.
        let square = upper(z, z); // F30
        let fourth = upper(square, square); // F28
        let miss = (1 << FRACTION) - upper(mu, fourth).cast_signed(); // F28
        // |miss| < 2^-12: shifted by 3 it fits, and the product needs its upper word alone.
        let z = z.wrapping_add_signed(upper_signed((z >> 1).cast_signed(), miss << 3));
        #[expect(clippy::indexing_slicing, reason = "two bits index four octaves")]
        let mantissa = upper(z, TABLES.quarter_octaves[(zeros & 3) as usize]);
        Self { mantissa, quarters: zeros >> 2, up }
    }

    /// The product with a signal, for w of 1 or more.
    #[inline]
    pub(crate) fn of_one_or_more(self, signal: PerUnit) -> PerUnit {
        // At most the signal itself. With 56 fractional bits w has 7 leading zeros at most, so that a quarter of them is 0 or 1.
        let down = 31 - self.quarters;
        let wide = i64::from(signal.to_bits()) * i64::from(self.mantissa.cast_signed()) + (1 << (down - 1));
        #[expect(clippy::cast_possible_truncation, reason = "no larger than the signal")]
        let word = (wide >> down) as i32;
        PerUnit::from_bits(word)
    }

    /// The value.
    #[inline]
    pub(crate) fn value(self) -> U16F16 {
        U16F16::from_bits(self.mantissa >> (15 - self.quarters))
    }
}

/// [`Tables::seeds`], computed by the compiler in integers.
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
    // At least 2⁴⁴, so there are at most 19 zeros, all of them in the upper word.
    inverse::<44>(sum.saturating_add(1 << 44))
}

/// The same from a sum below 2⁶¹ with 56 fractional bits.
#[inline]
pub(crate) fn reciprocal_of_one_plus_fine(sum: u64) -> PerUnit {
    inverse::<56>(sum + (1 << 56))
}

/// The inverse, with 28 fractional bits, of a number of at least 1 with this many fractional bits.
#[inline]
fn inverse<const BITS: u32>(whole: u64) -> PerUnit {
    #[expect(clippy::cast_possible_truncation, reason = "the two words of it")]
    let (upper, lower) = ((whole >> 32) as u32, whole as u32);
    let zeros = upper.leading_zeros();
    // z has 30 fractional bits: 28 wanted. It is below 2 and shifted as a signed number: if the compiler knew that a share is not
    // negative, it would no longer use the single instruction for a product with it.
    let z = reciprocal(upper << zeros | lower >> 1 >> (31 - zeros)).cast_signed();
    PerUnit::from_bits(z >> (66 - BITS - zeros))
}

/// part / (part + sum) with 28 fractional bits, from a part below 2³¹ with 28 and a sum with 44. 0 for a part of 0.
#[inline]
pub(crate) fn share_of(part: u32, sum: u64) -> PerUnit {
    if part == 0 {
        return PerUnit::from_bits(0);
    }
    let whole = sum.saturating_add(u64::from(part) << 16);
    let zeros = whole.leading_zeros();
    let z = reciprocal(((whole << zeros) >> 32) as u32);
    // The product has 58 fractional bits and is below 2⁶³. The whole is at least 2¹⁶, so there are at most 47 zeros.
    let share = (u64::from(part) * u64::from(z)) >> 50_u32.saturating_sub(zeros);
    let word = share.min(1 << FRACTION) as i32;
    PerUnit::from_bits(word)
}

/// 1/μ in [1, 2] with 30 fractional bits, of μ in [½, 1) with 32. A value of 64 bits with 44 fractional ones and its `zeros` before
/// it is μ·2^(20 − zeros).
#[inline]
fn reciprocal(mu: u32) -> u32 {
    let seed = u32::MAX / ((mu >> 16) + 1); // 1/μ, F16, just below
    let seed = seed << 14; // F30, in [1, 2]
    // One Newton step: z + z·(1 − μz).
    #[expect(clippy::cast_possible_wrap, reason = "μz is below 1 with 30 fractional bits")]
    let miss = (1 << 30) - upper(mu, seed) as i32; // F30
    // miss < 2^-14: shifted by 2 it fits, and the product needs its upper word alone.
    seed.wrapping_add_signed(upper_signed(seed.cast_signed(), miss << 2))
}
