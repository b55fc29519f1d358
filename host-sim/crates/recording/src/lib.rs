//! Recordings of a drive: signals with their units, and the files that they are read from and written to.
//!
//! [`Recording`] is what all other crates work on: signals in SI units on one time base. `formats` reads and writes it (text, MAT,
//! MDF 4, Parquet), [`excitation`] makes input signals, [`files`] writes a file whole or not at all and shows where an error stands
//! in a source text. Start at [`read`]. Nothing here knows a model.
#![forbid(unsafe_code)]
// All output is returned to the caller: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]
// No mathematics of the platform: its last bit differs from one to the next (clippy.toml).
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]
#![cfg_attr(
    not(all(feature = "mat", feature = "mdf4", feature = "parquet")),
    allow(dead_code, reason = "what the formats share is not all used without one of them")
)]

pub mod channel_map;
mod column;
pub mod display_unit;
mod error;
pub mod excitation;
pub mod files;
pub mod formats;
pub mod guess;
mod header;
pub mod linkage;
pub mod recording;
pub mod seeded_noise;
mod signal;
mod static_table;
mod unit;
mod unit_in_name;

pub use channel_map::{ChannelMap, MapError, Mapping, PressureZero, Scale};
pub use error::RecordingError;
pub use formats::chunks::{PART_ROWS, Part, Parts};
pub use formats::format::{Format, MAX_BINARY_BYTES, MAX_UNPACKED_BYTES};
pub use formats::mark_fault::{MarkFault, MarkedCell};
pub use formats::memory::{ColumnInMemory, Held};
pub use formats::read::{in_parts, read, read_from, read_through};
pub use formats::sheet::{Series, WrittenColumn};
pub use formats::survey::{survey, survey_from};
pub use formats::surveyed::Surveyed;
pub use formats::text::lines::{MAX_COLUMNS, MAX_LINE_BYTES, MAX_ROWS, MAX_SKIPPED_LINES, MAX_VALUES};
pub use formats::text_fault::{TextFault, UnitClash};
pub use formats::unknown::{UnknownColumn, unknown_among, unknown_columns};
pub use formats::unsupported::Unsupported;
pub use linkage::Linkage;
pub use recording::{At, Column, FromAngle, Note, Recording, median_interval};
pub use signal::Signal;
pub use static_table::StaticTable;
pub use unit::{ATMOSPHERE_PA, Dimension, Unit};
