//! A recording that is read from front to back in parts, so that the memory needed does not depend on its length.

use std::fmt;

use super::read::of_its_name;
use crate::error::RecordingError;
use crate::formats::text::csv::Opened;
use crate::recording::Recording;

/// Usual number of rows of a part.
pub const PART_ROWS: usize = 500_000;

/// A recording that is read in parts. A file that is not text by rows is held in memory anyway and comes as a single part.
pub struct Parts<'a> {
    /// `None` after the last part, or an error.
    left: Option<Opened<'a>>,
    usual_rows: usize,
}

impl fmt::Debug for Parts<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Parts").field("usual_rows", &self.usual_rows).finish_non_exhaustive()
    }
}

/// A part of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its rows, as a recording of its own. It carries only notes that no earlier part had; the last part notes the number of rows left out in all.
    pub recording: Recording,
    /// Whether it is the last part of the recording.
    pub is_last: bool,
}

impl<'a> Parts<'a> {
    /// Parts of about `usual_rows` rows each.
    pub(crate) fn of(opened: Opened<'a>, usual_rows: usize) -> Self {
        Self { left: Some(opened), usual_rows }
    }

    /// The next part: the rows that are still held, filled up to the usual number of rows, but with at least half a part of new rows. `None` after
    /// the last part.
    ///
    /// # Errors
    /// An invalid row, as in [`read`](super::read::read); or [`RecordingError::TooFewRows`] where the whole recording has fewer than two rows.
    pub fn read_next(&mut self) -> Result<Option<Part>, RecordingError> {
        let mut reader = match self.left.take() {
            None => return Ok(None),
            Some(Opened::Whole(recording)) => return Ok(Some(Part { recording, is_last: true })),
            Some(Opened::Rows(reader)) => reader,
        };
        let rows = self.usual_rows.max(reader.rows_held() + self.usual_rows.div_ceil(2));
        reader.read_on(rows).map_err(|error| of_its_name(reader.name(), error))?;
        if reader.is_at_end() {
            return Ok(Some(Part { recording: reader.rest()?, is_last: true }));
        }
        let recording = reader.held()?;
        self.left = Some(Opened::Rows(reader));
        Ok(Some(Part { recording, is_last: false }))
    }

    /// Forgets the rows of the last part that come before this row: the next part begins with this row.
    pub fn forget_before(&mut self, row: usize) {
        if let Some(Opened::Rows(reader)) = &mut self.left {
            reader.forget_before(row);
        }
    }
}
