//! Reference model of a valve-controlled (or pump-controlled) hydraulic drive, for controllers and desktops.
//!
//! command → [`valve`] → slider → [`flow`] → [`chambers`] → [`mechanics`] → [`sensing`]. Each link is a type of its own that can
//! be stepped alone; [`drive::Drive`] composes them into one fixed-cost implicit step a tick. The equations are written once,
//! over [`number::Number`]: fixed point on the controller and, bit for bit the same, on the desktop; `f64`, dual numbers and vectors on the
//! desktop. [`machine::Machine`] holds a drive's SI parameters, [`parameter::Parameter`] names them.
//!
//! No allocation, no clock, no I/O, no `unsafe`, no floating point in a step.
//!
//! ```
//! use model_core::chambers::ChamberState;
//! use model_core::drive::{Drive, DriveState, Entry, Load};
//! use model_core::fixed_point::PerUnit;
//! use model_core::machine::{Machine, Source, Tick};
//! use model_core::number::Number;
//! use model_core::parameter::Parameter;
//!
//! let mut machine = Machine::with_defaults(Source::Valve);
//! machine.set(Parameter::AreaA, 3.117e-3);
//! machine.set(Parameter::AreaB, 1.861e-3);
//! machine.set(Parameter::VolumeA, 5.2e-4);
//! machine.set(Parameter::VolumeB, 3.3e-4);
//! let drive = Drive::<PerUnit>::new::<64>(&machine, Tick::OneMillisecond)?;
//!
//! let half = PerUnit::saturated(0.5);
//! let pressures = ChamberState { a: PerUnit::saturated(0.3), b: half };
//! let mut state: DriveState<PerUnit> = drive.at_rest(PerUnit::ZERO, pressures, PerUnit::travel(0.5));
//! for _ in 0..100 {
//!     drive.step(&mut state, Entry::Command(half), Load::NONE); // 5 V
//! }
//! let position_m = PerUnit::strokes(state.motion.position) * drive.bases().stroke_m;
//! assert!(position_m > 0.15, "a positive command extends the rod");
//! # Ok::<(), model_core::machine::MachineError>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::float_arithmetic, clippy::unwrap_used, clippy::panic, clippy::indexing_slicing))]

#[cfg(feature = "std")]
extern crate std;

mod bases;
mod bristles;
mod capacity;
pub mod cavitation;
mod chain;
pub mod chambers;
mod coefficients;
pub mod drive;
mod edge_effects;
mod end_stop;
mod feed;
pub mod fixed_point;
pub mod flow;
pub mod follow;
mod friction;
pub mod machine;
pub mod mechanics;
mod metering;
pub mod number;
pub mod paper;
pub mod parameter;
mod position_load;
mod relaxation;
mod roots;
pub mod sensing;
pub mod sensors;
pub mod supply;
mod temperature;
mod unnamed;
pub mod valve;
mod valve_effects;
mod vocabulary;
