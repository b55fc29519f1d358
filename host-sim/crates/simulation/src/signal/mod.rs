//! TODO.

pub mod noise;
pub mod slope;
pub mod spectrum;
pub mod window;
