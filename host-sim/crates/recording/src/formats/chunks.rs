//! A recording that is read from front to back in parts, so that its length takes no memory.

use std::fmt;

use super::read::of_its_name;
use crate::error::RecordingError;
use crate::formats::text::csv::Opened;
use crate::recording::Recording;

/// Rows that a part usually has.
pub const PART_ROWS: usize = 500_000;

/// A recording that is read in parts. What is no text of rows, and so is held in memory anyway, comes as one.
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
    /// Its rows, as a recording of their own. It notes what no part before has; how many rows were left out in all, the last.
    pub recording: Recording,
    /// Whether the recording ends with it.
    pub is_last: bool,
}

impl<'a> Parts<'a> {
    /// Parts of some `usual_rows` each.
    pub(crate) fn of(opened: Opened<'a>, usual_rows: usize) -> Self {
        Self { left: Some(opened), usual_rows }
    }

    /// The rows that are held, filled up to those of a part; half of one more where that many are held already. `None` after the last
    /// part.
    ///
    /// # Errors
    /// A row that is none, as in [`read`](super::read::read); or [`RecordingError::TooFewRows`] where the whole has fewer than two.
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

    /// Forgets the rows of the last part before this one: the next part begins with it.
    pub fn forget_before(&mut self, row: usize) {
        if let Some(Opened::Rows(reader)) = &mut self.left {
            reader.forget_before(row);
        }
    }
}
