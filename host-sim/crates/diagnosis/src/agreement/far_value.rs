//! Refitted values far from where the machine file says they are, or where no such drive has them.

use identification::fit::{Estimate, Free};
use model_core::machine::{Machine, Parameter, Source};

/// A value this many of its allowed standard deviations away is told: one in 400 is, where the machine file's doubts are right.
pub(crate) const FAR_FROM: f64 = 3.0;
/// From here on it is no longer chance among the dozen values of a fit.
const VERY_FAR_FROM: f64 = 5.0;
/// It is only told where the recordings determine it: its change exceeds its own standard deviation this many times.
const DETERMINED: f64 = 3.0;
/// A value that was known to this share of itself ...
const KNOWN: f64 = 0.5;
/// ... and has become so many times as large, or as small, is another drive's.
const FOLD: f64 = 3.0;
/// Bulk moduli of hydraulic oil, Pa: the pure oil has 1.4 to 2 GPa, water glycol up to 2.5; with hoses and a few per cent of air a tenth of that.
const BULK_MODULI_PA: std::ops::RangeInclusive<f64> = 1e8..=2.5e9;

/// A refitted value far from its nominal value.
#[derive(Clone, Debug, PartialEq)]
pub struct FarValue {
    /// Which.
    pub parameter: Parameter,
    /// The machine file's value, SI.
    pub nominal: f64,
    /// The refitted one, SI.
    pub value: f64,
    /// How many of the allowed standard deviations lie between.
    pub sigmas: f64,
    /// Whether no such drive has this value.
    pub is_impossible: bool,
    /// What else would explain it, the likelier first.
    pub suggests: &'static [Cause],
}

/// Something in the machine file or the recordings that pulls a value away if it is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Bore and rod, so the areas.
    Bore,
    /// Load or moving mass.
    Load,
    /// Rated flow of the valve or displacement of the pump.
    Flow,
    /// Supply pressure.
    Supply,
    /// Volumes of chambers and hoses.
    Volume,
    /// The unit or scale of the position.
    PositionUnit,
    /// The unit or scale of the command, or of the pump's speed.
    CommandUnit,
    /// The unit or scale of the pressures.
    PressureUnit,
    /// The unit or scale of the force.
    ForceUnit,
    /// Time stamps, or a filter behind a sensor.
    Times,
}

/// The far ones of fitted values. A tolerance is not among them: it cannot be left ([`Tolerated`](super::Tolerated)). Nor is an amount that has changed:
/// it is a finding. Nor is how a spool is limited, by its speed or by what pulls it: that is a structure, from none of which a value is far.
#[must_use]
pub fn far_values(machine: &Machine<f64>, free: &[Free], estimates: &[Estimate]) -> Vec<FarValue> {
    let far = |estimate: &Estimate| {
        let free = free.iter().find(|free| free.parameter == estimate.parameter && free.tolerance().is_none())?;
        let value = estimate.value;
        let has_changed = free.near().is_some_and(|most| (value - free.nominal()).abs() > most);
        if has_changed || free.parameter == Parameter::SpeedOverdrive {
            return None;
        }
        let sigmas = free.deviations(value).abs();
        let is_determined = estimate.at_bound || sigmas * free.width(value) > DETERMINED * estimate.std;
        let is_impossible = is_impossible(free, value);
        let is_far = sigmas > FAR_FROM || (is_impossible && sigmas > 1.0);
        let suggests = causes(machine, estimate.parameter);
        (is_determined && is_far).then_some(FarValue {
            parameter: estimate.parameter,
            nominal: free.nominal(),
            value,
            sigmas,
            is_impossible,
            suggests,
        })
    };
    let mut found: Vec<FarValue> = estimates.iter().filter_map(far).collect();
    found.sort_by(|a, b| b.is_impossible.cmp(&a.is_impossible).then(b.sigmas.total_cmp(&a.sigmas)));
    found
}

/// Whether no drive that the machine file may mean has this value.
fn is_impossible(free: &Free, value: f64) -> bool {
    use Parameter as P;
    let nominal = free.nominal();
    let folded = || {
        let known = nominal != 0.0 && free.width(nominal) < KNOWN * nominal.abs();
        known && free.deviations(value).abs() > VERY_FAR_FROM && !(1.0 / FOLD..=FOLD).contains(&(value / nominal))
    };
    match free.parameter {
        P::BulkModulus => BULK_MODULI_PA.contains(&nominal) && !BULK_MODULI_PA.contains(&value) || folded(),
        // Small times, overlaps and offsets may well be several times as large as was thought.
        P::ValveOffset | P::DeadZone | P::TimeConstant1 | P::TimeConstant2 | P::TransportDelay | P::RateLimit => false,
        _ => folded(),
    }
}

/// What pulls a value away if it is wrong.
fn causes(machine: &Machine<f64>, parameter: Parameter) -> &'static [Cause] {
    use Cause as C;
    use Parameter as P;
    let is_without_oil = machine.source == Source::Force && machine.get(P::AreaA) <= 0.0;
    match parameter {
        P::ViscousFriction | P::MovingMass | P::LoadForce if is_without_oil => {
            &[C::ForceUnit, C::Load, C::PositionUnit]
        }
        P::BulkModulus => &[C::PositionUnit, C::Bore, C::Volume],
        P::ViscousFriction => &[C::Load, C::Bore, C::PositionUnit],
        P::MovingMass | P::LoadForce => &[C::Load, C::Bore, C::PressureUnit],
        P::FlowCoefficient | P::ReturnCoefficient => &[C::Flow, C::Bore, C::Supply, C::PositionUnit],
        P::PumpDisplacement => &[C::Flow, C::Bore, C::CommandUnit, C::PositionUnit],
        P::ValveGain | P::ValveOffset | P::DeadZone => &[C::CommandUnit, C::Flow],
        P::RateLimit | P::TimeConstant1 | P::TimeConstant2 | P::TransportDelay => &[C::Times, C::CommandUnit],
        P::AreaA | P::AreaB | P::Stroke => &[C::Bore, C::PositionUnit],
        P::VolumeA | P::VolumeB => &[C::Volume, C::Bore],
        P::SupplyPressure | P::FlowLimit => &[C::Supply, C::PressureUnit, C::Flow],
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use identification::fit::Freedom;

    use super::*;

    fn far(parameter: Parameter, (nominal, sigma): (f64, f64), value: f64, std: f64) -> Option<FarValue> {
        let free = [Free { parameter, freedom: Freedom::Around { nominal, sigma } }];
        let estimate = Estimate { parameter, before: nominal, value, std, at_bound: false };
        far_values(&Machine::with_defaults(Source::Valve), &free, &[estimate]).pop()
    }

    #[test]
    fn a_value_beyond_its_doubt_is_told_where_the_recordings_determine_it() {
        let bulk = |value, std| far(Parameter::BulkModulus, (1.2e9, 1.2e8), value, std);
        assert_eq!(bulk(1.5e9, 1e7), None);
        let moved = bulk(1.6e9, 1e7).unwrap();
        assert!((moved.sigmas - 3.33).abs() < 0.01 && !moved.is_impossible);
        assert_eq!(bulk(1.6e9, 2e8), None);
    }

    #[test]
    fn what_no_such_drive_has_is_told_apart_from_what_is_only_unlikely() {
        assert!(far(Parameter::BulkModulus, (1.2e9, 1.2e8), 1.17e10, 1e7).unwrap().is_impossible);
        assert!(far(Parameter::BulkModulus, (1.2e9, 6e8), 9e7, 1e6).unwrap().is_impossible);
        assert!(far(Parameter::ValveGain, (0.1, 0.01), -0.1, 1e-3).unwrap().is_impossible);
        assert!(far(Parameter::FlowCoefficient, (2e-7, 2e-8), 2e-8, 1e-10).unwrap().is_impossible);
        // Known by its order of size only, or small anyway.
        assert_eq!(far(Parameter::ViscousFriction, (4e3, 8e3), 2e4, 1e2), None);
        assert!(!far(Parameter::DeadZone, (0.01, 0.002), 0.04, 1e-3).unwrap().is_impossible);
    }

    #[test]
    fn a_value_that_was_known_only_roughly_is_far_in_its_logarithm() {
        let roughly = |parameter, (nominal, sigma), value, std| {
            let free = Free::around(parameter, nominal, sigma);
            let estimate = Estimate { parameter, before: nominal, value, std, at_bound: false };
            far_values(&Machine::with_defaults(Source::Valve), &[free], &[estimate]).pop()
        };
        let bulk = |value, std| roughly(Parameter::BulkModulus, (1.2e9, 3.6e8), value, std);
        assert_eq!((bulk(1.8e9, 1e7), bulk(2.4e9, 1e9)), (None, None));
        // Half of it is as far as twice of it.
        let half = bulk(5e8, 1e7).unwrap();
        assert!((half.sigmas - 2.4_f64.ln() / 1.3_f64.ln()).abs() < 1e-9 && !half.is_impossible, "{half:?}");
        assert!(bulk(4e9, 1e7).unwrap().is_impossible);
        // A valve of zero lap by the file that has a twelfth of overlap.
        let lap = roughly(Parameter::DeadZone, (0.0, 0.03), 0.06, 1e-3).unwrap();
        assert!(lap.nominal == 0.0 && lap.sigmas > 3.0 && !lap.is_impossible, "{lap:?}");
        assert_eq!(roughly(Parameter::DeadZone, (0.0, 0.03), 1e-6, 1e-7), None);
        // A pilot stage that opens no further.
        assert_eq!(roughly(Parameter::SpeedOverdrive, (0.5, 2.0), 1e-6, 1e-7), None);
    }
}
