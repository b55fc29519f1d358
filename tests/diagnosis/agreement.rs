//! Recordings and a machine file that do not belong together are told apart from drives that only lack physics.

use std::path::{Path, PathBuf};
use std::time::Instant;

use diagnosis::agreement::{Change, Doubt, doubts};
use diagnosis::base_parameters;
use model_core::machine::Parameter;
use recording::{Recording, Signal};

use super::hall;

fn of_folder(folder: &Path) -> Vec<Doubt> {
    let (file, recordings) = test_press::folder(folder);
    doubts(&file, &base_parameters(&file), &recordings.iter().collect::<Vec<_>>()).unwrap()
}

/// Every third of them; all: `cargo test --release -p system-tests --test diagnosis no_drive_at_hand -- --ignored`.
#[test]
fn no_drive_at_hand_is_refused() {
    assert_none_is_refused(3);
}

#[test]
#[ignore = "some minutes"]
fn no_drive_at_hand_is_refused_of_all_of_them() {
    assert_none_is_refused(1);
}

fn assert_none_is_refused(of: usize) {
    let mut seen = 0;
    for set in ["concealed", "concealed-hard", "foreign"] {
        let Some(set) = system_tests::at_hand::shared(set) else { continue };
        let mut folders: Vec<PathBuf> = std::fs::read_dir(set).unwrap().map(|entry| entry.unwrap().path()).collect();
        folders.retain(|folder| folder.join("machine.toml").is_file());
        folders.sort();
        for folder in folders.into_iter().step_by(of) {
            let begun = Instant::now();
            let found = of_folder(&folder);
            println!("{}: {:.2} s", folder.display(), begun.elapsed().as_secs_f64());
            for doubt in &found {
                println!("{doubt:?}");
            }
            assert!(found.iter().all(|doubt| !doubt.is_certain), "{}", folder.display());
            seen += 1;
        }
    }
    println!("{seen} drives");
}

/// What may have happened to the recordings of a drive that is known by its data sheet alone, and what would mend it.
#[test]
fn of_a_drive_known_by_its_data_sheet_what_is_wrong_with_a_channel_is_told_and_mended() {
    use Signal as S;
    let case = hall::case(&[]);
    let stroke_m = case.file.machine.get(Parameter::Stroke);
    let with = |signal: Signal, change: &dyn Fn(f64) -> f64| -> Vec<Recording> {
        let changed = |recording: &Recording| {
            let mut changed = recording.clone();
            let values: Vec<f64> = recording.signal(signal).unwrap().iter().map(|value| change(*value)).collect();
            changed.replace(signal, &values);
            changed
        };
        case.training.iter().map(changed).collect()
    };
    let exchanged = |recording: &Recording| {
        let mut changed = recording.clone();
        changed.replace(S::PressureA, recording.signal(S::PressureB).unwrap());
        changed.replace(S::PressureB, recording.signal(S::PressureA).unwrap());
        changed
    };
    let late = |recording: &Recording| {
        let mut changed = recording.clone();
        let (command, time_s) = (recording.signal(S::Command).unwrap(), recording.time_s());
        let rows = time_s.partition_point(|time| time - time_s[0] < 0.02);
        let late: Vec<f64> = (0..command.len()).map(|row| command[row.saturating_sub(rows)]).collect();
        changed.replace(S::Command, &late);
        changed
    };
    let scaled = |signal, factor| Change::Scaled(signal, factor);
    let wrong: Vec<(Vec<Recording>, Change)> = vec![
        (with(S::Position, &|m| 0.1 * m), scaled(S::Position, 10.0)),
        (with(S::Position, &|m| m / 25.4), scaled(S::Position, 25.4)),
        (with(S::Position, &|m| stroke_m - m), Change::Reversed(S::Position)),
        (with(S::Position, &|m| -m), Change::Reversed(S::Position)),
        (with(S::Position, &|m| m + 0.8 * stroke_m), Change::Moved(S::Position, 0.0)),
        (with(S::Position, &|m| m - 0.8 * stroke_m), Change::Moved(S::Position, 0.0)),
        (with(S::Command, &|v| -v), Change::Reversed(S::Command)),
        (with(S::Command, &|v| 10.0 * v), scaled(S::Command, 0.1)),
        (case.training.iter().map(exchanged).collect(), Change::PressuresExchanged),
        (with(S::Time, &|s| 1e3 * s), scaled(S::Time, 1e-3)),
        (case.training.iter().map(late).collect(), Change::Earlier(S::Command, 0.0)),
    ];
    let free = base_parameters(&case.file);
    let of = |recordings: &[Recording]| doubts(&case.file, &free, &recordings.iter().collect::<Vec<_>>()).unwrap();
    assert_eq!(of(&case.training), []);
    let unseen = |recordings: &[Recording]| -> Vec<Recording> {
        recordings.iter().map(|recording| recording.limited_to(|signal| signal != S::Spool)).collect()
    };
    for (recordings, mended) in &wrong {
        for recordings in [recordings, &unseen(recordings)] {
            let found = of(recordings);
            let [doubt] = found.as_slice() else { panic!("{mended:?}: {found:?}") };
            let [change] = doubt.changed.changes.as_slice() else { panic!("{mended:?}: {doubt:?}") };
            assert!(doubt.is_certain, "{mended:?}: {doubt:?}");
            match (change, mended) {
                (Change::Moved(found, _), Change::Moved(signal, _)) => assert_eq!(found, signal),
                (Change::Earlier(found, by_s), Change::Earlier(signal, _)) => {
                    assert!(found == signal && (0.012..0.028).contains(by_s), "{by_s}");
                }
                _ => assert_eq!(change, mended),
            }
        }
    }
}

/// The same ratio of areas, another size: mass and flow tell.
#[test]
fn areas_of_a_cylinder_of_another_size_are_told() {
    let mut case = hall::case(&[]);
    let other = Change::Cylinder { bore_mm: 80.0, rod_mm: 45.0 };
    case.file.machine = other.on(&case.file.machine);
    let free = base_parameters(&case.file);
    let found = doubts(&case.file, &free, &case.training.iter().collect::<Vec<_>>()).unwrap();
    let changes: Vec<&Change> = found.iter().flat_map(|doubt| &doubt.changed.changes).collect();
    assert_eq!(changes, [&Change::Cylinder { bore_mm: 63.0, rod_mm: 36.0 }]);
}
