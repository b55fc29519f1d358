//! The archive of an FMU.

use std::env::consts::{ARCH, DLL_SUFFIX, OS};
use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::contents::{Contents, FmuError};
use super::description::{MODEL_IDENTIFIER, fmi2, fmi3};
use super::library::Library;

/// A version of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    #[default]
    Three,
}

/// The bytes of an FMU: identical for the same drive, version and library. It holds one library, for the kind of computer that this program runs on.
///
/// # Errors
/// The drive's name or values cannot be written into one of its files.
pub fn pack(contents: &Contents, version: Version, library: &Library) -> Result<Vec<u8>, FmuError> {
    let mut description = match version {
        Version::Two => fmi_schema::serialize(&fmi2::description(contents), false)?,
        Version::Three => fmi_schema::serialize(&fmi3::description(contents), false)?,
    };
    description.push('\n');
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::DEFAULT)
        .unix_permissions(0o644);
    // First in the archive: a tool that only wants to identify the FMU need not read further.
    archive.start_file("modelDescription.xml", options)?;
    archive.write_all(description.as_bytes())?;
    for (name, bytes) in contents.resources()? {
        archive.start_file(format!("resources/{name}"), options)?;
        archive.write_all(&bytes)?;
    }
    archive.start_file(binary(version), options.unix_permissions(0o755))?;
    archive.write_all(library.bytes())?;
    Ok(archive.finish()?.into_inner())
}

/// The path of the library in the archive: in the folder of this kind of computer, named as this version requires.
fn binary(version: Version) -> String {
    let folder = match (version, OS) {
        (Version::Two, "windows") => format!("win{}", usize::BITS),
        // Its names are for x86, but tools look there on other processors too, and not everywhere else.
        (Version::Two, system) => format!("{}{}", named(system), usize::BITS),
        (Version::Three, system) => format!("{ARCH}-{}", named(system)),
    };
    format!("binaries/{folder}/{MODEL_IDENTIFIER}{DLL_SUFFIX}")
}

/// A system as the standard calls it.
fn named(system: &str) -> &str {
    if system == "macos" { "darwin" } else { system }
}
