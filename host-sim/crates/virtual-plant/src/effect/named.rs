//! Effects by name and a number, for the command line.

use super::flow::FlowEffect;
use super::friction::{DryFriction, FrictionLevel};
use super::load::LoadEffect;
use super::load_holding::LoadHolding;
use super::oil::OilTemperature;
use super::sensing::{MeasuredSignal, SensingEffect};
use super::valve::ValveEffect;
use super::{Cavitation, PlantEffect};
use crate::flow::edges::GainCurve;

type Make = fn(f64) -> PlantEffect;

/// Name, unit of the number, and the effect, with usual values of its other parameters.
#[rustfmt::skip]
const EFFECTS: [(&str, &str, Make); 35] = [
    ("hose-compliance", "m3/Pa", PlantEffect::hose_compliance),
    ("pump-slip", "m3/s/Pa", PlantEffect::pump_slip),
    ("internal-leakage", "m3/s/Pa", PlantEffect::internal_leakage),
    ("external-leakage", "m3/s/Pa", |conductance| PlantEffect::external_leakage([conductance, 0.0])),
    ("entrained-air", "1", PlantEffect::entrained_air),
    ("cavitation", "Pa", |floor_pa| PlantEffect::Cavitation(Cavitation::of_vapour(floor_pa))),
    ("position-dependent-volume", "1", |_| PlantEffect::PositionDependentVolume),
    ("coulomb-friction", "N", PlantEffect::coulomb_friction),
    ("stribeck-friction", "N", |sliding_n| friction(FrictionLevel::Stribeck { sliding_n, break_away_n: 1.8 * sliding_n, velocity_m_per_s: 0.012 })),
    ("friction-asymmetry", "N", |mean_n| friction(FrictionLevel::Asymmetric { extending_n: 1.35 * mean_n, retracting_n: 0.65 * mean_n })),
    ("position-dependent-friction", "N", |force_n| friction(FrictionLevel::Bump { force_n, rise_n: 2.0 * force_n, at_m: 0.16, width_m: 0.03 })),
    ("pressure-dependent-friction", "m2", |area_m2| friction(FrictionLevel::Pressure { area_m2, share_of_higher: 0.75, least_n: 30.0 })),
    ("presliding", "N", |sliding_n| PlantEffect::Friction(DryFriction::giving(FrictionLevel::Presliding { sliding_n, break_away_n: 1.15 * sliding_n }, 4e-4, 8e3))),
    ("position-dependent-load", "N", |force_n| PlantEffect::Load(LoadEffect::Linkage { force_n, neutral_m: 0.1, reach_m: 0.12 })),
    ("end-stop", "m", |at_m| PlantEffect::Load(LoadEffect::EndStop { at_m, extending: true, stiffness: 2e9, damping_s_per_m: 3.0 })),
    ("valve-hysteresis", "1", |width| PlantEffect::Valve(ValveEffect::WeightedPlays { width })),
    ("spool-stiction", "1", |break_away| PlantEffect::Valve(ValveEffect::Stiction { break_away, kinetic_share: 0.15, jump_s: 1.5e-3 })),
    ("null-drift", "1", |travel| PlantEffect::Valve(ValveEffect::NullDrift { travel, period_s: 5.0 })),
    ("solenoid-saturation", "1", |ceiling| PlantEffect::Valve(ValveEffect::Saturation { ceiling })),
    ("flow-force", "1/Pa", |closing_per_pa| PlantEffect::Valve(ValveEffect::FlowForce { closing_per_pa, braking_s_per_root_pa: 5e-7 })),
    ("dead-zone-asymmetry", "1", |extending| PlantEffect::Flow(FlowEffect::DeadZone { extending, retracting: 0.0 })),
    ("flow-gain-nonlinearity", "1", |slope| PlantEffect::Flow(FlowEffect::Gain(GainCurve::Notch { knee: 0.15, slope, rounding: 0.03 }))),
    ("metering-asymmetry", "1", |size| PlantEffect::Flow(FlowEffect::Metering { sizes: [1.0, size, 1.0, 0.9 * size] })),
    ("supply-droop", "Pa s/m3", |resistance| PlantEffect::Flow(FlowEffect::SupplyDroop { resistance_pa_s_per_m3: resistance, gas_volume_m3: 5e-5, line_pa_s2_per_m6: 0.2 * resistance / 3e-4 })),
    ("tank-back-pressure", "Pa s2/m6", |quadratic| PlantEffect::Flow(FlowEffect::BackPressure { linear_pa_s_per_m3: 5e-5 * quadratic, quadratic_pa_s2_per_m6: quadratic })),
    ("counterbalance", "Pa", |setting_pa| PlantEffect::Flow(FlowEffect::Counterbalance(LoadHolding { settings_pa: [setting_pa, f64::INFINITY], pilot_ratio: 3.0, span_pa: 3e6, time_constant_s: 0.015 }))),
    ("valve-leakage", "1", |opening| PlantEffect::Flow(FlowEffect::Leakage { opening, reach: 0.06, laminar_pa: 3e5 })),
    ("laminar-transition", "Pa", |pressure_pa| PlantEffect::Flow(FlowEffect::LaminarTransition { pressure_pa })),
    ("linkage-backlash", "m", |play_m| PlantEffect::Sensing(SensingEffect::Backlash { play_m })),
    ("position-sensor-lag", "s", |delay_s| PlantEffect::Sensing(SensingEffect::PositionDelay { delay_s })),
    ("sensor-offset", "Pa", |offset| PlantEffect::Sensing(SensingEffect::Offset { channel: MeasuredSignal::PressureA, offset })),
    ("oil-temperature", "K/s", |rise_k_per_s| PlantEffect::OilTemperature(OilTemperature { rise_k_per_s, share_of_power: 0.5, reference_power_w: 800.0 })),
    ("~pump-ripple", "1", |share| PlantEffect::Flow(FlowEffect::PumpRipple { share, frequency_hz: 40.0 })),
    ("~structural-flexibility", "Hz", |frequency_hz| PlantEffect::Sensing(SensingEffect::Flexibility { frequency_hz, damping: 0.03, share: 1.0 })),
    ("~hung-mass", "kg", |mass_kg| PlantEffect::Load(LoadEffect::HungMass { mass_kg, frequency_hz: 15.0, damping: 0.03 })),
];

fn friction(level: FrictionLevel) -> PlantEffect {
    PlantEffect::Friction(DryFriction::giving(level, 1e-5, 2e4))
}

impl PlantEffect {
    /// Leakage out of A and of B, a third of which becomes turbulent beyond 2·10⁶ Pa.
    #[must_use]
    pub const fn external_leakage(conductances_m3_per_s_pa: [f64; 2]) -> Self {
        Self::ExternalLeakage { conductances_m3_per_s_pa, turbulent_share: 0.35, transition_pa: 2.0e6 }
    }

    /// Air, half of which is in solution at 6·10⁶ Pa.
    #[must_use]
    pub const fn entrained_air(share: f64) -> Self {
        Self::EntrainedAir { share, dissolving_pa: 6.0e6 }
    }

    /// Names and units of the effects that [`Self::named`] makes.
    pub fn known() -> impl Iterator<Item = (&'static str, &'static str)> {
        EFFECTS.iter().map(|&(name, unit, _)| (name, unit))
    }

    /// The effect with this name and strength, in the unit that [`Self::known`] gives, with usual values of its other parameters.
    #[must_use]
    pub fn named(name: &str, strength: f64) -> Option<Self> {
        EFFECTS.iter().find(|effect| effect.0 == name).map(|effect| effect.2(strength))
    }
}
