//! TODO.

mod c99;
pub mod fmu;
pub mod rust;
