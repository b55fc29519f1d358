//! What is read, what is refused, and what comes out again.

use std::io::{self, Read};

use super::*;
use crate::files::source_error::{Explained, render};
use crate::{ChannelMap, MAX_COLUMNS, Mapping, Scale, read, read_from};

fn read_text(text: impl AsRef<[u8]>) -> Result<Recording, RecordingError> {
    read_from("run.csv", text.as_ref(), &ChannelMap::default())
}

fn mapped(text: &str, arguments: &[&str]) -> Result<Recording, RecordingError> {
    let map = ChannelMap::from_arguments(arguments.iter().copied()).unwrap();
    read_from("run.csv", text.as_bytes(), &map)
}

/// The error that a text gives, which must carry the file's name and the given line.
#[track_caller]
fn refused(text: impl AsRef<[u8]>, line: Option<usize>) -> RecordingError {
    let error = read_text(text).unwrap_err();
    assert!(error.to_string().starts_with("run.csv"), "{error}");
    assert_eq!(error.place().line(), line, "{error}");
    assert!(render(&error).contains("= expected: "), "{}", render(&error));
    error
}

macro_rules! assert_error {
    ($error:expr, $pattern:pat) => {{
        let error = $error;
        assert!(matches!(error, $pattern), "{error:?}");
    }};
}

const PLAIN: &str = "time [s],command [V],position [mm],remark\n0,0,10,a\n0.1,1.5,11,\n0.2,-2,12.5,c\n";

#[test]
fn a_plain_recording_is_read_in_si_units() {
    let recording = read_text(PLAIN).unwrap();
    assert_eq!(recording.name(), "run.csv");
    assert_eq!(recording.rows(), 3);
    assert_eq!(recording.time_s(), [0.0, 0.1, 0.2]);
    assert_eq!(recording.signal(Signal::Command).unwrap(), [0.0, 1.5, -2.0]);
    assert_eq!(recording.signal(Signal::Position).unwrap(), [0.01, 0.011, 0.0125]);
    assert_eq!(recording.column(Signal::Position).unwrap().header, "position [mm]");
    assert_eq!(recording.ignored(), ["remark"]);
    assert!(recording.notes().is_empty());
    assert!(!recording.has(Signal::Spool));
    assert!((recording.sample_interval_s() - 0.1).abs() < 1e-12);
}

#[test]
fn a_column_that_is_left_unused_is_not_known_by_its_name() {
    let mut map = ChannelMap::default();
    map.leave_unused("position [mm]");
    let read = |text: &str, map: &ChannelMap| read_from("run.csv", text.as_bytes(), map);
    let recording = read(PLAIN, &map).unwrap();
    assert!(recording.has(Signal::Command) && !recording.has(Signal::Position));
    assert_eq!(recording.ignored(), ["position [mm]", "remark"]);
    map.leave_unused("time [s]");
    assert_error!(read(PLAIN, &map), Err(RecordingError::NoTimeColumn { .. }));
    let asked = ChannelMap::from_arguments(["time=time", "position=position"]).unwrap();
    assert!(read(PLAIN, &map.overlaid_with(&asked)).unwrap().has(Signal::Position), "what is asked for by hand counts");
    let mut of_units = ChannelMap::default();
    of_units.leave_unused("position [mm]");
    let below = "time,command,position\ns,V,mm\n0,0,10\n0.1,1.5,11\n";
    assert!(!read(below, &of_units).unwrap().has(Signal::Position), "the unit stands below the name");
}

#[test]
fn german_spreadsheet_files_are_read() {
    let text = "\u{feff}# Prüfstand 3\r\n\r\n\"time [ms]\";position [mm];\"oil_temperature [K]\"\r\n0;0,5;300\r\n#\r\n10;\"0,75\";300,5\r\n";
    let recording = read_text(text).unwrap();
    assert_eq!(recording.time_s(), [0.0, 0.01]);
    assert_eq!(recording.signal(Signal::Position).unwrap(), [0.0005, 0.00075]);
    assert_eq!(recording.signal(Signal::OilTemperature).unwrap(), [300.0 - 273.15, 300.5 - 273.15]);
    let tabs = read_text("time [s]\tspool\tx\n0\t0,5\t\n1\t0,6\t\n").unwrap();
    assert_eq!(tabs.signal(Signal::Spool).unwrap(), [0.5, 0.6]);
}

#[test]
fn other_names_are_mapped_and_the_map_wins() {
    let text = "Zeit [ms],Kolbenweg [mm],position [m],U\n0,1,9,0\n1,2,9,1\n";
    let map = ["time=Zeit [ms]", "position=Kolbenweg [mm]", "command=U [mV]"];
    let recording = mapped(text, &map).unwrap();
    assert_eq!(recording.signal(Signal::Position).unwrap(), [0.001, 0.002]);
    assert_eq!(recording.signal(Signal::Command).unwrap(), [0.0, 0.001]);
    assert_eq!(recording.ignored(), ["position [m]"]);
    assert_error!(mapped(PLAIN, &["spool=Schieber [%]"]).unwrap_err(), RecordingError::MappedColumnAbsent { .. });
    // A mapping whose unit contradicts the file's does not match the column.
    assert_error!(mapped(text, &["time=Zeit [s]"]).unwrap_err(), RecordingError::MappedColumnAbsent { .. });
}

#[test]
fn a_machine_files_map_may_name_columns_that_are_not_there() {
    let mut map = ChannelMap::default();
    map.insert(Signal::Spool, Mapping::column("S [%]", false));
    let recording = read_from("run.csv", PLAIN.as_bytes(), &map).unwrap();
    assert!(matches!(recording.notes(), [Note::MappedColumnAbsent { signal: Signal::Spool, .. }]));
}

#[test]
fn repeated_times_and_incomplete_rows_are_left_out_and_counted() {
    let recording = read_text("time [s],spool\n0,0\n1,1\n1,9\n2,\n3,3\n3,3\n").unwrap();
    assert_eq!(recording.signal(Signal::Spool).unwrap(), [0.0, 1.0, 3.0]);
    let expected =
        [Note::DuplicateTimes { rows: 2, first: At::Line(4) }, Note::IncompleteRows { rows: 1, first: At::Line(5) }];
    assert_eq!(recording.notes(), expected);
    let told: Vec<String> = recording.notes().iter().map(ToString::to_string).collect();
    assert_eq!(told[0], "2 rows repeat the time before them and are left out, the first in line 4");
    assert_eq!(told[1], "1 row has an empty cell and is left out, in line 5");
    let once = read_text("time [s],spool\n0,0\n1,1\n1,9\n2,2\n50,3\n").unwrap();
    let told: Vec<String> = once.notes().iter().map(ToString::to_string).collect();
    assert_eq!(told[0], "1 row repeats the time before it and is left out, in line 4");
    assert_eq!(told[1], "1 gap in time, of 48 s at 2 s");
}

#[test]
fn uneven_times_are_allowed_and_gaps_noted() {
    let recording = read_text("time [s],spool\n-5,0\n-4,0\n-2.5,0\n-1.5,1\n98.5,2\n").unwrap();
    assert_eq!(recording.notes(), [Note::Gaps { count: 1, longest_s: 100.0, at_s: -1.5 }]);
}

#[test]
fn a_spreadsheet_s_own_letters_are_read_and_noted() {
    let western =
        b"time [\xb5s];oil_temperature [\xb0C];Ventilhub \xfc;position [mm]\r\n0;40,5;x;1\r\n100;41;\xf6l;2\r\n";
    let recording = read_text(western).unwrap();
    assert_eq!(recording.signal(Signal::OilTemperature).unwrap(), [40.5, 41.0]);
    assert_eq!((recording.time_s()[1], recording.ignored()), (100e-6, ["Ventilhub ü".to_owned()].as_slice()));
    assert_eq!(recording.notes(), [Note::ReadAsWindows1252 { first: At::Line(1) }]);
    // A text in UTF-8 has no such note.
    assert_eq!(read_text("time [µs],oil_temperature [°C]\n0,40\n1,41\n").unwrap().notes(), []);
}

#[test]
fn files_without_a_table_are_refused() {
    assert_error!(refused("", None), RecordingError::Empty { .. });
    assert_error!(refused("# only\n\n", None), RecordingError::Empty { .. });
    assert_error!(refused("time [s],spool\n", None), RecordingError::TooFewRows { rows: 0, .. });
    assert_error!(refused("time [s],spool\n0,0\n", None), RecordingError::TooFewRows { rows: 1, .. });
    assert_error!(refused("time [s],spool\n0,\n1,\n", None), RecordingError::TooFewRows { rows: 0, skipped: 2, .. });
    assert_error!(refused(b"time [s],temp [\x81C]\n", Some(1)), RecordingError::NotUtf8 { byte: 0x81, .. });
    assert_error!(refused("time [s],spool\n0,\u{0}\n", Some(2)), RecordingError::ControlCharacter { .. });
    assert_error!(refused("time [s],spool\n0,\"1\n1,2\n", Some(2)), RecordingError::OpenQuote { .. });
}

#[test]
fn columns_that_cannot_be_understood_are_refused() {
    assert_error!(refused("x,index\n0,1\n", Some(1)), RecordingError::NoTimeColumn { .. });
    assert_error!(refused("Time [s],spool\n", Some(1)), RecordingError::NoTimeColumn { .. });
    assert_error!(refused("time,spool\n", Some(1)), RecordingError::MissingUnit { .. });
    assert_error!(refused("time [s],position\n", Some(1)), RecordingError::MissingUnit { .. });
    let several = refused("time [s],position,spool,pressure_a\n0,1,2,3\n", Some(1)).to_string();
    let expected = "columns `position`, `pressure_a` have no unit; expected a unit in brackets after the name, in the file or as \
        --map \"position=position […]\": `position` one of: m mm; `pressure_a` one of: Pa kPa MPa bar psi";
    assert!(several.ends_with(expected), "{several}");
    assert_error!(refused("time [s],position [inch]\n", Some(1)), RecordingError::UnknownUnit { .. });
    assert_error!(refused("time [s],spool,spool [%]\n", Some(1)), RecordingError::DuplicateColumn { .. });
    let alike = refused("time [s],spool,spool\n", Some(1)).to_string();
    assert!(
        alike.starts_with("run.csv:1:16: columns 2 and 3 are both called `spool`; expected names that differ"),
        "{alike}"
    );
    let map = ChannelMap::from_arguments(["spool=Hub"]).unwrap();
    let mapped = read_from("run.csv", &b"time [s],Hub,Hub\n0,1,2\n1,2,3\n"[..], &map).unwrap_err();
    assert!(matches!(mapped, RecordingError::AlikeColumns { numbers: [2, 3], .. }), "{mapped}");
    let error = refused("time [s],position [bar]\n", Some(1));
    assert_eq!(
        error.to_string(),
        "run.csv:1:10: position is given in `bar`; expected a unit of position, one of: m mm; where it is not needed, \
         `unused = [\"position [bar]\"]` in [channels] of the machine file leaves it out"
    );
}

#[test]
fn cells_that_are_no_numbers_are_refused_with_line_and_column() {
    let error = refused("time [s],position [mm]\n# c\n0,1\n1,abc\n", Some(4));
    assert_eq!(error.place().spot.as_ref().unwrap().column, 3);
    assert_error!(error, RecordingError::NotANumber { .. });
    for bad in ["inf", "-Infinity", "1e999"] {
        assert_error!(refused(format!("time [s],spool\n0,{bad}\n"), Some(2)), RecordingError::NotFinite { .. });
    }
    let overflow = "time [s],pressure_a [bar]\n0,1e306\n";
    assert_error!(refused(overflow, Some(2)), RecordingError::NotFinite { .. });
    let timeless = read_text("time [s],spool\n0,0\n,1\n2,2\n").unwrap();
    assert_eq!(timeless.notes(), [Note::IncompleteRows { rows: 1, first: At::Line(3) }]);
}

#[test]
fn rows_that_do_not_fit_are_refused() {
    for (text, found) in [("0,1,2\n", 3), ("0\n", 1)] {
        let error = refused(format!("time [s],spool\n{text}"), Some(2));
        assert!(matches!(error, RecordingError::RaggedRow { found: n, expected: 2, .. } if n == found), "{error}");
    }
    let error = refused("time [s],spool\n0,0\n1,0\n0.5,0\n", Some(4));
    assert_error!(error, RecordingError::TimeBackwards { .. });
}

/// Repeats a pattern without end.
struct Endless(&'static [u8], usize);

impl Read for Endless {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        for byte in buffer.iter_mut() {
            *byte = self.0[self.1 % self.0.len()];
            self.1 += 1;
        }
        Ok(buffer.len())
    }
}

#[test]
fn endless_garbage_is_refused_early() {
    let error = |pattern| read_from("big", Endless(pattern, 0), &ChannelMap::default()).unwrap_err();
    assert_error!(error(b"\x7fXLF\x02\n\xff"), RecordingError::ControlCharacter { .. });
    assert_error!(error(b"\x81\xed\n"), RecordingError::NotUtf8 { .. });
    assert_error!(error(b"\0"), RecordingError::LineTooLong { .. });
    assert_error!(error(b"a,"), RecordingError::LineTooLong { .. });
    assert_error!(error(b"lorem ipsum\n"), RecordingError::Text { .. });
    assert_error!(error(b"#\n"), RecordingError::TooManySkippedLines { .. });
    assert_error!(error(b"\n"), RecordingError::TooManySkippedLines { .. });
    assert_error!(error(b"Name\t\n"), RecordingError::ExportLayout { .. });
    let wide = "time [s]".to_owned() + &",x".repeat(MAX_COLUMNS) + "\n";
    assert_error!(refused(wide, Some(1)), RecordingError::TooManyColumns { .. });
    let widest = "time [s]".to_owned() + &",x".repeat(MAX_COLUMNS - 1) + "\n";
    assert_error!(refused(widest, None), RecordingError::TooFewRows { .. });
}

#[test]
fn a_signal_that_shall_be_judged_must_be_there_and_vary() {
    let recording = read_text("time [s],spool,command [V]\n0,0.5,0\n1,0.5,1\n").unwrap();
    assert!(recording.check_varies(Signal::Command).is_ok());
    let constant = recording.check_varies(Signal::Spool).unwrap_err();
    assert_eq!(
        constant.to_string(),
        "run.csv: spool is 0.5 in every row; expected a signal that moves; one that never changes cannot be judged"
    );
    assert_error!(recording.check_varies(Signal::Position).unwrap_err(), RecordingError::MissingSignal { .. });
}

#[test]
fn a_recording_is_written_in_its_own_columns_and_units() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.csv");
    let text = "time [ms];x;\"position [mm]\";command [V]\n0;;0,1;-0,5\n2,5;;0,3;1e-7\n";
    let recording = read_text(text).unwrap();
    recording.write_csv(&path, &[(Signal::Command, &[0.1, 1.0 / 3.0]), (Signal::Flow, &[0.0, 0.0])], &[]).unwrap();
    let written = std::fs::read_to_string(&path).unwrap();
    assert_eq!(written, "time [ms],position [mm],command [V]\n0,0.1,0.1\n2.5,0.3,0.3333333333333333\n");
    let nan = recording.write_csv(&path, &[(Signal::Command, &[0.0, f64::NAN])], &[]).unwrap_err();
    assert_error!(nan, RecordingError::NotFinite { .. });
    assert_error!(
        recording.write_csv(&path, &[(Signal::Command, &[0.0])], &[]).unwrap_err(),
        RecordingError::LengthMismatch { .. }
    );
    assert_eq!(std::fs::read_to_string(&path).unwrap(), written);
    let nowhere = recording.write_csv(&folder.path().join("no/out.csv"), &[], &[]).unwrap_err();
    assert_error!(nowhere, RecordingError::Write { .. });
    assert_error!(read(folder.path(), &ChannelMap::default()).unwrap_err(), RecordingError::Io { .. });
    assert_error!(read(&folder.path().join("none"), &ChannelMap::default()).unwrap_err(), RecordingError::Io { .. });
}

#[test]
fn recordings_made_in_the_program_are_checked() {
    let time = || Column::si(Signal::Time, vec![0.0, 1.0]);
    let new = |columns| Recording::new("made", columns);
    assert!(new(vec![time(), Column::si(Signal::Spool, vec![0.0, 1.0])]).is_ok());
    assert_error!(new(vec![]).unwrap_err(), RecordingError::NoTimeColumn { .. });
    assert_error!(new(vec![Column::si(Signal::Time, vec![0.0])]).unwrap_err(), RecordingError::TooFewRows { .. });
    assert_error!(
        new(vec![Column::si(Signal::Time, vec![0.0, 0.0])]).unwrap_err(),
        RecordingError::TimeBackwards { .. }
    );
    assert_error!(new(vec![time(), time()]).unwrap_err(), RecordingError::DuplicateColumn { .. });
    assert_error!(
        new(vec![time(), Column::si(Signal::Spool, vec![])]).unwrap_err(),
        RecordingError::LengthMismatch { .. }
    );
    let infinite = Column::si(Signal::Spool, vec![0.0, f64::INFINITY]);
    assert_error!(new(vec![time(), infinite]).unwrap_err(), RecordingError::NotFinite { .. });
}

#[test]
fn readings_of_a_sensor_become_values_and_are_written_back_as_readings() {
    let mut map = ChannelMap::default();
    let sensor =
        |header: &str, zero, full| Mapping { scale: Some(Scale { zero, full }), ..Mapping::column(header, false) };
    map.insert(Signal::Spool, sensor("spool_sensor [V]", 5.0, -5.0));
    map.insert(Signal::Command, sensor("u", 5.0, 1.0));
    map.insert(Signal::PressureA, sensor("p [counts]", 100.0, 1e-5));
    let text = "time [s],u,spool_sensor [V],p [counts]\n0,5,5,100\n1,7.5,0,120\n";
    let recording = read_from("run.csv", text.as_bytes(), &map).unwrap();
    assert_eq!(recording.signal(Signal::Spool).unwrap(), [0.0, 1.0]);
    assert_eq!(recording.signal(Signal::Command).unwrap(), [0.0, 2.5]);
    assert!((recording.signal(Signal::PressureA).unwrap()[1] - 20e5).abs() < 1e-6);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.csv");
    recording.write_csv(&path, &[], &[]).unwrap();
    assert_eq!(std::fs::read_to_string(path).unwrap(), text);
}

#[test]
fn a_recording_limited_to_some_signals_holds_and_writes_only_these() {
    let recording = read_text("time [s],spool,flow [m3/s]\n0,0,1\n1,,2\n2,1,3\n").unwrap();
    let limited = recording.limited_to(|signal| signal != Signal::Spool);
    assert!(!limited.has(Signal::Spool) && limited.ignored() == ["spool"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.csv");
    limited.write_csv(&path, &[], &[]).unwrap();
    assert_eq!(std::fs::read_to_string(path).unwrap(), "time [s],flow [m3/s]\n0,1\n1,2\n2,3\n");
}

/// A triangle with sides of 0.6 and 0.5 m and the cylinder of 0.45 m at 0, as a machine file has it.
fn with_linkage(maps: &[&str]) -> ChannelMap {
    let triangle = crate::linkage::Triangle {
        base_m: 0.6,
        arm_m: 0.5,
        length_retracted_m: 0.45,
        angle_at_zero_rad: 0.0,
        rises: crate::linkage::Rises::Extending,
    };
    let mut map = ChannelMap::from_arguments(maps.iter().copied()).unwrap();
    map.linkage = Some(std::sync::Arc::new(crate::Linkage::of_sides(triangle, 0.3).unwrap()));
    map
}

#[test]
fn an_angle_becomes_the_position_in_any_unit_and_under_any_name() {
    let length = |degrees: f64| (0.61 - 0.6 * degrees.to_radians().cos()).sqrt() - 0.45;
    let in_rad = 60_f64.to_radians();
    let radians = format!("time [s],angle [rad]\n0,{in_rad:?}\n1,{in_rad:?}\n");
    let mut scaled = with_linkage(&[]);
    let scale = Some(crate::Scale { zero: 2.0, full: 1.0 });
    scaled.insert(Signal::Angle, crate::Mapping { header: "joint [V]".into(), required: false, scale });
    for (text, map) in [
        ("time [s],angle [deg]\n0,60\n1,60\n", with_linkage(&[])),
        (radians.as_str(), with_linkage(&[])),
        ("time [s],Winkel [deg]\n0,60\n1,60\n", with_linkage(&["angle=Winkel [deg]"])),
        (&format!("time [s],joint [V]\n0,{:?}\n1,3\n", 2.0 + in_rad), scaled),
    ] {
        let recording = read_from("r.csv", text.as_bytes(), &map).unwrap();
        assert!((recording.signal(Signal::Position).unwrap()[0] - length(60.0)).abs() < 1e-12, "{text}");
        assert_eq!(recording.notes(), [Note::PositionFromAngle]);
        // The angle stays, as it was recorded.
        assert!((recording.signal(Signal::Angle).unwrap()[0] - in_rad).abs() < 1e-12);
    }
}

#[test]
fn a_recorded_position_is_taken_and_an_angle_without_linkage_is_not_passed_over_in_silence() {
    let both =
        read_from("r.csv", &b"time [s],angle [deg],position [mm]\n0,60,7\n1,61,8\n"[..], &with_linkage(&[])).unwrap();
    assert_eq!(
        (both.signal(Signal::Position).unwrap()[0].to_bits(), both.notes()),
        (7e-3_f64.to_bits(), &[Note::AngleBesidePosition][..])
    );
    let lone = read_from("r.csv", &b"time [s],angle [deg]\n0,60\n1,61\n"[..], &ChannelMap::default()).unwrap();
    assert!(!lone.has(Signal::Position));
    assert!(lone.notes()[0].to_string().contains("no [linkage]"), "{}", lone.notes()[0]);
}

#[test]
fn an_angle_that_the_linkage_does_not_reach_is_refused_with_its_line() {
    let text = &b"time [s],angle [deg]\n0,60\n1,179\n2,181\n3,60\n"[..];
    let error = read_from("r.csv", text, &with_linkage(&[])).unwrap_err();
    assert_eq!(
        error.to_string(),
        "r.csv:4:3: a joint angle of 181 deg, which the linkage of the machine file does not reach; expected 0 to 180 deg, from end to end of \
         [linkage]: its zero, its way or its table may be another one"
    );
    // Without a linkage, or where the position is recorded, any angle will do.
    assert!(read_from("r.csv", text, &ChannelMap::default()).is_ok());
}

#[test]
fn rows_that_are_left_out_keep_their_angle_and_are_written_back() {
    let text = &b"time [s],angle [deg],spool\n0,60,0\n1,,0\n1.5,200,\n2,60,0\n"[..];
    let recording = read_from("r.csv", text, &with_linkage(&[])).unwrap();
    assert_eq!(recording.rows(), 2);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.csv");
    recording.write_csv(&path, &[], &[]).unwrap();
    let written = std::fs::read_to_string(&path).unwrap();
    let rows: Vec<&str> = written.lines().collect();
    assert_eq!((rows[0], rows[2], rows[3]), ("time [s],angle [deg],spool,position [m]", "1,,0,", "1.5,200,,"));
    assert!(rows[1].starts_with("0,60,0,0.1067"), "{}", rows[1]);
}
