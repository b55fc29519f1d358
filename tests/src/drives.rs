//! The three drives for which every accuracy is stated.

use model_core::machine::{Machine, Parameter as P, Source};

pub use mps2::trial::pump;

/// A machine with a name for tables.
#[derive(Clone, Copy, Debug)]
pub struct NamedDrive {
    /// Its name in a table.
    pub name: &'static str,
    /// Its parameters.
    pub machine: Machine<f64>,
}

/// The paper's printed values, with the assumed supply; stiff: D/m is 5500 1/s.
#[must_use]
pub fn printed() -> Machine<f64> {
    Machine::with_defaults(Source::Valve).with(&[
        (P::SupplyPressure, 7.0e6),
        (P::FlowLimit, 3.0e-4),
        (P::ValveGain, 0.0559),
        (P::ValveOffset, 0.0345),
        (P::DeadZone, 0.105),
        (P::RateLimit, 12.0),
        (P::TimeConstant1, 0.018),
        (P::TimeConstant2, 0.0279),
        (P::TransportDelay, 0.007),
        (P::FlowCoefficient, 2.4e-7),
        (P::LaminarTransition, 2.0e3),
        (P::AreaA, 3.117e-3),
        (P::AreaB, 1.861e-3),
        (P::Stroke, 0.3),
        (P::BulkModulus, 1.2e9),
        (P::VolumeA, 1.2e9 / 9.63e12),
        (P::VolumeB, 1.2e9 / 1.28e12),
        (P::MovingMass, 18.3),
        (P::ViscousFriction, 1.0e5),
    ])
}

/// The printed drive with the oil columns of a 63/40 × 300 mm cylinder.
#[must_use]
pub fn press() -> Machine<f64> {
    printed().with(&[(P::VolumeA, 1.2e9 / 2.3e12), (P::VolumeB, 1.2e9 / 3.6e12)])
}

/// The press with a heavy load and little damping: the oil spring rings.
#[must_use]
pub fn heavy() -> Machine<f64> {
    press().with(&[(P::MovingMass, 200.0), (P::ViscousFriction, 5.0e3)])
}

/// All three.
#[must_use]
pub fn named() -> [NamedDrive; 3] {
    [
        NamedDrive { name: "printed", machine: printed() },
        NamedDrive { name: "press", machine: press() },
        NamedDrive { name: "heavy", machine: heavy() },
    ]
}
