//! A drive as an FMU: a model that tools for co-simulation import, after the standard FMI, version 2.0 or 3.0.
//!
//! An FMU is an archive with a description of its variables, a shared library that computes them, and the files that the library
//! reads. The library is the same for every drive and both versions, and contains no drive: the drive is in a machine file in the archive.
//! This module holds what both sides share: the variables and the archive's contents. The library is the crate `drive-fmu`.

mod archive;
mod contents;
mod description;
mod library;
mod units;
mod variable;

use crc::{CRC_64_XZ, Crc};

pub use archive::{Version, pack};
pub use contents::{Contents, ContentsError, FmuError, Settings};
pub use description::MODEL_IDENTIFIER;
pub use library::{Library, LibraryError};
pub use variable::{Role, Variable};

/// A checksum of what a state of the drive depends on.
const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);

/// What the description, the library and a stored state must agree on: the library's version, the list of variables, and the drive with its tick and number type.
#[must_use]
pub fn token(contents: &Contents) -> String {
    let (version, source) = (env!("CARGO_PKG_VERSION"), contents.machine.source.name());
    format!("drive-fmu/{version}/{source}/{:016x}", fingerprint(contents))
}

/// A number that differs from drive to drive: of all values, of the tick and of the number type. What the drive is called does not matter.
#[must_use]
pub fn fingerprint(contents: &Contents) -> u64 {
    // Every value is in it with all its digits.
    CRC.checksum(format!("{:?} {:?}", contents.machine, contents.settings).as_bytes())
}
