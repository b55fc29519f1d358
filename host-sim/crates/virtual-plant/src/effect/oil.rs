//! Oil that warms up during a recording, and oil with a measured temperature that differs from recording to recording.

use crate::tangent::Real;
use crate::terms::{Conditions, Terms};

/// Temperature rises with time and with the hydraulic power that is dissipated; viscosity falls by Vogel's law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OilTemperature {
    /// Rise at the reference power, K/s.
    pub rise_k_per_s: f64,
    /// Share of the rise that depends on the power; the remaining share depends on time alone.
    pub share_of_power: f64,
    /// Power at which both values apply, W.
    pub reference_power_w: f64,
}

/// Kelvin per unit of the state variable.
const UNIT_K: f64 = 10.0;

impl OilTemperature {
    /// ln(μ/μ0) = B/(T − T0) − B/(T1 − T0), with values of a mineral oil at 40 °C: it halves within about 18 K.
    pub(crate) fn condition<R: Real>(own: &[R], conditions: &mut Conditions<R>) {
        const B_K: f64 = 800.0;
        const ABOVE_T0_K: f64 = 140.0;
        if let [rise] = own {
            let above = (*rise * UNIT_K + ABOVE_T0_K).at_least(1.0);
            conditions.viscosity = conditions.viscosity * (R::from(B_K) / above - B_K / ABOVE_T0_K).exp();
        }
    }

    pub(crate) fn apply<R: Real>(&self, supply_pa: f64, rates: &mut [R], terms: &Terms<R>) {
        if let [rate] = rates {
            let power = terms.delivered.abs() * (supply_pa / self.reference_power_w);
            *rate = (power * self.share_of_power + (1.0 - self.share_of_power)) * (self.rise_k_per_s / UNIT_K);
        }
    }
}

/// Mineral oil at a constant temperature; viscosity over temperature after Walther (ASTM D341).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OilGrade {
    /// Kinematic viscosity at 40 °C, mm²/s: the number of its ISO grade.
    pub at_40_mm2_per_s: f64,
    /// At 100 °C, mm²/s.
    pub at_100_mm2_per_s: f64,
    /// Temperature that the machine's values are for, °C.
    pub reference_c: f64,
    /// Its own temperature, °C.
    pub temperature_c: f64,
}

impl OilGrade {
    /// The same oil at another temperature.
    #[must_use]
    pub const fn at(self, temperature_c: f64) -> Self {
        Self { temperature_c, ..self }
    }

    /// Mean relative loss of viscosity per kelvin between two temperatures, 1/K.
    #[must_use]
    pub fn mean_loss_per_k(&self, from_c: f64, to_c: f64) -> f64 {
        libm::log(self.kinematic_mm2_per_s(from_c) / self.kinematic_mm2_per_s(to_c)) / (to_c - from_c)
    }

    /// lg lg(ν + 0.7) = A − B·lg T, through both given values. The change of density is neglected.
    fn kinematic_mm2_per_s(&self, temperature_c: f64) -> f64 {
        let kelvin = |celsius: f64| libm::log10(celsius + 273.15);
        let ordinate = |viscosity: f64| libm::log10(libm::log10(viscosity + 0.7));
        let (cold, hot) = (ordinate(self.at_40_mm2_per_s), ordinate(self.at_100_mm2_per_s));
        let share = (kelvin(temperature_c) - kelvin(40.0)) / (kelvin(100.0) - kelvin(40.0));
        libm::pow(10.0, libm::pow(10.0, cold + share * (hot - cold))) - 0.7
    }

    pub(crate) fn condition<R: Real>(&self, conditions: &mut Conditions<R>) {
        let thinned = self.kinematic_mm2_per_s(self.temperature_c) / self.kinematic_mm2_per_s(self.reference_c);
        conditions.viscosity = conditions.viscosity * thinned;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grade_goes_through_its_two_values_and_halves_within_15_to_20_k() {
        let oil = OilGrade { at_40_mm2_per_s: 46.0, at_100_mm2_per_s: 6.8, reference_c: 40.0, temperature_c: 40.0 };
        assert!((oil.kinematic_mm2_per_s(40.0) - 46.0).abs() < 1e-9);
        assert!((oil.kinematic_mm2_per_s(100.0) - 6.8).abs() < 1e-9);
        let halved = |from_c: f64| core::f64::consts::LN_2 / oil.mean_loss_per_k(from_c, from_c + 10.0);
        assert!(halved(30.0) < 15.0 && (17.0..20.0).contains(&halved(50.0)), "{} {}", halved(30.0), halved(50.0));
    }
}
