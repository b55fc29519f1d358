//! The firmware in the loop: its parts and its machine are simulated at the other end of a serial line.

pub mod lockstep;
pub mod remote;
