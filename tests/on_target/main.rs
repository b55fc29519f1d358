//! The model on the emulated target: does it compute what the host computes, and what does it cost?
//!
//! Agreement of host and target does not show that they are right: the tests of `accuracy` compare them with the oracle.

mod baked;
mod baked_images;
#[cfg(unix)]
mod budget;
mod cycles;
mod image;
mod log;
mod overflow;
mod parity;
mod runtimes;
mod sequences;
mod trials;
#[cfg(unix)]
mod whole;
