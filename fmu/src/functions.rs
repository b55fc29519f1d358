//! The C functions of FMI 2.0 and 3.0: pointers become arguments of an [`Instance`](crate::Instance), and a refusal becomes a line of the tool's log.
//!
//! Both versions are functions of one library over one kind of instance. All that a version asks of co-simulation are present, because tools
//! look for each; functions that this FMU does not support return an error. A tool guarantees (FMI 2.0, 2.1; FMI 3.0, 2.2) that pointers refer
//! to as many values as it states, and that an instance or a state is one that it was given and has not freed; every `unsafe` below relies on
//! this and on nothing else.
#![expect(unsafe_code, reason = "the standard's interface is one of pointers; only this module has them")]

#[macro_use]
mod handle;
mod both;
mod fmi2;
mod fmi3;
mod log;
mod pointers;

#[cfg(test)]
mod tests;
