//! Writing a recording back in its own columns and units.

#[cfg(any(feature = "mat", feature = "parquet"))]
use std::io;
use std::ops::Range;
use std::path::Path;

use super::format::Format;
use super::sheet::{Series, Sheet, WrittenColumn};
use super::unsupported::Unsupported;
use crate::error::RecordingError;
use crate::files::atomic;
use crate::files::source_error::Place;
use crate::recording::Recording;

impl Recording {
    /// Writes this recording with the values of some signals replaced and others added, as a simulation does.
    ///
    /// One row for each row of the file, its known columns in their order under their own headers and
    /// in their own units; signals that are `added` follow in SI units. `replaced` and `added` hold SI
    /// values, one for each row of the recording; a replaced signal that the recording has no column
    /// for is left out. A row that was left out in reading is written in its place with its original cells, and
    /// with the replaced and added signals at its time, interpolated linearly between the rows around it; where it has
    /// no time, or one outside the recording's, they are blank. Separator is the comma and decimals
    /// have a point, whatever the recording used; ignored columns are not written. The file appears
    /// whole or not at all.
    pub fn write_csv(&self, path: &Path, replaced: &[Series<'_>], added: &[Series<'_>]) -> Result<(), RecordingError> {
        let sheet = self.checked(path, self.rows(), replaced, added)?;
        atomic::write(path, |out| sheet.write_csv(out))
            .map_err(|source| RecordingError::Write { place: Place::file(&path.display().to_string()), source })
    }

    /// Rows of the text that [`Self::write_csv`] writes, by their index in this recording; the header comes before the first row.
    ///
    /// A row that was left out comes together with the row after it, or with the last row at the end of the recording. Series end where the rows end;
    /// `path` stands for the file in messages.
    pub fn csv_rows(
        &self,
        path: &Path,
        rows: Range<usize>,
        replaced: &[Series<'_>],
        added: &[Series<'_>],
    ) -> Result<Vec<u8>, RecordingError> {
        let mut text = Vec::new();
        let sheet = self.checked(path, rows.end, replaced, added)?;
        let header = if rows.start == 0 { sheet.write_header(&mut text) } else { Ok(()) };
        header
            .and_then(|()| sheet.write_rows(rows, &mut text))
            .map_err(|source| RecordingError::Write { place: Place::file(&path.display().to_string()), source })?;
        Ok(text)
    }

    /// The columns of the table that [`Self::write_csv`] writes: each header with its values in the column's unit, bit for bit the numbers of the text.
    pub fn written(&self, replaced: &[Series<'_>], added: &[Series<'_>]) -> Result<Vec<WrittenColumn>, RecordingError> {
        let sheet = self.checked(Path::new(&self.path), self.rows(), replaced, added)?;
        Ok(sheet.columns.iter().map(|column| (column.header.clone(), column.values().collect())).collect())
    }

    /// As [`Self::write_csv`], in the format that the extension selects: `.mat` and `.parquet`, in upper or lower case; CSV otherwise.
    ///
    /// What is blank in CSV is NaN in a MAT-file and null in Parquet.
    pub fn write(&self, path: &Path, replaced: &[Series<'_>], added: &[Series<'_>]) -> Result<(), RecordingError> {
        match Format::of_extension(path) {
            #[cfg(feature = "mat")]
            Some(Format::Mat) => self.write_packed(path, replaced, added, crate::formats::mat::write),
            #[cfg(feature = "parquet")]
            Some(Format::Parquet) => self.write_packed(path, replaced, added, crate::formats::parquet::write),
            #[allow(unreachable_patterns, reason = "reached where the program was built without a feature")]
            Some(format @ (Format::Mat | Format::Parquet)) => {
                Err(RecordingError::FeatureAbsent { place: Place::file(&path.display().to_string()), format })
            }
            Some(Format::Mdf4 | Format::Xlsx | Format::Gzip) => {
                let (place, what) = (Place::file(&path.display().to_string()), Unsupported::Writing);
                Err(RecordingError::Unsupported { place, what })
            }
            Some(Format::Text) | None => self.write_csv(path, replaced, added),
        }
    }

    /// Writes the table as the bytes that a format makes of it.
    #[cfg(any(feature = "mat", feature = "parquet"))]
    fn write_packed(
        &self,
        path: &Path,
        replaced: &[Series<'_>],
        added: &[Series<'_>],
        packed: fn(&Sheet<'_>) -> io::Result<Vec<u8>>,
    ) -> Result<(), RecordingError> {
        let bytes = packed(&self.checked(path, self.rows(), replaced, added)?);
        atomic::write(path, |out| out.write_all(&bytes?))
            .map_err(|source| RecordingError::Write { place: Place::file(&path.display().to_string()), source })
    }

    /// The table to be written, after checking that every series has the expected number of values and all are finite.
    fn checked<'a>(
        &'a self,
        path: &Path,
        expected: usize,
        replaced: &[Series<'a>],
        added: &[Series<'a>],
    ) -> Result<Sheet<'a>, RecordingError> {
        let place = || Place::file(&path.display().to_string());
        for &(signal, values) in replaced.iter().chain(added) {
            let (header, found) = (signal.name().to_owned(), values.len());
            if found != expected {
                return Err(RecordingError::LengthMismatch { place: place(), header, found, expected });
            }
            if let Some(value) = values.iter().find(|value| !value.is_finite()) {
                return Err(RecordingError::NotFinite { place: place(), header, found: value.to_string() });
            }
        }
        Ok(self.sheet(replaced, added))
    }
}
