//! Every effect of the vocabulary at a strength that shows on the press.

use model_core::machine::{Machine, Parameter as P};

/// An effect with its strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effect {
    /// Name as in the machine file, with what distinguishes it where one effect has several forms.
    pub name: &'static str,
    /// What is set, SI units.
    pub values: &'static [(P, f64)],
    /// Whether it is part of [`every_effect`]; of several forms of one effect the costlier is.
    pub together: bool,
}

impl Effect {
    const fn new(name: &'static str, values: &'static [(P, f64)]) -> Self {
        Self { name, values, together: true }
    }

    const fn other_form(name: &'static str, values: &'static [(P, f64)]) -> Self {
        Self { name, values, together: false }
    }
}

/// The machine with all effects at once.
#[must_use]
pub fn every_effect(machine: &Machine<f64>) -> Machine<f64> {
    EFFECTS.iter().filter(|effect| effect.together).fold(*machine, |machine, effect| machine.with(effect.values))
}

/// All effects, in the order of the chain.
pub const EFFECTS: &[Effect] = &[
    Effect::new("valve-hysteresis", &[(P::HysteresisWidth, 0.02), (P::HysteresisSpread, 0.5)]),
    Effect::new("spool-stiction", &[(P::StictionBand, 0.01), (P::StictionKept, 0.2)]),
    Effect::new("null-drift", &[(P::NullDriftTravel, 0.02), (P::NullDriftTime, 2.0)]),
    Effect::new("solenoid-saturation", &[(P::SolenoidOnset, 0.3), (P::SolenoidCurvature, 0.8), (P::SolenoidLoss, 0.1)]),
    Effect::new("flow-force", &[(P::FlowForce, 3e-8)]),
    Effect::new("dead-zone-asymmetry", &[(P::DeadZoneDifference, 0.02)]),
    Effect::new(
        "flow-gain-nonlinearity",
        &[(P::FlowGainLinear, 0.3), (P::FlowGainBeyond, 0.2), (P::FlowGainNotch, 0.1)],
    ),
    Effect::new(
        "metering-asymmetry",
        &[(P::MeteringRatio, 0.2), (P::MeteringPorts, -0.1), (P::MeteringDirections, 0.05)],
    ),
    Effect::other_form("metering-asymmetry, tank edges alone", &[(P::MeteringRatio, 0.2)]),
    Effect::new("supply-droop", &[(P::DroopResistance, 3e9), (P::DroopTime, 0.05)]),
    Effect::other_form("supply-droop, without memory", &[(P::DroopResistance, 3e9)]),
    Effect::new("tank-back-pressure", &[(P::ReturnResistance, 3e12), (P::ReturnLaminar, 1e9)]),
    Effect::new("valve-leakage", &[(P::ValveLeakageOpening, 0.01)]),
    Effect::new("laminar-transition", &[(P::LaminarPressure, 5e4)]),
    Effect::new("pump-slip", &[(P::PumpSlip, 1e-12)]),
    Effect::new("internal-leakage", &[(P::InternalLeakage, 2e-12)]),
    Effect::new("external-leakage", &[(P::ExternalLeakageA, 2e-12), (P::ExternalLeakageB, 4e-12)]),
    Effect::new("entrained-air", &[(P::AirShare, 0.01)]),
    Effect::new("hose-compliance", &[(P::HoseCompliance, 1e-13)]),
    Effect::new("position-dependent-volume", &[(P::VolumeShare, 1.0)]),
    Effect::new("coulomb-friction", &[(P::CoulombFriction, 500.0)]),
    Effect::new(
        "stribeck-friction",
        &[(P::StribeckForce, 300.0), (P::StribeckExcess, 300.0), (P::StribeckVelocity, 0.02)],
    ),
    Effect::new("friction-asymmetry", &[(P::AsymmetricExtending, 200.0), (P::AsymmetricRetracting, 100.0)]),
    Effect::new(
        "position-dependent-friction",
        &[
            (P::PositionFriction, 200.0),
            (P::PositionFrictionSlope, 100.0),
            (P::PositionFrictionBow, 50.0),
            (P::PositionDragSlope, 0.5),
            (P::PositionDragBow, -0.2),
        ],
    ),
    Effect::new("pressure-dependent-friction", &[(P::PressureFriction, 3e-5)]),
    Effect::new(
        "position-dependent-load",
        &[(P::LoadSpring, 5e3), (P::LoadSpringForce, 500.0), (P::LoadSpringBow, 1e4)],
    ),
    Effect::new(
        "end-stop",
        &[(P::StopRetracted, 0.12), (P::StopExtended, 0.18), (P::StopStiffness, 1e8), (P::StopDamping, 1e4)],
    ),
    Effect::new("presliding", &[(P::PreslidingForce, 300.0), (P::PreslidingStiffness, 1e8)]),
    Effect::new("linkage-backlash", &[(P::BacklashPlay, 1e-3)]),
    Effect::new("position-sensor-lag", &[(P::PositionLag, 5e-3), (P::PositionDelay, 7.3e-3)]),
    Effect::new(
        "sensor-offset",
        &[
            (P::PressureAOffset, 1e5),
            (P::PressureBOffset, -5e4),
            (P::SpoolOffset, 0.01),
            (P::PressureAFactor, 0.01),
            (P::PressureBFactor, 0.02),
            (P::SpoolFactor, -0.01),
            (P::PositionFactor, 0.01),
        ],
    ),
    Effect::new(
        "oil-temperature",
        &[
            (P::ViscosityLoss, 0.3),
            (P::WarmingTime, 5.0),
            (P::ViscosityLossPerKelvin, 0.04),
            (P::ReferenceTemperature, 40.0),
        ],
    ),
    Effect::new(
        "unnamed",
        &[
            (P::TableQuantity, 1.0),
            (P::TableOver, 1.0),
            (P::TableOver2, 2.0),
            (P::TableFrom, -0.2),
            (P::TableTo, 0.2),
            (P::TableFrom2, 0.1),
            (P::TableTo2, 0.2),
            (P::TableValue0, 300.0),
            (P::TableValue4, 200.0),
            (P::TableValue8, -100.0),
            (P::TableValue10, 50.0),
            (P::TableValue13, -150.0),
            (P::TableValue17, -250.0),
            (P::TableValue20, -300.0),
        ],
    ),
    Effect::other_form(
        "unnamed, flow into A",
        &[
            (P::TableQuantity, 2.0),
            (P::TableOver, 4.0),
            (P::TableFrom, 1e6),
            (P::TableTo, 6e6),
            (P::TableValue1, 1e-6),
            (P::TableValue3, -1e-6),
            (P::TableValue6, 2e-6),
        ],
    ),
    Effect::other_form(
        "unnamed, flow out of B",
        &[
            (P::TableQuantity, 3.0),
            (P::TableOver, 5.0),
            (P::TableFrom, 1e6),
            (P::TableTo, 6e6),
            (P::TableValue1, 1e-6),
            (P::TableValue3, -1e-6),
            (P::TableValue6, 2e-6),
        ],
    ),
    Effect::other_form(
        "unnamed, slider travel",
        &[
            (P::TableQuantity, 4.0),
            (P::TableOver, 3.0),
            (P::TableFrom, -0.5),
            (P::TableTo, 0.5),
            (P::TableValue1, 0.01),
            (P::TableValue5, -0.02),
        ],
    ),
];
