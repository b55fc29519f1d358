//! The virtual test bed: a drive written from the physics, in `f64`, and the sensors on it.
//!
//! It shares no equation with `model-core`, only the SI parameters, and has two uses: solved to 1e-10
//! it is the oracle of the fixed-point core's accuracy tests; solved to 1e-7, with effects and
//! sensors, it makes the recordings on which the diagnosis is tested.
//!
//! Start at [`Bench`], which runs a [`Plant`] with its [`Sensors`] to a recording, or at [`concealed`] for drives with known truth. It does not
//! use `simulation` or a step of `model-core`; of `model-core` it uses only the table of parameters.
#![forbid(unsafe_code)]
// All output is returned to the caller: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]

mod boundary;
mod checks;
pub mod concealed;
mod effect;
mod excitation;
mod flow;
pub mod hall;
mod integrator;
mod physics;
mod plant;
mod rig;
pub mod sensor;
mod spool;
mod tangent;
mod terms;

pub use effect::flow::FlowEffect;
pub use effect::friction::{DryFriction, FrictionLevel};
pub use effect::load::LoadEffect;
pub use effect::oil::{OilGrade, OilTemperature};
pub use effect::sensing::{MeasuredSignal, SensingEffect};
pub use effect::valve::ValveEffect;
pub use effect::{Cavitation, LoadHolding, PlantEffect};
pub use excitation::input::{Command, Commands, LoadError, LoadProfile, PumpCommand};
pub use flow::edges::GainCurve;
pub use plant::{InitialState, Plant, PlantError, PlantState};
pub use recording::excitation::signals::{Dither, Excitation};
pub use recording::excitation::text::ExcitationError;
pub use rig::recorded::{SyntheticRecording, WriteError};
pub use rig::run::{Bench, Drive};
pub use rig::truth::truth_near;
pub use sensor::linkage::{Linkage, LinkageError};
pub use sensor::sensors::{Sensors, Thermometer};
