//! Excel workbooks (`.xlsx`), by the library `calamine`.
//!
//! The sheet with the recording becomes text with one line a row, which is read as any other text: header, row of units, dates, empty cells and all. Numbers come as the
//! workbook holds them, to the last digit, whatever their format shows. Of several sheets that with a column of time is read.

use std::collections::HashMap;
use std::io::{self, Cursor, Read, Write};

use calamine::{CellErrorType, DataRef, Reader, SheetType, Xlsx, XlsxError};
use chrono::{NaiveDate, TimeDelta};
use zip::ZipArchive;

use super::catch_panic::contained;
use super::format::{Format, MAX_UNPACKED_BYTES};
use super::sheet::quoted;
use super::text::csv::Opened;
use super::text::heading::Heading;
use super::text::lines::{self, Lines, MAX_COLUMNS};
use super::unsupported::Unsupported;
use crate::channel_map::ChannelMap;
use crate::error::RecordingError;
use crate::files::source_error::Place;

/// Opens the sheet that holds the recording.
pub(crate) fn open(name: &str, bytes: Vec<u8>, map: &ChannelMap) -> Result<Opened<'static>, RecordingError> {
    Opened::text(name, Box::new(Cursor::new(text(name, bytes, map)?)), map)
}

/// The text of the sheet that holds the recording.
pub(crate) fn text(name: &str, bytes: Vec<u8>, map: &ChannelMap) -> Result<Vec<u8>, RecordingError> {
    check(name, &bytes, MAX_UNPACKED_BYTES)?;
    // The library does not promise that it never panics on damaged files.
    let sheets = contained(|| sheets(bytes)).and_then(Result::ok);
    let mut sheets = sheets.ok_or_else(|| damaged(name, "sheets that cannot be read"))?;
    sheets.retain(|(_, text)| !text.is_empty());
    if sheets.len() > 1 {
        let timed: Vec<usize> = (0..sheets.len()).filter(|index| has_time(&sheets[*index].1, map)).collect();
        match timed.as_slice() {
            [] => sheets.truncate(1),
            [one] => sheets.swap(0, *one),
            several => {
                let what = Unsupported::Sheets(several.iter().map(|index| sheets[*index].0.clone()).collect());
                return Err(RecordingError::Unsupported { place: Place::file(name), what });
            }
        }
    }
    Ok(sheets.into_iter().next().map(|(_, text)| text).unwrap_or_default())
}

fn damaged(name: &str, what: &'static str) -> RecordingError {
    RecordingError::Damaged { place: Place::file(name), format: Format::Xlsx, what }
}

/// Checks that an archive is a workbook, and that it unpacks to no more than may be held, whatever its list of files says.
fn check(name: &str, bytes: &[u8], most_bytes: u64) -> Result<(), RecordingError> {
    let unsupported = |what| RecordingError::Unsupported { place: Place::file(name), what };
    let opened = contained(|| ZipArchive::new(Cursor::new(bytes))).and_then(Result::ok);
    let mut archive = opened.ok_or_else(|| damaged(name, "a list of its parts that cannot be read"))?;
    if archive.index_for_name("xl/workbook.bin").is_some() {
        return Err(unsupported(Unsupported::Foreign(
            "a binary Excel workbook (.xlsb)",
            "what is read: save it as CSV or .xlsx",
        )));
    }
    if archive.index_for_name("xl/workbook.xml").is_none() {
        return Err(unsupported(other_archive(&mut archive)));
    }
    let mut unpacked = 0;
    for index in 0..archive.len() {
        let counted = contained(|| {
            let part = archive.by_index(index).map_err(io::Error::other)?;
            io::copy(&mut part.take(most_bytes + 1 - unpacked), &mut io::sink())
        });
        let counted = counted.and_then(Result::ok);
        unpacked += counted.ok_or_else(|| damaged(name, "packed data that cannot be unpacked"))?;
        if unpacked > most_bytes {
            return Err(RecordingError::TooLarge { place: Place::file(name), most_bytes });
        }
    }
    Ok(())
}

/// What an archive is that is no workbook.
fn other_archive(archive: &mut ZipArchive<Cursor<&[u8]>>) -> Unsupported {
    const SAVED: &str = "what is read: save it as CSV or .xlsx";
    const NUMBERS: &str = "the numbers: CSV or .xlsx from the program that wrote it";
    let has = |name: &str| archive.index_for_name(name).is_some();
    if has("word/document.xml") {
        return Unsupported::Foreign("a Word document (.docx)", NUMBERS);
    }
    if has("ppt/presentation.xml") {
        return Unsupported::Foreign("a PowerPoint presentation (.pptx)", NUMBERS);
    }
    if !has("content.xml") {
        return Unsupported::Foreign("a ZIP archive", "a file in it: unpack it");
    }
    let mut kind = String::new();
    let told = contained(|| archive.by_name("mimetype").map_err(io::Error::other)?.take(100).read_to_string(&mut kind));
    let is_sheet = told.is_none_or(|read| read.is_err()) || kind.contains("spreadsheet");
    if is_sheet {
        Unsupported::Foreign("an OpenDocument spreadsheet (.ods)", SAVED)
    } else {
        Unsupported::Foreign("an OpenDocument file that is no spreadsheet", NUMBERS)
    }
}

/// The names and texts of the sheets.
fn sheets(bytes: Vec<u8>) -> Result<Vec<(String, Vec<u8>)>, XlsxError> {
    let is_calculated = is_calculated(&bytes);
    let mut workbook = Xlsx::new(Cursor::new(bytes))?;
    let is_sheet = |sheet: &&calamine::Sheet| sheet.typ == SheetType::WorkSheet;
    let names: Vec<String> =
        workbook.sheets_metadata().iter().filter(is_sheet).map(|sheet| sheet.name.clone()).collect();
    let mut texts = Vec::new();
    for name in names {
        let (mut text, lacks_values) = rows(&mut workbook, &name, &Formulas::default())?;
        if lacks_values || !is_calculated {
            let formulas = Formulas::of(&mut workbook, &name, is_calculated)?;
            if !formulas.cells.is_empty() {
                text = rows(&mut workbook, &name, &formulas)?.0;
            }
        }
        texts.push((name, text));
    }
    Ok(texts)
}

/// Whether the formulas of a workbook have been calculated: a library that writes them leaves that to the program that opens the file.
fn is_calculated(bytes: &[u8]) -> bool {
    let mut text = String::new();
    let read = ZipArchive::new(Cursor::new(bytes)).map_err(io::Error::other).and_then(|mut archive| {
        archive.by_name("xl/workbook.xml").map_err(io::Error::other)?.read_to_string(&mut text)
    });
    read.is_err() || !["1", "true"].iter().any(|yes| text.contains(&format!("fullCalcOnLoad=\"{yes}\"")))
}

/// The formulas of a sheet.
#[derive(Default)]
struct Formulas {
    /// By row and column.
    cells: HashMap<(u32, u32), String>,
    /// Whether a zero may be a value that has not been calculated.
    is_zero_none: bool,
}

impl Formulas {
    fn of(workbook: &mut Xlsx<Cursor<Vec<u8>>>, name: &str, is_calculated: bool) -> Result<Self, XlsxError> {
        let mut reader = workbook.worksheet_cells_reader(name)?;
        let mut cells = HashMap::new();
        while let Some(cell) = reader.next_formula()? {
            if !cell.get_value().is_empty() {
                cells.insert(cell.get_position(), format!("={}", cell.get_value()));
            }
        }
        Ok(Self { cells, is_zero_none: !is_calculated })
    }

    /// The formula of a cell whose value has not been calculated.
    fn instead_of(&self, value: &DataRef<'_>, at: (u32, u32)) -> Option<&str> {
        let is_none = match value {
            DataRef::Empty => true,
            DataRef::Int(0) => self.is_zero_none,
            DataRef::Float(value) => self.is_zero_none && *value == 0.0,
            _ => false,
        };
        if is_none { self.cells.get(&at).map(String::as_str) } else { None }
    }
}

/// The rows of a sheet, each on the line of its number, and whether cells have no value. Such a cell is written as its formula, which then is no number.
fn rows(workbook: &mut Xlsx<Cursor<Vec<u8>>>, name: &str, formulas: &Formulas) -> Result<(Vec<u8>, bool), XlsxError> {
    let mut cells = workbook.worksheet_cells_reader(name)?;
    let (mut text, mut line, mut column) = (Vec::new(), 0, 0);
    let mut lacks_values = false;
    // Empty cells at the end of a row are cells: as many as the header, the first row that is no comment, has.
    let (mut width, mut is_comment) = (None, false);
    while let Some(cell) = cells.next_cell()? {
        let (at_row, at_column) = cell.get_position();
        let written = match cell.get_value() {
            // A comment, which a quotation mark before it would hide.
            DataRef::SharedString(text) if at_column == 0 => comment(text).unwrap_or_else(|| in_text(text)),
            DataRef::String(text) if at_column == 0 => comment(text).unwrap_or_else(|| in_text(text)),
            value => match formulas.instead_of(value, (at_row, at_column)) {
                Some(formula) => in_text(formula),
                None => written(value),
            },
        };
        lacks_values |= matches!(cell.get_value(), DataRef::Empty);
        // What lies far outside, or in a row that has been passed, is no part of a table.
        if written.is_empty() || at_row < line || at_column as usize >= 2 * MAX_COLUMNS {
            continue;
        }
        if at_row > line {
            end_row(&mut text, column, is_comment, &mut width);
            is_comment = false;
            text.resize(text.len() + (at_row - line) as usize, b'\n');
            (line, column) = (at_row, 0);
        }
        if at_column < column {
            continue;
        }
        text.resize(text.len() + (at_column - column) as usize, b',');
        column = at_column;
        is_comment |= column == 0 && lines::is_comment(written.as_bytes());
        text.write_all(written.as_bytes())?;
    }
    if !text.is_empty() {
        end_row(&mut text, column, is_comment, &mut width);
        text.push(b'\n');
    }
    Ok((text, lacks_values))
}

/// Adds the empty cells at the end of a row, whose last cell stands in `column`.
fn end_row(text: &mut Vec<u8>, column: u32, is_comment: bool, width: &mut Option<u32>) {
    if text.last().is_none_or(|last| *last == b'\n') || is_comment {
        return;
    }
    let last = *width.get_or_insert(column);
    text.resize(text.len() + last.saturating_sub(column) as usize, b',');
}

/// A cell as it stands in a text.
fn written(value: &DataRef<'_>) -> String {
    match value {
        DataRef::Int(value) => value.to_string(),
        DataRef::Float(value) => format!("{value}"),
        DataRef::String(text) | DataRef::DateTimeIso(text) | DataRef::DurationIso(text) => in_text(text),
        DataRef::SharedString(text) => in_text(text),
        DataRef::Bool(value) => u8::from(*value).to_string(),
        DataRef::DateTime(stamp) => date(stamp.as_f64()),
        DataRef::Error(CellErrorType::NA) => "#N/A".to_owned(),
        DataRef::Error(error) => in_text(&error.to_string()),
        DataRef::Empty => String::new(),
    }
}

fn in_text(text: &str) -> String {
    quoted(text.trim())
}

/// The text of a row's first cell that makes the row a comment.
fn comment(text: &str) -> Option<String> {
    let on_one_line = || text.replace(char::is_control, " ");
    lines::is_comment(text.as_bytes()).then(on_one_line)
}

/// A date that is counted in days, with the time of the day.
fn date(days: f64) -> String {
    let microseconds = (days * 86_400e6).round();
    #[expect(clippy::cast_possible_truncation, reason = "no date of a workbook is beyond the year 9999")]
    let passed = TimeDelta::microseconds(microseconds.clamp(0.0, 3e17) as i64);
    let first = NaiveDate::from_ymd_opt(1899, 12, 30).and_then(|day| day.and_hms_opt(0, 0, 0));
    let at = first.and_then(|first| first.checked_add_signed(passed));
    at.map_or_else(String::new, |at| at.format("%Y-%m-%dT%H:%M:%S%.6f").to_string())
}

/// Whether a text has a header with a column of time.
fn has_time(text: &[u8], map: &ChannelMap) -> bool {
    let mut lines = Lines::new("", Box::new(text));
    Heading::read(&mut lines).is_ok_and(|(heading, _)| heading.has_time(map))
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;
    use std::io::Write as _;

    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    use super::*;
    use crate::{Recording, Signal, read_from};

    /// A workbook of sheets with these names and rows; the cells of a row are as they stand in its XML.
    fn workbook(sheets: &[(&str, &[&[&str]])]) -> Vec<u8> {
        workbook_of(sheets, "")
    }

    /// The same, with another part of the list of sheets.
    fn workbook_of(sheets: &[(&str, &[&[&str]])], more: &str) -> Vec<u8> {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        let mut add = |name: &str, text: String| {
            zip.start_file(name, SimpleFileOptions::default()).unwrap();
            zip.write_all(text.as_bytes()).unwrap();
        };
        let (mut list, mut relations) = (String::new(), String::new());
        for (index, (name, rows)) in sheets.iter().enumerate() {
            let number = index + 1;
            write!(list, "<sheet name=\"{name}\" sheetId=\"{number}\" r:id=\"r{number}\"/>").unwrap();
            write!(
                relations,
                "<Relationship Id=\"r{number}\" Target=\"worksheets/sheet{number}.xml\" \
                 Type=\"http://schemas.openxmlformats.org/officeDocument/2006/relationships/worksheet\"/>"
            )
            .unwrap();
            let mut data = String::new();
            for (row, cells) in rows.iter().enumerate() {
                write!(data, "<row r=\"{}\">", row + 1).unwrap();
                for (letter, cell) in ('A'..).zip(*cells).filter(|(_, cell)| !cell.is_empty()) {
                    let place = format!("{letter}{}", row + 1);
                    match cell.split_once('|') {
                        Some(("formula", value)) => write!(data, "<c r=\"{place}\"><f>{value}</f></c>"),
                        Some(("zero", value)) => write!(data, "<c r=\"{place}\"><f>{value}</f><v>0</v></c>"),
                        Some(("date", value)) => write!(data, "<c r=\"{place}\" s=\"1\"><v>{value}</v></c>"),
                        Some((kind, value)) => write!(data, "<c r=\"{place}\" t=\"{kind}\"><v>{value}</v></c>"),
                        None if cell.parse::<f64>().is_ok() => write!(data, "<c r=\"{place}\"><v>{cell}</v></c>"),
                        None => write!(data, "<c r=\"{place}\" t=\"inlineStr\"><is><t>{cell}</t></is></c>"),
                    }
                    .unwrap();
                }
                data.push_str("</row>");
            }
            let sheet = format!(
                "<worksheet xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\"><sheetData>{data}</sheetData></worksheet>"
            );
            add(&format!("xl/worksheets/sheet{number}.xml"), sheet);
        }
        let main = "xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\" \
            xmlns:r=\"http://schemas.openxmlformats.org/officeDocument/2006/relationships\"";
        add("xl/workbook.xml", format!("<workbook {main}><sheets>{list}</sheets>{more}</workbook>"));
        let packages = "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"";
        let start = "<Relationship Id=\"r1\" Target=\"xl/workbook.xml\" \
            Type=\"http://schemas.openxmlformats.org/officeDocument/2006/relationships/officeDocument\"/>";
        add("_rels/.rels", format!("<Relationships {packages}>{start}</Relationships>"));
        add("xl/_rels/workbook.xml.rels", format!("<Relationships {packages}>{relations}</Relationships>"));
        let formats = "<cellXfs><xf numFmtId=\"0\"/><xf numFmtId=\"22\"/></cellXfs>";
        add("xl/styles.xml", format!("<styleSheet {main}>{formats}</styleSheet>"));
        zip.finish().unwrap().into_inner()
    }

    fn read(bytes: &[u8]) -> Result<Recording, RecordingError> {
        read_from("run.xlsx", bytes, &ChannelMap::default())
    }

    #[test]
    fn a_sheet_is_read_as_a_text_is() {
        let rows: &[&[&str]] = &[
            &["# Bench 3, run 7"],
            &[],
            &["remark", "time", "position", "load_force"],
            &["", "ms", "mm", "N"],
            &["a, b", "0", "1.234", "1300"],
            &["", "10", "0.1", "e|#N/A"],
            &["", "20", "1.25", "1300.125"],
        ];
        let recording = read(&workbook(&[("Data", rows)])).unwrap();
        assert_eq!(recording.time_s(), [0.0, 0.02]);
        assert_eq!(recording.signal(Signal::Position).unwrap(), [0.001_234, 0.00125]);
        assert_eq!(recording.signal(Signal::LoadForce).unwrap(), [1300.0, 1300.125]);
        assert_eq!(recording.ignored(), ["remark"]);
        assert_eq!(recording.notes()[0].to_string(), "1 row has an empty cell and is left out, in line 6");
        // A row of the sheet is a line in messages. A number that is a text there has the mark that it is written with.
        let comma: &[&[&str]] = &[&["time [s]", "spool"], &["0.5", "0"], &["1.5", "0,25"], &["2.5", "0"]];
        let refused = read(&workbook(&[("Data", comma)])).unwrap_err();
        assert!(
            matches!(refused, RecordingError::Mark { .. }) && refused.to_string().starts_with("run.xlsx:3:5"),
            "{refused}"
        );
    }

    #[test]
    fn formulas_without_values_and_errors_are_refused_and_empty_cells_are_cells() {
        let of = |cell: &str| {
            read(&workbook(&[(
                "Run",
                &[&["time [s]", "position [mm]", "remark"], &["0", "0.5", "x"], &["1", cell], &["2", "1.5"], &["3"]],
            )]))
        };
        let told = of("formula|A2*2").unwrap_err().to_string();
        let begins =
            "run.xlsx:3:3: column `position [mm]` holds `=A2*2`; expected a number: formulas without a saved value";
        assert!(told.starts_with(begins), "{told}");
        let told = of("e|#DIV/0!").unwrap_err().to_string();
        assert!(
            told.starts_with("run.xlsx:3:3: column `position [mm]` holds `#DIV/0!`; expected a number: correct"),
            "{told}"
        );
        // A library writes a zero, and that the workbook is still to be calculated.
        assert_eq!(of("zero|A2*2").unwrap().rows(), 3);
        let begun = [&[&["time [s]", "position [mm]"][..], &["0", "0.5"], &["1", "zero|A2*2"]][..]];
        let told = read(&workbook_of(&[("Run", begun[0])], "<calcPr fullCalcOnLoad=\"1\"/>")).unwrap_err().to_string();
        assert!(told.contains("holds `=A2*2`"), "{told}");
        assert_eq!(of("1.25").unwrap().rows(), 3, "the last row has no position");
        assert_eq!(of("").unwrap().rows(), 2);
        assert_eq!(of("formula|").unwrap().rows(), 2, "an empty formula is an empty cell");
        // Numbers have a point, whatever a spreadsheet shows; numbers that are text and have a comma are refused.
        let told = of("1,25").unwrap_err().to_string();
        assert!(
            told.contains("`1,25` with a comma") && told.contains("make numbers of the cells that are text"),
            "{told}"
        );
        let units: &[&[&str]] = &[&["time [s]", "position [mm]"], &["s", "cm"], &["0", "0.5"], &["1", "0.75"]];
        let told = read(&workbook(&[("Run", units)])).unwrap_err().to_string();
        assert!(
            told.starts_with("run.xlsx:1:10: column `position [mm]` has the unit `mm` in its name and `cm`"),
            "{told}"
        );
    }

    #[test]
    fn dates_are_times() {
        let rows: &[&[&str]] = &[
            &["time", "spool"],
            &["date|45000.25", "0.1"],
            &["date|45000.250000115741", "0.2"],
            &["date|45000.2500002315", "0.3"],
        ];
        let recording = read(&workbook(&[("Data", rows)])).unwrap();
        let worst = recording.time_s().iter().zip([0.0, 0.01, 0.02]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 3e-6, "{worst}");
    }

    #[test]
    fn of_several_sheets_that_with_times_is_read() {
        let notes: &[&[&str]] = &[&["Made by", "Somebody"]];
        let run: &[&[&str]] = &[&["time [s]", "spool"], &["0", "0.1"], &["1", "0.2"]];
        assert_eq!(read(&workbook(&[("Notes", notes), ("Run", run), ("Empty", &[])])).unwrap().rows(), 2);
        let two = read(&workbook(&[("Run 1", run), ("Notes", notes), ("Run 2", run)])).unwrap_err();
        let expected = "run.xlsx: a workbook with times in the sheets `Run 1`, `Run 2`; expected one recording a workbook: save each sheet as CSV or \
             as a workbook of its own";
        assert_eq!(two.to_string(), expected);
        assert!(matches!(read(&workbook(&[("Notes", notes)])), Err(RecordingError::NoTimeColumn { .. })));
    }

    #[test]
    fn other_archives_say_what_they_are() {
        let archive = |name: &str| {
            let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
            zip.start_file(name, SimpleFileOptions::default()).unwrap();
            zip.write_all(b"x").unwrap();
            read(&zip.finish().unwrap().into_inner()).unwrap_err().to_string()
        };
        assert!(
            archive("content.xml")
                .contains("an OpenDocument spreadsheet (.ods); expected what is read: save it as CSV or .xlsx")
        );
        assert!(archive("xl/workbook.bin").contains("(.xlsb)"));
        assert!(archive("word/document.xml").contains("a Word document (.docx); expected the numbers"));
        assert!(archive("run.csv").contains("a ZIP archive; expected a file in it: unpack it"));
        let whole = workbook(&[("Run", &[&["time [s]", "spool"], &["0", "0.1"], &["1", "0.2"]])]);
        for length in (4..whole.len()).step_by(7) {
            assert!(read(&whole[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn a_workbook_that_becomes_too_much_is_refused_whatever_its_list_says() {
        let workbook = workbook(&[("Run", &[&["time [s]", "spool"]])]);
        check("run.xlsx", &workbook, 1 << 20).unwrap();
        let refused = check("run.xlsx", &workbook, 1 << 8).unwrap_err();
        assert!(matches!(refused, RecordingError::TooLarge { .. }), "{refused}");
    }
}
