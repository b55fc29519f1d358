//! TODO.

pub mod cpu;
pub mod dual;
pub mod simd;
