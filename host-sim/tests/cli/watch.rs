//! `watch`: whether a drive still follows its model as it did while it was healthy.
#![cfg(feature = "virtual-plant")]

use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use super::{done, refused, root, run, text};

/// Recordings of the installed press with these effects: `train-1` … `train-4` and two to judge.
fn recorded(folder: &Path, name: &str, seed: &str, effects: &[&str]) {
    let machine = root().join("presets/press-63-40-installed.toml").display().to_string();
    let signals = ["steps:6V", "sweep:5V", "random:6V,seed=1", "steps:4V"].into_iter().flat_map(|one| ["--train", one]);
    let judged = ["random:5V,seed=9", "steps:5V"].into_iter().flat_map(|one| ["--holdout", one]);
    let effects = effects.iter().flat_map(|effect| ["--effect", effect]);
    let first = ["testbed", "--machine", &machine, "--seed", seed, "--spread", "0", "--out", name];
    let arguments: Vec<&str> = first.into_iter().chain(signals).chain(judged).chain(effects).collect();
    done(folder, &arguments);
}

/// A folder with recordings of the healthy press, and `w.toml`: its machine file with the band that these tell.
fn healthy() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path(), "then", "1", &[]);
    let healthy: Vec<String> = (1..5).map(|k| format!("then/train-{k}.csv")).collect();
    let learn = ["watch", "--machine", "then/machine.toml", "--save-machine", "w.toml", "--healthy"];
    let told = done(folder.path(), &learn.into_iter().chain(healthy.iter().map(String::as_str)).collect::<Vec<_>>());
    assert!(told.contains("position") && told.contains("machine file with its band: w.toml"), "{told}");
    folder
}

/// What is said of the recordings of a case: the headline, and for programs; with the exit status that asks for an answer.
fn watched(folder: &Path, case: &str) -> (String, Value, Option<i32>) {
    let judged = [format!("{case}/holdout-1.csv"), format!("{case}/holdout-2.csv")];
    let arguments = ["watch", "--machine", "w.toml", "--json", "w.json", "--exit-code", &judged[0], &judged[1]];
    let output = run(folder, &arguments);
    let json = std::fs::read_to_string(folder.join("w.json")).unwrap();
    let headline = text(&output.stdout).lines().next().unwrap().to_owned();
    (headline, serde_json::from_str(&json).unwrap(), output.status.code())
}

#[test]
fn a_drive_that_changed_leaves_its_band_at_the_link_that_changed_and_a_healthy_one_stays_in_it() {
    let folder = healthy();
    let folder = folder.path();
    recorded(folder, "same", "2", &[]);
    let (headline, told, status) = watched(folder, "same");
    assert!(headline.starts_with("in its band: 2 recordings, at most "), "{headline}");
    assert_eq!((&told["in_band"], status), (&Value::Bool(true), Some(0)));
    for (effect, link, said) in [
        ("internal-leakage=3e-12", "flow-and-chambers", "flow + chambers: pressure_"),
        ("valve-hysteresis=0.02", "valve", "valve: spool"),
    ] {
        recorded(folder, "worn", "2", &[effect]);
        let (headline, told, status) = watched(folder, "worn");
        let expected = format!("outside its band in 2 of 2 recordings: holdout-1.csv, {said}");
        assert!(headline.starts_with(&expected), "{headline}");
        assert_eq!((&told["in_band"], status), (&Value::Bool(false), Some(1)));
        assert_eq!(told["recordings"][0]["left"]["link"], link, "{told}");
    }
}

/// A recording with some of its columns alone.
fn limited(folder: &Path, from: &str, to: &str, signals: &[&str]) {
    let text = std::fs::read_to_string(folder.join(from)).unwrap();
    let rows: Vec<Vec<&str>> =
        text.lines().filter(|line| !line.starts_with('#')).map(|row| row.split(',').collect()).collect();
    let is_kept = |column: &&str| signals.iter().any(|signal| column.starts_with(signal));
    let kept: Vec<usize> = (0..rows[0].len()).filter(|column| is_kept(&rows[0][*column])).collect();
    let lines = rows.iter().map(|row| kept.iter().map(|column| row[*column]).collect::<Vec<_>>().join(","));
    std::fs::write(folder.join(to), lines.collect::<Vec<_>>().join("\n")).unwrap();
}

#[test]
fn the_position_alone_names_the_mechanics_which_says_where_to_look() {
    let folder = healthy();
    let folder = folder.path();
    recorded(folder, "worn", "2", &["internal-leakage=2e-11"]);
    limited(folder, "worn/holdout-1.csv", "p.csv", &["time", "command", "position"]);
    let told = done(folder, &["watch", "--machine", "w.toml", "p.csv"]);
    assert!(told.starts_with("outside its band: p.csv, mechanics: position is "), "{told}");
}

#[test]
fn what_cannot_be_watched_is_refused_with_what_is_missing() {
    let folder = healthy();
    let folder = folder.path();
    let bare = refused(folder, &["watch", "then/holdout-1.csv", "--machine", "then/machine.toml"]);
    assert!(bare.contains("no table [watch]; expected one, or --healthy"), "{bare}");
    let few = ["watch", "--machine", "then/machine.toml", "--healthy", "then/train-1.csv", "then/train-2.csv"];
    let few = refused(folder, &few);
    assert!(few.contains("2 recordings of the healthy drive; expected at least 3"), "{few}");
    let share = refused(folder, &["watch", "then/holdout-1.csv", "--machine", "w.toml", "--false-alarms", "2"]);
    assert!(share.contains("a share between 0 and 1"), "{share}");
    // So rare a false alarm is beyond what the band's memory can tell from chance.
    let rare = refused(folder, &["watch", "then/holdout-1.csv", "--machine", "w.toml", "--false-alarms", "1e-9"]);
    assert!(rare.contains("holdout-1.csv") && rare.contains("false alarms more often"), "{rare}");
    let only_spool = std::fs::read_to_string(folder.join("w.toml")).unwrap();
    let cut: Vec<&str> = only_spool.lines().filter(|line| !line.starts_with("spool = ")).collect();
    std::fs::write(folder.join("cut.toml"), cut.join("\n")).unwrap();
    limited(folder, "then/holdout-1.csv", "s.csv", &["time", "command", "spool"]);
    let none = refused(folder, &["watch", "s.csv", "--machine", "cut.toml"]);
    assert!(
        none.contains("none of the signals that are watched is recorded: pressure_a, pressure_b, position"),
        "{none}"
    );
}

#[test]
fn a_machine_file_of_other_values_has_no_band_of_these() {
    let folder = healthy();
    let folder = folder.path();
    done(folder, &["fit", "then/train-1.csv", "--machine", "w.toml", "--save-machine", "f.toml"]);
    assert!(!std::fs::read_to_string(folder.join("f.toml")).unwrap().contains("[watch]"));
}
