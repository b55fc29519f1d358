//! The drives of the trials, in SI units.

use model_core::machine::{Machine, Source};
use model_core::parameter::Parameter as P;

/// The paper's valve on a 63/40 × 300 mm cylinder: what `presets/press-63-40.toml` says.
#[must_use]
pub fn press() -> Machine<f64> {
    with(
        Source::Valve,
        &[
            (P::SupplyPressure, 7.0e6),
            (P::FlowLimit, 3.0e-4),
            (P::ValveGain, 0.0559),
            (P::ValveOffset, 0.0345),
            (P::DeadZone, 0.1049),
            (P::RateLimit, 12.0),
            (P::TimeConstant1, 0.018),
            (P::TimeConstant2, 0.0279),
            (P::TransportDelay, 0.007),
            (P::FlowCoefficient, 2.4e-7),
            (P::AreaA, 3.117e-3),
            (P::AreaB, 1.861e-3),
            (P::Stroke, 0.3),
            (P::VolumeA, 5.2e-4),
            (P::VolumeB, 3.3e-4),
            (P::BulkModulus, 1.2e9),
            (P::MovingMass, 18.3),
            (P::ViscousFriction, 1.0e5),
        ],
    )
}

/// A 50/20 × 200 mm cylinder on a reversible pump of 1.6 cm³.
#[must_use]
pub fn pump() -> Machine<f64> {
    with(
        Source::Pump,
        &[
            (P::SupplyPressure, 1e7),
            (P::TankPressure, 4e5),
            (P::AreaA, 1.9635e-3),
            (P::AreaB, 1.6493e-3),
            (P::Stroke, 0.2),
            (P::VolumeA, 2.5e-4),
            (P::VolumeB, 2.2e-4),
            (P::MovingMass, 20.0),
            (P::ViscousFriction, 5.0e3),
            (P::PumpDisplacement, 1.6e-6),
            (P::ReturnCoefficient, 1e-7),
        ],
    )
}

fn with(source: Source, values: &[(P, f64)]) -> Machine<f64> {
    let mut machine = Machine::with_defaults(source);
    for &(parameter, value) in values {
        machine.set(parameter, value);
    }
    machine
}
