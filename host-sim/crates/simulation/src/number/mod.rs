//! The numbers on which the core's equations run in addition to `f64` and fixed point: dual numbers for derivatives, and
//! SIMD lanes. The values of both equal those of the `f64` run to the last bit.

pub mod cpu;
pub mod dual;
pub mod simd;
