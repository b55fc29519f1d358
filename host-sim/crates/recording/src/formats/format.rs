//! The file formats of recordings, recognised by the content of a file.
//!
//! In reading, the extension of the name does not choose the format; it only improves messages. In writing, it chooses the format.

use std::fmt;
use std::path::Path;

use super::unsupported::Unsupported;

/// Largest file of a format that is not text, in bytes: such a file is held in memory.
pub const MAX_BINARY_BYTES: u64 = 4 << 30;
/// Most bytes that packed data may take when unpacked: for a MAT-file all data together, for an MDF file those of a group that is read, for a
/// Parquet file those of a column.
pub const MAX_UNPACKED_BYTES: u64 = 1 << 30;

/// Number of bytes at the start of a file that show its format.
pub(super) const HEAD: usize = 20;

/// A format of recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Text with a separator, or the export of `TwinCAT` Scope.
    Text,
    /// MATLAB's MAT-file, version 5 or 7.
    Mat,
    /// ASAM MDF 4.
    Mdf4,
    /// Apache Parquet.
    Parquet,
}

impl Format {
    /// The format whose files usually have this extension, in upper or lower case.
    #[must_use]
    pub fn of_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "csv" | "txt" => Some(Format::Text),
            "mat" => Some(Format::Mat),
            "mf4" => Some(Format::Mdf4),
            "parquet" => Some(Format::Parquet),
            _ => None,
        }
    }

    /// The format that the first bytes of a file show; text where they show none.
    pub(super) fn of_content(head: &[u8]) -> Result<Self, Unsupported> {
        let starts = |magic: &[u8]| head.starts_with(magic);
        if starts(b"MATLAB 5.0 MAT-file") {
            Ok(Format::Mat)
        } else if starts(b"MATLAB 7.3 MAT-file") || starts(b"\x89HDF\r\n\x1a\n") {
            Err(Unsupported::Hdf5)
        } else if starts(b"MDF     ") {
            Ok(Format::Mdf4)
        } else if starts(b"UnFinMF ") {
            Err(Unsupported::Unfinished)
        } else if starts(b"PAR1") {
            Ok(Format::Parquet)
        } else {
            Ok(Format::Text)
        }
    }

    /// The feature of the program that reads and writes this format; `None` for a format that is always included.
    #[must_use]
    pub fn feature(self) -> Option<&'static str> {
        match self {
            Format::Text => None,
            Format::Mat => Some("mat"),
            Format::Mdf4 => Some("mdf4"),
            Format::Parquet => Some("parquet"),
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Format::Text => "text",
            Format::Mat => "a MAT-file",
            Format::Mdf4 => "an MDF file",
            Format::Parquet => "a Parquet file",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_content_tells_the_format_and_the_name_does_not() {
        assert_eq!(Format::of_content(b"MATLAB 5.0 MAT-file, P"), Ok(Format::Mat));
        assert_eq!(Format::of_content(b"MDF     4.10    asa"), Ok(Format::Mdf4));
        assert_eq!(Format::of_content(b"PAR1\x15\x04"), Ok(Format::Parquet));
        assert_eq!(Format::of_content(b"PAR"), Ok(Format::Text));
        assert_eq!(Format::of_content(b"\x89HDF\r\n\x1a\n"), Err(Unsupported::Hdf5));
        assert_eq!(Format::of_extension(Path::new("a.b/RUN.MF4")), Some(Format::Mdf4));
        assert_eq!(Format::of_extension(Path::new("mat")), None);
    }
}
