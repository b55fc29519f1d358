//! A drive as an FMU: a model that tools for co-simulation import, by FMI 3.0.
//!
//! An FMU is an archive of a description of its variables, a shared library that computes them, and what the library
//! reads. The library is the same for every drive and knows nothing of any: the drive is in a machine file in the archive.
//! Here is what both sides have in common, the variables and the archive's contents; the library is the crate `drive-fmu`.

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

/// What the description and the library have to agree on: the library's version and which variables there are.
#[must_use]
pub fn token(source: Source) -> String {
    let source = match source {
        Source::Valve => "valve",
        Source::Pump => "pump",
    };
    format!("drive-fmu/{}/{source}", env!("CARGO_PKG_VERSION"))
}
