//! The archive of an FMU.

use std::env::consts::{ARCH, DLL_SUFFIX, OS};
use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::contents::{Contents, FmuError};
use super::description::{MODEL_IDENTIFIER, description};
use super::library::Library;

/// The bytes of an FMU: identical for the same drive and library. It holds one library, for the kind of computer that this program runs on.
///
/// # Errors
/// The drive's name or values cannot be written into one of its files.
pub fn pack(contents: &Contents, library: &Library) -> Result<Vec<u8>, FmuError> {
    let mut description = fmi_schema::serialize(&description(contents), false)?;
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
    archive.start_file(binary(), options.unix_permissions(0o755))?;
    archive.write_all(library.bytes())?;
    Ok(archive.finish()?.into_inner())
}

/// The path of the library in the archive: in the folder of this kind of computer, named as FMI requires.
fn binary() -> String {
    let system = if OS == "macos" { "darwin" } else { OS };
    format!("binaries/{ARCH}-{system}/{MODEL_IDENTIFIER}{DLL_SUFFIX}")
}
