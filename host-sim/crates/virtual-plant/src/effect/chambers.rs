//! What happens to the oil in the chambers: leakage, air, hoses, volumes.

use crate::tangent::Real;
use crate::terms::{State, Terms};

/// dV/dp of C·p/(1 + p/ps) is C/(1 + p/ps)².
pub(crate) fn hose_compliance<R: Real>(compliance: f64, stiffening_pa: f64, state: &State<R>, terms: &mut Terms<R>) {
    let at = |pressure: R| {
        let stretch = pressure / stiffening_pa + 1.0;
        R::from(compliance) / (stretch * stretch)
    };
    terms.capacity_a = terms.capacity_a + at(state.pressure_a);
    terms.capacity_b = terms.capacity_b + at(state.pressure_b);
}

/// Flow through a gap; a share of it becomes turbulent beyond the transition.
fn gap<R: Real>(across: R, conductance: f64, share: f64, transition_pa: f64) -> R {
    let relative = across / transition_pa;
    let fading = (relative * relative + 1.0).sqrt().sqrt();
    (across * (1.0 - share) + across / fading * share) * conductance
}

pub(crate) fn internal_leakage<R: Real>(
    conductance: f64,
    share: f64,
    transition_pa: f64,
    state: &State<R>,
    terms: &mut Terms<R>,
) {
    let flow = gap(state.pressure_a - state.pressure_b, conductance, share, transition_pa) / state.viscosity;
    terms.into_a = terms.into_a - flow;
    terms.into_b = terms.into_b + flow;
}

/// Leakage to the outside, with a conductance for each chamber.
pub(crate) fn external_leakage<R: Real>(
    conductances: [f64; 2],
    share: f64,
    transition_pa: f64,
    state: &State<R>,
    terms: &mut Terms<R>,
) {
    let [a, b] = conductances;
    terms.into_a = terms.into_a - gap(state.pressure_a, a, share, transition_pa) / state.viscosity;
    terms.into_b = terms.into_b - gap(state.pressure_b, b, share, transition_pa) / state.viscosity;
}

/// Bubbles of air, polytropic, which dissolve as the pressure rises: their share of the volume is
/// α·(p0/p)^(1/n)·1/(1 + (p/pd)²), and their compressibility is that share over n·p.
pub(crate) fn entrained_air<R: Real>(share: f64, dissolving_pa: f64, state: &State<R>, terms: &mut Terms<R>) {
    const ATMOSPHERE_PA: f64 = 1.013e5;
    const POLYTROPIC: f64 = 1.3;
    let softness = |pressure: R| {
        let absolute = (pressure + ATMOSPHERE_PA).at_least(0.1 * ATMOSPHERE_PA);
        let relative = absolute / dissolving_pa;
        let free = (absolute / ATMOSPHERE_PA).powf(-1.0 / POLYTROPIC) * share / (relative * relative + 1.0);
        free / (absolute * POLYTROPIC)
    };
    terms.softness_a = terms.softness_a + softness(state.pressure_a);
    terms.softness_b = terms.softness_b + softness(state.pressure_b);
}

/// The chambers' volumes follow the piston, down to a twentieth of their size at mid-stroke.
pub(crate) fn moving_volumes<R: Real>(areas: [f64; 2], stroke_m: f64, state: &State<R>, terms: &mut Terms<R>) {
    let from_middle = state.position - 0.5 * stroke_m;
    let [least_a, least_b] = [0.05 * terms.volume_a.value(), 0.05 * terms.volume_b.value()];
    terms.volume_a = (terms.volume_a + from_middle * areas[0]).at_least(least_a);
    terms.volume_b = (terms.volume_b - from_middle * areas[1]).at_least(least_b);
}
