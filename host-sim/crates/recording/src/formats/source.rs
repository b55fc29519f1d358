//! Where a recording comes from: a file, or the bytes of any other source.

use std::fs::File;
use std::io;
#[cfg(any(feature = "mat", feature = "mdf4", feature = "parquet", feature = "xlsx"))]
use std::io::Read;
use std::path::Path;

#[cfg(any(feature = "mat", feature = "mdf4", feature = "parquet", feature = "xlsx"))]
use super::format::MAX_BINARY_BYTES;
use crate::error::RecordingError;
use crate::files::source_error::Place;

/// Opens a file; also gives its name for messages.
pub(crate) fn open(path: &Path) -> Result<(String, File), RecordingError> {
    let name = path.display().to_string();
    match File::open(path) {
        Ok(file) => Ok((name, file)),
        Err(source) => Err(unreadable(&name, source)),
    }
}

pub(crate) fn unreadable(name: &str, source: io::Error) -> RecordingError {
    RecordingError::Io { place: Place::file(name), source }
}

/// All bytes of a file that is not text.
#[cfg(any(feature = "mat", feature = "mdf4", feature = "parquet", feature = "xlsx"))]
pub(crate) fn held(name: &str, packed: impl Read) -> Result<Vec<u8>, RecordingError> {
    let mut bytes = Vec::new();
    packed.take(MAX_BINARY_BYTES + 1).read_to_end(&mut bytes).map_err(|source| unreadable(name, source))?;
    if bytes.len() as u64 > MAX_BINARY_BYTES {
        return Err(RecordingError::TooLarge { place: Place::file(name), most_bytes: MAX_BINARY_BYTES });
    }
    Ok(bytes)
}
