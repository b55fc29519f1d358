//! From the true signals of the plant to what its sensors record: linkage, lag, offset, noise and rounding.

pub(crate) mod before_noise;
pub(crate) mod linkage;
pub mod sensors;
