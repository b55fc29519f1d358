//! Writing a recording back in its own columns and units.

use super::{Recording, RecordingError, Signal, Unit};
use crate::atomic;
use crate::diagnostic::Place;
use std::io::{self, Write};
use std::path::Path;

impl Recording {
    /// Writes this recording with the values of some signals replaced and others added, as a simulation does.
    ///
    /// One row for each row of the file, its known columns in their order under their own headers and
    /// in their own units; signals that are `added` follow in SI units. `replaced` and `added` hold SI
    /// values, one for each row of the recording; a replaced signal that the recording has no column
    /// for is left out. A row that was left out in reading stands in its place with what it held, and
    /// with the replaced and added signals at its time, linear between the rows around it; where it has
    /// no time, or one outside the recording's, they are blank. Separator is the comma and decimals
    /// have a point, whatever the recording used; ignored columns are not written. The file appears
    /// whole or not at all.
    pub fn write_csv(&self, path: &Path, replaced: &[Series<'_>], added: &[Series<'_>]) -> Result<(), RecordingError> {
        let place = || Place::file(&path.display().to_string());
        for &(signal, values) in replaced.iter().chain(added) {
            let header = signal.name().to_owned();
            if values.len() != self.rows() {
                let (found, expected) = (values.len(), self.rows());
                return Err(RecordingError::LengthMismatch { place: place(), header, found, expected });
            }
            if let Some(value) = values.iter().find(|value| !value.is_finite()) {
                return Err(RecordingError::NotFinite { place: place(), header, found: value.to_string() });
            }
        }
        atomic::write(path, |out| self.write_to(out, replaced, added))
            .map_err(|source| RecordingError::Write { place: place(), source })
    }

    fn write_to(&self, out: &mut dyn Write, replaced: &[Series<'_>], added: &[Series<'_>]) -> io::Result<()> {
        let own = self.columns.iter().enumerate().map(|(index, column)| {
            let new = replaced.iter().find(|(signal, _)| *signal == column.signal);
            let (values, cell) = new.map_or((column.values.as_slice(), Some(index)), |(_, values)| (*values, None));
            Written { header: quoted(&column.header), unit: column.unit, values, cell }
        });
        let further = added.iter().map(|&(signal, values)| {
            let unit = signal.si_unit();
            Written { header: format!("{signal} [{unit}]"), unit, values, cell: None }
        });
        let columns: Vec<Written<'_>> = own.chain(further).collect();
        let headers: Vec<&str> = columns.iter().map(|column| column.header.as_str()).collect();
        writeln!(out, "{}", headers.join(","))?;
        let cells = self.left_out.cells.chunks_exact(self.columns.len());
        let mut left_out = self.left_out.after.iter().zip(cells).peekable();
        for row in 0..=self.rows() {
            while let Some((_, cells)) = left_out.next_if(|(after, _)| **after == row) {
                let at = cells[0].and_then(|time| self.between(time));
                let value = |column: &Written<'_>| match column.cell {
                    Some(index) => cells[index],
                    None => at.map(|(row, share)| mixed(column.values, row, share)),
                };
                write_row(out, &columns, value)?;
            }
            if row < self.rows() {
                write_row(out, &columns, |column| Some(column.values[row]))?;
            }
        }
        Ok(())
    }

    /// The row at or before a time, and the share of the way to the next one.
    fn between(&self, time: f64) -> Option<(usize, f64)> {
        let time_s = self.time_s();
        let row = time_s.partition_point(|&row| row <= time).checked_sub(1)?;
        match time_s.get(row + 1) {
            Some(next) => Some((row, (time - time_s[row]) / (next - time_s[row]))),
            None => (time <= time_s[row]).then_some((row, 0.0)),
        }
    }
}

/// A signal with one SI value for each row.
pub type Series<'a> = (Signal, &'a [f64]);

/// A column as it is written.
struct Written<'a> {
    header: String,
    unit: Unit,
    values: &'a [f64],
    /// Which cell of a row that was left out it shows; `None` for what is computed.
    cell: Option<usize>,
}

fn mixed(values: &[f64], row: usize, share: f64) -> f64 {
    if share > 0.0 { values[row] + share * (values[row + 1] - values[row]) } else { values[row] }
}

fn write_row(
    out: &mut dyn Write,
    columns: &[Written<'_>],
    value: impl Fn(&Written<'_>) -> Option<f64>,
) -> io::Result<()> {
    for (index, column) in columns.iter().enumerate() {
        let separator = if index == 0 { "" } else { "," };
        let text = value(column).map_or_else(String::new, |value| column.unit.print(value));
        write!(out, "{separator}{text}")?;
    }
    writeln!(out)
}

/// A header, in quotation marks where it holds a separator or a quotation mark.
fn quoted(header: &str) -> String {
    if header.contains([',', ';', '\t', '"']) {
        format!("\"{}\"", header.replace('"', "\"\""))
    } else {
        header.to_owned()
    }
}
