//! Numbers of a text, which has one decimal mark: a point or a comma.
//!
//! Of `1.300` alone nobody can say whether it is 1.3 or, with a thousands mark, 1300. The mark of a file is known to be the decimal one from a
//! number that cannot be grouped by thousands, such as `0.002` or `12.5`, or because cells end at each comma. A file with both marks is refused, and so is
//! one in which no number tells.

use super::lines::TextLine;
use crate::column::Column;
use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::formats::mark_fault::{MarkFault, MarkedCell};

/// The decimal mark of a text, as far as its numbers have told it.
#[derive(Debug)]
pub(crate) struct DecimalMark {
    separator: u8,
    first: Option<First>,
    /// Whether the mark of the first cell is known to be the decimal mark.
    is_known: bool,
}

/// The first cell with a mark.
#[derive(Debug)]
struct First {
    mark: u8,
    place: Place,
    cell: MarkedCell,
}

/// Why a cell is not a number of its file.
enum Fault {
    NotANumber,
    Thousands,
    OtherMark,
}

impl DecimalMark {
    pub(crate) fn new(separator: u8) -> Self {
        Self { separator, first: None, is_known: false }
    }

    /// The number of a cell; NaN and infinity are numbers here.
    pub(crate) fn number(
        &mut self,
        line: TextLine<'_>,
        header: &str,
        text: &str,
        index: usize,
    ) -> Result<f64, RecordingError> {
        let fault = match self.parsed(text) {
            Ok((value, None)) => return Ok(value),
            Ok((value, Some(mark))) => {
                let first = self.first.get_or_insert_with(|| First {
                    mark,
                    place: line.cell(self.separator, index),
                    cell: MarkedCell { line: line.number(), header: header.to_owned(), text: text.to_owned() },
                });
                if first.mark == mark {
                    let ends_cells = self.separator == b',' && mark == b'.';
                    self.is_known = self.is_known || ends_cells || !is_group(text);
                    return Ok(value);
                }
                Fault::OtherMark
            }
            Err(fault) => fault,
        };
        let (place, header, text) = (line.cell(self.separator, index), header.to_owned(), text.to_owned());
        let cell = |header, text| Box::new(MarkedCell { line: line.number(), header, text });
        Err(match (fault, &self.first) {
            (Fault::OtherMark, Some(first)) => {
                let fault = MarkFault::Other(Box::new(first.cell.clone()));
                RecordingError::Mark { place, cell: cell(header, text), fault }
            }
            (Fault::Thousands, _) => {
                RecordingError::Mark { place, cell: cell(header, text), fault: MarkFault::Thousands }
            }
            (Fault::OtherMark | Fault::NotANumber, _) => RecordingError::NotANumber { place, header, found: text },
        })
    }

    /// The number of a cell that is only kept to be written back.
    pub(crate) fn lenient(&self, text: &str) -> Option<f64> {
        self.parsed(text).ok().map(|(value, _)| value)
    }

    /// A number, and its mark where that is still to be looked at.
    fn parsed(&self, text: &str) -> Result<(f64, Option<u8>), Fault> {
        let Some(at) = text.bytes().position(|byte| matches!(byte, b'.' | b',')) else {
            let grouped = || text.contains(['\'', '\u{2019}', ' ', '\u{a0}', '\u{202f}', '_']) && is_grouped(text);
            let fault = |_| if grouped() { Fault::Thousands } else { Fault::NotANumber };
            return text.parse().map(|value| (value, None)).map_err(fault);
        };
        let mark = text.as_bytes()[at];
        if text[at + 1..].contains(['.', ',']) {
            return Err(if is_grouped(text) { Fault::Thousands } else { Fault::NotANumber });
        }
        let value = if mark == b',' { text.replacen(',', ".", 1).parse() } else { text.parse() };
        let fault = |_| if is_grouped(text) { Fault::Thousands } else { Fault::NotANumber };
        let value = value.map_err(fault)?;
        let is_settled = self.is_known && self.first.as_ref().is_some_and(|first| first.mark == mark);
        Ok((value, (!is_settled).then_some(mark)))
    }

    /// Checks at the end of a text that one of its numbers has told the mark.
    pub(crate) fn check(&self) -> Result<(), RecordingError> {
        match &self.first {
            Some(First { place, cell, .. }) if !self.is_known => {
                let (place, cell) = (place.clone(), Box::new(cell.clone()));
                Err(RecordingError::Mark { place, cell, fault: MarkFault::Unknown })
            }
            _ => Ok(()),
        }
    }
}

/// Whether a number with one mark can be one grouped by thousands: `1.300` and `-12,000`, and not `0.300`, `1.30` or `1300.000`.
fn is_group(text: &str) -> bool {
    let digits = text.trim_start_matches(['+', '-']);
    let Some((before, after)) = digits.split_once(['.', ',']) else { return false };
    let whole = !before.starts_with('0') && (1..=3).contains(&before.len());
    whole && after.len() == 3 && [before, after].iter().all(|part| part.bytes().all(|byte| byte.is_ascii_digit()))
}

/// Whether a text is a number with groups of three digits: `1.234,5`, `1,234,567`, `1'300`.
fn is_grouped(text: &str) -> bool {
    let is_mark =
        |character: char| matches!(character, '.' | ',' | '\'' | '\u{2019}' | ' ' | '\u{a0}' | '\u{202f}' | '_');
    let mut parts = text.trim_start_matches(['+', '-']).split(is_mark);
    let head = parts.next().is_some_and(|part| (1..=3).contains(&part.len()));
    let parts: Vec<&str> = parts.collect();
    let are_digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    // The last part may be what stands behind the decimal mark.
    let groups = parts.len().saturating_sub(usize::from(parts.len() > 1));
    let plain = text.trim_start_matches(['+', '-']).chars().all(|c| c.is_ascii_digit() || is_mark(c));
    head && plain
        && groups > 0
        && parts.iter().all(|part| are_digits(part))
        && parts[..groups].iter().all(|part| part.len() == 3)
}

/// Whether a cell says that it has no value: empty, or NaN, null and their like as programs write them.
pub(crate) fn is_missing(text: &str) -> bool {
    const WORDS: [&str; 10] = ["nan", "null", "na", "n/a", "<na>", "none", "nil", "#n/a", "#nv", "missing"];
    let Some(&first) = text.as_bytes().first() else { return true };
    // What Microsoft's C library writes: 1.#QNAN, -1.#IND.
    if text.contains('#') && text.len() < 12 {
        let after = text.trim_start_matches(['+', '-']).strip_prefix("1.#");
        let is_not_a_number = |name: &str| ["qnan", "snan", "ind"].iter().any(|known| name.starts_with(known));
        if after.is_some_and(|name| is_not_a_number(&name.to_ascii_lowercase())) {
            return true;
        }
    }
    if first.is_ascii_digit() || text.len() > 12 {
        return false;
    }
    let word = text.trim_start_matches(['+', '-']).to_ascii_lowercase();
    // `nan(ind)` and `nan(snan)`.
    WORDS.contains(&word.as_str()) || word.starts_with("nan(")
}

/// A cell of a known column in SI units.
pub(crate) fn si(
    line: TextLine<'_>,
    text: &str,
    column: &Column,
    mark: &mut DecimalMark,
    index: usize,
) -> Result<f64, RecordingError> {
    let value = mark.number(line, &column.header, text, index)?;
    let place = || line.cell(mark.separator, index);
    let Some(si) = column.read(value) else { return Err(column.out_of_reach(place(), value)) };
    if si.is_finite() {
        return Ok(si);
    }
    Err(RecordingError::NotFinite { place: place(), header: column.header.clone(), found: text.to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ChannelMap, Recording, Signal, read_from};

    fn read(text: &str) -> Result<Recording, RecordingError> {
        read_from("run.csv", text.as_bytes(), &ChannelMap::default())
    }

    #[test]
    fn a_text_with_two_marks_is_refused_with_both_cells() {
        for text in [
            "time [s];position [mm];load_force [N]\n0,000;149,5;998\n0,002;149,6;1.300\n",
            "time [s]\tposition [mm]\tload_force [N]\n0.000\t149.5\t998\n0.002\t149.6\t1,300\n",
            "time [s];load_force [N];spool\n0;1.300;0,5\n1;1.301;0,5\n",
            "time [s],load_force [N],position [mm]\n0,\"1,300\",149.5\n1,\"1,301\",149.5\n",
            "load_force [N];time [s]\n1.300;0,5\n1.301;0,6\n",
        ] {
            let refused = read(text).unwrap_err();
            assert!(matches!(refused, RecordingError::Mark { fault: MarkFault::Other(_), .. }), "{text}: {refused}");
        }
        let refused = read("time [s];load_force [N]\n0,5;998\n1,5;1.300\n").unwrap_err().to_string();
        let expected = "run.csv:3:5: column `load_force [N]` holds `1.300` with a point, and column `time [s]` holds `0,5` with a comma in line 2; \
             expected one decimal mark in the whole file and no thousands mark: 1300 is written so";
        assert_eq!(refused, expected);
    }

    #[test]
    fn a_thousands_mark_is_refused() {
        for cell in ["1.234,5", "1,234.5", "1.234.567", "1 300", "1'300", "1\u{202f}300,5", "-12\u{a0}300"] {
            let refused = read(&format!("time [s];load_force [N]\n0;1\n1;{cell}\n2;3\n")).unwrap_err();
            assert!(matches!(refused, RecordingError::Mark { fault: MarkFault::Thousands, .. }), "{cell}: {refused}");
        }
        for cell in ["1.2.3", "12.05.2024", "a.b,c", "1..2", ".", "--1"] {
            let refused = read(&format!("time [s];load_force [N]\n0;1\n1;{cell}\n2;3\n")).unwrap_err();
            assert!(matches!(refused, RecordingError::NotANumber { .. }), "{cell}: {refused}");
        }
    }

    #[test]
    fn where_no_number_tells_the_mark_nothing_is_guessed() {
        for text in [
            "time [ms];load_force [N]\n0;1.300\n10;998\n20;-2.150\n",
            "time [ms];load_force [N]\n0;1,300\n10;1,400\n",
            "time [ms],load_force [N]\n0,\"1,300\"\n10,\"1,400\"\n",
        ] {
            let refused = read(text).unwrap_err();
            assert!(matches!(refused, RecordingError::Mark { fault: MarkFault::Unknown, .. }), "{text}: {refused}");
        }
        // One number that cannot be grouped by thousands tells it, wherever it stands; or commas end the cells.
        for (text, force) in [
            ("time [ms];load_force [N]\n0;1.300\n10;998\n20;0.150\n", 1.3),
            ("time [s];load_force [N]\n0,00;1,300\n0,01;1,400\n", 1.3),
            ("time [ms],load_force [N]\n0,1.300\n10,1.400\n", 1.3),
            ("time [ms],load_force [N]\n0,\"1,30\"\n10,\"1,400\"\n", 1.3),
            ("time [ms];load_force [N]\n0;1300.125\n10;1.400\n", 1300.125),
            ("time [ms];load_force [N]\n0;1300\n10;1400\n", 1300.0),
        ] {
            let found = read(text).unwrap().signal(Signal::LoadForce).unwrap()[0];
            assert!((found - force).abs() < 1e-12, "{text}: {found}");
        }
    }

    #[test]
    fn what_programs_write_for_no_value_is_no_value() {
        for cell in [
            "",
            "NaN",
            "nan",
            "-nan",
            "-nan(ind)",
            "NA",
            "N/A",
            "#N/A",
            "null",
            "NULL",
            "None",
            "1.#QNAN",
            "-1.#IND",
            "<NA>",
        ] {
            let recording = read(&format!("time [s],spool\n0,0\n1,{cell}\n2,2\n")).unwrap();
            assert_eq!(recording.signal(Signal::Spool).unwrap(), [0.0, 2.0], "{cell}");
            assert_eq!(recording.notes()[0].to_string(), "1 row has an empty cell and is left out, in line 3");
        }
        for cell in ["inf", "-Infinity", "1.#INF", "x", "-", "#DIV/0!"] {
            assert!(read(&format!("time [s],spool\n0,0\n1,{cell}\n2,2\n")).is_err(), "{cell}");
        }
    }
}
