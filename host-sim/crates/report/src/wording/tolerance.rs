//! Tolerances that a fit used up.

use diagnosis::agreement::Tolerated;
use model_core::machine::{Machine, Parameter};

use crate::size::{Size, size};

/// The heading above tolerances.
pub const WITHIN: &str = "Within tolerance, not findings";

/// The tolerances that were used up to their ends, a clause each.
pub fn used_up(machine: &Machine<f64>, tolerated: &[Tolerated]) -> impl Iterator<Item = String> {
    tolerated.iter().filter_map(|one| at_limit(machine, one))
}

/// A tolerance with its limit, if it was used up; or with what it was then, if what is left to it around that was.
#[must_use]
pub fn at_limit(machine: &Machine<f64>, tolerated: &Tolerated) -> Option<String> {
    if let Some(then) = tolerated.left_then {
        let (then, now) =
            (size(machine, tolerated.parameter, then)?, size(machine, tolerated.parameter, tolerated.value)?);
        let thing = tolerated_thing(tolerated.parameter);
        return Some(format!(
            "{thing} has moved as far as it may since then, within its tolerance: {}{} → {}{}",
            then.amount, then.of, now.amount, now.of
        ));
    }
    let limit = tolerated.most.copysign(tolerated.value);
    let Size { amount, of, .. } = size(machine, tolerated.parameter, limit)?;
    tolerated.at_limit.then(|| {
        let thing = tolerated_thing(tolerated.parameter);
        format!("{thing} is at the end of its tolerance ({amount}{of}): what is beyond is not within the drawing")
    })
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
        P::EdgeRounding => "rounding of the valve's edges",
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
    use test_press::press;

    use super::*;

    #[test]
    fn only_a_tolerance_that_is_used_up_is_told_with_its_limit_and_the_sign_of_its_value() {
        let tolerated = |parameter, value, most, at_limit| Tolerated {
            parameter,
            value,
            std: 0.0,
            most,
            at_limit,
            left_then: None,
        };
        let all = [
            tolerated(Parameter::StribeckForce, 869.9, 870.0, true),
            tolerated(Parameter::AirShare, 0.005, 0.01, false),
            tolerated(Parameter::MeteringPorts, -0.0799, 0.08, true),
        ];
        let told: Vec<String> = used_up(&press(&[]), &all).collect();
        let end = "what is beyond is not within the drawing";
        assert_eq!(
            told[0],
            format!("seal friction is at the end of its tolerance (870 N, 4.0 % of full force): {end}")
        );
        assert!(told[1].contains("of B and A is at the end of its tolerance (8.0 % smaller edges of B than of A)"));
        assert_eq!(told.len(), 2);
    }
}
