//! Tables without a clock: sweeps of a static bench in the order of their samples, means of runs, any other file with headers.
//!
//! Text as [`crate::formats::text::csv`] reads it, but no column need be time and no header need be a known signal with a known unit: columns
//! are found by their header, or by its part before the unit. Values stay in the file's own units.

use std::io::Read;
use std::path::Path;

use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::formats::source::open;
use crate::formats::text::decimal_mark::{DecimalMark, is_missing};
use crate::formats::text::heading::Heading;
use crate::formats::text::lines::{Input, Lines, most_rows};
use crate::recording::{At, Note};
use crate::signal::{Signal, split_header};
use crate::unit::{Dimension, Unit};

/// Columns of numbers under their headers.
#[derive(Clone, Debug, PartialEq)]
pub struct StaticTable {
    path: String,
    /// Header and values of each column that holds numbers.
    columns: Vec<(String, Vec<f64>)>,
    /// Rows that were left out because a cell was empty.
    pub incomplete: usize,
    /// What a user should know about how it was read.
    pub notes: Vec<Note>,
}

impl StaticTable {
    /// A table made in the program; all columns have the same length.
    #[must_use]
    pub fn new(path: &str, columns: Vec<(String, Vec<f64>)>) -> Self {
        Self { path: path.to_owned(), columns, incomplete: 0, notes: Vec::new() }
    }

    /// Reads a file. Rows with an empty cell are left out and counted.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let (name, file) = open(path)?;
        Self::read_from(&name, file)
    }

    /// Reads from any source; `name` stands for the file in messages.
    pub fn read_from(name: &str, input: impl Read) -> Result<Self, RecordingError> {
        Self::of_text(name, Box::new(input))
    }

    fn of_text(name: &str, input: Input<'_>) -> Result<Self, RecordingError> {
        let mut lines = Lines::new(name, input);
        let file = lines.file();
        let (mut heading, mut splitter) = Heading::read(&mut lines)?;
        heading.look_below(&mut lines, &mut splitter)?;
        let mut columns: Vec<(String, Vec<f64>)> =
            heading.offers().into_iter().map(|offer| (offer.header, Vec::new())).collect();
        let mut mark = DecimalMark::new(heading.separator);
        let (mut rows, mut incomplete) = (0, 0);
        while let Some(line) = lines.next()? {
            let cells = splitter.split(line)?;
            let (found, expected) = (cells.len(), columns.len());
            if found < expected || (expected..found).any(|index| !cells.get(index).is_empty()) {
                return Err(RecordingError::RaggedRow { place: line.whole(), found, expected });
            }
            let most = most_rows(expected);
            if rows == most {
                return Err(RecordingError::TooManyRows { place: line.whole(), most });
            }
            rows += 1;
            if (0..expected).any(|index| is_missing(cells.get(index))) {
                incomplete += 1;
                continue;
            }
            for (index, (header, values)) in columns.iter_mut().enumerate() {
                let text = cells.get(index);
                let value = mark.number(line, header, text, index)?;
                if !value.is_finite() {
                    let (place, header) = (line.cell(heading.separator, index), header.clone());
                    return Err(RecordingError::NotFinite { place, header, found: text.to_owned() });
                }
                values.push(value);
            }
        }
        mark.check()?;
        let kept = rows - incomplete;
        if kept < 2 {
            return Err(RecordingError::TooFewRows { place: file, rows: kept, skipped: incomplete });
        }
        let notes = lines.western().map(|line| Note::ReadAsWindows1252 { first: At::Line(line) });
        Ok(Self { path: name.to_owned(), columns, incomplete, notes: notes.into_iter().collect() })
    }

    /// The file's name without its folder.
    #[must_use]
    pub fn name(&self) -> &str {
        Path::new(&self.path).file_name().and_then(|name| name.to_str()).unwrap_or(&self.path)
    }

    /// Headers and values, in the order of the file.
    #[must_use]
    pub fn columns(&self) -> &[(String, Vec<f64>)] {
        &self.columns
    }

    /// How many rows there are.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, values)| values.len())
    }

    /// The column of this header, with or without its unit.
    pub fn column(&self, header: &str) -> Result<(&str, &[f64]), RecordingError> {
        let exact = self.columns.iter().find(|(own, _)| own == header);
        let named = || self.columns.iter().find(|(own, _)| split_header(own).0 == header);
        let (own, values) = exact.or_else(named).ok_or_else(|| RecordingError::ColumnAbsent {
            place: Place::file(&self.path),
            header: header.to_owned(),
            present: self.columns.iter().map(|(header, _)| header.clone()).collect(),
        })?;
        Ok((own, values))
    }

    /// The times, s, if a column is a clock.
    #[must_use]
    pub fn clock_s(&self) -> Option<Vec<f64>> {
        self.columns.iter().find_map(|(header, values)| {
            let (name, unit) = split_header(header);
            let unit = Unit::parse(unit?).filter(|unit| unit.dimension() == Dimension::Time)?;
            (Signal::parse(name) == Some(Signal::Time)).then(|| values.iter().map(|&value| unit.to_si(value)).collect())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<StaticTable, RecordingError> {
        StaticTable::read_from("sweep.csv", text.as_bytes())
    }

    #[test]
    fn a_table_needs_no_clock_and_no_known_names() {
        let table = read("order,I_soll [mA],Q\n0,1.5,-2\n1,,3\n2,2.5,4\n").unwrap();
        assert_eq!(table.column("I_soll").unwrap(), ("I_soll [mA]", [1.5, 2.5].as_slice()));
        assert_eq!((table.rows(), table.incomplete, table.clock_s()), (2, 1, None));
        assert_eq!(read("time [ms],x\n0,1\n10,2\n").unwrap().clock_s(), Some(vec![0.0, 0.01]));
        assert!(read("time [bar],x\n0,1\n10,2\n").unwrap().clock_s().is_none());
    }

    #[test]
    fn what_cannot_be_read_says_where() {
        let line = |text| crate::files::source_error::Explained::place(&read(text).unwrap_err()).line();
        assert_eq!(line("a,b\n1,2\n1,x\n"), Some(3));
        assert_eq!(line("a,b\n1,2\n1\n"), Some(3));
        assert_eq!(line("a,b\n1,inf\n"), Some(2));
        let absent = read("a,b\n1,2\n3,4\n").unwrap().column("c").unwrap_err().to_string();
        assert!(absent.contains("`c` is not a column") && absent.contains("a, b"), "{absent}");
        assert!(matches!(read("a\n1\n"), Err(RecordingError::TooFewRows { .. })));
    }
}
