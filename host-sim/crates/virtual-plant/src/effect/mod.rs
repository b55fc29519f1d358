//! The effects the plant can have beyond the paper's model.
//!
//! Each is one variant of [`PlantEffect`] and one function below. Their forms deliberately differ from
//! those of a plain textbook hypothesis, so that a diagnosis is tested on physics that it does not
//! contain itself. To add one: a variant, its name, its function, its line in [`PlantEffect::apply`]; an
//! effect with a memory needs an extra state.

pub(crate) mod cavitation;
pub(crate) mod chambers;
pub(crate) mod flow;
pub(crate) mod friction;
pub(crate) mod load;
pub(crate) mod load_holding;
mod named;
pub(crate) mod oil;
pub(crate) mod sensing;
pub(crate) mod valve;

use crate::flow::edges::Edges;
use crate::flow::orifice::signed_root;
use crate::tangent::Real;
use crate::terms::{Conditions, Inputs, State, Terms};

pub use cavitation::Cavitation;
pub(crate) use flow::FlowEffect;
pub(crate) use friction::{DryFriction, FrictionLevel};
pub(crate) use load::LoadEffect;
pub use load_holding::LoadHolding;
pub(crate) use oil::{OilGrade, OilTemperature};
pub(crate) use sensing::SensingEffect;
pub(crate) use valve::ValveEffect;

/// An effect of the plant, with its parameters in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PlantEffect {
    /// Hoses widen with pressure, at a decreasing rate: each takes up C·p/(1 + p/ps).
    HoseCompliance {
        /// C, volume per pressure at zero pressure, m³/Pa, in each chamber.
        compliance_m3_per_pa: f64,
        /// ps, Pa: at this pressure the volume is half of C·p. Large.
        stiffening_pressure_pa: f64,
    },
    /// The turning pump loses flow: through laminar gaps, and a small share that is proportional to √p.
    PumpSlip {
        /// Flow lost per pressure across the pump at the reference pressure, m³/s/Pa.
        conductance_m3_per_s_pa: f64,
        /// Share of the loss that is turbulent at the reference pressure, 0–1.
        turbulent_share: f64,
        /// Pressure at which both values apply, Pa.
        reference_pressure_pa: f64,
    },
    /// Leakage past the piston, A to B: laminar; a small share becomes turbulent beyond a transition.
    InternalLeakage {
        /// Flow per pressure difference at small differences, m³/s/Pa.
        conductance_m3_per_s_pa: f64,
        /// Share that becomes turbulent, 0–1.
        turbulent_share: f64,
        /// Pressure difference of the transition, Pa.
        transition_pa: f64,
    },
    /// Dry friction by elastic bristles (`LuGre` without the Stribeck dip): below its force it holds the rod
    /// elastically, and at that force the rod slides.
    CoulombFriction {
        /// Force in steady sliding, N.
        force_n: f64,
        /// Bristle stiffness σ0, N/m.
        stiffness_n_per_m: f64,
        /// Bristle damping σ1, N·s/m.
        damping_n_s_per_m: f64,
    },
    /// Leakage out of the chambers, partly turbulent.
    ExternalLeakage {
        /// Flow per pressure, at small pressures, out of A and out of B, m³/s/Pa.
        conductances_m3_per_s_pa: [f64; 2],
        /// Share that becomes turbulent, 0–1.
        turbulent_share: f64,
        /// Pressure of the transition, Pa.
        transition_pa: f64,
    },
    /// Air in the oil, polytropic, which dissolves as the pressure rises.
    EntrainedAir {
        /// Share of the volume at atmospheric pressure.
        share: f64,
        /// Absolute pressure at which half of it is in solution, Pa.
        dissolving_pa: f64,
    },
    /// Oil under suction boils, or releases its air: below a certain pressure the void grows steeply.
    Cavitation(Cavitation),
    /// The chambers' volumes follow the piston.
    PositionDependentVolume,
    /// Between command and spool.
    Valve(ValveEffect),
    /// Between spool and chambers.
    Flow(FlowEffect),
    /// Dry friction.
    Friction(DryFriction),
    /// A force that depends on the position or the motion.
    Load(LoadEffect),
    /// Between the true signals and the sensors.
    Sensing(SensingEffect),
    /// The oil warms up.
    OilTemperature(OilTemperature),
    /// The oil has another temperature than the one that the machine's values are for.
    OilGrade(OilGrade),
}

impl PlantEffect {
    /// Hose compliance that stiffens at 6·10⁷ Pa.
    #[must_use]
    pub const fn hose_compliance(compliance_m3_per_pa: f64) -> Self {
        Self::HoseCompliance { compliance_m3_per_pa, stiffening_pressure_pa: 6.0e7 }
    }

    /// Pump slip, a tenth of it turbulent at 5·10⁶ Pa.
    #[must_use]
    pub const fn pump_slip(conductance_m3_per_s_pa: f64) -> Self {
        Self::PumpSlip { conductance_m3_per_s_pa, turbulent_share: 0.1, reference_pressure_pa: 5.0e6 }
    }

    /// Internal leakage, a tenth of which becomes turbulent beyond 3·10⁶ Pa.
    #[must_use]
    pub const fn internal_leakage(conductance_m3_per_s_pa: f64) -> Self {
        Self::InternalLeakage { conductance_m3_per_s_pa, turbulent_share: 0.1, transition_pa: 3.0e6 }
    }

    /// Dry friction with bristles of 3·10⁷ N/m and 2·10⁴ N·s/m.
    #[must_use]
    pub const fn coulomb_friction(force_n: f64) -> Self {
        Self::CoulombFriction { force_n, stiffness_n_per_m: 3.0e7, damping_n_s_per_m: 2.0e4 }
    }

    /// Another consumer on the same supply, where it is one.
    pub(crate) fn other_consumer(&self) -> Option<&FlowEffect> {
        match self {
            Self::Flow(other @ FlowEffect::OtherConsumer { .. }) => Some(other),
            _ => None,
        }
    }

    /// Its plainer form, with a strength near its own times a factor; none where it has no plainer form.
    #[must_use]
    pub fn plainer(&self, factor: f64) -> Option<Self> {
        match self {
            Self::Friction(friction) => friction.plainer(factor).map(Self::Friction),
            _ => None,
        }
    }

    /// The name in the project's vocabulary; a leading ~ marks an effect outside the vocabulary.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::HoseCompliance { .. } => "hose-compliance",
            Self::PumpSlip { .. } => "pump-slip",
            Self::InternalLeakage { .. } => "internal-leakage",
            Self::CoulombFriction { .. } => "coulomb-friction",
            Self::ExternalLeakage { .. } => "external-leakage",
            Self::EntrainedAir { .. } => "entrained-air",
            Self::Cavitation(_) => "cavitation",
            Self::PositionDependentVolume => "position-dependent-volume",
            Self::Valve(effect) => effect.name(),
            Self::Flow(effect) => effect.name(),
            Self::Friction(friction) => friction.name(),
            Self::Load(effect) => effect.name(),
            Self::Sensing(effect) => effect.name(),
            Self::OilTemperature(_) | Self::OilGrade(_) => "oil-temperature",
        }
    }

    /// The same effect in oil whose measured temperature is this, °C.
    #[must_use]
    pub const fn in_oil_at(self, temperature_c: f64) -> Self {
        match self {
            Self::OilGrade(oil) => Self::OilGrade(oil.at(temperature_c)),
            other => other,
        }
    }

    /// How many states of its own it integrates (all start at zero and are of order one).
    #[must_use]
    pub const fn states(&self) -> usize {
        match self {
            Self::CoulombFriction { .. } | Self::Friction(_) | Self::OilTemperature(_) => 1,
            Self::Flow(effect) => effect.states(),
            Self::Load(effect) => effect.states(),
            _ => 0,
        }
    }

    /// Changes the conditions that every term depends on: supply pressure and viscosity.
    pub(crate) fn condition<R: Real>(&self, inputs: &Inputs, own: &[R], conditions: &mut Conditions<R>) {
        match self {
            Self::Flow(effect) => effect.condition(inputs, own, conditions),
            Self::OilTemperature(_) => OilTemperature::condition(own, conditions),
            Self::OilGrade(oil) => oil.condition(conditions),
            _ => {}
        }
    }

    /// Adds the effect to the plant's terms; `own` are its states and their derivatives.
    pub(crate) fn apply<R: Real>(
        &self,
        plant: &Fixed<'_>,
        inputs: &Inputs,
        state: &State<R>,
        own: (&[R], &mut [R]),
        terms: &mut Terms<R>,
    ) {
        match *self {
            Self::HoseCompliance { compliance_m3_per_pa, stiffening_pressure_pa } => {
                chambers::hose_compliance(compliance_m3_per_pa, stiffening_pressure_pa, state, terms);
            }
            Self::PumpSlip { conductance_m3_per_s_pa, turbulent_share, reference_pressure_pa } => {
                let law = Slip { conductance_m3_per_s_pa, turbulent_share, reference_pressure_pa };
                pump_slip(law, inputs, state, terms);
            }
            Self::InternalLeakage { conductance_m3_per_s_pa, turbulent_share, transition_pa } => {
                chambers::internal_leakage(conductance_m3_per_s_pa, turbulent_share, transition_pa, state, terms);
            }
            Self::ExternalLeakage { conductances_m3_per_s_pa, turbulent_share, transition_pa } => {
                chambers::external_leakage(conductances_m3_per_s_pa, turbulent_share, transition_pa, state, terms);
            }
            Self::EntrainedAir { share, dissolving_pa } => chambers::entrained_air(share, dissolving_pa, state, terms),
            Self::Cavitation(cavitation) => {
                cavitation.apply(plant.areas_m2.map(|area_m2| area_m2 * plant.stroke_m), state, terms);
            }
            Self::PositionDependentVolume => chambers::moving_volumes(plant.areas_m2, plant.stroke_m, state, terms),
            Self::CoulombFriction { force_n, stiffness_n_per_m, damping_n_s_per_m } => {
                let level = FrictionLevel::Constant(force_n);
                dry_friction(&DryFriction { level, stiffness_n_per_m, damping_n_s_per_m }, own, state, terms);
            }
            Self::Friction(friction) => dry_friction(&friction, own, state, terms),
            Self::Flow(effect) => effect.apply(plant.edges, inputs, state, own, terms),
            Self::Load(effect) => effect.apply(state, own, terms),
            Self::OilTemperature(oil) => oil.apply(inputs.supply_pa, own.1, terms),
            Self::Valve(_) | Self::Sensing(_) | Self::OilGrade(_) => {}
        }
    }
}

/// The properties of the plant that do not change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fixed<'a> {
    pub(crate) edges: &'a Edges,
    pub(crate) areas_m2: [f64; 2],
    pub(crate) stroke_m: f64,
}

fn dry_friction<R: Real>(law: &DryFriction, (own, rates): (&[R], &mut [R]), state: &State<R>, terms: &mut Terms<R>) {
    if let ([bristle], [rate]) = (own, rates) {
        *rate = law.apply(*bristle, state, terms);
    }
}

#[derive(Clone, Copy)]
struct Slip {
    conductance_m3_per_s_pa: f64,
    turbulent_share: f64,
    reference_pressure_pa: f64,
}

/// Pump slip: the loss is taken from the port that the pump feeds, while it turns (it fades out below a fifth of a turn per second).
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
