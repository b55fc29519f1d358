//! The firmware on Arm's MPS2 boards as QEMU emulates them, `mps2-an386` (Cortex-M4F) and `mps2-an385` (Cortex-M3).
//!
//! ```text
//! trial        drives under inputs that host and target both run    → parity, budget
//! in_the_loop  the firmware's parts, at the other end of a line     → loop
//! cost         instructions and stack of a step                  → budget, baked_budget
//! commanded    steps under a list of commands                       → cycles, baked_cycles
//! image        what binaries consist of that have nothing else    → steps, parity
//! board, uart  the boards themselves, on the target only            → every binary
//! ```
//!
//! `board` is at the root of the crate.
#![no_std]
#![deny(unsafe_code)]

#[cfg(test)]
extern crate std;

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod board;
pub mod commanded;
#[cfg(all(target_arch = "arm", target_os = "none"))]
pub mod cost;
mod image;
pub mod in_the_loop;
pub mod trial;
#[cfg(all(target_arch = "arm", target_os = "none"))]
pub mod uart;

#[cfg(all(target_arch = "arm", target_os = "none"))]
pub use board::{CLOCK_HZ, Counter, INSTRUCTIONS_PER_COUNT, Log, console, exit};
