//! Columns of a file that hold no known signal, to be looked at.

use std::path::Path;

use super::survey::survey;
use super::surveyed::{MOST_ROWS, Surveyed};
use crate::error::RecordingError;
use crate::recording::Recording;
use crate::signal::Signal;
use crate::unit::Unit;

/// A column that holds no known signal, as it stands in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownColumn {
    /// Its header.
    pub header: String,
    /// Its unit, where it has a known one.
    pub unit: Option<Unit>,
    /// Times, s; empty where the column cannot be drawn over time: not every row holds a number.
    pub time_s: Vec<f64>,
    /// Its values, in its unit, one for each time.
    pub values: Vec<f64>,
}

/// The columns of a recording's file that hold no known signal, of long files the first rows.
///
/// # Errors
/// The file cannot be read.
pub fn unknown_columns(path: &Path, recording: &Recording) -> Result<Vec<UnknownColumn>, RecordingError> {
    if recording.ignored().is_empty() {
        return Ok(Vec::new());
    }
    Ok(unknown_among(&survey(path)?, recording))
}

/// Of the surveyed columns of a recording's file those that hold no known signal.
#[must_use]
pub fn unknown_among(all: &[Surveyed], recording: &Recording) -> Vec<UnknownColumn> {
    let clock = recording.column(Signal::Time);
    let clock = clock.and_then(|clock| all.iter().find(|column| is_called(column, &clock.header)));
    recording.ignored().iter().map(|header| with_times(header, all, clock, recording)).collect()
}

fn is_called(column: &Surveyed, header: &str) -> bool {
    column.name == header || column.header() == header
}

fn with_times(header: &str, all: &[Surveyed], clock: Option<&Surveyed>, recording: &Recording) -> UnknownColumn {
    let found = all.iter().find(|column| is_called(column, header));
    let (unit, values) = found.map_or((None, &[][..]), |column| (column.unit, column.values.as_slice()));
    let own = recording.time_s();
    let of_file = clock.filter(|clock| !clock.is_stamped && clock.values.len() == values.len());
    let time_s: Vec<f64> = if values.len() == own.len() || (values.len() == MOST_ROWS && own.len() > MOST_ROWS) {
        own[..values.len()].to_vec()
    } else if let Some(clock) = of_file.filter(|_| !values.is_empty()) {
        // Rows that a recording leaves out, as their times repeat, stand in the file all the same.
        clock.values.iter().map(|time| clock.unit.map_or(*time, |unit| unit.to_si(*time))).collect()
    } else {
        Vec::new()
    };
    let values = if time_s.is_empty() { Vec::new() } else { values.to_vec() };
    UnknownColumn { header: header.to_owned(), unit, time_s, values }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ChannelMap, read};

    #[test]
    fn a_column_that_no_signal_is_known_for_comes_with_its_times() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        let text = "time [ms];position [mm];Motorstrom [A];remark;odd\n0;1;5,5;a;1\n10;2;6;b;\n20;3;6,5;c;2\n";
        std::fs::write(&path, text).unwrap();
        let recording = read(&path, &ChannelMap::default()).unwrap();
        let found = unknown_columns(&path, &recording).unwrap();
        let headers: Vec<&str> = found.iter().map(|column| column.header.as_str()).collect();
        assert_eq!(headers, ["Motorstrom [A]", "remark", "odd"]);
        assert_eq!(
            (found[0].time_s.as_slice(), found[0].values.as_slice()),
            ([0.0, 0.01, 0.02].as_slice(), [5.5, 6.0, 6.5].as_slice())
        );
        assert!(found[1..].iter().all(|column| column.time_s.is_empty() && column.values.is_empty()), "{found:?}");
    }
}
