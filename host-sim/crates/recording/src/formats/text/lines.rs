//! The lines of a text file, read with bounded memory, and their cells.
//!
//! The limits are defined here: for any input, at most one line is held, and an input that is not a recording
//! is refused at the first line that shows this.

use std::io::{BufRead, BufReader, Read};
use std::ops::Range;

use crate::error::RecordingError;
use crate::files::source_error::{Place, is_number};

/// Longest line, in bytes.
pub const MAX_LINE_BYTES: usize = 1 << 20;
/// Most columns of a recording.
pub const MAX_COLUMNS: usize = 4096;
/// Most rows of a recording.
pub const MAX_ROWS: usize = 20_000_000;
/// Most values of a recording's known columns, all together: 1.6 GB, and as much again while they are read.
pub const MAX_VALUES: usize = 200_000_000;
/// Most blank lines and comments.
pub const MAX_SKIPPED_LINES: usize = 1_000_000;

/// Most rows of a recording with so many known columns.
pub(crate) fn most_rows(columns: usize) -> usize {
    MAX_ROWS.min(MAX_VALUES / columns.max(1))
}

/// The source of a text. It is a single type, so that the readers are compiled once in this crate and not in each crate that uses them.
pub(crate) type Input<'a> = Box<dyn Read + 'a>;

/// What spreadsheets write in the place of a value, in English and in German: cells, and no comments.
const SHEET_ERRORS: [&str; 13] = [
    "#N/A", "#NV", "#DIV/0!", "#REF!", "#VALUE!", "#NAME?", "#NULL!", "#NUM!", "#CALC!", "#SPILL!", "#WERT!",
    "#BEZUG!", "#ZAHL!",
];

/// Whether a line is a comment.
pub(crate) fn is_comment(line: &[u8]) -> bool {
    line.starts_with(b"#") && !SHEET_ERRORS.iter().any(|error| line.starts_with(error.as_bytes()))
}

/// The lines of a file that are neither blank nor comments (`#`).
pub(crate) struct Lines<'a> {
    file: String,
    input: BufReader<Input<'a>>,
    bytes: Vec<u8>,
    number: usize,
    skipped: usize,
    /// Whether the line has an end; the last one of a file that was cut off has none.
    is_ended: bool,
    /// Whether the line is to be read once more.
    is_put_back: bool,
    /// The first line that is Windows-1252 and not UTF-8.
    western: Option<usize>,
    /// The number of the last comment above the header, and its text without the mark; none where it is not UTF-8.
    comment: (usize, String),
    has_header: bool,
}

/// One line, and where it stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TextLine<'a> {
    file: &'a str,
    number: usize,
    pub(crate) text: &'a str,
    is_ended: bool,
}

impl<'a> TextLine<'a> {
    /// A line that was read before.
    pub(crate) fn of(file: &'a str, number: usize, text: &'a str) -> Self {
        Self { file, number, text, is_ended: true }
    }

    pub(crate) fn place(self, span: Range<usize>) -> Place {
        Place::in_line(self.file, self.number, self.text, span)
    }

    pub(crate) fn whole(self) -> Place {
        self.place(0..self.text.len())
    }

    /// The place of one cell.
    pub(crate) fn cell(self, separator: u8, index: usize) -> Place {
        self.place(cell_span(self.text, separator, index))
    }

    pub(crate) fn number(self) -> usize {
        self.number
    }

    /// Whether an end of the line was found, and not the end of the file.
    pub(crate) fn is_ended(self) -> bool {
        self.is_ended
    }
}

impl<'a> Lines<'a> {
    pub(crate) fn new(file: &str, input: Input<'a>) -> Self {
        Self {
            file: file.to_owned(),
            input: BufReader::new(input),
            bytes: Vec::new(),
            number: 0,
            skipped: 0,
            is_ended: true,
            is_put_back: false,
            western: None,
            comment: (0, String::new()),
            has_header: false,
        }
    }

    pub(crate) fn file(&self) -> Place {
        Place::file(&self.file)
    }

    pub(crate) fn file_name(&self) -> &str {
        &self.file
    }

    /// The first line that was read as Windows-1252, as Excel writes it in western Europe, because it is not UTF-8.
    pub(crate) fn western(&self) -> Option<usize> {
        self.western
    }

    /// The header: the first line with content, and the splitter for this and all later lines. Above it, the line `sep=;` tells Excel the separator. Where
    /// that line is one of numbers, the comment above it with as many cells is the header, as `NumPy` writes it.
    pub(crate) fn header(&mut self) -> Result<(TextLine<'_>, Splitter), RecordingError> {
        let place = self.file();
        let empty = || RecordingError::Empty { place: place.clone() };
        let told = told_separator(self.next()?.ok_or_else(empty)?.text);
        if told.is_none() {
            self.put_back();
        }
        let first = self.next()?.ok_or_else(empty)?;
        let separator = told.unwrap_or_else(|| detect_separator(first.text));
        let cells = |text: &str| text.split(char::from(separator)).count();
        let (has_numbers, width) = (has_numbers(first.text, separator), cells(first.text));
        self.has_header = true;
        let header = if has_numbers && width > 1 && cells(&self.comment.1) == width {
            self.put_back();
            TextLine::of(&self.file, self.comment.0, &self.comment.1)
        } else {
            self.line()?
        };
        Ok((header, Splitter::new(separator)))
    }

    /// Lets [`Self::next`] return the line that it returned last once more.
    pub(crate) fn put_back(&mut self) {
        self.is_put_back = true;
    }

    /// The next line with content, without its end; `None` after the last one.
    pub(crate) fn next(&mut self) -> Result<Option<TextLine<'_>>, RecordingError> {
        if !std::mem::take(&mut self.is_put_back) && !self.advance()? {
            return Ok(None);
        }
        self.line().map(Some)
    }

    /// The line that was read last.
    fn line(&self) -> Result<TextLine<'_>, RecordingError> {
        let text = str::from_utf8(&self.bytes).map_err(|error| {
            let (good, rest) = self.bytes.split_at(error.valid_up_to());
            let good = String::from_utf8_lossy(good);
            let place = Place::in_line(&self.file, self.number, &good, good.len()..good.len());
            RecordingError::NotUtf8 { place, byte: rest.first().copied().unwrap_or_default() }
        })?;
        let line = TextLine { file: &self.file, number: self.number, text, is_ended: self.is_ended };
        if let Some((at, character)) = text.char_indices().find(|&(_, c)| c.is_control() && c != '\t') {
            let place = line.place(at..at + character.len_utf8());
            return Err(RecordingError::ControlCharacter { place, character });
        }
        Ok(line)
    }

    /// Reads the next line with content; `false` after the last one.
    fn advance(&mut self) -> Result<bool, RecordingError> {
        loop {
            self.bytes.clear();
            let mut limited = (&mut self.input).take(MAX_LINE_BYTES as u64 + 1);
            let read = limited.read_until(b'\n', &mut self.bytes);
            let read = read.map_err(|source| RecordingError::Io { place: Place::file(&self.file), source })?;
            if read == 0 {
                return Ok(false);
            }
            self.number += 1;
            self.is_ended = self.bytes.ends_with(b"\n");
            if read > MAX_LINE_BYTES {
                let place = Place::in_line(&self.file, self.number, "", 0..0);
                return Err(RecordingError::LineTooLong { place, most_bytes: MAX_LINE_BYTES });
            }
            if self.number == 1 && self.bytes.starts_with("\u{feff}".as_bytes()) {
                self.bytes.drain(..3);
            }
            // What DOS ended a file with, and what a loss of power leaves at its end: without an end of the line, or a line of nothing else.
            let is_end = |byte: &&u8| matches!(**byte, 0 | 0x1a | b'\r' | b'\n');
            let ended = self.bytes.iter().rev().take_while(is_end).count();
            if self.has_header && (!self.is_ended || ended == self.bytes.len()) {
                self.bytes.truncate(self.bytes.len() - ended);
            }
            let kept = self.bytes.trim_ascii_end().len();
            // Trailing separators count as cells, so trailing tabs are kept.
            let kept = kept + self.bytes[kept..].iter().take_while(|&&byte| byte == b'\t' || byte == b' ').count();
            self.bytes.truncate(kept);
            let start = self.bytes.trim_ascii_start();
            if !start.is_empty() && !is_comment(start) {
                break;
            }
            if !self.has_header && !start.is_empty() {
                let text = str::from_utf8(start[1..].trim_ascii_start()).unwrap_or_default();
                self.comment = (self.number, text.to_owned());
            }
            self.skipped += 1;
            if self.skipped > MAX_SKIPPED_LINES {
                let place = Place::in_line(&self.file, self.number, "", 0..0);
                return Err(RecordingError::TooManySkippedLines { place, most: MAX_SKIPPED_LINES });
            }
        }
        if str::from_utf8(&self.bytes).is_err()
            && let Some(text) = western(&self.bytes)
        {
            self.western.get_or_insert(self.number);
            self.bytes = text.into_bytes();
        }
        Ok(true)
    }
}

/// The text of a line in Windows-1252; `None` where it has control characters or bytes that are undefined there, as in noise and
/// in files of other kinds.
fn western(bytes: &[u8]) -> Option<String> {
    let text = encoding_rs::WINDOWS_1252.decode_without_bom_handling(bytes).0;
    let is_text = |character: char| !character.is_control() || character == '\t';
    text.chars().all(is_text).then(|| text.into_owned())
}

/// Splits lines into cells.
#[derive(Debug)]
pub(crate) struct Splitter {
    core: csv_core::Reader,
    separator: u8,
    text: Vec<u8>,
    ends: Vec<usize>,
}

impl Splitter {
    fn new(separator: u8) -> Self {
        let core = csv_core::ReaderBuilder::new().delimiter(separator).build();
        Self { core, separator, text: Vec::new(), ends: vec![0; MAX_COLUMNS] }
    }

    pub(crate) fn separator(&self) -> u8 {
        self.separator
    }

    /// The cells of a line.
    pub(crate) fn split(&mut self, line: TextLine<'_>) -> Result<Cells<'_>, RecordingError> {
        use csv_core::ReadRecordResult as Outcome;
        self.core.reset();
        self.text.resize(line.text.len() + 1, 0);
        let (outcome, _, text_end, count) = self.core.read_record(line.text.as_bytes(), &mut self.text, &mut self.ends);
        // The end of the line counts as the end of the input.
        let (outcome, text_more, count) = match outcome {
            Outcome::InputEmpty => {
                if open_quote(line.text, self.separator) {
                    return Err(RecordingError::OpenQuote { place: line.whole() });
                }
                let (outcome, _, more, ended) =
                    self.core.read_record(&[], &mut self.text[text_end..], &mut self.ends[count..]);
                (outcome, more, count + ended)
            }
            other => (other, 0, count),
        };
        match outcome {
            Outcome::Record | Outcome::End => {}
            Outcome::OutputEndsFull | Outcome::OutputFull | Outcome::InputEmpty => {
                return Err(RecordingError::TooManyColumns { place: line.whole(), most: MAX_COLUMNS });
            }
        }
        let text = str::from_utf8(&self.text[..text_end + text_more])
            .expect("valid UTF-8 split at ASCII characters is valid UTF-8");
        Ok(Cells { text, ends: &self.ends[..count] })
    }
}

/// The cells of one line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cells<'a> {
    text: &'a str,
    ends: &'a [usize],
}

impl<'a> Cells<'a> {
    pub(crate) fn len(self) -> usize {
        self.ends.len()
    }

    /// A cell without surrounding blanks; the empty text for an index past the last cell.
    pub(crate) fn get(self, index: usize) -> &'a str {
        let start = index.checked_sub(1).map_or(Some(0), |before| self.ends.get(before).copied());
        match (start, self.ends.get(index)) {
            (Some(start), Some(&end)) => self.text[start..end].trim(),
            _ => "",
        }
    }

    pub(crate) fn iter(self) -> impl Iterator<Item = &'a str> {
        (0..self.len()).map(move |index| self.get(index))
    }
}

/// The separator that a line `sep=;` tells.
fn told_separator(line: &str) -> Option<u8> {
    let line = line.trim_start().trim_start_matches('"');
    let told = line.get(..4).filter(|key| key.eq_ignore_ascii_case("sep="))?;
    match line.as_bytes().get(told.len()) {
        None => Some(b'\t'),
        Some(b'\\') if line[told.len()..].starts_with("\\t") => Some(b'\t'),
        Some(&mark) if mark == b'\t' || (mark.is_ascii_punctuation() && mark != b'"') => Some(mark),
        Some(_) => None,
    }
}

/// Whether every cell of a line is a number, or empty.
fn has_numbers(line: &str, separator: u8) -> bool {
    let mut cells = line.split(char::from(separator)).map(str::trim).filter(|cell| !cell.is_empty()).peekable();
    cells.peek().is_some() && cells.all(is_number)
}

/// The separator of a header row: the first tab, semicolon or comma outside quotes and brackets, or else a stroke `|`. More strokes than those, the first of
/// them before any, separate names with commas; a name may have them, too, as `|v|`.
fn detect_separator(header: &str) -> u8 {
    let is_framed = header.starts_with('|') == header.ends_with('|');
    let are_more = is_framed && header.matches('|').count() > header.matches(['\t', ';', ',']).count();
    let mut quoted = false;
    let mut depth = 0_u32;
    for byte in header.bytes() {
        match byte {
            b'"' => quoted = !quoted,
            b'[' if !quoted => depth += 1,
            b']' if !quoted => depth = depth.saturating_sub(1),
            b'\t' | b';' | b',' if !quoted && depth == 0 => return byte,
            b'|' if are_more && !quoted && depth == 0 => return byte,
            _ => {}
        }
    }
    if header.contains('|') { b'|' } else { b',' }
}

/// The bytes of one cell in its line, quotes included.
fn cell_span(line: &str, separator: u8, index: usize) -> Range<usize> {
    let mut quoted = false;
    let mut cell = 0;
    let mut start = 0;
    for (at, byte) in line.bytes().enumerate() {
        match byte {
            b'"' => quoted = !quoted,
            _ if byte == separator && !quoted => {
                if cell == index {
                    return start..at;
                }
                cell += 1;
                start = at + 1;
            }
            _ => {}
        }
    }
    start..line.len()
}

/// Whether a cell that begins with a quotation mark does not end with one.
fn open_quote(line: &str, separator: u8) -> bool {
    let mut quoted = false;
    let mut cell_start = true;
    for byte in line.bytes() {
        match byte {
            b'"' if quoted || cell_start => quoted = !quoted,
            _ => {}
        }
        cell_start = byte == separator && !quoted;
    }
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(text: &str, separator: u8) -> Vec<String> {
        let line = TextLine::of("f", 1, text);
        Splitter::new(separator).split(line).unwrap().iter().map(str::to_owned).collect()
    }

    #[test]
    fn lines_split_into_cells() {
        assert_eq!(cells("a, b ,c", b','), ["a", "b", "c"]);
        assert_eq!(cells("a;;", b';'), ["a", "", ""]);
        assert_eq!(cells("\"x, \"\"y\"\"\",2", b','), ["x, \"y\"", "2"]);
        assert_eq!(cells("°C\tµ", b'\t'), ["°C", "µ"]);
    }

    #[test]
    fn the_separator_is_the_first_one_outside_brackets() {
        assert_eq!(detect_separator("time [s],a;b"), b',');
        assert_eq!(detect_separator("\"t, rel [s]\";a"), b';');
        assert_eq!(detect_separator("time [s]\ta"), b'\t');
        assert_eq!(detect_separator("time [s]"), b',');
        assert_eq!(detect_separator("time [s]|a"), b'|');
        assert_eq!(detect_separator("time [s],|v|"), b',');
        assert_eq!(detect_separator("|v| [m/s],time [s]"), b',');
        assert_eq!(detect_separator("time [s]|Druck, links [bar]|position [mm]"), b'|');
    }

    #[test]
    fn a_quotation_mark_left_open_is_an_error_on_its_line() {
        let line = TextLine::of("f", 3, "1,\"2");
        let error = Splitter::new(b',').split(line).unwrap_err();
        assert!(matches!(error, RecordingError::OpenQuote { .. }), "{error}");
    }

    #[test]
    fn place_of_a_cell() {
        assert_eq!(cell_span("a,\"b,c\",d", b',', 1), 2..7);
        assert_eq!(cell_span("a,b", b',', 1), 2..3);
        assert_eq!(cell_span("a,b", b',', 9), 2..3);
    }

    #[test]
    fn many_columns_leave_room_for_fewer_rows() {
        assert_eq!((most_rows(0), most_rows(10), most_rows(20)), (MAX_ROWS, MAX_ROWS, MAX_ROWS / 2));
    }
}
