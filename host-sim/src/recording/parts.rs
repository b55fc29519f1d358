//! A recording that is read from front to back in parts, so that its length takes no memory.

use super::csv::{Opened, Reader};
use super::format::of_its_name;
use super::{Recording, RecordingError};
use std::io::Read;

/// Rows that a part usually has.
pub const PART_ROWS: usize = 500_000;

/// A recording that is read in parts. What is no text of rows, and so is held in memory anyway, comes as one.
#[derive(Debug)]
pub struct Parts<R> {
    source: Source<R>,
    usual_rows: usize,
}

#[derive(Debug)]
enum Source<R> {
    Rows(Box<Reader<R>>),
    Whole(Option<Recording>),
}

/// A part of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its rows, as a recording of their own. It notes what no part before has; how many rows were left out in all, the last.
    pub recording: Recording,
    /// Whether the recording ends with it.
    pub is_last: bool,
}

impl<R: Read> Parts<R> {
    /// Parts of a text whose header is read.
    pub(super) fn of_text(opened: Opened<R>, usual_rows: usize) -> Self {
        let source = match opened {
            Opened::Rows(reader) => Source::Rows(reader),
            Opened::Whole(recording) => Source::Whole(Some(recording)),
        };
        Self { source, usual_rows }
    }

    /// A recording as one part.
    #[must_use]
    pub fn whole(recording: Recording) -> Self {
        Self { source: Source::Whole(Some(recording)), usual_rows: usize::MAX }
    }

    /// The rows that are held, filled up to those of a part; half of one more where that many are held already. `None` after the last
    /// part.
    ///
    /// # Errors
    /// A row that is none, as in [`read`](super::read); or [`RecordingError::TooFewRows`] where the whole has fewer than two.
    pub fn read_next(&mut self) -> Result<Option<Part>, RecordingError> {
        match &mut self.source {
            Source::Whole(recording) => Ok(recording.take().map(|recording| Part { recording, is_last: true })),
            Source::Rows(reader) if reader.is_at_end() => Ok(None),
            Source::Rows(reader) => {
                let rows = self.usual_rows.max(reader.rows_held() + self.usual_rows.div_ceil(2));
                reader.read_on(rows).map_err(|error| of_its_name(reader.name(), error))?;
                Ok(Some(Part { recording: reader.held()?, is_last: reader.is_at_end() }))
            }
        }
    }

    /// Forgets the rows of the last part before this one: the next part begins with it.
    pub fn forget_before(&mut self, row: usize) {
        if let Source::Rows(reader) = &mut self.source {
            reader.forget_before(row);
        }
    }
}
