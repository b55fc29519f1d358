//! Boards: pins, peripherals, nothing else.

pub mod mps2;
pub mod stack;
pub mod uart;
