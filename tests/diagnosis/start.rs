//! Recordings that do not begin at rest.

use diagnosis::Verdict;
use recording::{Column, Recording, Signal};

use super::bed::{Case, valve_case};

/// A recording from this row on, its time counted from there.
fn from(recording: &Recording, row: usize) -> Recording {
    let cut = |column: &Column| {
        let values = &column.values[row..];
        let zero = if column.signal == Signal::Time { values[0] } else { 0.0 };
        Column { values: values.iter().map(|value| value - zero).collect(), ..column.clone() }
    };
    Recording::new(recording.name(), recording.columns().iter().map(cut).collect()).unwrap()
}

/// The row of the first change of the command, and the row some rows later.
fn after_first_step(recording: &Recording, rows: usize) -> usize {
    let command = recording.signal(Signal::Command).unwrap();
    let moved = command.iter().position(|volts| (volts - command[0]).abs() > 0.5).unwrap();
    moved + rows
}

fn cut(case: &mut Case, rows: usize) {
    for recording in case.training.iter_mut().chain(&mut case.held_out) {
        *recording = from(recording, after_first_step(recording, rows));
    }
}

#[test]
fn a_drive_whose_recordings_begin_with_a_step_misses_nothing() {
    let mut case = valve_case(1, None, true, None);
    // Sweeps and triangles have no step.
    case.training.pop();
    case.held_out.pop();
    cut(&mut case, 0);
    assert_eq!(case.diagnose().verdict, Verdict::NothingMissing);
}

#[test]
fn a_drive_whose_recordings_begin_in_the_middle_of_a_stroke_misses_nothing() {
    for without_spool in [false, true] {
        let mut case = valve_case(1, None, true, None);
        cut(&mut case, 15);
        if without_spool {
            for recording in case.training.iter_mut().chain(&mut case.held_out) {
                *recording = recording.limited_to(|signal| signal != Signal::Spool);
            }
        }
        let found = case.diagnose();
        assert_eq!(found.verdict, Verdict::NothingMissing, "{without_spool}");
        assert!(found.shown.iter().any(|shown| shown.prepared.unsettled > 0));
        let position = |shown: &diagnosis::Shown| {
            let channel = shown.prepared.channels.iter().find(|channel| channel.signal == Signal::Position).unwrap();
            channel.fit_percent(&channel.over_noise(shown.after.signal(Signal::Position).unwrap()))
        };
        assert!(found.shown.iter().all(|shown| position(shown) > 97.0), "{without_spool}");
    }
}
