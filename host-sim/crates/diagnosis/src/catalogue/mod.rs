//! Effects that a drive may have and the paper's model leaves out: one file for each effect, one line in the [`CATALOGUE`].
//!
//! Every file has the same headings: What it adds · How it shows · What looks alike · Parameters · Source. An effect's equation
//! runs in model-core; the files here contain what the diagnosis needs to try it.

mod cavitation;
mod coulomb_friction;
mod counterbalance;
mod dead_zone_asymmetry;
mod end_stop;
mod entrained_air;
mod external_leakage;
mod flow_force;
mod flow_gain_nonlinearity;
mod friction_asymmetry;
mod hose_compliance;
mod hypothesis;
mod internal_leakage;
mod laminar_transition;
mod linkage_backlash;
mod metering_asymmetry;
mod null_drift;
mod oil_temperature;
mod position_dependent_friction;
mod position_dependent_load;
mod position_dependent_volume;
mod position_sensor_lag;
mod presliding;
mod pressure_dependent_friction;
mod pump_slip;
mod sensor_offset;
mod solenoid_saturation;
mod spool_stiction;
mod stribeck_friction;
mod supply_droop;
mod tank_back_pressure;
mod valve_hysteresis;
mod valve_leakage;

use model_core::machine::Parameter;

pub(crate) use hypothesis::AMOUNT_KNOWN;
use hypothesis::{LUGRE, softest_bristles};

pub use hypothesis::{
    EffectParameter, Extension, Form, Hypothesis, Kind, LookAlike, Scene, Subsystem, covered_by, full_flow_m3_per_s,
    full_force_n, is_elastic, tolerance,
};

/// Every effect that is tried, in the order of the chain.
pub const CATALOGUE: &[&Hypothesis] = &[
    &valve_hysteresis::HYPOTHESIS,
    &spool_stiction::HYPOTHESIS,
    &null_drift::HYPOTHESIS,
    &solenoid_saturation::HYPOTHESIS,
    &flow_force::HYPOTHESIS,
    &dead_zone_asymmetry::HYPOTHESIS,
    &flow_gain_nonlinearity::HYPOTHESIS,
    &metering_asymmetry::HYPOTHESIS,
    &supply_droop::HYPOTHESIS,
    &tank_back_pressure::HYPOTHESIS,
    &valve_leakage::HYPOTHESIS,
    &counterbalance::HYPOTHESIS,
    &laminar_transition::HYPOTHESIS,
    &pump_slip::HYPOTHESIS,
    &internal_leakage::HYPOTHESIS,
    &external_leakage::HYPOTHESIS,
    &entrained_air::HYPOTHESIS,
    &cavitation::HYPOTHESIS,
    &hose_compliance::HYPOTHESIS,
    &position_dependent_volume::HYPOTHESIS,
    &coulomb_friction::HYPOTHESIS,
    &stribeck_friction::HYPOTHESIS,
    &friction_asymmetry::HYPOTHESIS,
    &position_dependent_friction::HYPOTHESIS,
    &pressure_dependent_friction::HYPOTHESIS,
    &position_dependent_load::HYPOTHESIS,
    &end_stop::HYPOTHESIS,
    &presliding::HYPOTHESIS,
    &oil_temperature::HYPOTHESIS,
    &linkage_backlash::HYPOTHESIS,
    &position_sensor_lag::HYPOTHESIS,
    &sensor_offset::HYPOTHESIS,
];

/// A parameter's name in reports, with its unit: the last part of its key.
#[must_use]
pub fn short_name(parameter: Parameter) -> &'static str {
    let key = parameter.description().key;
    key.rsplit_once('.').map_or(key, |(_, name)| name)
}

#[cfg(test)]
mod tests {
    use model_core::machine::Machine;
    use recording::Signal;
    use test_press::press;

    use super::*;
    use crate::test_scene::scene;

    #[test]
    fn every_effect_is_in_the_machine_files_vocabulary_and_has_a_typical_effect_parameter_in_range() {
        let machine = press(&[]);
        let scene = scene(&machine, &[Signal::Spool, Signal::PressureA, Signal::PressureB, Signal::Position]);
        for hypothesis in CATALOGUE {
            for effect_parameter in hypothesis.effect_parameters() {
                let description = effect_parameter.parameter.description();
                let own = hypothesis.parameters().any(|parameter| parameter == effect_parameter.parameter);
                assert!(own || effect_parameter.parameter == LUGRE.parameter, "{}", description.key);
                let (low, high) = effect_parameter.range(&scene);
                assert!(
                    low < high && description.min <= low && high <= description.max,
                    "{}: {low}..{high}",
                    description.key
                );
                let may_be_negative = matches!(
                    effect_parameter.kind,
                    Kind::Signed(_) | Kind::Place(..) | Kind::Floor(..) | Kind::Setting(..)
                );
                assert!(may_be_negative || low > 0.0, "{}: {low}", description.key);
            }
            if let Some(extension) = hypothesis.extends {
                let plain = CATALOGUE.iter().find(|known| known.name == extension.plain).unwrap();
                assert!(plain.parameters().any(|parameter| parameter == extension.given));
                assert!(extension.taken.iter().all(|taken| hypothesis.parameters().any(|own| own == *taken)));
            }
        }
    }

    #[test]
    fn every_refined_form_has_plain_ones_within_it() {
        let mut refined = 0;
        for hypothesis in CATALOGUE {
            for &form in hypothesis.refined {
                assert!(hypothesis.plain_of(form).next().is_some(), "{}", hypothesis.name);
                refined += 1;
            }
            assert!(hypothesis.forms.iter().all(|form| hypothesis.plain_of(form).next().is_none()));
        }
        assert!(refined > 0);
    }

    #[test]
    fn what_drifts_and_what_warms_up_act_slowly() {
        let machine = press(&[]);
        let scene = Scene { duration_s: 3600.0, ..scene(&machine, &[Signal::Position]) };
        let slow: Vec<&str> = CATALOGUE
            .iter()
            .filter(|hypothesis| hypothesis.is_slow(&scene))
            .map(|hypothesis| hypothesis.name)
            .collect();
        assert_eq!(slow, ["null-drift", "oil-temperature"]);
    }

    #[test]
    fn a_floor_of_the_pressures_is_asked_for_only_where_one_falls_below_it_and_is_on_at_zero() {
        let machine = press(&[]);
        let reached = |lowest_pa: f64| {
            let scene = Scene { lowest_pa, ..scene(&machine, &[Signal::Position]) };
            let names = CATALOGUE.iter().filter(|hypothesis| !hypothesis.is_reached(&scene));
            names.map(|hypothesis| hypothesis.name).collect::<Vec<_>>()
        };
        assert_eq!(reached(1e5), ["cavitation"]);
        assert_eq!(reached(f64::INFINITY), ["cavitation"]);
        assert_eq!(reached(-1e5), [""; 0]);
        let on = |machine: &Machine<f64>| cavitation::HYPOTHESIS.is_on(machine, &[]);
        assert!(!on(&machine) && on(&press(&[(Parameter::CavitationFloor, 0.0)])));
    }

    #[test]
    fn every_effect_of_the_machine_files_vocabulary_is_a_hypothesis() {
        for parameter in Parameter::ALL {
            let key = parameter.description().key;
            let Some(name) = key.strip_prefix("effects.").and_then(|rest| rest.split_once('.')).map(|(name, _)| name)
            else {
                continue;
            };
            // The correction table is never a hypothesis.
            if name == "unnamed" {
                continue;
            }
            let hypothesis = CATALOGUE.iter().find(|hypothesis| hypothesis.name == name);
            let tried = hypothesis.is_some_and(|hypothesis| {
                hypothesis.effect_parameters().any(|effect_parameter| effect_parameter.parameter == *parameter)
            });
            assert!(tried, "{key}");
        }
    }
}
