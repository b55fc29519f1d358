//! Oil temperature: as the oil warms, its viscosity and the viscous friction fall, and leakage rises.
//!
//! u = w(t)·e^(−κ·(T − T0)) multiplies D and divides the leakage conductances. T is measured, κ the viscosity's relative loss per
//! kelvin, and T0 the temperature that the machine's values are for. w(t) = 1 − loss·(1 − e^(−t/τ)), t since the state's start, is a warming
//! that is not measured.
//!
//! The exponential is held within 1/8..8 in every number type: from three halvings above T0 to three doublings below it. All of u is below 8 in
//! fixed point. Its error is 1e-6 of its value, for temperatures from −50 to 150 °C.
//! The progress of the warming is kept with 56 fractional bits, so that it does not stall at time constants of a day; its rate is
//! exact to 2e-4 at 1e5 s. The coefficients of the links are those of the thinnest oil that there can be.

use crate::number::Number;

/// Least of the exponential, and the inverse of its largest.
pub(crate) const THINNEST: f64 = 0.125;
/// How often the root of the exponential is squared.
pub(crate) const SQUARINGS: i32 = 5;

/// What the oil's viscosity depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Viscosity<N: Number> {
    pub warming: Option<Warming<N>>,
    pub thinning: Option<Thinning<N>>,
    /// Viscosity of the thinnest oil, as a share of the viscosity that the machine's values are for.
    pub thinnest: N,
    /// 1 over it.
    pub per_thinnest: N::Steep,
}

/// Coefficients of the warming at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Warming<N: Number> {
    /// (1 − e^(−h/τ))/`share`
    pub rate: N::Gain,
    /// A small power of two.
    pub share: N,
    /// Magnitude of the loss.
    pub change: N,
    /// Whether the oil becomes thinner: it is then thinnest at the end, else at the start.
    pub thins: bool,
}

/// Coefficients of the viscosity over a measured temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Thinning<N: Number> {
    /// T0, per unit of temperature.
    pub reference: N,
    /// κ per unit of temperature, over 2^[`SQUARINGS`].
    pub rate: N::Gain,
    /// Largest magnitude of the exponent, over the same power.
    pub most: N,
    /// 1/3
    pub third: N::Gain,
}

/// The oil in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Oil<N> {
    /// Viscosity above that of the thinnest, as a share of the viscosity that the machine's values are for.
    pub(crate) excess: N,
    /// Viscosity of the thinnest over this one's, 0..1.
    pub(crate) thinness: N,
}

impl<N: Number> Viscosity<N> {
    /// The oil when the share `done` of the warming has happened, at this measured temperature (per unit).
    #[inline]
    pub(crate) fn oil(&self, done: N::Travel, temperature: N) -> Oil<N> {
        let excess = match (&self.warming, &self.thinning) {
            (Some(warming), None) => warming.excess(done),
            (None, Some(thinning)) => thinning.viscosity(temperature) - self.thinnest,
            (Some(warming), Some(thinning)) => {
                warming.viscosity(done).times(thinning.viscosity(temperature)) - self.thinnest
            }
            (None, None) => N::ZERO,
        };
        Oil { excess, thinness: N::inverse_one_plus([excess], [self.per_thinnest]) }
    }

    /// Advances the warming by one tick.
    #[inline]
    pub(crate) fn step(&self, done: &mut N::Travel) {
        if let Some(warming) = &self.warming {
            warming.step(done);
        }
    }
}

impl<N: Number> Warming<N> {
    #[inline]
    fn done(done: N::Travel) -> N {
        N::of_travel(done).max(N::ZERO).min(N::ONE)
    }

    /// Viscosity above the least viscosity of this warming.
    #[inline]
    fn excess(&self, done: N::Travel) -> N {
        let done = Self::done(done);
        self.change.times(if self.thins { N::ONE - done } else { done })
    }

    /// w
    #[inline]
    fn viscosity(&self, done: N::Travel) -> N {
        let changed = self.change.times(Self::done(done));
        if self.thins { N::ONE - changed } else { N::ONE + changed }
    }

    #[inline]
    fn step(&self, done: &mut N::Travel) {
        let left = N::ONE - N::of_travel(*done);
        *done = N::travelled(*done, [self.rate], [left.times(self.share)]);
    }
}

impl<N: Number> Thinning<N> {
    /// e^(−κ·(T − T0)), 1/8..8: its 32nd root by the series to the fourth order, squared five times. The series leaves 3e-7 of the value,
    /// rounding in fixed point less than 7e-7.
    #[inline]
    pub(crate) fn viscosity(&self, temperature: N) -> N {
        let root = N::dot([self.rate], [self.reference - temperature]).limited(self.most);
        // 1 + y·(1 + y/2·(1 + y/3·(1 + y/4)))
        let fourth = N::ONE + root.halved().halved();
        let third = N::ONE + N::dot([self.third], [root]).times(fourth);
        let second = N::ONE + root.halved().times(third);
        let series = N::ONE + root.times(second);
        (0..SQUARINGS).fold(series, |power, _| power.times(power))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::number::PerUnit;

    fn thinning<N: Number<Real = f64>>(loss_per_unit: f64, reference: f64) -> Thinning<N> {
        let roots = f64::from(1 << SQUARINGS);
        Thinning {
            reference: N::saturated(reference),
            rate: N::gain(loss_per_unit / roots).unwrap(),
            most: N::saturated(-THINNEST.ln() / roots),
            third: N::gain(1.0 / 3.0).unwrap(),
        }
    }

    #[test]
    fn a_unit_of_temperature_at_a_loss_of_ln_2_halves_the_viscosity() {
        let halved = thinning::<PerUnit>(core::f64::consts::LN_2, 1.5).viscosity(PerUnit::saturated(2.5)).to_f64();
        assert!((halved - 0.5).abs() < 5e-7, "{halved}");
        assert_eq!(thinning::<PerUnit>(1.0, 1.5).viscosity(PerUnit::saturated(1.5)), PerUnit::ONE);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn viscosity_is_the_exponential_within_its_range(loss in 1e-4..2.5_f64, reference in -0.8..4.8_f64, temperature in -2.0..6.0_f64) {
            let temperature = PerUnit::saturated(temperature);
            let exact = (-loss * (temperature.to_f64() - reference)).exp().clamp(THINNEST, 1.0 / THINNEST);
            let fixed = thinning::<PerUnit>(loss, reference).viscosity(temperature).to_f64();
            let real = thinning::<f64>(loss, reference).viscosity(temperature.to_f64());
            prop_assert!((real / exact - 1.0).abs() < 4e-7, "{real} {exact}");
            prop_assert!((fixed / exact - 1.0).abs() < 1e-6, "{fixed} {exact}");
        }
    }
}
