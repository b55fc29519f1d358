//! The text export of `TwinCAT` Scope.
//!
//! The layout is assumed as follows, after the maker's documentation of the text export and exports of
//! Scope 3.4:
//!
//! - A block about the file (`Name`, `File`, `Starttime of export`, …), then a block about the
//!   channels that begins with a row `Name` again. Each row of a block begins with its key: `Name`,
//!   `SymbolComment`, `Data-Type`, `SampleTime[ms]`, `SymbolName`, `Unit` and others. Blank lines
//!   separate the blocks; an export without the first block is read too.
//! - A column that repeats the key in every row of the channel block is a time column. The channels
//!   to its right, up to the next time column, are sampled at its times. Two forms are therefore read:
//!   one time column for each channel, and one for each sample time.
//! - Then the rows: times in ms since the start of the export, and values as scaled by the export.
//!   Channels with fewer samples end early, with empty cells. A line `EOF` may close the file.
//! - Separator is a tab or a semicolon, with decimal comma or point, or a comma with points.
//!
//! A channel is known by its name (`position [mm]`), or by name or symbol through the channel map
//! (`GVL.Kolbenweg [mm]`); its unit stands in brackets in the map or in the name, or else in the row
//! `Unit` (`mm (Length)`). Values are taken as they stand: where the rows of factors and offsets would change
//! them, a note says so. All signals come out at the times of the first known channel of the file:
//! those with other times are interpolated linearly there. Times outside any signal's range and repeated times are
//! left out; they are written back where the recording is. Time goes out as `time [s]`. Full timestamps
//! instead of ms are refused.

use super::decimal_mark::{DecimalMark, is_missing, si};
use super::lines::{Lines, Splitter, TextLine, most_rows};
use crate::channel_map::ChannelMap;
use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::formats::resample::{self, Sampled};
use crate::header::{Offer, assign, clash, leave_unused};
use crate::recording::{At, Column, Note, Recording};
use crate::signal::{Signal, split_header};
use crate::unit::{Dimension, Unit};

/// The first cell of an export; no recording's first column can have this header.
pub(crate) const FIRST_CELL: &str = "Name";

/// Most header rows; a real export has about twenty.
const MAX_HEADER_ROWS: usize = 200;

/// Larger than any time in ms: a full timestamp counts 100 ns since 1601.
const FULL_TIMESTAMP: f64 = 1e15;

/// The channel block: rows of cells; the first cell of each row is its key.
type Block = Vec<Vec<String>>;

/// One known channel: its samples, and the columns in which they stand.
struct Channel {
    time_cell: usize,
    value_cell: usize,
    samples: Sampled,
}

/// Reads an export whose first line has the cells `first`.
pub(crate) fn read(
    mut lines: Lines<'_>,
    mut splitter: Splitter,
    first: Vec<String>,
    map: &ChannelMap,
) -> Result<Recording, RecordingError> {
    let file = lines.file();
    let name = lines.file_name().to_owned();
    let separator = splitter.separator();
    let time = Column::of_file("time".into(), Signal::Time, milliseconds());
    let mut mark = DecimalMark::new(separator);
    let mut block: Block = vec![first];
    let mut channels: Option<Channels> = None;
    let mut header_rows = 1;
    let mut rows = 0;
    while let Some(line) = lines.next()? {
        let cells = splitter.split(line)?;
        let key = cells.get(0);
        if key == "EOF" {
            break;
        }
        if channels.is_none() && !key.is_empty() && mark.lenient(key).is_none() {
            if key == FIRST_CELL {
                block.clear();
            }
            header_rows += 1;
            if header_rows > MAX_HEADER_ROWS {
                return Err(RecordingError::ExportLayout { place: line.whole(), missing: "rows of numbers" });
            }
            block.push(cells.iter().map(str::to_owned).collect());
            continue;
        }
        let channels = match &mut channels {
            Some(channels) => channels,
            none => none.insert(Channels::find(&block, map, &file)?),
        };
        rows += 1;
        // Every channel has its own times.
        let most = most_rows(2 * channels.known.len());
        if rows > most {
            return Err(RecordingError::TooManyRows { place: line.whole(), most });
        }
        if cells.len() > channels.width && (channels.width..cells.len()).any(|at| !cells.get(at).is_empty()) {
            return Err(RecordingError::RaggedRow {
                place: line.whole(),
                found: cells.len(),
                expected: channels.width,
            });
        }
        for channel in &mut channels.known {
            let (time_text, text) = (cells.get(channel.time_cell), cells.get(channel.value_cell));
            if !is_missing(time_text) && !is_missing(text) {
                let time_s = si(line, time_text, &time, &mut mark, channel.time_cell)?;
                let value = si(line, text, &channel.samples.column, &mut mark, channel.value_cell)?;
                channels.repeated += usize::from(!channel.push(line, separator, time_s, value)?);
                if channels.repeated == 1 {
                    channels.first_repeated = line.number();
                }
            }
        }
    }
    match channels {
        Some(mut channels) => {
            mark.check()?;
            channels.notes.extend(lines.western().map(|line| Note::ReadAsWindows1252 { first: At::Line(line) }));
            let at = At::Line(channels.first_repeated);
            let repeated = (channels.repeated > 0).then_some((channels.repeated, at));
            let known = channels.known.into_iter().map(|channel| channel.samples).collect();
            resample::together(&name, known, channels.ignored, channels.notes, repeated)
        }
        None => Err(RecordingError::TooFewRows { place: file, rows: 0, skipped: 0 }),
    }
}

fn milliseconds() -> Unit {
    Unit::parse("ms").unwrap_or(Unit::si(Dimension::Time))
}

impl Channel {
    /// An export has the unit in a separate row; a recording that is written needs it in the header.
    fn with_unit_in_header(mut self) -> Self {
        let column = &mut self.samples.column;
        if split_header(&column.header).1 != Some(column.unit.symbol()) {
            column.header = format!("{} [{}]", column.header, column.unit);
        }
        self
    }

    /// Adds a sample; `false` when it repeats the time before it and is left out.
    fn push(&mut self, line: TextLine<'_>, separator: u8, time_s: f64, value: f64) -> Result<bool, RecordingError> {
        let place = || line.cell(separator, self.time_cell);
        if time_s > FULL_TIMESTAMP * 1e-3 {
            let found = format!("{:.0}", time_s * 1e3);
            return Err(RecordingError::FullTimestamps { place: place(), found });
        }
        let backwards = |previous_s| RecordingError::TimeBackwards { place: place(), previous_s, found_s: time_s };
        self.samples.push(time_s, value).map_err(backwards)
    }
}

/// The known channels of an export.
struct Channels {
    width: usize,
    known: Vec<Channel>,
    ignored: Vec<String>,
    notes: Vec<Note>,
    repeated: usize,
    first_repeated: usize,
}

impl Channels {
    fn find(block: &Block, map: &ChannelMap, file: &Place) -> Result<Self, RecordingError> {
        let cell = |key: &str, index: usize| {
            let row = block.iter().find(|row| row[0] == key)?;
            row.get(index).map(String::as_str).filter(|text| !text.is_empty())
        };
        if !block.iter().any(|row| row[0] == "SampleTime[ms]" || row[0] == "Data-Type") {
            let missing = "a row `SampleTime[ms]` or `Data-Type`";
            return Err(RecordingError::ExportLayout { place: file.clone(), missing });
        }
        let width = block.first().map_or(0, Vec::len);
        let is_time = |index: usize| {
            cell(FIRST_CELL, index) == Some(FIRST_CELL)
                && block.iter().all(|row| row.get(index).is_none_or(|text| text.is_empty() || *text == row[0]))
        };
        let mut places = Vec::new();
        let mut offers = Vec::new();
        let mut time_cell = 0;
        for index in 0..width {
            if is_time(index) {
                time_cell = index;
            } else if let Some(name) = cell(FIRST_CELL, index) {
                places.push((time_cell, index));
                offers.push(offer(name, cell("SymbolName", index), cell("Unit", index)));
            }
        }
        leave_unused(&mut offers, map);
        let assignment = assign(&offers, map, file, |_| file.clone())?;
        let known: Vec<Channel> = assignment
            .known
            .into_iter()
            .map(|(at, column)| Channel {
                time_cell: places[at].0,
                value_cell: places[at].1,
                samples: Sampled::new(column),
            })
            .filter(|channel| channel.samples.column.signal != Signal::Time)
            .map(Channel::with_unit_in_header)
            .collect();
        if known.is_empty() {
            return Err(RecordingError::ExportLayout {
                place: file.clone(),
                missing: "a channel that is a known signal; name them with --map",
            });
        }
        let has_factor = |channel: &&Channel| {
            let stated = |row: &Vec<String>| {
                let text = row.get(channel.value_cell).map(String::as_str).filter(|text| !text.is_empty());
                neutral(&row[0]).zip(text).is_some_and(|(neutral, text)| !is_number(text, neutral))
            };
            block.iter().any(stated)
        };
        let signals: Vec<Signal> =
            known.iter().filter(has_factor).map(|channel| channel.samples.column.signal).collect();
        let mut notes = assignment.notes;
        notes.extend((!signals.is_empty()).then_some(Note::FactorsInHeader { signals }));
        Ok(Self { width, known, ignored: assignment.ignored, notes, repeated: 0, first_repeated: 0 })
    }
}

/// The value with which a row of the channel block changes nothing, if it is one with which an export may have scaled its values, or not: `ScaleFactor`,
/// `Unit ScaleFactor`, `Offset`, `Unit Offset` and other spellings of them. The header is the same either way.
fn neutral(key: &str) -> Option<f64> {
    let letters: String = key.chars().filter(char::is_ascii_alphabetic).collect::<String>().to_ascii_lowercase();
    let is_of_time = letters.contains("time");
    if is_of_time {
        None
    } else if letters.contains("offset") {
        Some(0.0)
    } else {
        ["scale", "factor", "gain"].iter().any(|word| letters.contains(word)).then_some(1.0)
    }
}

/// Whether a text is this number, with a decimal point or a comma.
fn is_number(text: &str, expected: f64) -> bool {
    text.replacen(',', ".", 1).parse::<f64>().is_ok_and(|value| (value - expected).abs() <= f64::EPSILON)
}

fn offer(name: &str, symbol: Option<&str>, unit: Option<&str>) -> Offer {
    // `mm (Length)`, or `(None)`.
    let unit = unit.map(|text| text.split('(').next().unwrap_or_default().trim()).filter(|text| !text.is_empty());
    let owned = |text: Option<&str>| text.map(str::to_owned);
    let (short, in_name) = split_header(name);
    let mut names = vec![(name.to_owned(), owned(unit)), (short.to_owned(), owned(in_name.or(unit)))];
    names.extend(symbol.map(|symbol| (symbol.to_owned(), owned(unit))));
    Offer { header: name.to_owned(), names, clash: unit.and_then(|unit| clash(name, unit)) }
}

#[cfg(test)]
mod tests {
    use crate::channel_map::ChannelMap;
    use crate::error::RecordingError;
    use crate::formats::read::read_from;
    use crate::recording::{At, Note};
    use crate::signal::Signal;

    /// Two sample times; the slow channel begins later and has fewer rows.
    const EXPORT: &str = "Name\tBench\nFile\tC:\\bench.csv\nStarttime of export\t132959733843760000\t2. Mai 2022\n\n\n\
        Name\tcommand [V]\tPos\tName\tpressure_a\n\
        SymbolComment\t\t\tSymbolComment\t\n\
        Data-Type\tREAL64\tREAL32\tData-Type\tREAL32\n\
        SampleTime[ms]\t0,5\t0,5\tSampleTime[ms]\t1\n\
        SymbolName\tMAIN.u\tMAIN.axis.pos\tSymbolName\tMAIN.pa\n\
        Unit\t(None)\t(None)\tUnit\tbar (Pressure)\n\n\
        0\t0\t10\t0,5\t50\n\
        0,5\t1\t11\t1,5\t60\n\
        1\t2\t12\t\t\n\
        1,5\t3\t13,5\t\t\n\
        2\t3\t14\t\t\nEOF\n";

    fn read(text: &str, map: &[&str]) -> Result<super::Recording, RecordingError> {
        let map = ChannelMap::from_arguments(map.iter().copied()).unwrap();
        read_from("scope.csv", text.as_bytes(), &map)
    }

    #[test]
    fn channels_come_out_at_the_times_of_the_first() {
        let recording = read(EXPORT, &["position=MAIN.axis.pos [mm]"]).unwrap();
        assert_eq!(recording.time_s(), [0.0005, 0.001, 0.0015]);
        assert_eq!(recording.signal(Signal::Command).unwrap(), [1.0, 2.0, 3.0]);
        assert_eq!(recording.signal(Signal::Position).unwrap(), [0.011, 0.012, 0.0135]);
        assert_eq!(recording.signal(Signal::PressureA).unwrap(), [5e6, 5.5e6, 6e6]);
        assert_eq!(recording.column(Signal::PressureA).unwrap().header, "pressure_a [bar]");
        assert_eq!(recording.notes(), [Note::Resampled { signals: vec![Signal::PressureA], rows_left_out: 2 }]);
    }

    #[test]
    fn a_channel_is_also_mapped_by_its_name() {
        let recording = read(EXPORT, &["position=Pos [m]"]).unwrap();
        assert_eq!(recording.signal(Signal::Position).unwrap(), [11.0, 12.0, 13.5]);
        let unmapped = read(EXPORT, &[]).unwrap();
        assert_eq!(unmapped.ignored(), ["Pos"]);
    }

    #[test]
    fn semicolons_and_one_time_column_for_each_channel() {
        let text = "Name;spool;Name;position [mm]\nSampleTime[ms];1;SampleTime[ms];1\n0;0,1;0;1\n1;0,2;1;2\n1;9;2;3\n";
        let recording = read(text, &[]).unwrap();
        assert_eq!(recording.signal(Signal::Spool).unwrap(), [0.1, 0.2]);
        assert_eq!(recording.signal(Signal::Position).unwrap(), [0.001, 0.002]);
        assert!(recording.notes().contains(&Note::DuplicateTimes { rows: 1, first: At::Line(5) }));
    }

    #[test]
    fn factors_in_the_header_are_noted_where_they_would_change_a_known_signal() {
        let map = ["position=MAIN.axis.pos [mm]"];
        let usual = "ScaleFactor\t1\t1\tScaleFactor\t1\nUnit Offset\t0\t0\tUnit Offset\t0\n";
        assert_eq!(
            read(&EXPORT.replacen("SymbolName", &format!("{usual}SymbolName"), 1), &map).unwrap().notes().len(),
            1
        );
        let scaled = "ScaleFactor\t1\t1\tScaleFactor\t1e-05\nUnit ScaleFactor\t1\t1000\tUnit ScaleFactor\t1\n";
        let export = EXPORT.replacen("SymbolName", &format!("{scaled}SymbolName"), 1);
        let signals = vec![Signal::Position, Signal::PressureA];
        assert!(read(&export, &map).unwrap().notes().contains(&Note::FactorsInHeader { signals }));
        for row in ["Scale-Factor", "UNIT SCALEFACTOR", "Unit Offset", "offset", "Gain"] {
            let export = EXPORT.replacen("SymbolName", &format!("{row}\t1\t2,5\t{row}\t0\nSymbolName"), 1);
            let noted =
                |note: &Note| matches!(note, Note::FactorsInHeader { signals } if signals.contains(&Signal::Position));
            assert!(read(&export, &map).unwrap().notes().iter().any(noted), "{row}");
        }
        // A channel that is not read does not matter.
        let signals = vec![Signal::PressureA];
        assert!(read(&export, &[]).unwrap().notes().contains(&Note::FactorsInHeader { signals }));
    }

    #[test]
    fn what_is_left_out_is_written_back_in_its_place() {
        let export = EXPORT.replace("1\t2\t12\t\t\n", "1\t2\t12\t\t\n1\t2,5\t12,5\t\t\n");
        let recording = read(&export, &["position=MAIN.axis.pos [mm]"]).unwrap();
        assert_eq!(recording.rows(), 3);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.csv");
        recording.write_csv(&path, &[(Signal::Position, &[0.011, 0.013, 0.015])], &[]).unwrap();
        let expected = "time [s],command [V],Pos [mm],pressure_a [bar]\n0,0,,\n0.0005,1,11,50\n0.001,2,13,55\n\
            0.001,2.5,13,55\n0.0015,3,15,60\n0.002,3,,\n";
        assert_eq!(std::fs::read_to_string(&path).unwrap(), expected);
    }

    #[test]
    fn exports_that_cannot_be_used_say_why() {
        let full = "Name\tspool\nData-Type\tREAL\n132959733843760000\t1\n132959733843770000\t1\n";
        assert!(matches!(read(full, &[]).unwrap_err(), RecordingError::FullTimestamps { .. }));
        let bare = "Name\tspool\n0\t1\n";
        assert!(matches!(read(bare, &[]).unwrap_err(), RecordingError::ExportLayout { .. }));
        let unknown = "Name\tfoo\nData-Type\tREAL\n0\t1\n";
        assert!(matches!(read(unknown, &[]).unwrap_err(), RecordingError::ExportLayout { .. }));
        let apart = "Name\tspool\tName\tflow [l/min]\nData-Type\tR\tData-Type\tR\n0\t1\t5\t1\n1\t1\t6\t1\n";
        assert!(matches!(read(apart, &[]).unwrap_err(), RecordingError::NoCommonTime { .. }));
        let back = "Name\tspool\nData-Type\tREAL\n1\t1\n0\t1\n";
        assert!(matches!(read(back, &[]).unwrap_err(), RecordingError::TimeBackwards { .. }));
        let text = "Name\tspool\nData-Type\tREAL\n1\tx\n";
        assert!(matches!(read(text, &[]).unwrap_err(), RecordingError::NotANumber { .. }));
    }
}
