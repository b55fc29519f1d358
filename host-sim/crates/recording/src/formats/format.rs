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

/// What files of a format are known by.
struct Row {
    /// Endings of their names.
    extensions: &'static [&'static str],
    /// Their first bytes; a text begins with anything.
    begins: &'static [u8],
    /// What messages call one.
    name: &'static str,
    /// The feature of the program that reads and writes them; `None` for what is always included.
    feature: Option<&'static str>,
}

impl Format {
    const ALL: [Self; 4] = [Self::Mat, Self::Mdf4, Self::Parquet, Self::Text];

    const fn row(self) -> Row {
        let (extensions, begins, name, feature): (&[&str], &[u8], _, _) = match self {
            Format::Text => (&["csv", "txt"], b"", "text", None),
            Format::Mat => (&["mat"], b"MATLAB 5.0 MAT-file", "a MAT-file", Some("mat")),
            Format::Mdf4 => (&["mf4"], b"MDF     ", "an MDF file", Some("mdf4")),
            Format::Parquet => (&["parquet"], b"PAR1", "a Parquet file", Some("parquet")),
        };
        Row { extensions, begins, name, feature }
    }

    /// The format whose files usually have this extension, in upper or lower case.
    #[must_use]
    pub fn of_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Self::ALL.into_iter().find(|format| format.row().extensions.contains(&extension.as_str()))
    }

    /// The format that the first bytes of a file show; text where they show none.
    pub(super) fn of_content(head: &[u8]) -> Result<Self, Unsupported> {
        for (begins, what) in UNSUPPORTED {
            if head.starts_with(begins) {
                return Err(what);
            }
        }
        Ok(Self::ALL.into_iter().find(|format| head.starts_with(format.row().begins)).unwrap_or(Format::Text))
    }

    /// The feature of the program that reads and writes this format; `None` for a format that is always included.
    #[must_use]
    pub fn feature(self) -> Option<&'static str> {
        self.row().feature
    }
}

/// Files that are not read, and why.
const UNSUPPORTED: [(&[u8], Unsupported); 3] = [
    (b"MATLAB 7.3 MAT-file", Unsupported::Hdf5),
    (b"\x89HDF\r\n\x1a\n", Unsupported::Hdf5),
    (b"UnFinMF ", Unsupported::Unfinished),
];

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.row().name)
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

    #[test]
    fn enough_of_a_file_is_read_to_know_its_format() {
        assert!(Format::ALL.iter().all(|format| format.row().begins.len() <= HEAD));
        assert!(UNSUPPORTED.iter().all(|(begins, _)| begins.len() <= HEAD));
    }
}
