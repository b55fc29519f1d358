//! Features of the formats that this program does not read.

use crate::files::source_error::quoted;

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
    /// A conversion of an MDF channel that gives no numbers, or is not computed; what it converts.
    Conversion(&'static str),
    /// A conversion of an MDF channel by a formula; the formula.
    Formula(String),
    /// A request to write a file of a format that is only read.
    Writing,
    /// Values that are stored in another file; the name of that file, as it stands in this one.
    Elsewhere(String),
    /// A file of another program or kind; what it is, and what to give instead.
    Foreign(&'static str, &'static str),
    /// A workbook in which several sheets hold a recording; their names.
    Sheets(Vec<String>),
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
            U::Conversion(what) => format!("a conversion {what}"),
            U::Formula(formula) => format!("a conversion by the formula {}", quoted(formula)),
            U::Writing => "the name of a file that is not written".into(),
            U::Elsewhere(name) => format!("values that stand in another file, `{name}`"),
            U::Foreign(what, _) => (*what).to_owned(),
            U::Sheets(names) => {
                let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
                format!("a workbook with times in the sheets {}", names.join(", "))
            }
            U::Layout(what) => format!("numbers as {what}"),
        }
    }

    /// What to do instead.
    pub(crate) fn expected(&self) -> &'static str {
        match self {
            U::Foreign(_, instead) => instead,
            U::Sheets(_) => "one recording a workbook: save each sheet as CSV or as a workbook of its own",
            U::Hdf5 => "a MAT-file of version 7: in MATLAB save('run.mat', '-v7', …), or export as CSV or Parquet",
            U::BigEndian => "a MAT-file saved on a PC",
            U::Unfinished => "a finished file: open it in the recorder's program, or asammdf, and save it",
            U::MdfVersion(_) => "version 4: in asammdf convert('4.10'), or export as CSV or Parquet",
            U::ColumnOriented => "data row by row: in asammdf convert('4.10')",
            U::Packing(_) => {
                "a file saved without packing, or by the usual one (Parquet: snappy, gzip, zstd or lz4; MDF: deflate)"
            }
            U::Conversion(_) | U::Formula(_) => {
                "a linear, rational or tabulated conversion, or converted values: asammdf exports them, as in MDF('run.mf4').export('parquet', \
                 'run'), or export as CSV in the program that recorded them"
            }
            U::Writing => "a name that ends with .csv, .mat or .parquet",
            U::Elsewhere(_) => "the file that holds the values itself",
            U::Layout(_) => "whole numbers of 1 to 64 bits, or floating ones of 16, 32 or 64",
        }
    }
}
