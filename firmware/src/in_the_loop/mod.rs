//! The firmware in the loop: its parts and its machine are at the other end of a serial line, and simulated there.

pub mod lockstep;
pub mod remote;
