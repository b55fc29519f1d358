//! What a recorded signal shows without a model: its noise, slope, spectrum and running means.

pub mod noise;
pub mod slope;
pub mod spectrum;
pub mod window;
