//! The reader of recordings in text form.
//!
//! One header row of `name [unit]`, first column time, then one row a line. Read besides the plain
//! form: `;` and tab as separators (taken from the header row) with decimal commas, a byte order
//! mark, Windows-1252 in place of UTF-8, CRLF, comment lines beginning with `#`, quoted cells. Times may be uneven and have gaps. A
//! row that repeats the time before it, or has an empty cell in a known column, is left out and
//! counted in the recording's notes, and written back where the recording is; no value is made up. Whatever else is wrong is an error.
//!
//! Memory: one line and the values of known columns, whatever the file holds.

use super::channels::ChannelMap;
use super::columns::{Offer, assign};
use super::error::RecordingError;
use super::lines::{Cells, Line, Lines, Splitter, detect_separator, most_rows, parse_number};
use super::{At, Column, LeftOut, Note, Recording, Signal, twincat};
use std::io::Read;

/// Reads a text from anywhere; `name` stands for the file in messages.
pub(super) fn read_from(name: &str, input: impl Read, map: &ChannelMap) -> Result<Recording, RecordingError> {
    let mut lines = Lines::new(name, input);
    let file = lines.file();
    let Some(header) = lines.next()? else {
        return Err(RecordingError::Empty { place: file });
    };
    let separator = detect_separator(header.text);
    let mut splitter = Splitter::new(separator);
    let cells = splitter.split(header)?;
    if cells.get(0) == twincat::FIRST_CELL {
        let names = cells.iter().map(str::to_owned).collect();
        return twincat::read(lines, splitter, names, map);
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
    let mut table = Table {
        columns: assignment.known,
        width,
        separator,
        row: Vec::new(),
        rows: 0,
        repeated: None,
        incomplete: None,
        left_out: LeftOut::default(),
    };
    while let Some(line) = lines.next()? {
        let cells = splitter.split(line)?;
        table.push(line, cells)?;
    }
    let mut notes = assignment.notes;
    notes.extend(lines.western().map(|line| Note::ReadAsWindows1252 { first: At::Line(line) }));
    notes.extend(table.repeated.map(|(rows, line)| Note::DuplicateTimes { rows, first: At::Line(line) }));
    notes.extend(table.incomplete.map(|(rows, line)| Note::IncompleteRows { rows, first: At::Line(line) }));
    let columns: Vec<Column> = table.columns.into_iter().map(|(_, column)| column).collect();
    let kept = columns[0].values.len();
    if kept < 2 {
        return Err(RecordingError::TooFewRows { place: file, rows: kept, skipped: table.rows - kept });
    }
    let mut recording = Recording::assemble(name, columns, assignment.ignored, notes);
    recording.left_out = table.left_out;
    Ok(recording)
}

/// Rows as they come in; the first column is time.
struct Table {
    /// Known columns with their cell's index.
    columns: Vec<(usize, Column)>,
    width: usize,
    separator: u8,
    /// The row at hand, SI.
    row: Vec<f64>,
    rows: usize,
    /// How many rows repeat a time, and the line of the first.
    repeated: Option<(usize, usize)>,
    /// How many rows have an empty cell, and the line of the first.
    incomplete: Option<(usize, usize)>,
    left_out: LeftOut,
}

impl Table {
    fn push(&mut self, line: Line<'_>, cells: Cells<'_>) -> Result<(), RecordingError> {
        if cells.len() != self.width {
            return Err(RecordingError::RaggedRow { place: line.whole(), found: cells.len(), expected: self.width });
        }
        let most = most_rows(self.columns.len());
        if self.rows == most {
            return Err(RecordingError::TooManyRows { place: line.whole(), most });
        }
        self.rows += 1;
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
            if found_s <= previous_s {
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
        let kept = self.columns[0].1.values.len();
        self.left_out.after.push(kept);
        for (index, column) in &self.columns {
            let value = parse_number(cells.get(*index), self.separator != b',').map(|value| column.unit.to_si(value));
            self.left_out.cells.push(value.filter(|value| value.is_finite()));
        }
    }
}

fn count(rows: &mut Option<(usize, usize)>, line: Line<'_>) {
    rows.get_or_insert((0, line.number())).0 += 1;
}

/// A cell of a known column in SI units.
pub(super) fn number(
    line: Line<'_>,
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
            let si = column.unit.to_si(value);
            if si.is_finite() {
                return Ok(si);
            }
            Err(RecordingError::NotFinite { place: place(), header: column.header.clone(), found: text.to_owned() })
        }
    }
}
