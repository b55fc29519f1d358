//! Failed sensors are found before effects are tried, and working sensors are not called failed.

use std::path::{Path, PathBuf};

use diagnosis::Verdict;
use identification::experiment::{Prepared, share_range_ends};
use recording::{ChannelMap, Column, Recording, Signal};
use simulation::sensor_fault::{FailureKind, Failures, MEASURED, RangeEnd, Side};
use virtual_plant::PlantEffect;

use super::bed::{Case, accepted, pump_case, valve_case};

/// The sensor failures that are reported for a recording, in words.
fn failures(recording: &Recording) -> Vec<String> {
    let of = |signal: Signal| {
        let found = recording.signal(signal).map(|values| Failures::of(signal, recording.time_s(), values));
        let found = found.unwrap_or_default();
        let ends = found.ends.into_iter().map(move |end| format!("{signal} at {}", end.reading));
        found.stretches.into_iter().map(move |stretch| format!("{signal} {stretch:?}")).chain(ends)
    };
    MEASURED.into_iter().flat_map(of).map(|said| format!("{}: {said}", recording.path())).collect()
}

fn recordings_below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            recordings_below(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "csv") {
            found.push(path);
        }
    }
}

#[test]
fn no_sensor_that_works_is_called_failed() {
    let mut said = Vec::new();
    for case in [valve_case(1, None, true, None), pump_case(2, None)] {
        said.extend(case.training.iter().chain(&case.held_out).flat_map(failures));
    }
    let mut paths = Vec::new();
    for folder in ["concealed", "concealed-hard", "data"].into_iter().filter_map(system_tests::at_hand::shared) {
        recordings_below(&folder, &mut paths);
    }
    // Static sweeps have no clock and are no recordings.
    let read: Vec<Recording> =
        paths.iter().filter_map(|path| recording::read(path, &ChannelMap::default()).ok()).collect();
    println!("{} recordings beside the repository", read.len());
    said.extend(read.iter().flat_map(failures));
    assert!(said.is_empty(), "{said:#?}");
}

/// Makes a sensor of one recording read `reading`, or repeat its last value, over some rows.
fn fail(recording: &mut Recording, signal: Signal, rows: std::ops::Range<usize>, reading: Option<f64>) {
    let mut columns: Vec<Column> = recording.columns().to_vec();
    let column = columns.iter_mut().find(|column| column.signal == signal).unwrap();
    let held = reading.unwrap_or(column.values[rows.start]);
    column.values[rows].fill(held);
    *recording = Recording::new(recording.name(), columns).unwrap();
}

/// The half second of the first training recording in which the rod moves most, by its rows.
fn moving(case: &Case) -> std::ops::Range<usize> {
    let position = case.training[0].signal(Signal::Position).unwrap();
    let starts = 1..position.len() - 251;
    let way = |row: &usize| (position[row + 250] - position[*row]).abs();
    let from = starts.max_by(|a, b| way(a).total_cmp(&way(b))).unwrap();
    from..from + 250
}

fn stretches(case: &Case, signal: Signal) -> Vec<(FailureKind, usize, usize)> {
    let prepared = Prepared::new(&case.training[0], &case.file.machine, case.file.load_source, None).unwrap();
    let channel = prepared.channels.iter().find(|channel| channel.signal == signal).unwrap();
    channel.stretches.iter().map(|stretch| (stretch.kind, stretch.from, stretch.to)).collect()
}

#[test]
fn failing_sensors_of_a_drive_that_lacks_nothing_are_found_and_nothing_is_missing() {
    let mut case = valve_case(1, None, true, None);
    let stuck = moving(&case);
    let first = &mut case.training[0];
    fail(first, Signal::Position, stuck.clone(), None);
    fail(first, Signal::PressureA, 900..940, Some(0.0));
    assert_eq!(stretches(&case, Signal::Position), [(FailureKind::Stuck, stuck.start, stuck.end)]);
    assert_eq!(stretches(&case, Signal::PressureA), [(FailureKind::Dropout, 900, 940)]);
    assert_eq!(case.diagnose().verdict, Verdict::NothingMissing);
}

#[test]
fn a_leak_is_named_although_the_position_hangs_for_half_a_second() {
    let mut case = valve_case(12, Some(PlantEffect::internal_leakage(4e-12)), true, None);
    let stuck = moving(&case);
    fail(&mut case.training[0], Signal::Position, stuck.clone(), None);
    assert_eq!(stretches(&case, Signal::Position).len(), 1);
    assert_eq!(accepted(&case.diagnose()), "internal-leakage");
}

/// The end of a range that one recording shows is that of the same sensor in another that comes there for a moment.
#[test]
fn a_moment_at_the_end_of_a_range_is_not_judged_where_another_recording_shows_the_end() {
    let case = valve_case(3, None, true, None);
    let mut prepared = case.prepared(&case.training);
    let (first, other) = prepared.split_at_mut(1);
    let of_b =
        |case: &mut Prepared| case.channels.iter().position(|channel| channel.signal == Signal::PressureB).unwrap();
    let (shows, visits) = (of_b(&mut first[0]), of_b(&mut other[0]));
    let end_pa = 1.1 * other[0].channels[visits].recorded.iter().copied().fold(0.0, f64::max);
    other[0].channels[visits].recorded[500..503].fill(end_pa);
    let rows = (0..first[0].rows()).map(|row| row < 200).collect();
    first[0].channels[shows].ends.push(RangeEnd { reading: end_pa, side: Side::High, rows });
    share_range_ends(&mut prepared.iter_mut().collect::<Vec<_>>());
    let failed = |channel: usize| &prepared[1].channels[channel].failed;
    assert_eq!(failed(visits).iter().filter(|failed| **failed).count(), 3);
    let elsewhere = (0..prepared[1].channels.len()).filter(|channel| *channel != visits);
    assert!(elsewhere.flat_map(failed).all(|failed| !failed));
}

#[test]
fn pressures_at_the_end_of_their_sensors_range_are_not_judged_and_nothing_is_missing() {
    let mut case = valve_case(3, None, true, None);
    let high = |recording: &Recording| {
        let mut read = recording.signal(Signal::PressureB).unwrap().to_vec();
        read.sort_by(f64::total_cmp);
        read[read.len() * 3 / 5]
    };
    let end_pa = high(&case.training[0]);
    for recording in case.training.iter_mut().chain(&mut case.held_out) {
        for signal in [Signal::PressureA, Signal::PressureB] {
            let read: Vec<f64> = recording.signal(signal).unwrap().iter().map(|pa| pa.min(end_pa)).collect();
            recording.replace(signal, &read);
        }
    }
    for prepared in case.prepared(&case.training) {
        let of_b = prepared.channels.iter().find(|channel| channel.signal == Signal::PressureB).unwrap();
        let recorded = of_b.recorded.iter().filter(|read| **read >= end_pa).count();
        let shown = of_b.ends.iter().map(simulation::sensor_fault::RangeEnd::count).sum::<usize>();
        assert!(recorded < 40 || shown >= recorded, "{}: {shown} of {recorded}", prepared.name);
    }
    assert_eq!(case.diagnose().verdict, Verdict::NothingMissing);
}
