//! The reader of recordings in text form.
//!
//! One header row of `name [unit]`, then one row per line; time in any column. Besides this plain form, the reader
//! accepts `;`, tab and `|` as separators (detected in the header row), decimal commas, a byte order
//! mark, Windows-1252 in place of UTF-8, CRLF, comment lines that begin with `#`, quoted cells, a row of units below the header, a separator at the end
//! of every line, and dates for times. A last line that is cut off is not read. Times may be uneven and have gaps. A
//! row that repeats the time before it (see [`coarse_stamps`](crate::formats::coarse_stamps) for times that most rows share), or has no value in a known column, is left out and
//! counted in the recording's notes, and written back where the recording is; no value is made up. Any other fault is an error.
//!
//! Memory: one line and the values of the known columns, however large the file is.

use super::clock::StampClock;
use super::decimal_mark::{DecimalMark, is_missing, si};
use super::heading::Heading;
use super::lines::{Cells, Input, Lines, Splitter, TextLine, most_rows};
use super::twincat;
use crate::channel_map::ChannelMap;
use crate::error::RecordingError;
use crate::formats::coarse_stamps::CoarseStamps;
use crate::formats::text_fault::TextFault;
use crate::header::assign;
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
        let (mut heading, mut splitter) = Heading::read(&mut lines)?;
        if heading.names[0] == twincat::FIRST_CELL {
            return twincat::read(lines, splitter, heading.names, map).map(Opened::Whole);
        }
        heading.look_below(&mut lines, &mut splitter)?;
        heading.check_times(map)?;
        let offers = heading.offers_with_stamps(map);
        let mut assignment = assign(&offers, map, &file, |index| heading.place(index))?;
        let Some(time) = assignment.known.iter().position(|(_, column)| column.signal == Signal::Time) else {
            return Err(heading.without_time());
        };
        assignment.known[..=time].rotate_right(1);
        let stamps = heading.is_stamped(assignment.known[0].0).then(StampClock::default);
        let last = heading.names.len() - 1;
        let table = TextRows {
            ends_known: assignment.known.iter().any(|(index, _)| *index == last),
            columns: assignment.known,
            width: heading.names.len(),
            separator: heading.separator,
            mark: DecimalMark::new(heading.separator),
            dates: stamps,
            shortest: usize::MAX,
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
            let number = line.number();
            let pushed = self.splitter.split(line).and_then(|cells| self.table.push(line, cells));
            if let Err(error) = pushed {
                let is_cut = is_of_a_cut_line(&error, line) && self.table.kept() > 1;
                if !is_cut || !matches!(self.lines.next(), Ok(None)) {
                    return Err(error);
                }
                self.notes.push(match error {
                    RecordingError::Text { fault: TextFault::Words(text), .. } => {
                        Note::LastLineOfWords { line: number, text }
                    }
                    _ => Note::CutLine { line: number },
                });
                self.is_at_end = true;
                break;
            }
            if self.table.held() == ROWS_TO_DECIDE {
                self.table.decide();
            }
        }
        if self.is_at_end {
            self.table.mark.check()?;
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
        if columns[0].is_index(&columns[0].header) {
            return Err(RecordingError::Index { place: self.lines.file(), header: columns[0].header.clone() });
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

/// Whether an error is such as the end of a file that was cut off within a line makes.
fn is_of_a_cut_line(error: &RecordingError, line: TextLine<'_>) -> bool {
    match error {
        RecordingError::RaggedRow { found, expected, .. } => found < expected,
        RecordingError::OpenQuote { .. } | RecordingError::Text { fault: TextFault::Words(_), .. } => true,
        _ => !line.is_ended(),
    }
}

/// Rows as they come in; the first column is time.
#[derive(Debug)]
struct TextRows {
    /// Known columns with their cell's index.
    columns: Vec<(usize, Column)>,
    width: usize,
    separator: u8,
    mark: DecimalMark,
    /// The clock of times that are dates or times of day.
    dates: Option<StampClock>,
    /// Whether the last cell of a row is that of a known column, and the length of the shortest.
    ends_known: bool,
    shortest: usize,
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
        if !self.times_s().is_empty() && self.is_of_words(cells) {
            let first = cells.iter().find(|cell| !cell.is_empty()).unwrap_or_default();
            return Err(RecordingError::Text { place: line.whole(), fault: TextFault::Words(first.to_owned()) });
        }
        let found = cells.len();
        let is_too_long = || (self.width..found).any(|index| !cells.get(index).is_empty());
        if found < self.width || (found > self.width && is_too_long()) || self.seems_cut(line, cells) {
            let found = if found == self.width { found - 1 } else { found };
            return Err(RecordingError::RaggedRow { place: line.whole(), found, expected: self.width });
        }
        let most = most_rows(self.columns.len());
        if self.held() == most {
            return Err(RecordingError::TooManyRows { place: line.whole(), most });
        }
        self.row.clear();
        if self.columns.iter().any(|(index, _)| is_missing(cells.get(*index))) {
            self.check_present(line, cells)?;
            count(&mut self.incomplete, line);
            self.leave_out(cells);
            return Ok(());
        }
        for (index, column) in &self.columns {
            let text = cells.get(*index);
            let value = match &mut self.dates {
                Some(dates) if column.signal == Signal::Time => dates.seconds(text).ok_or_else(|| {
                    let (place, header) = (line.cell(self.separator, *index), column.header.clone());
                    RecordingError::NotAStamp { place, header, found: text.to_owned() }
                })?,
                _ => si(line, text, column, &mut self.mark, *index)?,
            };
            self.row.push(value);
        }
        let found_s = self.row[0];
        if let Some(&previous_s) = self.columns[0].1.values.last() {
            if found_s < previous_s {
                let place = line.cell(self.separator, self.columns[0].0);
                return Err(RecordingError::TimeBackwards { place, previous_s, found_s });
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

    /// Checks that what stands beside an empty cell is a number, and no words.
    fn check_present(&self, line: TextLine<'_>, cells: Cells<'_>) -> Result<(), RecordingError> {
        let is_wrong = |(index, _): &&(usize, Column)| is_of_words(cells.get(*index));
        let Some((index, column)) = self.columns.iter().find(is_wrong) else { return Ok(()) };
        let (place, header) = (line.cell(self.separator, *index), column.header.clone());
        Err(RecordingError::NotANumber { place, header, found: cells.get(*index).to_owned() })
    }

    /// Whether these are no cells of a row but words, as below the rows: `End of file`, `Average,1.5,100`.
    fn is_of_words(&self, cells: Cells<'_>) -> bool {
        let time = cells.get(self.columns[0].0);
        let is_known = || cells.len() < self.width || self.columns.iter().any(|(known, _)| *known == 0);
        is_of_words(time) || (time.is_empty() && is_of_words(cells.get(0)) && is_known())
    }

    /// Whether the file ends within the last cell of the line: without an end of the line, in a known column, with fewer characters than any row before.
    fn seems_cut(&mut self, line: TextLine<'_>, cells: Cells<'_>) -> bool {
        if !self.ends_known {
            return false;
        }
        let length = cells.get(self.width - 1).len();
        if length > 0 && line.is_ended() {
            self.shortest = self.shortest.min(length);
        }
        !line.is_ended() && cells.len() == self.width && length < self.shortest && self.shortest < usize::MAX
    }

    fn leave_out(&mut self, cells: Cells<'_>) {
        self.left_out.after.push(self.times_s().len());
        for (index, column) in &self.columns {
            let text = cells.get(*index);
            let value = match &mut self.dates {
                Some(dates) if column.signal == Signal::Time => dates.seconds(text),
                _ => self.mark.lenient(text).and_then(|value| column.read(value)),
            };
            self.left_out.cells.push(value.filter(|value| value.is_finite()));
        }
    }
}

/// Whether a cell holds words: no number, date or sign of a missing value, nor the beginning of one.
fn is_of_words(cell: &str) -> bool {
    let is_number = || cell.parse::<f64>().is_ok() || is_missing(cell);
    // A duration such as PT1.5S, or the beginning of one; a formula without a value is told by its cell.
    let rest = cell.strip_prefix('P').map(|rest| rest.trim_start_matches(['T', '-']));
    let is_duration =
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(|first: char| first.is_ascii_digit()));
    let bare = cell.trim_start_matches(['+', '-', '.', ',']);
    let begins_as_number = bare.is_empty() || bare.starts_with(|first: char| first.is_ascii_digit());
    !begins_as_number && !is_duration && !cell.starts_with(['=', '#']) && !is_number()
}

fn count(rows: &mut Option<(usize, usize)>, line: TextLine<'_>) {
    rows.get_or_insert((0, line.number())).0 += 1;
}
