//! Boards: only pins and peripherals.

pub mod cost;
pub mod mps2;
pub mod stack;
pub mod uart;
