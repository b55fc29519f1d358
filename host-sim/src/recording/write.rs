//! Writing a recording back in its own columns and units.

use super::format::Format;
use super::sampled::{on_line, share_of};
use super::unsupported::Unsupported;
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
        let sheet = self.checked(path, replaced, added)?;
        atomic::write(path, |out| sheet.write_csv(out))
            .map_err(|source| RecordingError::Write { place: Place::file(&path.display().to_string()), source })
    }

    /// As [`Self::write_csv`], in the format that the file's name asks for: `.mat` and `.parquet`, in letters of any size; CSV otherwise.
    ///
    /// What is blank in CSV is NaN in a MAT-file and null in Parquet.
    pub fn write(&self, path: &Path, replaced: &[Series<'_>], added: &[Series<'_>]) -> Result<(), RecordingError> {
        match Format::of_extension(path) {
            #[cfg(feature = "mat")]
            Some(Format::Mat) => self.write_packed(path, replaced, added, super::mat::write),
            #[cfg(feature = "parquet")]
            Some(Format::Parquet) => self.write_packed(path, replaced, added, super::parquet::write),
            #[allow(unreachable_patterns, reason = "reached where the program was built without a feature")]
            Some(format @ (Format::Mat | Format::Parquet)) => {
                Err(RecordingError::FeatureAbsent { place: Place::file(&path.display().to_string()), format })
            }
            Some(Format::Mdf4) => {
                let (place, what) = (Place::file(&path.display().to_string()), Unsupported::Writing);
                Err(RecordingError::Unsupported { place, what })
            }
            Some(Format::Text) | None => self.write_csv(path, replaced, added),
        }
    }

    /// Writes the bytes that a format makes of the table.
    #[cfg(any(feature = "mat", feature = "parquet"))]
    fn write_packed(
        &self,
        path: &Path,
        replaced: &[Series<'_>],
        added: &[Series<'_>],
        packed: fn(&Sheet) -> io::Result<Vec<u8>>,
    ) -> Result<(), RecordingError> {
        let bytes = packed(&self.checked(path, replaced, added)?);
        atomic::write(path, |out| out.write_all(&bytes?))
            .map_err(|source| RecordingError::Write { place: Place::file(&path.display().to_string()), source })
    }

    /// What is to be written, once every series is as long as the recording and finite.
    fn checked(&self, path: &Path, replaced: &[Series<'_>], added: &[Series<'_>]) -> Result<Sheet, RecordingError> {
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
        Ok(self.sheet(replaced, added))
    }

    /// Every row of the file with what it holds now, column by column.
    fn sheet(&self, replaced: &[Series<'_>], added: &[Series<'_>]) -> Sheet {
        let own = self.columns.iter().enumerate().map(|(index, column)| {
            let new = replaced.iter().find(|(signal, _)| *signal == column.signal);
            let (values, cell) = new.map_or((column.values.as_slice(), Some(index)), |(_, values)| (*values, None));
            (column.header.clone(), column.unit, values, cell)
        });
        let further = added.iter().map(|&(signal, values)| {
            let unit = signal.si_unit();
            (format!("{signal} [{unit}]"), unit, values, None)
        });
        let columns = own.chain(further).map(|(header, unit, values, cell)| {
            let mut si = Vec::with_capacity(values.len() + self.left_out.after.len());
            let cells = self.left_out.cells.chunks_exact(self.columns.len());
            let mut left_out = self.left_out.after.iter().zip(cells).peekable();
            for row in 0..=self.rows() {
                while let Some((_, cells)) = left_out.next_if(|(after, _)| **after == row) {
                    si.push(if let Some(index) = cell {
                        cells[index]
                    } else {
                        let at = cells[0].and_then(|time| self.between(time));
                        at.map(|(row, share)| mixed(values, row, share))
                    });
                }
                si.extend(values.get(row).copied().map(Some));
            }
            Written { header, unit, si }
        });
        Sheet { columns: columns.collect() }
    }

    /// The row at or before a time, and the share of the way to the next one.
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

/// A table as it is written.
pub(super) struct Sheet {
    pub(super) columns: Vec<Written>,
}

/// A column as it is written.
pub(super) struct Written {
    pub(super) header: String,
    pub(super) unit: Unit,
    /// The value of each row, SI.
    si: Vec<Option<f64>>,
}

impl Written {
    /// The value of each row in the column's unit: the number that stands in a text, to the bit.
    #[cfg(any(feature = "mat", feature = "parquet"))]
    pub(super) fn values(&self) -> impl Iterator<Item = Option<f64>> {
        self.si.iter().map(|value| value.and_then(|value| self.unit.print(value).parse().ok()))
    }
}

impl Sheet {
    fn write_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        let headers: Vec<String> = self.columns.iter().map(|column| quoted(&column.header)).collect();
        writeln!(out, "{}", headers.join(","))?;
        for row in 0..self.columns.first().map_or(0, |column| column.si.len()) {
            for (index, column) in self.columns.iter().enumerate() {
                let separator = if index == 0 { "" } else { "," };
                let text = column.si[row].map_or_else(String::new, |value| column.unit.print(value));
                write!(out, "{separator}{text}")?;
            }
            writeln!(out)?;
        }
        Ok(())
    }
}

fn mixed(values: &[f64], row: usize, share: f64) -> f64 {
    if share > 0.0 { on_line(values[row], values[row + 1], share) } else { values[row] }
}

/// A header, in one line, and in quotation marks where it holds a separator or a quotation mark.
pub(crate) fn quoted(header: &str) -> String {
    let header = header.replace(|character: char| character.is_control() && character != '\t', " ");
    if header.contains([',', ';', '\t', '"']) { format!("\"{}\"", header.replace('"', "\"\"")) } else { header }
}
