//! The numbers that the core's equations run on beside `f64` and fixed point: dual numbers for derivatives and SIMD lanes. Both hold the `f64` run to the
//! last bit.

pub mod cpu;
pub mod dual;
pub mod simd;
