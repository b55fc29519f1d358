//! The press's three parts and its machine, simulated in memory, on a host or a controller: no line to anywhere, and the same bits on both.
//!
//! `parts` are asked by SPI frames; `short_run` is what the firmware is asked over them for a second.
//!
//! A crate of its own: how the compiler makes a step depends on what else calls it, and the budgets' images must not change by this.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod parts;
pub mod short_run;
