//! The table of a recording as it is written: its own columns in their units, with replaced and added signals.

use std::io::{self, Write};
use std::ops::Range;

use super::resample::{on_line, share_of};
use crate::recording::Recording;
use crate::signal::Signal;
use crate::unit::Unit;

impl Recording {
    /// The columns of the file with their present values, followed by the added signals.
    pub(super) fn sheet<'a>(&'a self, replaced: &[Series<'a>], added: &[Series<'a>]) -> Sheet<'a> {
        let own = self.columns.iter().enumerate().map(|(index, column)| {
            let new = replaced.iter().find(|(signal, _)| *signal == column.signal);
            let (values, cell) = new.map_or((column.values.as_slice(), Some(index)), |(_, values)| (*values, None));
            Written { recording: self, header: column.header.clone(), unit: column.unit, values, cell }
        });
        let further = added.iter().map(|&(signal, values)| {
            let unit = signal.si_unit();
            Written { recording: self, header: format!("{signal} [{unit}]"), unit, values, cell: None }
        });
        Sheet { recording: self, columns: own.chain(further).collect() }
    }

    /// Rows of the file in their order; each row that was left out comes together with the row after it.
    fn rows_of_the_file(&self, rows: Range<usize>) -> impl Iterator<Item = Row> {
        let before = self.left_out.after.partition_point(|&after| after < rows.start);
        let mut left_out = self.left_out.after.iter().enumerate().skip(before).peekable();
        let end = if rows.end == self.rows() { rows.end + 1 } else { rows.end };
        (rows.start..end).flat_map(move |row| {
            let mut rows = Vec::new();
            while let Some((index, _)) = left_out.next_if(|(_, after)| **after == row) {
                rows.push(Row::LeftOut(index));
            }
            rows.into_iter().chain((row < self.rows()).then_some(Row::Read(row)))
        })
    }

    /// The row at or before a time, and the fraction of the interval to the next row.
    fn between(&self, time: f64) -> Option<(usize, f64)> {
        let time_s = self.time_s();
        let row = time_s.partition_point(|&row| row <= time).checked_sub(1)?;
        match time_s.get(row + 1) {
            Some(&next) => Some((row, share_of(time_s[row], next, time))),
            None => (time <= time_s[row]).then_some((row, 0.0)),
        }
    }
}

/// A signal with one SI value for each row.
pub type Series<'a> = (Signal, &'a [f64]);

/// The header and the values of a column as it is written, in its unit; `None` where a cell is blank.
pub type WrittenColumn = (String, Vec<Option<f64>>);

/// A table as it is written.
pub(crate) struct Sheet<'a> {
    recording: &'a Recording,
    pub(crate) columns: Vec<Written<'a>>,
}

/// A column as it is written.
pub(crate) struct Written<'a> {
    recording: &'a Recording,
    pub(crate) header: String,
    pub(crate) unit: Unit,
    /// SI, one for each row that was read.
    values: &'a [f64],
    /// Index of its cell in rows that were left out, where it has one there.
    cell: Option<usize>,
}

/// A row of the file.
#[derive(Clone, Copy)]
enum Row {
    /// A row that was read; its index among those.
    Read(usize),
    /// A row that was left out; its index among those.
    LeftOut(usize),
}

impl Written<'_> {
    /// Its value in a row, SI.
    fn si(&self, row: Row) -> Option<f64> {
        let index = match row {
            Row::Read(row) => return Some(self.values[row]),
            Row::LeftOut(index) => index,
        };
        let width = self.recording.columns.len();
        let cells = &self.recording.left_out.cells[index * width..][..width];
        if let Some(cell) = self.cell {
            return cells[cell];
        }
        let (row, share) = self.recording.between(cells[0]?)?;
        mixed(self.values, row, share)
    }

    /// The value of each row in the column's unit: bit for bit the number that a text would hold.
    pub(crate) fn values(&self) -> impl Iterator<Item = Option<f64>> {
        self.recording
            .rows_of_the_file(0..self.recording.rows())
            .map(|row| self.si(row).and_then(|si| self.unit.print(si).parse().ok()))
    }
}

impl Sheet<'_> {
    pub(super) fn write_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        self.write_header(out)?;
        self.write_rows(0..self.recording.rows(), out)
    }

    pub(super) fn write_header(&self, out: &mut dyn Write) -> io::Result<()> {
        let headers: Vec<String> = self.columns.iter().map(|column| quoted(&column.header)).collect();
        writeln!(out, "{}", headers.join(","))
    }

    pub(super) fn write_rows(&self, rows: Range<usize>, out: &mut dyn Write) -> io::Result<()> {
        for row in self.recording.rows_of_the_file(rows) {
            for (index, column) in self.columns.iter().enumerate() {
                let separator = if index == 0 { "" } else { "," };
                let text = column.si(row).map_or_else(String::new, |si| column.unit.print(si));
                write!(out, "{separator}{text}")?;
            }
            writeln!(out)?;
        }
        Ok(())
    }
}

/// The value interpolated between a row and the next by `share`; none beyond the end.
fn mixed(values: &[f64], row: usize, share: f64) -> Option<f64> {
    let from = *values.get(row)?;
    if share > 0.0 { Some(on_line(from, *values.get(row + 1)?, share)) } else { Some(from) }
}

/// A header on one line; in quotation marks where it contains a separator or a quotation mark.
pub fn quoted(header: &str) -> String {
    let header = header.replace(|character: char| character.is_control() && character != '\t', " ");
    if header.contains([',', ';', '\t', '"']) { format!("\"{}\"", header.replace('"', "\"\"")) } else { header }
}
