//! The drives of the trials, in SI units.

use model_core::machine::{Machine, Parameter as P, Source};

use super::preset;

/// The paper's valve on a 63/40 × 300 mm cylinder: what `presets/press-63-40.toml` says, whatever the firmware is built with.
#[must_use]
pub fn press() -> Machine<f64> {
    Machine::with_defaults(preset::SOURCE).with(preset::VALUES)
}

/// A 50/20 × 200 mm cylinder on a reversible pump of 1.6 cm³.
#[must_use]
pub fn pump() -> Machine<f64> {
    Machine::with_defaults(Source::Pump).with(&[
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
    ])
}

/// 20 kg on 200 mm that a force moves.
#[must_use]
pub fn mass() -> Machine<f64> {
    Machine::with_defaults(Source::Force).with(&[(P::Stroke, 0.2), (P::MovingMass, 20.0), (P::ViscousFriction, 5.0e3)])
}
