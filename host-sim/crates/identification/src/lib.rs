//! TODO.

pub mod clock;
pub mod compare;
pub mod experiment;
pub mod fit;
pub mod input_noise;
pub mod static_curve;
