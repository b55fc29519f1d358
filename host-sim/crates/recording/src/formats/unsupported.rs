//! Features of the formats that this program does not read.

/// A feature of a file that is not read, and what to do instead.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unsupported {
    /// MATLAB's version 7.3, or any other HDF5 file.
    Hdf5,
    /// A MAT-file of a processor that writes the high byte first (big-endian).
    BigEndian,
    /// An MDF file that its recorder has not closed.
    Unfinished,
    /// An MDF file of another version than 4; its version.
    MdfVersion(String),
    /// Data of an MDF file that are stored column by column, as version 4.2 allows.
    ColumnOriented,
    /// An unsupported compression; its name or number.
    Packing(String),
    /// A conversion of an MDF channel that is not a numeric formula; its number in the standard.
    Conversion(u8),
    /// A request to write an MDF file.
    Writing,
    /// Values that are stored in another file; the name of that file, as it stands in this one.
    Elsewhere(String),
    /// A number with an unusual layout; a description of it.
    Layout(String),
}

use Unsupported as U;

impl Unsupported {
    /// What was found.
    pub(crate) fn found(&self) -> String {
        match self {
            U::Hdf5 => "an HDF5 file, as MATLAB's version 7.3 is".into(),
            U::BigEndian => "a MAT-file with the high byte first".into(),
            U::Unfinished => "an MDF file that its recorder has not closed".into(),
            U::MdfVersion(version) => format!("an MDF file of version {version}"),
            U::ColumnOriented => "data that stand column by column".into(),
            U::Packing(name) => format!("data packed by {name}"),
            U::Conversion(kind) => format!("a conversion of type {kind}"),
            U::Writing => "the name of an MDF file, which is not written".into(),
            U::Elsewhere(name) => format!("values that stand in another file, `{name}`"),
            U::Layout(what) => format!("numbers as {what}"),
        }
    }

    /// What to do instead.
    pub(crate) fn expected(&self) -> &'static str {
        match self {
            U::Hdf5 => "a MAT-file of version 7: in MATLAB save('run.mat', '-v7', …), or export as CSV or Parquet",
            U::BigEndian => "a MAT-file saved on a PC",
            U::Unfinished => "a finished file: open it in the recorder's program, or asammdf, and save it",
            U::MdfVersion(_) => "version 4: in asammdf convert('4.10'), or export as CSV or Parquet",
            U::ColumnOriented => "data row by row: in asammdf convert('4.10')",
            U::Packing(_) => {
                "a file saved without packing, or by the usual one (Parquet: snappy, gzip, zstd or lz4; MDF: deflate)"
            }
            U::Conversion(_) => "the numbers themselves, or a linear, rational or tabulated conversion of them",
            U::Writing => "a name that ends with .csv, .mat or .parquet",
            U::Elsewhere(_) => "the file that holds the values itself",
            U::Layout(_) => "whole numbers of 8 to 64 bits, or floating ones of 32 or 64",
        }
    }
}
