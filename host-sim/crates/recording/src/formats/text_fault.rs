//! What can be wrong with the layout of a text: its separator, its units, its times and what stands below its rows.

use crate::files::source_error::{Place, quoted};

/// What is wrong with the layout of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TextFault {
    /// A column has one unit in its name and another one beside it.
    UnitsDiffer {
        /// Its header.
        header: String,
        /// The two units.
        units: Box<UnitClash>,
    },
    /// The header has no separator.
    NoSeparator {
        /// Whether it looks as if blanks separated its cells.
        has_blanks: bool,
    },
    /// Times in a form that is not read; the header and the first cell of the column.
    UnreadableTime {
        /// The header of the column.
        header: String,
        /// Its first cell.
        found: String,
    },
    /// A line of words among the rows of numbers or below them; its first words.
    Words(String),
}

/// The unit in the name of a column, and another one that the file gives beside it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnitClash {
    /// The unit in the name.
    pub in_name: String,
    /// The unit in a row of units.
    pub beside: String,
    /// Where that one stands, if it is known.
    pub beside_at: Option<Place>,
}

use TextFault as F;

impl TextFault {
    /// What was found.
    pub(crate) fn found(&self) -> String {
        match self {
            F::UnitsDiffer { header, units } => {
                let at = units.beside_at.as_ref().and_then(|place| place.spot.as_ref());
                let at = at.map_or_else(String::new, |spot| format!(", line {} column {}", spot.line, spot.column));
                let (in_name, beside) = (quoted(&units.in_name), quoted(&units.beside));
                format!(
                    "column {} has the unit {in_name} in its name and {beside} in the row of units{at}",
                    quoted(header)
                )
            }
            F::NoSeparator { has_blanks: true } => "a header whose cells seem to be separated by blanks".into(),
            F::NoSeparator { has_blanks: false } => {
                "a header of one cell, without a comma, semicolon, tab or `|`".into()
            }
            F::UnreadableTime { header, found } if found.contains('/') => {
                format!(
                    "column {} holds {}, in which the day or the month may stand first",
                    quoted(header),
                    quoted(found)
                )
            }
            F::UnreadableTime { header, found } => format!("column {} holds {}", quoted(header), quoted(found)),
            F::Words(found) => format!("a line of words, {}, where a row of numbers should be", quoted(found)),
        }
    }

    /// What to do.
    pub(crate) fn expected(&self) -> &'static str {
        match self {
            F::UnitsDiffer { .. } => "one unit: correct the header or the row of units",
            F::NoSeparator { .. } => {
                "a comma, semicolon, tab or `|` between the cells of every line, among them `time [s]`: replace the blanks, or name another mark in a \
                 line such as `sep=:` above the header. Other lines above the header begin with `#`"
            }
            F::UnreadableTime { .. } => {
                "times such as 2024-05-06T07:08:09.125, 06.05.2024 07:08:09,125 or 07:08:09.125, or a column `time [s]` of numbers"
            }
            F::Words(_) => "rows of numbers up to the end: delete the line, or begin it with `#`",
        }
    }
}
