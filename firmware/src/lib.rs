//! The reference model on a controller.
//!
//! Data's way on the target: counts → measured → reference → command → counts. This crate holds what is the same on every
//! board and is tested on the host; boards and binaries are wiring.
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
#![forbid(unsafe_code)]

pub mod frame;
pub mod message;
pub mod monitor;
pub mod recorder;
pub mod reference;
pub mod set_point;

#[cfg(test)]
extern crate std;
