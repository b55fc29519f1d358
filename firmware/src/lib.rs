//! The reference model on a controller.
//!
//! Data flow on the target: counts → measured → reference → command → counts. This crate holds everything that is the same on every
//! board, and is tested on the host; boards are crates of their own (`firmware/boards`) and contain only wiring.
//!
//! ```text
//! io ─ scaling ─ measured ─ supervision ─ control (reference inside) ─ supervision's limits ─ scaling ─ io
//!  │                            all of it, once a tick: period
//!  └ ads8688, ls7366r, ad5754
//! ```
//!
//! ```
//! use firmware::control::Reference;
//! use model_core::machine::{Machine, Parameter, Source, Tick};
//! use model_core::number::{Number, PerUnit};
//!
//! let mut machine = Machine::with_defaults(Source::Valve);
//! machine.set(Parameter::AreaA, 3.117e-3);
//! machine.set(Parameter::AreaB, 1.861e-3);
//! machine.set(Parameter::VolumeA, 5.2e-4);
//! machine.set(Parameter::VolumeB, 3.3e-4);
//! let mut reference: Reference<64> = Reference::at_rest(&machine, Tick::OneMillisecond, 0.5)?;
//! let predicted = reference.step(PerUnit::saturated(0.5));
//! assert!(predicted.spool >= PerUnit::ZERO);
//! # Ok::<(), model_core::machine::MachineError>(())
//! ```
#![no_std]
#![deny(unsafe_code)]

// What `host-sim plan --firmware` writes names it, in this crate as in any other.
extern crate self as firmware;
#[cfg(test)]
extern crate std;

pub mod app;
pub mod commissioning;
pub mod control;
pub mod excitation;
pub mod io;
pub mod measured;
#[cfg(test)]
mod mock;
pub mod monitor;
pub mod period;
pub mod recorder;
pub mod scaling;
pub mod set_point;
pub mod supervision;

/// The README's code.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

/// The code of the book's chapter for other firmware.
#[cfg(doctest)]
#[doc = include_str!("../../docs/embedding.md")]
mod embedding {}
