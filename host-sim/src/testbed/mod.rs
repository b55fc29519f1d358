//! The virtual test bed: a drive written from the physics, in `f64`, and the sensors on it.
//!
//! It shares no equation with `model-core`, only the SI parameters, and has two uses: solved to 1e-10
//! it is the oracle of the fixed-point core's accuracy tests; solved to 1e-7, with effects and
//! sensors, it makes the recordings that the diagnosis is tried on.

#[cfg(test)]
mod behaviour;
mod bench;
pub mod draw;
mod edges;
mod effect;
#[cfg(test)]
mod effects_behaviour;
pub mod excitation;
mod grammar;
mod input;
mod linkage;
mod orifice;
mod outside;
mod physics;
mod plant;
pub mod sensors;
mod shaped_slider;
mod sight;
mod slider;
mod stiff;
mod synthetic;
mod tangent;
mod truth;
#[cfg(test)]
mod validation;

pub use bench::{Bench, Drive};
pub use edges::GainCurve;
pub use effect::{
    Cavitation, Channel, DryFriction, FlowEffect, FrictionLevel, LoadEffect, OilGrade, OilTemperature, PlantEffect, SensingEffect,
    ValveEffect,
};
pub use excitation::{Dither, Excitation};
pub use grammar::ExcitationError;
pub use input::{Command, Commands, LoadError, LoadProfile, PumpCommand};
pub use linkage::{Linkage, LinkageError};
pub use plant::{InitialState, Plant, PlantError, PlantState};
pub use sensors::{Sensors, Thermometer};
pub use synthetic::{SyntheticRecording, WriteError};
pub use truth::truth_near;
