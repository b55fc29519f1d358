//! TODO.

pub(crate) mod before_noise;
pub(crate) mod linkage;
pub mod sensors;
