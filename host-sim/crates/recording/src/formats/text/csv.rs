//! The reader of recordings in text form.
//!
//! One header row of `name [unit]`, time in the first column, then one row per line. Besides this plain form, the reader
//! accepts `;` and tab as separators (detected in the header row) with decimal commas, a byte order
//! mark, Windows-1252 in place of UTF-8, CRLF, comment lines that begin with `#`, and quoted cells. Times may be uneven and have gaps. A
//! row that repeats the time before it (see [`coarse_stamps`](crate::formats::coarse_stamps) for times that most rows share), or has an empty cell in a known column, is left out and
//! counted in the recording's notes, and written back where the recording is; no value is made up. Any other fault is an error.
//!
//! Memory: one line and the values of the known columns, however large the file is.

use super::lines::{Cells, Input, Lines, Splitter, TextLine, most_rows, parse_number};
use super::twincat;
use crate::channel_map::ChannelMap;
use crate::error::RecordingError;
use crate::formats::coarse_stamps::CoarseStamps;
use crate::header::{Offer, assign};
use crate::recording::{At, Column, LeftOut, Note, Recording, gaps};
use crate::signal::Signal;

/// A recording whose header has been read.
pub(crate) enum Opened<'a> {
    /// Its rows are read one after the other.
    Rows(Box<Reader<'a>>),
    /// A recording read as a whole: an export whose channels have their own clocks, or a file that is not text.
    Whole(Recording),
}

impl<'a> Opened<'a> {
    /// A text from any source; `name` stands for the file in messages.
    pub(crate) fn text(name: &str, input: Input<'a>, map: &ChannelMap) -> Result<Self, RecordingError> {
        let mut lines = Lines::new(name, input);
        let file = lines.file();
        let (header, mut splitter) = lines.header()?;
        let separator = splitter.separator();
        let cells = splitter.split(header)?;
        if cells.get(0) == twincat::FIRST_CELL {
            let names = cells.iter().map(str::to_owned).collect();
            return twincat::read(lines, splitter, names, map).map(Opened::Whole);
        }
        let width = cells.len();
        let offers: Vec<Offer> = cells.iter().map(Offer::plain).collect();
        let assignment = assign(&offers, map, &file, |index| header.cell(separator, index))?;
        match assignment.known.first() {
            Some((0, column)) if column.signal == Signal::Time => {}
            _ => {
                let header_text = offers.first().map_or_else(String::new, |offer| offer.header.clone());
                return Err(RecordingError::NoTimeColumn { place: header.cell(separator, 0), header: header_text });
            }
        }
        let table = TextRows {
            columns: assignment.known,
            width,
            separator,
            row: Vec::new(),
            repeated: None,
            incomplete: None,
            left_out: LeftOut::default(),
            stamps: Stamps::Undecided,
        };
        let (ignored, notes) = (assignment.ignored, assignment.notes);
        Ok(Opened::Rows(Box::new(Reader {
            lines,
            splitter,
            table,
            ignored,
            notes,
            western: None,
            told_gaps: 0,
            is_at_end: false,
        })))
    }

    /// All of its rows.
    pub(crate) fn whole(self) -> Result<Recording, RecordingError> {
        match self {
            Opened::Rows(mut reader) => {
                reader.read_on(usize::MAX)?;
                reader.rest()
            }
            Opened::Whole(recording) => Ok(recording),
        }
    }
}

/// A text that is read row by row.
pub(crate) struct Reader<'a> {
    lines: Lines<'a>,
    splitter: Splitter,
    table: TextRows,
    ignored: Vec<String>,
    /// Notes about the header.
    notes: Vec<Note>,
    /// The first line of the whole text that is Windows-1252, once it has been noted.
    western: Option<usize>,
    /// The row up to which gaps have been noted.
    told_gaps: usize,
    is_at_end: bool,
}

impl Reader<'_> {
    /// Reads on until so many rows are held and at least two of them can be used, or to the end.
    pub(crate) fn read_on(&mut self, rows: usize) -> Result<(), RecordingError> {
        while self.table.held() < rows.max(ROWS_TO_DECIDE) || self.table.kept() < 2 {
            let Some(line) = self.lines.next()? else {
                self.is_at_end = true;
                break;
            };
            let cells = self.splitter.split(line)?;
            self.table.push(line, cells)?;
            if self.table.held() == ROWS_TO_DECIDE {
                self.table.decide();
            }
        }
        if self.is_at_end {
            self.table.decide();
        }
        self.notes.extend(self.table.spread(self.is_at_end));
        Ok(())
    }

    pub(crate) fn name(&self) -> &str {
        self.lines.file_name()
    }

    /// Whether the text has no further rows.
    pub(crate) fn is_at_end(&self) -> bool {
        self.is_at_end
    }

    /// The number of rows held, including those left out.
    pub(crate) fn rows_held(&self) -> usize {
        self.table.held()
    }

    /// Forgets the rows before this one.
    pub(crate) fn forget_before(&mut self, row: usize) {
        let row = row.min(self.table.kept());
        self.table.forget_before(row);
        self.told_gaps = self.told_gaps.saturating_sub(row);
    }

    /// The rows that are held; a later part may contain some of them again. It has only notes that no earlier part had.
    pub(crate) fn held(&mut self) -> Result<Recording, RecordingError> {
        let kept = self.table.kept();
        let of = |column: &Column| Column { values: column.values[..kept].to_vec(), ..column.clone() };
        let columns = self.table.columns.iter().map(|(_, column)| of(column)).collect();
        let (left_out, ignored) = (self.table.left_out.clone(), self.ignored.clone());
        let recording = self.recording(columns, left_out, ignored);
        self.told_gaps = kept.saturating_sub(1);
        recording
    }

    /// The same for a text that has been read to its end, without a later part. It also notes how many rows were left out in all.
    pub(crate) fn rest(mut self) -> Result<Recording, RecordingError> {
        let columns = std::mem::take(&mut self.table.columns).into_iter().map(|(_, column)| column).collect();
        let (left_out, ignored) = (std::mem::take(&mut self.table.left_out), std::mem::take(&mut self.ignored));
        self.recording(columns, left_out, ignored)
    }

    fn recording(
        &mut self,
        columns: Vec<Column>,
        left_out: LeftOut,
        ignored: Vec<String>,
    ) -> Result<Recording, RecordingError> {
        let rows = columns.first().map_or(0, |time| time.values.len());
        if rows < 2 {
            return Err(RecordingError::TooFewRows { place: self.lines.file(), rows, skipped: left_out.after.len() });
        }
        let mut notes = std::mem::take(&mut self.notes);
        if self.western.is_none() {
            self.western = self.lines.western();
            notes.extend(self.western.map(|line| Note::ReadAsWindows1252 { first: At::Line(line) }));
        }
        if self.is_at_end {
            let TextRows { repeated, incomplete, .. } = self.table;
            notes.extend(repeated.map(|(rows, line)| Note::DuplicateTimes { rows, first: At::Line(line) }));
            notes.extend(incomplete.map(|(rows, line)| Note::IncompleteRows { rows, first: At::Line(line) }));
        }
        notes.extend(gaps(&columns[0].values[self.told_gaps..]));
        Ok(Recording { path: self.lines.file_name().to_owned(), columns, ignored, notes, left_out })
    }
}

/// Rows as they come in; the first column is time.
#[derive(Debug)]
struct TextRows {
    /// Known columns with their cell's index.
    columns: Vec<(usize, Column)>,
    width: usize,
    separator: u8,
    /// The values of the current row, SI.
    row: Vec<f64>,
    /// How many rows repeat a time, and the line of the first.
    repeated: Option<(usize, usize)>,
    /// How many rows have an empty cell, and the line of the first.
    incomplete: Option<(usize, usize)>,
    left_out: LeftOut,
    stamps: Stamps,
}

/// How rows that share a time stamp are treated.
#[derive(Debug)]
enum Stamps {
    /// Too few rows were read to say.
    Undecided,
    /// They repeat a time and are left out.
    Repeat,
    /// They are spread.
    Coarse(CoarseStamps),
}

/// Rows after which it is decided how rows that share a time stamp are treated.
const ROWS_TO_DECIDE: usize = 1000;

impl TextRows {
    /// The times of the rows held, s.
    fn times_s(&self) -> &[f64] {
        self.columns.first().map_or(&[], |(_, time)| &time.values)
    }

    /// The number of rows held.
    fn held(&self) -> usize {
        self.times_s().len() + self.left_out.after.len()
    }

    /// Decides how rows that share a time stamp are treated, if that is still open.
    fn decide(&mut self) {
        if !matches!(self.stamps, Stamps::Undecided) {
            return;
        }
        let mut columns: Vec<&mut Vec<f64>> = self.columns.iter_mut().map(|(_, column)| &mut column.values).collect();
        let found = CoarseStamps::found(&mut columns, &mut self.left_out);
        if found.is_some() {
            self.repeated = None;
        }
        self.stamps = found.map_or(Stamps::Repeat, Stamps::Coarse);
    }

    /// Spreads the rows that share a time stamp, if they are to be; with a note the first time.
    fn spread(&mut self, is_at_end: bool) -> Option<Note> {
        let Stamps::Coarse(coarse) = &mut self.stamps else { return None };
        coarse.spread(&mut self.columns[0].1.values, is_at_end)
    }

    /// The number of rows held, without those left out and those that wait to be spread.
    fn kept(&self) -> usize {
        let waiting = if let Stamps::Coarse(coarse) = &self.stamps { coarse.waiting(self.times_s()) } else { 0 };
        self.times_s().len() - waiting
    }

    fn forget_before(&mut self, row: usize) {
        for (_, column) in &mut self.columns {
            column.values.drain(..row);
        }
        if let Stamps::Coarse(coarse) = &mut self.stamps {
            coarse.forget(row);
        }
        let forgotten = self.left_out.after.partition_point(|&after| after < row);
        self.left_out.after.drain(..forgotten);
        self.left_out.cells.drain(..forgotten * self.columns.len());
        for after in &mut self.left_out.after {
            *after -= row;
        }
    }

    fn push(&mut self, line: TextLine<'_>, cells: Cells<'_>) -> Result<(), RecordingError> {
        if cells.len() != self.width {
            return Err(RecordingError::RaggedRow { place: line.whole(), found: cells.len(), expected: self.width });
        }
        let most = most_rows(self.columns.len());
        if self.held() == most {
            return Err(RecordingError::TooManyRows { place: line.whole(), most });
        }
        self.row.clear();
        let empty = self.columns.iter().filter(|(index, _)| cells.get(*index).is_empty()).count();
        let without_time = cells.get(0).is_empty();
        if empty == self.columns.len() || (empty > 0 && !without_time) {
            count(&mut self.incomplete, line);
            self.leave_out(cells);
            return Ok(());
        }
        for (index, column) in &self.columns {
            self.row.push(number(line, cells.get(*index), column, self.separator, *index)?);
        }
        let found_s = self.row[0];
        if let Some(&previous_s) = self.columns[0].1.values.last() {
            if found_s < previous_s {
                return Err(RecordingError::TimeBackwards { place: line.cell(self.separator, 0), previous_s, found_s });
            }
            if found_s <= previous_s && !matches!(self.stamps, Stamps::Coarse(_)) {
                count(&mut self.repeated, line);
                self.leave_out(cells);
                return Ok(());
            }
        }
        for ((_, column), &value) in self.columns.iter_mut().zip(&self.row) {
            column.values.push(value);
        }
        Ok(())
    }

    fn leave_out(&mut self, cells: Cells<'_>) {
        self.left_out.after.push(self.times_s().len());
        for (index, column) in &self.columns {
            let value = parse_number(cells.get(*index), self.separator != b',').and_then(|value| column.read(value));
            self.left_out.cells.push(value.filter(|value| value.is_finite()));
        }
    }
}

fn count(rows: &mut Option<(usize, usize)>, line: TextLine<'_>) {
    rows.get_or_insert((0, line.number())).0 += 1;
}

/// A cell of a known column in SI units.
pub(crate) fn number(
    line: TextLine<'_>,
    text: &str,
    column: &Column,
    separator: u8,
    index: usize,
) -> Result<f64, RecordingError> {
    let place = || line.cell(separator, index);
    match parse_number(text, separator != b',') {
        None => {
            Err(RecordingError::NotANumber { place: place(), header: column.header.clone(), found: text.to_owned() })
        }
        Some(value) => {
            let Some(si) = column.read(value) else { return Err(column.out_of_reach(place(), value)) };
            if si.is_finite() {
                return Ok(si);
            }
            Err(RecordingError::NotFinite { place: place(), header: column.header.clone(), found: text.to_owned() })
        }
    }
}
