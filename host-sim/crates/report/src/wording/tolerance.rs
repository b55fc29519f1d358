//! Tolerances that a fit used up.

use diagnosis::agreement::Tolerated;
use model_core::machine::Parameter;

/// The tolerances that were used up to their ends, a clause each.
pub fn used_up(tolerated: &[Tolerated]) -> impl Iterator<Item = String> + '_ {
    tolerated.iter().filter(|one| one.at_limit).map(at_limit)
}

/// A tolerance that was used up, with its limit.
fn at_limit(tolerated: &Tolerated) -> String {
    let unit = tolerated.parameter.description().unit;
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    format!(
        "{} is at the end of its tolerance ({:.2e}{unit}): what is beyond is not within the drawing",
        tolerated_thing(tolerated.parameter),
        tolerated.most.copysign(tolerated.value)
    )
}

/// What a tolerance is of, in words.
#[must_use]
pub fn tolerated_thing(parameter: Parameter) -> &'static str {
    use Parameter as P;
    match parameter {
        P::HysteresisWidth => "hysteresis of the valve",
        P::DeadZoneDifference => "difference between the overlaps",
        P::MeteringRatio => "difference between tank and supply edges",
        P::MeteringPorts => "difference between the edges of B and A",
        P::MeteringDirections => "difference between the edges for retracting and extending",
        P::DroopResistance => "droop of the supply",
        P::ReturnResistance | P::ReturnLaminar => "back pressure of the return line",
        P::ValveLeakageOpening => "leakage of the valve at its centre",
        P::InternalLeakage => "leakage past the piston",
        P::AirShare => "air in the oil",
        P::HoseCompliance => "compliance of the hoses",
        P::StribeckForce => "seal friction",
        P::StribeckExcess => "break-away force of the seals",
        P::BacklashPlay => "play in the linkage",
        P::PositionLag => "lag of the position's sensor",
        P::PressureAOffset => "offset of the pressure sensor in A",
        P::PressureBOffset => "offset of the pressure sensor in B",
        P::SpoolOffset => "offset of the spool's sensor",
        other => other.description().key,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_tolerance_that_is_used_up_is_told_with_its_limit_and_the_sign_of_its_value() {
        let tolerated = |parameter, value, most, at_limit| Tolerated { parameter, value, std: 0.0, most, at_limit };
        let told: Vec<String> = used_up(&[
            tolerated(Parameter::StribeckForce, 869.9, 870.0, true),
            tolerated(Parameter::AirShare, 0.005, 0.01, false),
            tolerated(Parameter::MeteringPorts, -0.0799, 0.08, true),
        ])
        .collect();
        let end = "what is beyond is not within the drawing";
        assert_eq!(told[0], format!("seal friction is at the end of its tolerance (8.70e2 N): {end}"));
        assert!(told[1].starts_with("difference between the edges of B and A") && told[1].contains("(-8.00e-2)"));
        assert_eq!(told.len(), 2);
    }
}
