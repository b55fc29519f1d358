//! A straight line in whole numbers: the form of every scale in the control period.
//!
//! word = (count·gain + offset)/2ˢʰⁱᶠᵗ, rounded to nearest, held at the ends of `i32`. Gain and offset have as many digits as 64 bits
//! hold without an overflow check, so the line is within 0.501 words plus (|slope|·2⁻²⁹ + 2⁻³⁰)·|count| of the exact one, for slopes
//! up to 2²⁰ words per count and a word of magnitude up to 3·10⁹ at count 0 (asserted below).

/// Largest shift.
const MOST_SHIFT: u32 = 40;
/// The gain's magnitude stays below 2³⁰, a count's within 2³², the offset's below 2⁶¹: a sum stays below 2⁶³.
const GAIN_LIMIT: f64 = (1_u32 << 30) as f64;
const COUNT_LIMIT: i64 = 1 << 32;
const OFFSET_LIMIT: f64 = (1_u64 << 61) as f64;
/// Below this a gain has too few digits.
const LEAST_GAIN: f64 = (1_u32 << 20) as f64;

/// A straight line from counts to words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StraightLine {
    gain: i32,
    offset: i64,
    shift: u32,
}

impl StraightLine {
    /// The line with this slope (words per count) and the word `at_zero` at count 0. `None` if it has no slope or does not fit.
    pub(crate) fn new(slope: f64, at_zero: f64) -> Option<Self> {
        let mut power = (1_u64 << MOST_SHIFT) as f64;
        for shift in (0..=MOST_SHIFT).rev() {
            let (gain, offset) = (libm::round(slope * power), libm::round(at_zero * power));
            // NaN is below no limit.
            if gain.abs() < GAIN_LIMIT && offset.abs() < OFFSET_LIMIT {
                #[expect(clippy::cast_possible_truncation, reason = "within the limits just above")]
                let line = Self { gain: gain as i32, offset: offset as i64, shift };
                return (gain.abs() >= LEAST_GAIN).then_some(line);
            }
            power *= 0.5;
        }
        None
    }

    /// The word at a count.
    pub(crate) fn at(self, count: i64) -> i32 {
        let count = count.clamp(-COUNT_LIMIT, COUNT_LIMIT);
        let half = (1_i64 << self.shift) >> 1;
        let word = (count * i64::from(self.gain) + self.offset + half) >> self.shift;
        #[expect(clippy::cast_possible_truncation, reason = "held within the type")]
        let word = word.clamp(i32::MIN.into(), i32::MAX.into()) as i32;
        word
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn half_a_word_a_count_from_ten_is_twelve_at_four() {
        assert_eq!(StraightLine::new(0.5, 10.0).unwrap().at(4), 12);
    }

    #[test]
    fn a_line_without_a_slope_or_beyond_all_words_is_refused() {
        for (slope, at_zero) in [(0.0, 0.0), (f64::NAN, 0.0), (1.0, f64::NAN), (1e10, 0.0), (1.0, 1e300), (1e-9, 0.0)] {
            assert_eq!(StraightLine::new(slope, at_zero), None, "{slope} {at_zero}");
        }
    }

    proptest! {
        #[test]
        fn the_line_is_the_real_one_and_held_at_the_ends(
            magnitude in -8.0..20.0, down in any::<bool>(), at_zero in -3e9..3e9, count in any::<i64>(), less in 0_u32..64,
        ) {
            let slope = libm::exp2(magnitude) * if down { -1.0 } else { 1.0 };
            let count = count >> less;
            let line = StraightLine::new(slope, at_zero).unwrap();
            let within = count.clamp(-COUNT_LIMIT, COUNT_LIMIT) as f64;
            let exact = (slope * within + at_zero).clamp(f64::from(i32::MIN), f64::from(i32::MAX));
            let allowed = 0.501 + (slope.abs() * libm::exp2(-29.0) + libm::exp2(-30.0)) * within.abs();
            prop_assert!((f64::from(line.at(count)) - exact).abs() <= allowed, "{} {exact}", line.at(count));
        }
    }
}
