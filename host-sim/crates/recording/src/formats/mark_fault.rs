//! What can be wrong with the decimal mark in a number of a text.

use crate::files::source_error::quoted;

/// What is wrong with the mark in a number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MarkFault {
    /// A cell before it has the other decimal mark.
    Other(Box<MarkedCell>),
    /// It has a thousands mark.
    Thousands,
    /// No number of the file tells whether its mark is a decimal or a thousands mark.
    Unknown,
}

/// A cell with a decimal mark.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MarkedCell {
    /// The number of its line.
    pub line: usize,
    /// The header of its column.
    pub header: String,
    /// What it holds.
    pub text: String,
}

impl MarkFault {
    /// What is to be said of the cell `found` beside what it holds.
    pub(crate) fn found(&self, found: &str) -> String {
        let mark = |text: &str| if text.contains(',') { "comma" } else { "point" };
        match self {
            MarkFault::Other(other) => format!(
                " with a {}, and column {} holds {} with a {} in line {}",
                mark(found),
                quoted(&other.header),
                quoted(&other.text),
                mark(&other.text),
                other.line
            ),
            MarkFault::Thousands => ", with a thousands mark".to_owned(),
            MarkFault::Unknown => {
                let (decimal, whole) = (found.replace(',', "."), found.replace([',', '.'], ""));
                format!(", and no number of the file tells whether this is {decimal} or {whole}")
            }
        }
    }

    /// What to do; numbers of a workbook have a point, whatever it shows.
    pub(crate) fn expected(&self, is_workbook: bool) -> &'static str {
        match self {
            MarkFault::Other(_) if is_workbook => {
                "one decimal mark in the whole file: make numbers of the cells that are text; numbers of a workbook have a point here, whatever it shows"
            }
            MarkFault::Other(_) => "one decimal mark in the whole file and no thousands mark: 1300 is written so",
            MarkFault::Thousands => "a number without it: 1300 is written so",
            MarkFault::Unknown => {
                "numbers that tell it: without thousands marks, and with other than three digits behind the decimal mark"
            }
        }
    }
}
