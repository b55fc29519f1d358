//! The file formats of recordings, one file or folder for each. Start at [`read`], which recognises the format ([`format`](mod@format));
//! `columns` turns the content of any of them into a recording.

#[cfg(any(feature = "parquet", feature = "xlsx"))]
mod catch_panic;
pub(crate) mod chunks;
mod coarse_stamps;
mod columns;
pub mod format;
#[cfg(feature = "gzip")]
mod gzip;
pub(crate) mod mark_fault;
#[cfg(feature = "mat")]
mod mat;
#[cfg(feature = "mdf4")]
mod mdf4;
pub(crate) mod memory;
#[cfg(feature = "parquet")]
mod parquet;
pub mod read;
mod resample;
pub mod sheet;
pub(crate) mod source;
mod stamp_clock;
pub mod survey;
pub(crate) mod surveyed;
pub(crate) mod text;
pub(crate) mod text_fault;
pub mod unknown;
pub(crate) mod unsupported;
pub mod write;
#[cfg(feature = "xlsx")]
mod xlsx;
