//! Recordings of a drive: reading, holding and writing.
//!
//! A recording is a table: the first column is time, each further one a [`Signal`]. Inside the
//! program every value is in SI units (pump speed in rev/s, temperature in °C, a current command in
//! mA). Header and unit of each column are kept, so that a result is written with the headers and units of the recording.

use std::fmt;
use std::path::Path;

use crate::display_unit::significant;
use crate::error::RecordingError;
use crate::files::source_error::{Place, counted, engineering, quoted, rounded};
use crate::signal::Signal;
use crate::unit::{ATMOSPHERE_PA, Unit};

pub use crate::column::{Column, FromAngle};

/// Where a row stands in its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum At {
    /// In this line of a text, from 1.
    Line(usize),
    /// In this row of a file without lines, from 1.
    Row(usize),
}

impl fmt::Display for At {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            At::Line(line) => write!(f, "line {line}"),
            At::Row(row) => write!(f, "row {row}"),
        }
    }
}

/// A correction made while reading, or something that a user should know about a recording.
#[derive(Clone, Debug, PartialEq)]
pub enum Note {
    /// Rows with the same time as the row before were left out.
    DuplicateTimes {
        /// How many.
        rows: usize,
        /// Where the first one is.
        first: At,
    },
    /// Rows share coarse time stamps and were spread.
    CoarseTimes {
        /// From one stamp to the next, s.
        step_s: f64,
        /// From one row to the next, s; of the longest stretch that is on one clock, if there is any.
        interval_s: f64,
        /// Stretches of rows that are each on one even clock.
        clocks: usize,
        /// The number of rows that fit no clock and were spread within their stamps.
        within_stamps: usize,
    },
    /// Rows without a value in a known column (an empty cell, NaN, null) were left out.
    IncompleteRows {
        /// How many.
        rows: usize,
        /// Where the first one is.
        first: At,
    },
    /// The last line of a text is cut off and was not read.
    CutLine {
        /// Its number.
        line: usize,
    },
    /// The last line of a text holds words and was not read.
    LastLineOfWords {
        /// Its number.
        line: usize,
        /// Its first words.
        text: String,
    },
    /// There are intervals without rows that are longer than ten usual intervals.
    Gaps {
        /// How many.
        count: usize,
        /// Length of the longest one, s.
        longest_s: f64,
        /// Time of the last row before the longest one, s.
        at_s: f64,
    },
    /// The machine file maps this signal to a column that the recording does not have.
    MappedColumnAbsent {
        /// The signal.
        signal: Signal,
        /// The header that is not there.
        header: String,
    },
    /// The text is not UTF-8 and was read as Windows-1252.
    ReadAsWindows1252 {
        /// Where the first such line is.
        first: At,
    },
    /// The header states factors or offsets of these signals, and not whether they have been applied to the values.
    FactorsInHeader {
        /// The signals.
        signals: Vec<Signal>,
    },
    /// The position was not recorded; it follows from the angle of the joint by the machine file's linkage.
    PositionFromAngle,
    /// Both were recorded: the position is taken, the angle is not used.
    AngleBesidePosition,
    /// The angle of the joint was recorded and no position, and no linkage is known.
    AngleWithoutLinkage,
    /// The pressures fit the drive only without the pressure of the air in them.
    TakenAsAbsolute,
    /// Signals with times of their own were interpolated to the times of the first one.
    Resampled {
        /// The signals.
        signals: Vec<Signal>,
        /// Rows of the first signal that were left out because another signal has no data there.
        rows_left_out: usize,
    },
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Note::DuplicateTimes { rows: 1, first } => {
                write!(f, "1 row repeats the time before it and is left out, in {first}")
            }
            Note::DuplicateTimes { rows, first } => {
                write!(f, "{rows} rows repeat the time before them and are left out, the first in {first}")
            }
            Note::CoarseTimes { step_s, interval_s, clocks, within_stamps } => {
                let ms = |time_s: f64| significant(1e3 * time_s, 3);
                let (step, rows) = (ms(*step_s), (step_s / interval_s * 10.0).round() / 10.0);
                write!(f, "time stamps are {step} ms apart and {rows} rows share one: ")?;
                match clocks {
                    0 => write!(f, "they fit no even clock and are spread within each stamp, about")?,
                    1 => write!(f, "they are spread evenly,")?,
                    _ => write!(f, "they are spread evenly in each of {clocks} stretches,")?,
                }
                write!(f, " {} ms apart", ms(*interval_s))?;
                if *clocks > 0 && *within_stamps > 0 {
                    write!(f, "; {} fit no even clock: spread within each stamp", counted(*within_stamps, "row"))?;
                }
                Ok(())
            }
            Note::IncompleteRows { rows: 1, first } => {
                write!(f, "1 row has an empty cell and is left out, in {first}")
            }
            Note::IncompleteRows { rows, first } => {
                write!(f, "{rows} rows have an empty cell and are left out, the first in {first}")
            }
            Note::LastLineOfWords { line, text } => {
                write!(
                    f,
                    "line {line}, the last one, begins with {} and is not read: it is no row of numbers",
                    quoted(text)
                )
            }
            Note::CutLine { line } => write!(f, "line {line}, the last one, is cut off and is not read"),
            Note::Gaps { count, longest_s, at_s } => {
                let which = if *count == 1 { "" } else { "the longest " };
                let (longest, at) = (engineering(rounded(*longest_s)), engineering(*at_s));
                write!(f, "{} in time, {which}of {longest} s at {at} s", counted(*count, "gap"))
            }
            Note::MappedColumnAbsent { signal, header } => write!(f, "no column `{header}` for {signal}"),
            Note::ReadAsWindows1252 { first } => {
                write!(f, "not UTF-8 from {first} on: read as Windows-1252, as Excel writes it")
            }
            Note::FactorsInHeader { signals } => {
                let names: Vec<_> = signals.iter().map(|signal| signal.name()).collect();
                write!(
                    f,
                    "the header states a scale factor or offset for {}, and not whether it is applied: the values are taken as they stand",
                    names.join(", ")
                )
            }
            Note::PositionFromAngle => {
                write!(
                    f,
                    "the position is not recorded: it comes from the joint's angle by the linkage of the machine file"
                )
            }
            Note::AngleBesidePosition => {
                write!(f, "position and joint angle are both recorded: the position is taken, the angle is not used")
            }
            Note::AngleWithoutLinkage => write!(
                f,
                "the joint's angle is recorded, no position, and no [linkage] that turns one into the other: the angle is not used. A machine \
                 file says it by base_m, arm_m and length_retracted_m, or by a table of angles_deg and positions_m"
            ),
            Note::TakenAsAbsolute => {
                let bar = significant(1e-5 * ATMOSPHERE_PA, 3);
                write!(f, "the pressures read about {bar} bar too much, as absolute sensors do: taken as absolute")
            }
            Note::Resampled { signals, rows_left_out } => {
                let names: Vec<_> = signals.iter().map(|signal| signal.name()).collect();
                write!(f, "{} interpolated to the times of the first channel", names.join(", "))?;
                let are = if *rows_left_out == 1 { "is" } else { "are" };
                write!(f, "; {} outside the common time {are} left out", counted(*rows_left_out, "row"))
            }
        }
    }
}

/// A recording: rising times, and the values of signals at these times.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The file as the user named it.
    pub(crate) path: String,
    /// Time first; all of one length.
    pub(crate) columns: Vec<Column>,
    pub(crate) ignored: Vec<String>,
    pub(crate) notes: Vec<Note>,
    pub(crate) left_out: LeftOut,
}

/// Rows of the file that are not among the values, kept to be written back.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LeftOut {
    /// For each of them, the number of kept rows before it.
    pub(crate) after: Vec<usize>,
    /// For each of them, the cells of the known columns in SI units; a cell that is blank or cannot be read is `None`.
    pub(crate) cells: Vec<Option<f64>>,
}

impl Recording {
    /// A recording made in the program, such as the input of a simulation.
    ///
    /// The first column is time; times rise, every value is finite, every column is as long as the
    /// first and holds a different signal, and there are at least two rows. Anything else is an error.
    pub fn new(name: &str, columns: Vec<Column>) -> Result<Self, RecordingError> {
        let place = || Place::file(name);
        let rows = match columns.first() {
            Some(first) if first.signal == Signal::Time => first.values.len(),
            other => {
                let present = other.iter().map(|column| column.header.clone()).collect();
                return Err(RecordingError::NoTimeColumn { place: place(), present });
            }
        };
        if rows < 2 {
            return Err(RecordingError::TooFewRows { place: place(), rows, skipped: 0 });
        }
        for (index, column) in columns.iter().enumerate() {
            let header = column.header.clone();
            let found = column.values.len();
            if found != rows {
                return Err(RecordingError::LengthMismatch { place: place(), header, found, expected: rows });
            }
            if let Some(value) = column.values.iter().find(|value| !value.is_finite()) {
                return Err(RecordingError::NotFinite { place: place(), header, found: value.to_string() });
            }
            if let Some(first) = columns[..index].iter().find(|before| before.signal == column.signal) {
                let (signal, first) = (column.signal, first.header.clone());
                return Err(RecordingError::DuplicateColumn { place: place(), signal, first, second: header });
            }
        }
        if let Some(pair) = columns[0].values.windows(2).find(|pair| pair[1] <= pair[0]) {
            return Err(RecordingError::TimeBackwards { place: place(), previous_s: pair[0], found_s: pair[1] });
        }
        Ok(Self::assemble(name, columns, Vec::new(), Vec::new()))
    }

    /// The same commands, in a unit that is not converted: V or mA.
    pub fn count_command_in(&mut self, unit: Unit) {
        for column in self.columns.iter_mut().filter(|column| column.signal == Signal::Command) {
            (column.header, column.unit) = (format!("{} [{unit}]", column.signal), unit);
        }
    }

    /// A recording of columns that are known to be valid.
    pub(crate) fn assemble(path: &str, columns: Vec<Column>, ignored: Vec<String>, mut notes: Vec<Note>) -> Self {
        notes.extend(gaps(&columns[0].values));
        Self { path: path.to_owned(), columns, ignored, notes, left_out: LeftOut::default() }
    }

    /// This recording without the signals that `kept` refuses, as if they had not been measured; their cells are not written back either.
    #[must_use]
    pub fn limited_to(&self, kept: impl Fn(Signal) -> bool) -> Self {
        let stays: Vec<bool> =
            self.columns.iter().map(|column| column.signal == Signal::Time || kept(column.signal)).collect();
        let of = |index: usize| stays[index % stays.len()];
        let mut limited = self.clone();
        let mut index = 0..;
        limited.columns.retain(|_| index.next().is_some_and(of));
        let mut index = 0..;
        limited.left_out.cells.retain(|_| index.next().is_some_and(of));
        let set_aside =
            self.columns.iter().zip(&stays).filter(|(_, stays)| !**stays).map(|(column, _)| column.header.clone());
        limited.ignored.extend(set_aside);
        limited
    }

    /// The first `rows` rows, at least two and at most all of them. Rows that were left out in reading are not written back.
    #[must_use]
    pub fn first(&self, rows: usize) -> Self {
        let mut columns = self.columns.clone();
        for column in &mut columns {
            column.values.truncate(rows.max(2));
        }
        Self { columns, left_out: LeftOut::default(), ..self.clone() }
    }

    /// Takes its pressures as read by absolute sensors, and notes it. They are written back as they were read.
    pub fn take_as_absolute(&mut self) {
        for column in self.columns.iter_mut().filter(|column| column.signal.is_pressure()) {
            column.unit = column.unit.absolute();
            for value in &mut column.values {
                *value -= ATMOSPHERE_PA;
            }
        }
        self.notes.push(Note::TakenAsAbsolute);
    }

    /// Replaces the values of a signal by as many other values.
    pub fn replace(&mut self, signal: Signal, values: &[f64]) {
        if let Some(column) = self.columns.iter_mut().find(|column| column.signal == signal) {
            column.values.copy_from_slice(values);
        }
    }

    /// The file's name without its folder.
    #[must_use]
    pub fn name(&self) -> &str {
        Path::new(&self.path).file_name().and_then(|name| name.to_str()).unwrap_or(&self.path)
    }

    /// The file as the user named it.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The times, s, as recorded: they rise and may start at any value.
    #[must_use]
    pub fn time_s(&self) -> &[f64] {
        &self.columns[0].values
    }

    /// The known columns in the order of the file; time is the first.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The values of a signal in SI units, one for each row, where the recording has it.
    #[must_use]
    pub fn signal(&self, signal: Signal) -> Option<&[f64]> {
        self.column(signal).map(|column| column.values.as_slice())
    }

    /// The column of a signal, with header and unit.
    #[must_use]
    pub fn column(&self, signal: Signal) -> Option<&Column> {
        self.columns.iter().find(|column| column.signal == signal)
    }

    /// Whether the recording has this signal.
    #[must_use]
    pub fn has(&self, signal: Signal) -> bool {
        self.column(signal).is_some()
    }

    /// Whether another recording holds the same values, whatever their units, headers and formats.
    #[must_use]
    pub fn holds_what(&self, other: &Self) -> bool {
        let held = |column: &Column| other.signal(column.signal) == Some(column.values.as_slice());
        self.columns.len() == other.columns.len() && self.columns.iter().all(held)
    }

    /// The places of the first two of several recordings that hold the same, whatever they are called.
    #[must_use]
    pub fn held_twice(all: &[&Self]) -> Option<(usize, usize)> {
        all.iter().enumerate().find_map(|(second, one)| {
            let first = all[..second].iter().position(|other| other.holds_what(one))?;
            Some((first, second))
        })
    }

    /// The first recording that was held out and holds the same as one to train on: that one, and it.
    #[must_use]
    pub fn trained_on<'a>(training: &'a [Self], held_out: &'a [Self]) -> Option<(&'a Self, &'a Self)> {
        held_out.iter().find_map(|second| Some((training.iter().find(|first| first.holds_what(second))?, second)))
    }

    /// The number of rows, at least two.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.time_s().len()
    }

    /// The median of the intervals between rows, s.
    #[must_use]
    pub fn sample_interval_s(&self) -> f64 {
        median_interval(self.time_s())
    }

    /// The headers of columns that hold no known signal. Their cells are not kept.
    #[must_use]
    pub fn ignored(&self) -> &[String] {
        &self.ignored
    }

    /// Corrections made while reading, and what a user should know.
    #[must_use]
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// The values of a signal that is required, in SI units.
    pub fn require(&self, signal: Signal) -> Result<&[f64], RecordingError> {
        self.signal(signal).ok_or_else(|| RecordingError::MissingSignal {
            place: Place::file(&self.path),
            signal,
            present: self.columns.iter().map(|column| column.signal.name()).collect(),
        })
    }

    /// Checks that a signal is there and changes; a constant signal cannot be judged.
    pub fn check_varies(&self, signal: Signal) -> Result<(), RecordingError> {
        let values = self.require(signal)?;
        if values.windows(2).any(|pair| pair[0].to_bits() != pair[1].to_bits()) {
            return Ok(());
        }
        let value = values.first().copied().unwrap_or_default();
        Err(RecordingError::ConstantSignal { place: Place::file(&self.path), signal, value })
    }
}

/// The note about intervals that are longer than usual.
pub(crate) fn gaps(time_s: &[f64]) -> Option<Note> {
    let usual = median_interval(time_s);
    let gaps = time_s.windows(2).filter(|pair| pair[1] - pair[0] > 10.0 * usual);
    let longest = gaps.clone().max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
    Some(Note::Gaps { count: gaps.count(), longest_s: longest[1] - longest[0], at_s: longest[0] })
}

/// The median interval between neighbours; NaN for fewer than two times.
#[must_use]
pub fn median_interval(time_s: &[f64]) -> f64 {
    let mut intervals: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = intervals.len() / 2;
    if intervals.is_empty() {
        return f64::NAN;
    }
    *intervals.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests;
