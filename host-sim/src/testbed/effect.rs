//! The effects the plant can have beyond the paper's model.
//!
//! Each is one variant of [`PlantEffect`] and one function below. Their forms are on purpose not
//! those of a plain textbook hypothesis, so that a diagnosis is tried on physics it has not written
//! itself. To add one: a variant, its name, its function, its line in [`PlantEffect::apply`]; what
//! has a memory takes an extra state.

use super::orifice::signed_root;
use super::physics::{Inputs, State, Terms};
use super::tangent::Real;

/// An effect of the plant, with its parameters in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PlantEffect {
    /// Hoses widen with pressure, less and less: each takes up C·p/(1 + p/ps).
    HoseCompliance {
        /// C, volume per pressure at zero pressure, m³/Pa, in each chamber.
        compliance_m3_per_pa: f64,
        /// ps, Pa: at this pressure half of the volume is missing. Large.
        stiffening_pressure_pa: f64,
    },
    /// The turning pump loses flow: laminar gaps, and a small share that goes with the root.
    PumpSlip {
        /// Flow lost per pressure across the pump at the reference pressure, m³/s/Pa.
        conductance_m3_per_s_pa: f64,
        /// Share of the loss that is turbulent at the reference pressure, 0–1.
        turbulent_share: f64,
        /// Pressure at which both shares are meant, Pa.
        reference_pressure_pa: f64,
    },
    /// Leakage past the piston, A to B: laminar, a small share turns turbulent beyond a transition.
    InternalLeakage {
        /// Flow per pressure difference at small differences, m³/s/Pa.
        conductance_m3_per_s_pa: f64,
        /// Share that turns turbulent, 0–1.
        turbulent_share: f64,
        /// Pressure difference of the transition, Pa.
        transition_pa: f64,
    },
    /// Dry friction by elastic bristles (`LuGre` without the Stribeck dip): it holds, elastically, below
    /// its force, and slides at that force.
    CoulombFriction {
        /// Force in steady sliding, N.
        force_n: f64,
        /// Bristle stiffness σ0, N/m.
        stiffness_n_per_m: f64,
        /// Bristle damping σ1, N·s/m.
        damping_n_s_per_m: f64,
    },
}

impl PlantEffect {
    /// Hose compliance that stiffens at 6·10⁷ Pa.
    #[must_use]
    pub const fn hose_compliance(compliance_m3_per_pa: f64) -> Self {
        Self::HoseCompliance { compliance_m3_per_pa, stiffening_pressure_pa: 6.0e7 }
    }

    /// Pump slip with a tenth of it turbulent at 5·10⁶ Pa.
    #[must_use]
    pub const fn pump_slip(conductance_m3_per_s_pa: f64) -> Self {
        Self::PumpSlip { conductance_m3_per_s_pa, turbulent_share: 0.1, reference_pressure_pa: 5.0e6 }
    }

    /// Internal leakage of which a tenth turns turbulent beyond 3·10⁶ Pa.
    #[must_use]
    pub const fn internal_leakage(conductance_m3_per_s_pa: f64) -> Self {
        Self::InternalLeakage { conductance_m3_per_s_pa, turbulent_share: 0.1, transition_pa: 3.0e6 }
    }

    /// Dry friction on bristles of 3·10⁷ N/m with 2·10⁴ N·s/m.
    #[must_use]
    pub const fn coulomb_friction(force_n: f64) -> Self {
        Self::CoulombFriction { force_n, stiffness_n_per_m: 3.0e7, damping_n_s_per_m: 2.0e4 }
    }

    /// The name in the project's vocabulary.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::HoseCompliance { .. } => "hose-compliance",
            Self::PumpSlip { .. } => "pump-slip",
            Self::InternalLeakage { .. } => "internal-leakage",
            Self::CoulombFriction { .. } => "coulomb-friction",
        }
    }

    /// Names and units of the effects that [`Self::named`] makes.
    pub const KNOWN: [(&'static str, &'static str); 4] = [
        ("hose-compliance", "m3/Pa"),
        ("pump-slip", "m3/s/Pa"),
        ("internal-leakage", "m3/s/Pa"),
        ("coulomb-friction", "N"),
    ];

    /// The effect of this name and strength, in the unit that [`Self::KNOWN`] says, with its other parameters as usual.
    #[must_use]
    pub fn named(name: &str, strength: f64) -> Option<Self> {
        match name {
            "hose-compliance" => Some(Self::hose_compliance(strength)),
            "pump-slip" => Some(Self::pump_slip(strength)),
            "internal-leakage" => Some(Self::internal_leakage(strength)),
            "coulomb-friction" => Some(Self::coulomb_friction(strength)),
            _ => None,
        }
    }

    /// How many states of its own it integrates (all start at zero and are of order one).
    #[must_use]
    pub const fn states(&self) -> usize {
        match self {
            Self::CoulombFriction { .. } => 1,
            Self::HoseCompliance { .. } | Self::PumpSlip { .. } | Self::InternalLeakage { .. } => 0,
        }
    }

    /// Adds the effect to the plant's terms; `own` are its states, `rates` their derivatives.
    pub(super) fn apply<R: Real>(
        &self,
        inputs: &Inputs,
        state: &State<R>,
        own: &[R],
        rates: &mut [R],
        terms: &mut Terms<R>,
    ) {
        match *self {
            Self::HoseCompliance { compliance_m3_per_pa, stiffening_pressure_pa } => {
                hose_compliance(compliance_m3_per_pa, stiffening_pressure_pa, state, terms);
            }
            Self::PumpSlip { conductance_m3_per_s_pa, turbulent_share, reference_pressure_pa } => {
                let law = Slip { conductance_m3_per_s_pa, turbulent_share, reference_pressure_pa };
                pump_slip(law, inputs, state, terms);
            }
            Self::InternalLeakage { conductance_m3_per_s_pa, turbulent_share, transition_pa } => {
                internal_leakage(conductance_m3_per_s_pa, turbulent_share, transition_pa, state, terms);
            }
            Self::CoulombFriction { force_n, stiffness_n_per_m, damping_n_s_per_m } => {
                if let ([bristle], [rate]) = (own, rates) {
                    let law = Bristle { force_n, stiffness_n_per_m, damping_n_s_per_m };
                    *rate = coulomb_friction(law, *bristle, state, terms);
                }
            }
        }
    }
}

/// dV/dp of C·p/(1 + p/ps) is C/(1 + p/ps)².
fn hose_compliance<R: Real>(compliance: f64, stiffening_pa: f64, state: &State<R>, terms: &mut Terms<R>) {
    let at = |pressure: R| {
        let stretch = pressure / stiffening_pa + 1.0;
        R::from(compliance) / (stretch * stretch)
    };
    terms.capacity_a = terms.capacity_a + at(state.pressure_a);
    terms.capacity_b = terms.capacity_b + at(state.pressure_b);
}

#[derive(Clone, Copy)]
struct Slip {
    conductance_m3_per_s_pa: f64,
    turbulent_share: f64,
    reference_pressure_pa: f64,
}

/// Taken from the port that the pump feeds, while it turns (fades below a fifth of a turn per second).
fn pump_slip<R: Real>(law: Slip, inputs: &Inputs, state: &State<R>, terms: &mut Terms<R>) {
    const FADE_REV_PER_S: f64 = 0.2;
    let Some(pump) = inputs.pump else { return };
    let speed = pump.speed_rev_per_s.abs();
    let turning = speed / (speed + FADE_REV_PER_S) * law.conductance_m3_per_s_pa;
    let lost = |port: R| {
        let difference = port - inputs.tank_pressure_pa;
        let root = signed_root(difference, inputs.laminar_transition_pa) * law.reference_pressure_pa.sqrt();
        (difference * (1.0 - law.turbulent_share) + root * law.turbulent_share) * turning
    };
    match pump.direction {
        1.. => terms.into_a = terms.into_a - lost(state.pressure_a),
        0 => {}
        ..=-1 => terms.into_b = terms.into_b - lost(state.pressure_b),
    }
}

fn internal_leakage<R: Real>(conductance: f64, share: f64, transition_pa: f64, state: &State<R>, terms: &mut Terms<R>) {
    let difference = state.pressure_a - state.pressure_b;
    let relative = difference / transition_pa;
    let fading = (relative * relative + 1.0).sqrt().sqrt();
    let flow = (difference * (1.0 - share) + difference / fading * share) * conductance;
    terms.into_a = terms.into_a - flow;
    terms.into_b = terms.into_b + flow;
}

#[derive(Clone, Copy)]
struct Bristle {
    force_n: f64,
    stiffness_n_per_m: f64,
    damping_n_s_per_m: f64,
}

/// `bristle` is the deflection in parts of the one at which the bristles slide, Fc/σ0.
fn coulomb_friction<R: Real>(law: Bristle, bristle: R, state: &State<R>, terms: &mut Terms<R>) -> R {
    if law.force_n <= 0.0 {
        return 0.0.into();
    }
    let deflection_speed = state.velocity - state.velocity.abs() * bristle;
    terms.force = terms.force - bristle * law.force_n - deflection_speed * law.damping_n_s_per_m;
    deflection_speed * (law.stiffness_n_per_m / law.force_n)
}
