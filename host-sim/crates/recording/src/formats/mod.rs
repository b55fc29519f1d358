//! TODO.

#[cfg(feature = "parquet")]
mod catch_panic;
pub(crate) mod chunks;
mod columns;
pub mod format;
#[cfg(feature = "mat")]
mod mat;
#[cfg(feature = "mdf4")]
mod mdf4;
#[cfg(feature = "parquet")]
mod parquet;
mod resample;
pub(crate) mod text;
pub(crate) mod unsupported;
pub mod write;
