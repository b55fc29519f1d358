//! The model on the emulated target: does it compute what the host computes, and what does it cost?
//!
//! That host and target agree says nothing of whether they are right: that is what the tests of `accuracy` hold against the oracle.

#[cfg(unix)]
mod budget;
mod image;
mod log;
mod parity;
mod trials;
#[cfg(unix)]
mod whole;
