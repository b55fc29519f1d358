//! Oil that warms up over a recording.

use super::super::physics::{Conditions, Terms};
use super::super::tangent::Real;

/// Temperature rises with time and with the hydraulic power that is dissipated; viscosity falls by Vogel's law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OilTemperature {
    /// Rise at the reference power, K/s.
    pub rise_k_per_s: f64,
    /// Share of the rise that goes by the power; the rest goes by time alone.
    pub share_of_power: f64,
    /// Power at which both are meant, W.
    pub reference_power_w: f64,
}

/// Kelvin per unit of the state.
const UNIT_K: f64 = 10.0;

impl OilTemperature {
    /// ln(μ/μ0) = B/(T − T0) − B/(T1 − T0), with values of a mineral oil at 40 °C: it halves within about 18 K.
    pub(super) fn condition<R: Real>(own: &[R], conditions: &mut Conditions<R>) {
        const B_K: f64 = 800.0;
        const ABOVE_T0_K: f64 = 140.0;
        if let [rise] = own {
            let above = (*rise * UNIT_K + ABOVE_T0_K).at_least(1.0);
            conditions.viscosity = conditions.viscosity * (R::from(B_K) / above - B_K / ABOVE_T0_K).exp();
        }
    }

    pub(super) fn apply<R: Real>(&self, supply_pa: f64, rates: &mut [R], terms: &Terms<R>) {
        if let [rate] = rates {
            let power = terms.delivered.abs() * (supply_pa / self.reference_power_w);
            *rate = (power * self.share_of_power + (1.0 - self.share_of_power)) * (self.rise_k_per_s / UNIT_K);
        }
    }
}
