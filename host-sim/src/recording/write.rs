//! Writing a recording back in its own columns and units.

use super::{Recording, RecordingError, Signal};
use crate::atomic;
use crate::diagnostic::Place;
use std::io::{self, Write};
use std::path::Path;

impl Recording {
    /// Writes this recording with the values of some signals replaced, as a simulation does.
    ///
    /// One row for each row of the recording, its known columns in their order under their own
    /// headers and in their own units. `replaced` holds SI values, one for each row; a signal that
    /// the recording has no column for is left out. Separator is the comma and decimals have a
    /// point, whatever the recording used; ignored columns are not written. The file appears whole
    /// or not at all.
    pub fn write_csv(&self, path: &Path, replaced: &[(Signal, &[f64])]) -> Result<(), RecordingError> {
        let place = || Place::file(&path.display().to_string());
        for &(signal, values) in replaced {
            let header = signal.name().to_owned();
            if values.len() != self.rows() {
                let (found, expected) = (values.len(), self.rows());
                return Err(RecordingError::LengthMismatch { place: place(), header, found, expected });
            }
            if let Some(value) = values.iter().find(|value| !value.is_finite()) {
                return Err(RecordingError::NotFinite { place: place(), header, found: value.to_string() });
            }
        }
        atomic::write(path, |out| self.write_to(out, replaced))
            .map_err(|source| RecordingError::Write { place: place(), source })
    }

    fn write_to(&self, out: &mut dyn Write, replaced: &[(Signal, &[f64])]) -> io::Result<()> {
        let headers: Vec<_> = self.columns.iter().map(|column| quoted(&column.header)).collect();
        writeln!(out, "{}", headers.join(","))?;
        let values: Vec<&[f64]> = self
            .columns
            .iter()
            .map(|column| {
                let new = replaced.iter().find(|(signal, _)| *signal == column.signal);
                new.map_or(column.values.as_slice(), |(_, values)| values)
            })
            .collect();
        for row in 0..self.rows() {
            for (index, (column, values)) in self.columns.iter().zip(&values).enumerate() {
                let separator = if index == 0 { "" } else { "," };
                write!(out, "{separator}{}", column.unit.print(values[row]))?;
            }
            writeln!(out)?;
        }
        Ok(())
    }
}

/// A header, in quotation marks where it holds a separator or a quotation mark.
fn quoted(header: &str) -> String {
    if header.contains([',', ';', '\t', '"']) {
        format!("\"{}\"", header.replace('"', "\"\""))
    } else {
        header.to_owned()
    }
}
