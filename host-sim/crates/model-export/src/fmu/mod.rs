//! A drive as an FMU: a model that tools for co-simulation import, after the standard FMI 3.0.
//!
//! An FMU is an archive with a description of its variables, a shared library that computes them, and the files that the library
//! reads. The library is the same for every drive and contains none: the drive is in a machine file in the archive.
//! This module holds what both sides share: the variables and the archive's contents. The library is the crate `drive-fmu`.

mod archive;
mod contents;
mod description;
mod library;
mod units;
mod variable;

use model_core::machine::Source;

pub use archive::pack;
pub use contents::{Contents, ContentsError, FmuError, Settings};
pub use description::{MODEL_IDENTIFIER, description};
pub use library::{Library, LibraryError};
pub use variable::{Role, Variable};

/// What the description and the library must agree on: the library's version and the list of variables.
#[must_use]
pub fn token(source: Source) -> String {
    format!("drive-fmu/{}/{}", env!("CARGO_PKG_VERSION"), source.name())
}
