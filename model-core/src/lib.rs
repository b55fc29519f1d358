//! Reference model of a valve-controlled (or pump-controlled) hydraulic drive, for controllers and desktops.
//!
//! command → [`valve`] → spool → [`flow`] → [`chambers`] → [`mechanics`] → [`sensing`]. Each link is a type of its own that can
//! be stepped alone, and its file opens with the equations that it computes; [`drive::Drive`] composes them into one fixed-cost implicit step a tick.
//! The equations are written once, over [`number::Number`]: fixed point on the controller and, bit for bit the same, on the desktop; single
//! precision ([`number::Single`]), likewise, for a controller with an FPU; `f64`, dual numbers and vectors on the desktop. [`machine::Machine`] holds a drive's SI parameters, [`machine::Parameter`] names them.
//!
//! Modules from the bottom up, each importing only those above it:
//!
//! | module | holds |
//! |---|---|
//! | [`number`] | arithmetic: formats, rounding and saturation, roots |
//! | [`effects`] | the table of all effects; which of them a step is compiled for |
//! | [`machine`] | SI parameters: key, unit, range, default; scales of all per-unit quantities |
//! | [`ports`] | what the links hand to one another |
//! | `oil`, `correction_table` | viscosity over temperature; a table for misfits that no effect explains |
//! | [`valve`], [`flow`], [`chambers`], [`mechanics`], [`sensing`] | the links, each with its effects |
//! | [`drive`] | the links together: state, step, the paper's model by itself |
//! | `coefficients` | SI parameters → per-unit coefficients, for all of the above |
//! | [`control`] | model-following control around the drive |
//!
//! No allocation, no clock, no I/O, no `unsafe`; no floating point in a step in fixed point, nothing wider than an `f32` in single precision.
//!
//! ```
//! use model_core::drive::{Drive, DriveState, DriveInput, Load};
//! use model_core::machine::{Machine, Parameter, Source, Tick};
//! use model_core::number::{Number, PerUnit};
//! use model_core::ports::ChamberState;
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
//!     drive.step(&mut state, DriveInput::Command(half), Load::NONE); // 5 V
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

/// The chambers link: flows and velocity → pressures.
pub mod chambers;
mod coefficients;
pub mod control;
mod correction_table;
pub mod drive;
pub mod effects;
/// The flow link: spool, or pump, and pressures → flow into A and out of B.
pub mod flow;
#[doc(hidden)]
pub mod literal;
pub mod machine;
/// The mechanics link: forces → velocity and position.
pub mod mechanics;
pub mod number;
mod oil;
pub mod ports;
pub mod sensing;
/// The valve link: command → spool.
pub mod valve;

/// The README's code.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
