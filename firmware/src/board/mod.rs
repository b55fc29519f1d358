//! Boards: only pins and peripherals.

pub mod mps2;
pub mod stack;
pub mod uart;
