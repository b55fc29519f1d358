//! Boards: pins, peripherals, nothing else.

pub mod mps2;
