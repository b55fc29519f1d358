//! What a recorded signal shows without a model: its noise, slope, spectrum, correlation and running means.

pub mod correlation;
pub mod noise;
pub mod slope;
pub mod spectrum;
pub mod window;
