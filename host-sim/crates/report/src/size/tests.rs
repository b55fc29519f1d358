use diagnosis::catalogue::CATALOGUE;
use test_press::press;

use super::*;

/// The size in words, on the press: 21.8 kN of full force, 38 l/min of full flow, 17.9 V for full spool travel.
fn said(parameter: Parameter, value: f64) -> String {
    size(&press(&[]), parameter, value).unwrap().to_string()
}

#[test]
fn every_parameter_of_an_effect_has_a_size_and_no_other_has() {
    let machine = press(&[]);
    for &parameter in Parameter::ALL {
        assert_eq!(size(&machine, parameter, 0.01).is_some(), parameter.effect().is_some(), "{parameter:?}");
    }
    for parameter in CATALOGUE.iter().flat_map(|effect| effect.parameters()) {
        for value in [0.02, -0.02] {
            let size = size(&machine, parameter, value).unwrap();
            assert!(!size.amount.is_empty() && !size.to_string().contains("  "), "{parameter:?}: {size}");
        }
    }
}

#[test]
fn friction_is_a_force_and_a_share_of_full_force_with_a_grade() {
    assert_eq!(said(Parameter::StribeckForce, 500.0), "500 N, 2.3 % of full force: usual for a sealed cylinder");
    assert_eq!(said(Parameter::CoulombFriction, 913.0), "913 N, 4.2 % of full force: raised");
    let within = |value| size(&press(&[]), Parameter::StribeckForce, value).unwrap().within_tolerance();
    assert_eq!(within(870.0), "870 N, 4.0 % of full force: more than usual, within the tolerance");
    assert_eq!(within(500.0), "500 N, 2.3 % of full force: usual for a sealed cylinder");
    assert_eq!(said(Parameter::AsymmetricRetracting, 2419.0), "2419 N, 11 % of full force: worn or jammed");
    assert_eq!(said(Parameter::StribeckExcess, 500.0), "500 N, 2.3 % of full force");
    assert_eq!(said(Parameter::LoadSpringForce, -12_000.0), "12.0 kN against retracting, 55 % of full force");
    assert_eq!(
        said(Parameter::LoadSpring, 2e4),
        "3000 N at each end of the stroke, towards its middle, 14 % of full force"
    );
}

#[test]
fn leakage_is_a_flow_at_the_supply_pressure_and_a_share_of_full_flow_with_a_grade() {
    assert_eq!(
        said(Parameter::InternalLeakage, 2e-12),
        "0.84 l/min at 70 bar across the piston, 2.2 % of full flow: worn"
    );
    assert!(said(Parameter::ExternalLeakageB, 5e-13).ends_with(" at 70 bar in B, 0.55 % of full flow: raised"));
    assert!(said(Parameter::InternalLeakage, 5e-14).ends_with("0.055 % of full flow: usual for a sealed cylinder"));
    assert_eq!(
        said(Parameter::ValveLeakageOpening, 0.01),
        "0.54 l/min from supply to tank at 70 bar, spool at its centre, 1.4 % of full flow"
    );
    let mut pump = Machine::with_defaults(Source::Pump);
    pump.set(Parameter::PumpDisplacement, 1.6e-5);
    let slip = size(&pump, Parameter::PumpSlip, 2e-12).unwrap().to_string();
    assert_eq!(slip, "0.84 l/min at 70 bar, 3.5 % of full flow");
}

#[test]
fn spool_travel_is_a_share_and_the_command_that_it_takes() {
    assert!(said(Parameter::HysteresisWidth, 0.02).starts_with("2.0 % of full spool travel (0.36 V) between"));
    assert_eq!(
        said(Parameter::DeadZoneDifference, -0.05),
        "5.0 % of full spool travel (0.89 V) more overlap on the retracting side"
    );
    assert_eq!(said(Parameter::MeteringRatio, -0.08), "8.0 % smaller tank than supply edges");
    assert_eq!(said(Parameter::FlowForce, 3e-8), "21 % of its travel closed by 70 bar over the edges");
}

#[test]
fn lines_and_oil_are_told_in_bar_cubic_centimetres_and_per_cent() {
    assert_eq!(said(Parameter::DroopResistance, 3e9), "19 bar at a full flow of 38 l/min");
    assert_eq!(said(Parameter::ReturnResistance, 3e12), "12 bar at a full flow of 38 l/min");
    assert_eq!(said(Parameter::HoseCompliance, 1e-13), "1.0 cm³ per 100 bar in each chamber");
    assert_eq!(said(Parameter::AirShare, 0.005), "0.50 % of the oil by volume, at atmospheric pressure");
    assert_eq!(said(Parameter::HoldingSetB, 1.6e7), "160 bar in B open its load-holding valve without a pilot");
    assert_eq!(said(Parameter::PilotRatio, 2.7), "2.7 times as much as its own the other side's pressure opens it");
    assert_eq!(said(Parameter::CavitationFloor, -3e4), "0.71 bar absolute, below which no pressure falls");
}

#[test]
fn sensors_are_told_in_bar_mm_and_ms_with_the_direction_in_words() {
    assert_eq!(said(Parameter::PressureAOffset, -52_000.0), "0.52 bar read too little, 0.74 % of the supply pressure");
    assert_eq!(said(Parameter::PositionFactor, 0.01), "1.0 % read too much");
    assert_eq!(said(Parameter::BacklashPlay, 1e-3), "1.0 mm, 0.33 % of the stroke");
    assert_eq!(said(Parameter::PositionLag, 4e-3), "4.0 ms");
    assert_eq!(said(Parameter::WarmingTime, 600.0), "10 min");
}
