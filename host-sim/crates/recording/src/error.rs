//! Why a recording cannot be used.

use std::path::Path;
use std::{fmt, io};

use crate::files::atomic;
use crate::files::source_error::{Explained, Place, after_number, counted, engineering, is_number, quoted};
use crate::formats::format::Format;
use crate::formats::mark_fault::{MarkFault, MarkedCell};
use crate::formats::text_fault::TextFault;
use crate::formats::unsupported::Unsupported;
use crate::signal::{Signal, split_header};
use crate::unit::{Dimension, Unit};
use crate::unit_in_name::{split_suffix, variable};

/// Why a recording cannot be read, or cannot be used for the purpose in hand.
#[expect(missing_docs, reason = "every field is named in the text of its variant; `place` is where it was found")]
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file cannot be opened or read.
    Io { place: Place, source: io::Error },
    /// The file cannot be written.
    Write { place: Place, source: io::Error },
    /// The file holds nothing but blank lines and comments.
    Empty { place: Place },
    /// There are fewer than two rows that can be used; `skipped` rows had an empty cell or a repeated time.
    TooFewRows { place: Place, rows: usize, skipped: usize },
    /// More rows than the program takes.
    TooManyRows { place: Place, most: usize },
    /// More columns than the program takes.
    TooManyColumns { place: Place, most: usize },
    /// A line is longer than any line of a recording.
    LineTooLong { place: Place, most_bytes: usize },
    /// More blank lines and comments than a recording can have.
    TooManySkippedLines { place: Place, most: usize },
    /// A line is not UTF-8 text.
    NotUtf8 { place: Place, byte: u8 },
    /// A line holds a control character, as binary files do.
    ControlCharacter { place: Place, character: char },
    /// A quotation mark is not closed on its line.
    OpenQuote { place: Place },
    /// No column is time; `present` are the columns' names.
    NoTimeColumn { place: Place, present: Vec<String> },
    /// The column that is mapped to time numbers the rows.
    Index { place: Place, header: String },
    /// Two columns hold the same signal.
    DuplicateColumn { place: Place, signal: Signal, first: String, second: String },
    /// Two columns that are to be read are called alike; their numbers, from 1.
    AlikeColumns { place: Place, header: String, numbers: [usize; 2] },
    /// Known names without a unit in brackets; `place` is where the first one stands.
    MissingUnit { place: Place, columns: Vec<(Signal, String)> },
    /// A known name with an unknown unit.
    UnknownUnit { place: Place, signal: Signal, header: String, unit: String },
    /// A known name with a unit of another quantity.
    WrongDimension { place: Place, signal: Signal, header: String, unit: String },
    /// A column that `--map` names is not in the file.
    MappedColumnAbsent { place: Place, signal: Signal, header: String, present: Vec<String> },
    /// A column that was requested by its header is not in the file.
    ColumnAbsent { place: Place, header: String, present: Vec<String> },
    /// A row has more or fewer cells than the header.
    RaggedRow { place: Place, found: usize, expected: usize },
    /// A cell of a known column is not a number.
    NotANumber { place: Place, header: String, found: String },
    /// The mark in a number does not say, or contradicts, which number it is.
    Mark { place: Place, cell: Box<MarkedCell>, fault: MarkFault },
    /// The layout of a text does not say, or contradicts, what its cells are.
    Text { place: Place, fault: TextFault },
    /// A time that is not written as those of the rows above.
    NotAStamp { place: Place, header: String, found: String },
    /// A cell of a known column is NaN or infinite, as written or after conversion to SI.
    NotFinite { place: Place, header: String, found: String },
    /// An angle of the joint beyond what the linkage reaches, all in the unit of the file.
    AngleOutOfReach { place: Place, found: f64, from: f64, to: f64, unit: &'static str },
    /// Time is smaller than in the row before, both in s.
    TimeBackwards { place: Place, previous_s: f64, found_s: f64 },
    /// An export without the header rows or columns that this kind of export needs.
    ExportLayout { place: Place, missing: &'static str },
    /// An export whose times are dates and not offsets; a double cannot hold them precisely enough.
    FullTimestamps { place: Place, found: String },
    /// The channels of an export have no time interval in common.
    NoCommonTime { place: Place, from_s: f64, to_s: f64 },
    /// A required signal is missing.
    MissingSignal { place: Place, signal: Signal, present: Vec<&'static str> },
    /// A signal that is to be judged never changes; the value is in SI units.
    ConstantSignal { place: Place, signal: Signal, value: f64 },
    /// A file of a format that this build of the program does not read or write.
    FeatureAbsent { place: Place, format: Format },
    /// A file that is neither text nor of the format that its name shows.
    NotOfFormat { place: Place, format: Format },
    /// A file of a known format, in a variant that is not read.
    Unsupported { place: Place, what: Unsupported },
    /// A file that is incomplete or violates its format; `what` describes the fault.
    Damaged { place: Place, format: Format, what: &'static str },
    /// More bytes than may be held in memory, as they stand in the file or unpacked.
    TooLarge { place: Place, most_bytes: u64 },
    /// A known signal whose values have no times; `present` is what the file has.
    NoTimes { place: Place, header: String, present: Vec<String> },
    /// A file without times, or with no known signal besides time; `present` is what it has.
    NothingKnown { place: Place, present: Vec<String> },
    /// A known signal that holds something other than numbers.
    NotNumbers { place: Place, header: String, found: String },
    /// The number of values in a column differs from the number of times.
    LengthMismatch { place: Place, header: String, found: usize, expected: usize },
}

use RecordingError as E;

impl Explained for RecordingError {
    fn place(&self) -> &Place {
        match self {
            E::Io { place, .. }
            | E::Write { place, .. }
            | E::Empty { place }
            | E::TooFewRows { place, .. }
            | E::TooManyRows { place, .. }
            | E::TooManyColumns { place, .. }
            | E::LineTooLong { place, .. }
            | E::TooManySkippedLines { place, .. }
            | E::NotUtf8 { place, .. }
            | E::ControlCharacter { place, .. }
            | E::OpenQuote { place }
            | E::NoTimeColumn { place, .. }
            | E::Index { place, .. }
            | E::DuplicateColumn { place, .. }
            | E::AlikeColumns { place, .. }
            | E::MissingUnit { place, .. }
            | E::UnknownUnit { place, .. }
            | E::WrongDimension { place, .. }
            | E::MappedColumnAbsent { place, .. }
            | E::ColumnAbsent { place, .. }
            | E::RaggedRow { place, .. }
            | E::NotANumber { place, .. }
            | E::Mark { place, .. }
            | E::Text { place, .. }
            | E::NotAStamp { place, .. }
            | E::NotFinite { place, .. }
            | E::AngleOutOfReach { place, .. }
            | E::TimeBackwards { place, .. }
            | E::ExportLayout { place, .. }
            | E::FullTimestamps { place, .. }
            | E::NoCommonTime { place, .. }
            | E::MissingSignal { place, .. }
            | E::ConstantSignal { place, .. }
            | E::FeatureAbsent { place, .. }
            | E::NotOfFormat { place, .. }
            | E::Unsupported { place, .. }
            | E::Damaged { place, .. }
            | E::TooLarge { place, .. }
            | E::NoTimes { place, .. }
            | E::NothingKnown { place, .. }
            | E::NotNumbers { place, .. }
            | E::LengthMismatch { place, .. } => place,
        }
    }

    fn found(&self) -> String {
        match self {
            E::Io { source, .. } => format!("cannot be read: {source}"),
            E::Write { source, .. } => format!("cannot be written: {source}"),
            E::Empty { .. } => "there is nothing in the file".into(),
            E::TooFewRows { rows: 0, skipped: 0, .. } => "a header and no rows".into(),
            E::TooFewRows { rows, skipped: 0, .. } => counted(*rows, "row"),
            E::TooFewRows { rows, skipped, .. } => {
                let verbs = if *skipped == 1 { "has an empty cell or repeats" } else { "have an empty cell or repeat" };
                format!("{}; {skipped} {verbs} a time", counted(*rows, "usable row"))
            }
            E::TooManyRows { most, .. } => format!("more than {most} rows"),
            E::TooManyColumns { most, .. } => format!("more than {most} columns"),
            E::LineTooLong { most_bytes, .. } => format!("a line of more than {most_bytes} bytes"),
            E::TooManySkippedLines { most, .. } => format!("more than {most} blank lines and comments"),
            E::NotUtf8 { byte, .. } => format!("byte 0x{byte:02X}, which is not UTF-8 text"),
            E::ControlCharacter { character, .. } => {
                format!("control character U+{:04X}, which is not text", u32::from(*character))
            }
            E::OpenQuote { .. } => "a quotation mark that is not closed on its line".into(),
            E::NoTimeColumn { present, .. } if are_numbers(present) => "numbers where the header should be".into(),
            E::NoTimeColumn { .. } => "no column is time".into(),
            E::Index { header, .. } => format!("column {} numbers the rows, and is mapped to time", quoted(header)),
            E::AlikeColumns { header, numbers: [first, second], .. } => {
                format!("columns {first} and {second} are both called {}", quoted(header))
            }
            E::DuplicateColumn { signal, first, second, .. } => {
                format!("columns {} and {} both hold {signal}", quoted(first), quoted(second))
            }
            E::MissingUnit { columns, .. } => {
                let headers: Vec<String> = columns.iter().map(|(_, header)| quoted(header)).collect();
                match headers.as_slice() {
                    [one] => format!("column {one} has no unit"),
                    several => format!("columns {} have no unit", several.join(", ")),
                }
            }
            E::UnknownUnit { header, unit, .. } => {
                format!("column {} has the unknown unit {}", quoted(header), quoted(unit))
            }
            E::WrongDimension { signal, unit, .. } => format!("{signal} is given in {}", quoted(unit)),
            E::MappedColumnAbsent { signal, header, .. } => {
                format!("{signal} is mapped to {}, which is not a column of this file", quoted(header))
            }
            E::ColumnAbsent { header, .. } => format!("{} is not a column of this file", quoted(header)),
            E::RaggedRow { found, .. } => format!("a row of {found} cells"),
            E::NotANumber { header, found, .. }
            | E::NotFinite { header, found, .. }
            | E::NotAStamp { header, found, .. } => {
                format!("column {} holds {}", quoted(header), quoted(found))
            }
            E::Mark { cell, fault, .. } => {
                format!("column {} holds {}{}", quoted(&cell.header), quoted(&cell.text), fault.found(&cell.text))
            }
            E::Text { fault, .. } => fault.found(),
            E::AngleOutOfReach { found, unit, .. } => {
                format!("a joint angle of {found} {unit}, which the linkage of the machine file does not reach")
            }
            E::TimeBackwards { previous_s, found_s, .. } => {
                format!("time {} s after {} s", engineering(*found_s), engineering(*previous_s))
            }
            E::ExportLayout { missing, .. } => format!("a TwinCAT Scope export without {missing}"),
            E::FullTimestamps { found, .. } => format!("a full timestamp, {}", quoted(found)),
            E::NoCommonTime { from_s, to_s, .. } => {
                format!(
                    "the last channel begins at {} s, the first one ends at {} s",
                    engineering(*from_s),
                    engineering(*to_s)
                )
            }
            E::MissingSignal { signal, .. } => format!("there is no {signal}"),
            E::ConstantSignal { signal, value, .. } => {
                format!("{signal} is {value}{} in every row", after_number(signal.si_unit().symbol()))
            }
            E::FeatureAbsent { format, .. } => format!("{format}, which this build of the program leaves out"),
            E::NotOfFormat { format, .. } => format!("neither text nor {format}, as its name says"),
            E::Unsupported { what, .. } => what.found(),
            E::Damaged { format, what, .. } => format!("{format} with {what}"),
            E::TooLarge { most_bytes, .. } => format!("more than {} MiB", most_bytes >> 20),
            E::NoTimes { header, .. } => format!("{} has no times", quoted(header)),
            E::NothingKnown { .. } => "nothing in the file is a known signal with times".into(),
            E::NotNumbers { header, found, .. } => format!("{} holds {found}", quoted(header)),
            E::LengthMismatch { header, found, .. } => format!("column {} has {found} values", quoted(header)),
        }
    }

    fn expected(&self) -> String {
        match self {
            E::Io { source, .. } if source.kind() == io::ErrorKind::InvalidData => {
                "a whole file: save or copy it again".into()
            }
            E::Io { .. } => "a readable file".into(),
            E::Write { source, .. } => atomic::expected(source).into(),
            E::Empty { .. } => "a header such as `time [s],command [V],position [mm]` and rows".into(),
            E::TooFewRows { .. } => "at least two rows at different times with a number in every known column".into(),
            E::TooManyRows { .. } => "a part of it: what is read is held in memory".into(),
            E::TooManyColumns { .. } | E::TooLarge { .. } => "a smaller recording".into(),
            E::LineTooLong { .. } | E::TooManySkippedLines { .. } => {
                "a text file with a header and one row a line".into()
            }
            E::NotUtf8 { .. } => {
                "text in UTF-8, UTF-16 or Windows-1252; others are converted by `iconv -f … -t UTF-8 in.csv > out.csv`. A file that is no text is exported \
                 as CSV by the program that wrote it"
                    .into()
            }
            E::ControlCharacter { .. } => {
                "a text file in UTF-8 with line ends LF or CRLF; one that is no text is exported as CSV by the program that wrote it"
                    .into()
            },
            E::OpenQuote { .. } => "a closing quotation mark on the same line".into(),
            E::NoTimeColumn { present, .. } => time_column(present),
            E::Index { .. } => "a column of times: the number of a row is not its time".into(),
            E::AlikeColumns { .. } => "names that differ: rename or delete one of the two columns".into(),
            E::DuplicateColumn { signal, .. } => format!("one column for {signal}; choose with --map \"{signal}=…\""),
            E::MissingUnit { place, columns } => missing_units(place, columns),
            E::UnknownUnit { signal, header, .. } => {
                format!("a unit in brackets after the name, one of: {}{}", signal.units(), or_unused(*signal, header))
            }
            E::WrongDimension { signal, header, .. } => {
                format!("a unit of {signal}, one of: {}{}", signal.units(), or_unused(*signal, header))
            }
            E::MappedColumnAbsent { present, .. } | E::ColumnAbsent { present, .. } => {
                format!("one of its headers: {}", present.join(", "))
            }
            E::RaggedRow { expected, .. } => format!("{expected} cells, as many as the header has"),
            E::NotANumber { found, .. } => number(found).into(),
            E::Mark { place, fault, .. } => {
                let is_workbook = Format::of_extension(Path::new(&*place.file)) == Some(Format::Xlsx);
                fault.expected(is_workbook).into()
            }
            E::Text { fault, .. } => fault.expected().into(),
            E::NotAStamp { .. } => "a time written as in the rows above, such as 2024-05-06T07:08:09.125".into(),
            E::NotFinite { .. } => "a finite number".into(),
            E::AngleOutOfReach { from, to, unit, .. } => {
                let [from, to] = [from, to].map(|end| (1e4 * end).round() / 1e4);
                format!(
                    "{from} to {to} {unit}, from end to end of [linkage]: its zero, its way or its table may be another one"
                )
            }
            E::TimeBackwards { .. } => "times that rise from row to row".into(),
            E::ExportLayout { .. } => {
                "header rows `Name`, `Data-Type`, `SampleTime[ms]` … and a time column before the channels".into()
            }
            E::FullTimestamps { .. } => "times in ms since the start: export without full timestamps".into(),
            E::NoCommonTime { .. } => "channels recorded at the same time".into(),
            E::MissingSignal { signal, present, .. } => {
                format!(
                    "a column `{signal} [{}]`, or a --map for it; the file has: {}",
                    signal.si_unit(),
                    present.join(", ")
                )
            }
            E::ConstantSignal { .. } => "a signal that moves; one that never changes cannot be judged".into(),
            E::FeatureAbsent { format, .. } => {
                format!("the program built with the feature `{}`, or CSV", format.feature().unwrap_or_default())
            }
            E::NotOfFormat { format: Format::Mat, .. } => {
                "a MAT-file of version 5 or 7: save('run.mat', '-v7', …)".into()
            }
            E::NotOfFormat { format, .. } => format!("{format}, or text"),
            E::Unsupported { what, .. } => what.expected().into(),
            E::Damaged { .. } => "a whole file: save or copy it again".into(),
            E::NoTimes { present, .. } => {
                format!(
                    "`time [s]` (time_s) with as many values, or a --map \"time=…\"; the file has: {}",
                    few(present)
                )
            }
            E::NothingKnown { present, .. } => format!(
                "names and units such as `time [s]`, `position [mm]` (time_s, position_mm), or a --map \"position=… [mm]\"; \
                 the file has: {}",
                few(present)
            ),
            E::NotNumbers { .. } => "a vector of real numbers".into(),
            E::LengthMismatch { expected, .. } => format!("{expected}, one for each time"),
        }
    }

    fn key(&self) -> Option<String> {
        match self {
            E::MissingUnit { columns, .. } => columns.first().map(|(_, header)| header.clone()),
            E::UnknownUnit { header, .. }
            | E::WrongDimension { header, .. }
            | E::MappedColumnAbsent { header, .. }
            | E::ColumnAbsent { header, .. }
            | E::NotANumber { header, .. }
            | E::NotAStamp { header, .. }
            | E::NotFinite { header, .. }
            | E::NoTimes { header, .. }
            | E::NotNumbers { header, .. }
            | E::LengthMismatch { header, .. }
            | E::AlikeColumns { header, .. }
            | E::Text {
                fault: TextFault::UnitsDiffer { header, .. } | TextFault::UnreadableTime { header, .. }, ..
            } => Some(header.clone()),
            E::Mark { cell, .. } => Some(cell.header.clone()),
            E::DuplicateColumn { second, .. } => Some(second.clone()),
            E::AngleOutOfReach { .. } => Some(Signal::Angle.name().to_owned()),
            E::TimeBackwards { .. } => Some(Signal::Time.name().to_owned()),
            E::MissingSignal { signal, .. } | E::ConstantSignal { signal, .. } => Some(signal.name().to_owned()),
            _ => None,
        }
    }
}

/// How a column that is known by its name, and not needed, is left out; nothing of one that a map names, or of time.
fn or_unused(signal: Signal, header: &str) -> String {
    let name = split_header(header).0;
    let is_known = name == signal.name() || split_suffix(name).is_some_and(|(name, _)| name == signal.name());
    if signal == Signal::Time || !is_known {
        return String::new();
    }
    format!("; where it is not needed, `unused = [{header:?}]` in [channels] of the machine file leaves it out")
}

/// What columns without a unit need.
fn missing_units(place: &Place, columns: &[(Signal, String)]) -> String {
    let [(signal, header), ..] = columns else { return String::new() };
    let unit = signal.si_unit();
    let bracketed = format!("{signal} [{unit}]");
    let how = if place.spot.is_none() {
        let plain = variable(&bracketed, unit, &[]);
        format!("a unit with the name, as `{bracketed}` or `{plain}`")
    } else {
        format!("a unit in brackets after the name, in the file or as --map \"{signal}={header} […]\"")
    };
    if columns.len() == 1 {
        return format!("{how}, one of: {}{}", signal.units(), or_unused(*signal, header));
    }
    let each = columns.iter().map(|(signal, header)| format!("{} one of: {}", quoted(header), signal.units()));
    format!("{how}: {}", each.collect::<Vec<_>>().join("; "))
}

/// What a cell of numbers needs that holds this.
fn number(found: &str) -> &'static str {
    match found.chars().next() {
        Some('=') => {
            "a number: formulas without a saved value are calculated when the file is opened in a spreadsheet program and saved there"
        }
        Some('#') => "a number: correct the formula, or leave the cell empty, as a missing value",
        _ => "a decimal number such as -12.5 or 1.5e-3; units stand in the header, as `position [mm]`",
    }
}

/// What a text without time needs, which has these columns.
fn time_column(present: &[String]) -> String {
    if are_numbers(present) {
        return "a header such as `time [s],command [V],position [mm]` in the first line that is no comment (`#`)"
            .into();
    }
    // The index that pandas writes has no name.
    let named: Vec<String> = present.iter().filter(|header| !header.is_empty()).cloned().collect();
    let is_of_time = |header: &&String| {
        split_header(header).1.and_then(Unit::parse).is_some_and(|unit| unit.dimension() == Dimension::Time)
    };
    let suggested = named.iter().find(is_of_time).map_or("… [s]", String::as_str);
    format!(
        "a column `time [s]` (or ms, µs), or --map \"time={suggested}\"; other columns as well, by the names of `host-sim inspect --help`. Lines \
         above the header begin with `#`. The file has: {}",
        few(&named)
    )
}

/// Whether a header is a row of numbers.
fn are_numbers(names: &[String]) -> bool {
    names.iter().all(|name| is_number(name))
}

/// Names for a message; where there are many, only some of them.
fn few(names: &[String]) -> String {
    const MOST: usize = 30;
    let more = if names.len() > MOST { ", …" } else { "" };
    if names.is_empty() { "nothing".to_owned() } else { names[..names.len().min(MOST)].join(", ") + more }
}

impl fmt::Display for RecordingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; expected {}", self.place(), self.found(), self.expected())
    }
}
