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
    /// MATLAB's MAT-file, version 4, 5 or 7.
    Mat,
    /// ASAM MDF 4.
    Mdf4,
    /// Apache Parquet.
    Parquet,
    /// An Excel workbook, or another archive of its kind.
    Xlsx,
    /// Any of these, packed by gzip.
    Gzip,
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
    const ALL: [Self; 6] = [Self::Mat, Self::Mdf4, Self::Parquet, Self::Xlsx, Self::Gzip, Self::Text];

    const fn row(self) -> Row {
        let (extensions, begins, name, feature): (&[&str], &[u8], _, _) = match self {
            Format::Text => (&["csv", "txt"], b"", "text", None),
            Format::Mat => (&["mat"], b"MATLAB 5.0 MAT-file", "a MAT-file", Some("mat")),
            Format::Mdf4 => (&["mf4"], b"MDF     ", "an MDF file", Some("mdf4")),
            Format::Parquet => (&["parquet"], b"PAR1", "a Parquet file", Some("parquet")),
            Format::Xlsx => (&["xlsx"], b"PK\x03\x04", "an Excel workbook", Some("xlsx")),
            Format::Gzip => (&["gz"], b"\x1f\x8b", "a file packed by gzip", Some("gzip")),
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
        if is_version_4(head) {
            return Ok(Format::Mat);
        }
        Ok(Self::ALL.into_iter().find(|format| head.starts_with(format.row().begins)).unwrap_or(Format::Text))
    }

    /// The feature of the program that reads and writes this format; `None` for a format that is always included.
    #[must_use]
    pub fn feature(self) -> Option<&'static str> {
        self.row().feature
    }
}

/// Bytes of the five words with which a MAT-file of version 4 begins.
pub(super) const VERSION_4_HEAD: usize = 20;

/// Whether these are the first bytes of a MAT-file of version 4, which has no word of its own at its beginning: a small number with known digits, whether its
/// first matrix is complex, and a length of its name. No text begins so, because a byte of the first number is zero.
pub(super) fn is_version_4(head: &[u8]) -> bool {
    let Some(words) = head.get(..VERSION_4_HEAD).map(|head| head.as_chunks::<4>().0) else { return false };
    [u32::from_le_bytes, u32::from_be_bytes].into_iter().any(|word| {
        let [kind, _, _, complex, name] = [0, 1, 2, 3, 4].map(|index| word(words[index]));
        let known = kind < 5000 && kind / 100 % 10 == 0 && kind / 10 % 10 <= 5 && kind % 10 <= 2;
        known && complex <= 1 && (2..=4096).contains(&name)
    })
}

const SAVED: &str = "what is read: save it as CSV or .xlsx";
const UNPACKED: &str = "what is read: unpack it, or pack it by gzip";
const EXPORTED: &str = "what is read: export CSV, MAT, MDF 4 or Parquet in the program that recorded it";
const NUMBERS: &str = "the numbers: CSV or .xlsx from the program that wrote it";
const IN_UTF_8: &str = "text in UTF-8, as by `iconv -f UTF-32 -t UTF-8 in.csv > out.csv`";
const FROM_JSON: &str = "what is read: in Python pandas.read_json('run.json').to_csv('run.csv', index=False)";
const FROM_PYTHON: &str = "what is read: in Python df.to_parquet('run.parquet') or df.to_csv('run.csv')";

/// Files that are not read, and why.
const UNSUPPORTED: [(&[u8], Unsupported); 36] = [
    (b"MATLAB 7.3 MAT-file", Unsupported::Hdf5),
    (b"\x89HDF\r\n\x1a\n", Unsupported::Hdf5),
    (b"UnFinMF ", Unsupported::Unfinished),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", Unsupported::Foreign("an Excel 97 workbook (.xls)", SAVED)),
    (b"<?xml", Unsupported::Foreign("an XML file", "CSV or .xlsx, saved by the program that wrote it")),
    (b"<html", Unsupported::Foreign("an HTML page", "CSV or .xlsx, saved by the program that wrote it")),
    (b"%PDF", Unsupported::Foreign("a PDF document", NUMBERS)),
    (b"BZh", Unsupported::Foreign("a file packed by bzip2", UNPACKED)),
    (b"\xfd7zXZ\0", Unsupported::Foreign("a file packed by xz", UNPACKED)),
    (b"\x28\xb5\x2f\xfd", Unsupported::Foreign("a file packed by zstd", UNPACKED)),
    (b"7z\xbc\xaf\x27\x1c", Unsupported::Foreign("a 7z archive", UNPACKED)),
    (b"Rar!\x1a", Unsupported::Foreign("a RAR archive", UNPACKED)),
    (b"TDSm", Unsupported::Foreign("a TDMS file of LabVIEW", EXPORTED)),
    (b"LOGG", Unsupported::Foreign("a bus log of Vector (.blf)", EXPORTED)),
    (b"#ROSBAG", Unsupported::Foreign("a ROS bag", EXPORTED)),
    (b"\x89MCAP0\r\n", Unsupported::Foreign("an MCAP file", EXPORTED)),
    (b"SQLite format 3\0", Unsupported::Foreign("a database of SQLite", EXPORTED)),
    (b"ARROW1", Unsupported::Foreign("a file of Arrow or Feather", FROM_PYTHON)),
    (b"Obj\x01", Unsupported::Foreign("an Avro file", FROM_PYTHON)),
    (b"\x93NUMPY", Unsupported::Foreign("an array of NumPy", FROM_PYTHON)),
    (b"\x80\x03", Unsupported::Foreign("an object of Python (pickle)", FROM_PYTHON)),
    (b"\x80\x04", Unsupported::Foreign("an object of Python (pickle)", FROM_PYTHON)),
    (b"\x80\x05", Unsupported::Foreign("an object of Python (pickle)", FROM_PYTHON)),
    (b"\xff\xfe\0\0", Unsupported::Foreign("a text in UTF-32", IN_UTF_8)),
    (b"\0\0\xfe\xff", Unsupported::Foreign("a text in UTF-32", IN_UTF_8)),
    (b"\x89PNG\r\n\x1a\n", Unsupported::Foreign("a picture (PNG)", NUMBERS)),
    (b"\xff\xd8\xff", Unsupported::Foreign("a picture (JPEG)", NUMBERS)),
    (b"GIF8", Unsupported::Foreign("a picture (GIF)", NUMBERS)),
    (b"{\\rtf", Unsupported::Foreign("a document (RTF)", NUMBERS)),
    (b"\x7fELF", Unsupported::Foreign("a program", "a recording")),
    (b"MZ\x90\0", Unsupported::Foreign("a program", "a recording")),
    (b"{\"", Unsupported::Foreign("a JSON file", FROM_JSON)),
    (b"{\n", Unsupported::Foreign("a JSON file", FROM_JSON)),
    (b"{\r\n", Unsupported::Foreign("a JSON file", FROM_JSON)),
    (b"[{", Unsupported::Foreign("a JSON file", FROM_JSON)),
    (b"PK\x05\x06", Unsupported::Foreign("an empty ZIP archive", "the recording itself")),
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
        let version_4 = |kind: [u8; 4], name: [u8; 4]| [kind, [9; 4], [1; 4], [0; 4], name].concat();
        assert_eq!(Format::of_content(&version_4([0; 4], [7, 0, 0, 0])), Ok(Format::Mat));
        assert_eq!(Format::of_content(&version_4([0, 0, 3, 0xf2], [0, 0, 0, 7])), Ok(Format::Mat));
        assert_eq!(Format::of_content(&version_4([0; 4], [0; 4])), Ok(Format::Text));
        assert_eq!(Format::of_content(b"PK\x03\x04"), Ok(Format::Xlsx));
        assert_eq!(Format::of_content(b"\x1f\x8b\x08"), Ok(Format::Gzip));
        assert_eq!(Format::of_content(b"\x89HDF\r\n\x1a\n"), Err(Unsupported::Hdf5));
        for (head, what) in [
            (&b"\x89PNG\r\n\x1a\n\0"[..], "a picture (PNG)"),
            (b"{\"time\": [0]}", "a JSON file"),
            (b"\xff\xfe\0\0t", "a text in UTF-32"),
        ] {
            assert!(matches!(Format::of_content(head), Err(Unsupported::Foreign(found, _)) if found == what));
        }
        assert_eq!(Format::of_extension(Path::new("a.b/RUN.MF4")), Some(Format::Mdf4));
        assert_eq!(Format::of_extension(Path::new("mat")), None);
    }

    #[test]
    fn enough_of_a_file_is_read_to_know_its_format() {
        assert!(Format::ALL.iter().all(|format| format.row().begins.len() <= HEAD));
        assert!(UNSUPPORTED.iter().all(|(begins, _)| begins.len() <= HEAD));
    }
}
