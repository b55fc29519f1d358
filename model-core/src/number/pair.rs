//! A sum of many small parts in single precision: two words, of which the second holds what the first has rounded away.
//!
//! `high` is the sum rounded to nearest, `low` the rest, about half of a step of `high` at most; together they have 48 digits. A part is added as
//! by Kahan (*Further remarks on reducing truncation errors*, Comm. ACM 8, 1965), in four additions: first to `low`, which is rounded to 2⁻²⁴ of
//! that small sum, then both to `high`. The rest of the latter is exact where the part is not larger than the sum, else to 2⁻²⁴ of the part. A part
//! below 2⁻⁴⁹ of the sum is lost.

#![expect(clippy::float_arithmetic, reason = "this file is part of the arithmetic of `Single`")]

use core::hash::{Hash, Hasher};

/// Largest magnitude, as of the fixed-point position: strokes, or units of a sum of signals.
const LARGEST: f32 = 128.0;

/// A position in strokes, or another sum, of a drive in single precision: `high` + `low`, within ±128 and always finite.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "Unchecked", into = "Unchecked"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SinglePair {
    /// The sum, rounded to nearest. Compared first.
    high: f32,
    /// What is left of it.
    low: f32,
}

/// Both words as they are stored, of any value. They are called as what they become: so a baked drive writes them.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "SinglePair")]
struct Unchecked(f32, f32);

#[cfg(feature = "serde")]
impl From<Unchecked> for SinglePair {
    fn from(Unchecked(high, low): Unchecked) -> Self {
        Self::new(high, low)
    }
}

#[cfg(feature = "serde")]
impl From<SinglePair> for Unchecked {
    fn from(SinglePair { high, low }: SinglePair) -> Self {
        Self(high, low)
    }
}

/// `sum` + `part` rounded, and what the rounding left out: exactly where `part` is not larger than `sum`, else to 2⁻²³ of `part`.
#[inline]
pub(crate) const fn added(sum: f32, part: f32) -> (f32, f32) {
    let next = sum + part;
    (next, part - (next - sum))
}

impl SinglePair {
    /// The pair of both words, held within ±128. NaN becomes 0.
    #[must_use]
    pub const fn new(high: f32, low: f32) -> Self {
        const fn known(word: f32) -> f32 {
            if word.is_nan() { 0.0 } else { word.clamp(-LARGEST, LARGEST) }
        }
        let (high, low) = (known(high), known(low));
        Self::held(if high.abs() < low.abs() { added(low, high) } else { added(high, low) })
    }

    /// The sum rounded to a word, and the rest.
    #[must_use]
    pub const fn words(self) -> [f32; 2] {
        [self.high, self.low]
    }

    /// The pair nearest to a value. NaN becomes 0.
    #[expect(clippy::cast_possible_truncation, reason = "the first word rounds, the second takes what is left")]
    pub(super) fn of(value: f64) -> Self {
        let value = value.clamp(f64::from(-LARGEST), f64::from(LARGEST));
        let high = value as f32;
        Self::new(high, (value - f64::from(high)) as f32)
    }

    /// A word.
    #[inline]
    pub(super) const fn exactly(high: f32) -> Self {
        Self { high, low: 0.0 }
    }

    /// The sum with one more part.
    #[inline]
    pub(super) fn plus(self, part: f32) -> Self {
        Self::held(added(self.high, self.low + part))
    }

    /// The sum rounded to a word.
    #[inline]
    pub(super) const fn rounded(self) -> f32 {
        self.high
    }

    /// The value.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        f64::from(self.high) + f64::from(self.low)
    }

    #[inline]
    const fn held((high, low): (f32, f32)) -> Self {
        if high.abs() <= LARGEST { Self { high, low } } else { Self::at_limit(high) }
    }

    #[cold]
    #[inline(never)]
    const fn at_limit(high: f32) -> Self {
        Self::exactly(if high < 0.0 { -LARGEST } else { LARGEST })
    }
}

impl From<[f32; 2]> for SinglePair {
    fn from([high, low]: [f32; 2]) -> Self {
        Self::new(high, low)
    }
}

impl From<SinglePair> for [f32; 2] {
    fn from(pair: SinglePair) -> Self {
        pair.words()
    }
}

impl Hash for SinglePair {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.words().map(f32::to_bits).hash(state);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_million_parts_that_a_word_would_swallow_add_up() {
        let (mut pair, part) = (SinglePair::of(0.5), 1e-9_f32);
        for _ in 0..1_000_000 {
            pair = pair.plus(part);
        }
        assert!((0.5_f32 + part).to_bits() == 0.5_f32.to_bits(), "a word swallows it");
        assert!((pair.to_f64() - 0.501).abs() < 1e-9, "{pair:?}");
    }

    fn anything() -> impl Strategy<Value = f32> {
        any::<u32>().prop_map(f32::from_bits)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(5000))]

        #[test]
        fn a_sum_and_its_rest_are_exact_as_long_as_the_part_is_no_larger(
            a in -1e6_f32..1e6, b in -1e6_f32..1e6, small in 0_i32..16,
        ) {
            let b = b * 0.5_f32.powi(small);
            for (sum, part) in [(a, b), (b, a)] {
                let (next, rest) = added(sum, part);
                let off = (f64::from(next) + f64::from(rest) - f64::from(a) - f64::from(b)).abs();
                let allowed = if part.abs() <= sum.abs() { 0.0 } else { 0.5_f64.powi(23) * f64::from(part.abs()) };
                prop_assert!(off <= allowed && next.to_bits() == (a + b).to_bits(), "{off}");
            }
        }

        #[test]
        fn pairs_are_ordered_as_their_values(a in -2.0_f64..2.0, by in -1e-6_f64..1e-6) {
            let (one, other) = (SinglePair::of(a), SinglePair::of(a + by));
            prop_assert_eq!(one < other, one.to_f64() < other.to_f64());
            prop_assert!((one.to_f64() - a).abs() <= 2e-15);
            for pair in [one, other] {
                let [high, low] = pair.words();
                prop_assert_eq!(SinglePair::new(high, low).words().map(f32::to_bits), [high, low].map(f32::to_bits));
            }
        }

        #[test]
        fn a_pair_is_finite_and_within_its_range_whatever_it_is_made_of(words in prop::array::uniform3(anything())) {
            let [high, low, part] = words;
            let pair = SinglePair::new(high, low);
            let part = if part.is_finite() { part.clamp(-1e30, 1e30) } else { 1e30 };
            for pair in [pair, pair.plus(part)] {
                let [high, low] = pair.words();
                prop_assert!(high.abs() <= LARGEST && low.is_finite() && low.abs() <= 8e-6, "{pair:?}");
            }
        }

        #[test]
        fn parts_come_back_as_they_went(start in -100.0_f64..100.0, parts in prop::collection::vec((-1.0_f32..1.0, 0_i32..40), 1..200)) {
            let start = SinglePair::of(start);
            let (mut pair, mut size) = (start, 0.0);
            let parts: Vec<f32> = parts.into_iter().map(|(part, small)| part * 0.5_f32.powi(small)).collect();
            for part in parts.iter().copied().chain(parts.iter().map(|part| -part)) {
                pair = pair.plus(part);
                size += f64::from(part.abs());
            }
            // Each addition rounds `low` plus the part, and the rest where the part is larger; `low` is at most half a step of 128.
            let bound = 0.5_f64.powi(22) * (size + 8e-6 * 2.0 * parts.len() as f64);
            prop_assert!((pair.to_f64() - start.to_f64()).abs() <= bound, "{pair:?} from {start:?}");
        }
    }

    extern crate std;
    use std::vec::Vec;
}
