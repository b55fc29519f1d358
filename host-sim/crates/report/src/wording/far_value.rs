//! Values that a refit has moved far.

use diagnosis::agreement::{Cause, FarValue};
use model_core::machine::Parameter;
use recording::display_unit::{in_si, significant};

/// The values that a refit has moved farthest; of more than a few only how many, for where so many are far no single one is to blame.
#[must_use]
pub fn far_values(far: &[FarValue]) -> Vec<String> {
    const TOLD: usize = 4;
    let more = far.len().saturating_sub(TOLD);
    let more = (more > 0).then(|| format!("{more} more, in the table of refitted parameters"));
    far.iter().take(TOLD).map(far_value).chain(more).collect()
}

/// A value that a refit has moved far, and what else would explain it.
#[must_use]
pub fn far_value(far: &FarValue) -> String {
    let causes: Vec<&str> = far.suggests.iter().map(|cause| cause_of(*cause)).collect();
    let check = if causes.is_empty() { String::new() } else { format!("; check {}", causes.join(", ")) };
    let sigmas = significant(far.sigmas, 2);
    format!("{}, {sigmas} of its standard deviations away{check}", moved(far))
}

/// A value, with the machine file's.
pub(crate) fn moved(far: &FarValue) -> String {
    let description = far.parameter.description();
    let unit = if description.unit == "1" { String::new() } else { format!(" {}", description.unit) };
    let verdict = match far.parameter {
        _ if !far.is_impossible => "",
        Parameter::BulkModulus => ", which no oil has",
        _ => ", far from any drive that the machine file can mean",
    };
    let (value, nominal) = (in_si(far.value, 4), in_si(far.nominal, 4));
    format!("{} at {value}{unit} instead of {nominal}{verdict}", description.key)
}

fn cause_of(cause: Cause) -> &'static str {
    match cause {
        Cause::Bore => "bore and rod",
        Cause::Load => "load and moving mass",
        Cause::Flow => "the rated flow",
        Cause::Supply => "the supply pressure",
        Cause::Volume => "the volumes of chambers and hoses",
        Cause::PositionUnit => "the unit of position",
        Cause::CommandUnit => "the unit of the command",
        Cause::PressureUnit => "the unit of the pressures",
        Cause::ForceUnit => "the unit of the force",
        Cause::Times => "the time stamps, and filters behind the sensors",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_far_value_says_what_else_would_explain_it() {
        let far = FarValue {
            parameter: Parameter::BulkModulus,
            nominal: 1.2e9,
            value: 1.17e10,
            sigmas: 87.5,
            is_impossible: true,
            suggests: &[Cause::PositionUnit, Cause::Bore],
        };
        assert_eq!(
            far_value(&far),
            "cylinder.bulk_modulus_pa at 1.170e10 Pa instead of 1.200e9, which no oil has, 88 of its standard deviations away; \
             check the unit of position, bore and rod"
        );
    }
}
