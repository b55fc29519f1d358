//! The virtual test bed: a drive written from the physics, in `f64`, and the sensors on it.
//!
//! It shares no equation with `model-core`, only the SI parameters, and has two uses: solved to 1e-10
//! it is the oracle of the fixed-point core's accuracy tests; solved to 1e-7, with effects and
//! sensors, it makes the recordings that the diagnosis is tried on.

mod effect;
mod input;
mod orifice;
mod physics;
mod plant;
mod slider;
mod stiff;
mod tangent;
#[cfg(test)]
mod validation;

pub use effect::PlantEffect;
pub use input::{Commands, LoadError, LoadProfile, PumpCommand};
pub use plant::{Command, InitialState, Plant, PlantError, PlantState};
