//! The reference model on a controller.
//!
//! Data's way on the target: counts → measured → reference → command → counts. This crate holds what is the same on every
//! board and is tested on the host; boards and binaries are wiring.
//!
//! ```text
//! edge ─ calibration, travel ─ measured ─ fault, mode ─ control (reference inside) ─ limits ─ calibration ─ edge
//!   │                                        all of it, once a tick: period
//!   └ ads8688, ls7366r, dac
//! ```
//!
//! ```
//! use firmware::reference::Reference;
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
//! let mut reference: Reference<64> = Reference::at_rest(&machine, Tick::OneMillisecond, 0.5)?;
//! let predicted = reference.step(PerUnit::saturated(0.5));
//! assert!(predicted.slider >= PerUnit::ZERO);
//! # Ok::<(), model_core::machine::MachineError>(())
//! ```
#![no_std]
#![deny(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod ads8688;
#[cfg(all(target_arch = "arm", target_os = "none"))]
pub mod board;
pub mod calibration;
pub mod control;
pub mod dac;
pub mod desk;
pub mod edge;
pub mod fault;
pub mod following;
pub mod frame;
pub mod limits;
mod line;
pub mod lockstep;
pub mod log;
pub mod ls7366r;
pub mod measured;
pub mod message;
#[cfg(test)]
mod mock;
pub mod mode;
pub mod monitor;
pub mod operator;
pub mod outbox;
pub mod output;
pub mod period;
pub mod press;
pub mod recorder;
pub mod reference;
pub mod remote;
mod sense;
pub mod set_point;
pub mod station;
pub mod still;
pub mod travel;
pub mod trial;

/// The README's code.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

/// The code of the book's chapter for other firmware.
#[cfg(doctest)]
#[doc = include_str!("../../docs/embedding.md")]
mod embedding {}
