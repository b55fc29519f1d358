//! A first-order approach to a level, as slow as 10⁵ s at ticks of half a millisecond.
//!
//! In a tick the distance shrinks by 1 − e^(−h/τ), at the slowest 5e-9, little more than one step of a gain. So the share is
//! stored times a power of two that makes it about 1, and the change is added at a scale finer by that power, with the
//! rounding remainder carried ([`Number::accumulated`]): rate and end have a relative error of 4e-7, whatever the time constant.

use crate::number::Number;

/// Exponent, to base 2, of the largest power of two by which a share is multiplied.
const FINEST: u32 = 20;

/// The largest power of two up to 2²⁰ with which `share` stays at 1 at most.
#[expect(clippy::float_arithmetic, reason = "chosen once, before a run")]
pub(crate) fn fineness(share: f64) -> f64 {
    (1..=FINEST).rev().map(|power| f64::from(1_u32 << power)).find(|fine| share * fine <= 1.0).unwrap_or(1.0)
}

/// Coefficients of the approach at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Relaxation<N: Number> {
    /// (1 − e^(−h/τ)) times the fineness.
    pub share: N::Gain,
    /// 1 / fineness.
    pub fine: N::Gain,
}

impl<N: Number> Relaxation<N> {
    /// The value and its rounding remainder a tick later, on the way to `level`.
    #[inline]
    pub(crate) fn towards(&self, level: N, value: N, rest: N) -> (N, N) {
        value.accumulated(rest, [self.fine], [N::dot([self.share], [level - value])])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::PerUnit;

    #[test]
    fn after_a_hundred_seconds_a_thousandth_of_the_slowest_way_is_gone() {
        let turn = 5e-4 / 1e5;
        let share = 1.0 - libm::exp(-turn);
        let fine = fineness(share);
        let relaxation = Relaxation::<PerUnit> {
            share: PerUnit::gain(share * fine).unwrap(),
            fine: PerUnit::gain(1.0 / fine).unwrap(),
        };
        let (mut value, mut rest) = (PerUnit::ZERO, PerUnit::ZERO);
        for _ in 0..200_000 {
            (value, rest) = relaxation.towards(PerUnit::ONE, value, rest);
        }
        let exact = 1.0 - libm::exp(-200_000.0 * turn);
        assert!((exact - 1e-3).abs() < 1e-6 && (value.to_f64() - exact).abs() < 4e-7 * exact + 4e-9, "{value:?}");
    }

    #[test]
    fn shares_are_made_fine_but_never_beyond_one() {
        for share in [5e-9, 1e-6, 3e-5, 0.01, 0.2, 0.4, 0.7, 1.0] {
            let fine = fineness(share);
            assert!(share * fine <= 1.0 && (share * fine > 0.5 || fine >= 1_048_576.0), "{share}: {fine}");
        }
    }
}
