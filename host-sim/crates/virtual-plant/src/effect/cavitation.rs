//! Oil under suction: it boils, and releases the air that is dissolved in it.

use crate::tangent::Real;
use crate::terms::{State, Terms};

/// Bubbles as a function of the pressure, without any switch. Relative to the volume of a chamber that the piston sweeps, they take up
///
/// ```text
/// e^((pv − p)/δ)  +  β·pv'/p'·1/(1 + e^((p − pv)/δ))
/// ```
///
/// with p' and pv' absolute. The first term is vapour, which doubles for each 0.7 δ that the pressure falls. The second is air, a share β of the
/// oil's volume, which comes out of solution at the same pressure and then expands at constant temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cavitation {
    /// pv, Pa, from the same zero as the tank's pressure.
    pub floor_pa: f64,
    /// δ, Pa.
    pub steepness_pa: f64,
    /// β: dissolved air, as a share of the volume at pv.
    pub released: f64,
}

impl Cavitation {
    /// Oil that boils, δ 1.5 kPa, without air.
    #[must_use]
    pub const fn of_vapour(floor_pa: f64) -> Self {
        Self { floor_pa, steepness_pa: 1.5e3, released: 0.0 }
    }

    /// Adds −d/dp of the bubbles in both chambers; `swept_m3` are the volumes that the piston sweeps.
    pub(super) fn apply<R: Real>(&self, swept_m3: [f64; 2], state: &State<R>, terms: &mut Terms<R>) {
        let [a, b] = swept_m3;
        terms.capacity_a = terms.capacity_a + self.compressibility(state.pressure_a) * a;
        terms.capacity_b = terms.capacity_b + self.compressibility(state.pressure_b) * b;
    }

    /// Derivative of the bubbles' share, 1/Pa.
    fn compressibility<R: Real>(&self, pressure: R) -> R {
        const ATMOSPHERE_PA: f64 = 1.013e5;
        /// Largest exponent (pv − p)/δ: even the trial steps of the integrator do not reach a pressure as low as this.
        const LOWEST: f64 = 60.0;
        let below = (-(pressure - self.floor_pa) / self.steepness_pa).at_most(LOWEST);
        let vapour = below.exp();
        let free = vapour / (vapour + 1.0);
        let absolute = (pressure + ATMOSPHERE_PA).at_least(100.0);
        let air = R::from(self.released * (self.floor_pa + ATMOSPHERE_PA)) / absolute;
        (vapour + air * free * (R::from(1.0) - free)) / self.steepness_pa + air * free / absolute
    }
}
