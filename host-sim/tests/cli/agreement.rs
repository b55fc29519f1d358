//! Recordings that cannot be those of the machine file's drive are refused with what is wrong with them, before anything is searched.

use std::path::Path;

use tempfile::TempDir;

use super::{done, example, refused};

/// A folder with the example's machine file and its first training recording, the columns of one name changed.
fn folder_with(name: &str, change: impl Fn(f64) -> f64) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(example("machine.toml"), folder.path().join("machine.toml")).unwrap();
    let text = std::fs::read_to_string(example("train-1.csv")).unwrap();
    std::fs::write(folder.path().join("train-1.csv"), changed(&text, name, change)).unwrap();
    folder
}

/// A recording with the columns of one name changed.
fn changed(text: &str, name: &str, change: impl Fn(f64) -> f64) -> String {
    let (header, rows) = text.split_once('\n').unwrap();
    let is_changed: Vec<bool> = header.split(',').map(|column| column.starts_with(name)).collect();
    assert!(is_changed.contains(&true), "{header}");
    let changed = |row: &str| {
        let cell = |(cell, is_changed): (&str, &bool)| {
            if *is_changed { change(cell.parse().unwrap()).to_string() } else { cell.to_owned() }
        };
        row.split(',').zip(&is_changed).map(cell).collect::<Vec<_>>().join(",")
    };
    let rows: Vec<String> = rows.lines().map(changed).collect();
    format!("{header}\n{}\n", rows.join("\n"))
}

const FIT: [&str; 7] = ["fit", "--machine", "machine.toml", "--train", "train-1.csv", "--save-machine", "fitted.toml"];

fn fitted_as_recorded(folder: &Path) -> String {
    done(folder, &[&FIT[..], &["--as-recorded"]].concat())
}

#[test]
fn a_position_that_runs_the_other_way_is_no_missing_physics() {
    let folder = folder_with("position", |value| -value);
    for command in [&["diagnose", "."][..], &FIT] {
        let said = refused(folder.path(), command);
        assert!(said.contains("position seems to run the other way: turned round, the fit of position is 9"), "{said}");
        assert!(said.contains("(as recorded 0") && said.contains("or give --as-recorded"), "{said}");
    }
    assert!(!folder.path().join("fitted.toml").exists());
    let inspected = done(folder.path(), &["inspect", "train-1.csv", "--machine", "machine.toml"]);
    assert!(inspected.contains("position runs against what the machine file's model does"), "{inspected}");
    assert!(fitted_as_recorded(folder.path()).contains("What is left"));
}

#[test]
fn a_scale_that_a_refit_absorbs_is_told_and_so_are_the_values_that_absorb_it() {
    let folder = folder_with("position", |value| 0.1 * value);
    let said = refused(folder.path(), &FIT);
    assert!(said.contains("position seems to be a tenth of what it should be: taken 10 times as large"), "{said}");
    let fitted = fitted_as_recorded(folder.path());
    assert!(fitted.contains("which no oil has") && fitted.contains("the unit of position"), "{fitted}");
}

/// Taken as it is, the recording is judged all the same, and every form of the answer says what is wrong with it.
#[test]
fn what_is_taken_as_recorded_says_what_is_wrong_on_the_screen_on_the_page_and_in_the_json() {
    let folder = folder_with("position", |value| -value);
    let wrong = "position seems to run the other way";
    let diagnosed = ["diagnose", ".", "--as-recorded", "--json", "d.json", "--report", "d.html"];
    assert!(done(folder.path(), &diagnosed).contains(wrong));
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(read("d.html").contains(wrong));
    let json: serde_json::Value = serde_json::from_str(&read("d.json")).unwrap();
    assert_eq!(json["plausibility"][0]["certain"], true);
    assert_eq!(json["plausibility"][0]["changes"][0]["kind"], "reversed");
    let compare = ["compare", "--machine", "machine.toml", "--recording", "train-1.csv", "--report", "c.html"];
    let compared = done(folder.path(), &compare);
    assert!(compared.contains(wrong) && compared.contains("mend this first"), "{compared}");
    done(folder.path(), &["--quiet", "compare", "train-1.csv", "--machine", "machine.toml", "--report", "quiet.html"]);
    done(folder.path(), &[&FIT[..], &["--as-recorded", "--report", "f.html"]].concat());
    for page in ["c.html", "quiet.html", "f.html"] {
        // On the first screen: before the list of contents.
        let page = read(page);
        let (first, _) = page.split_once("<nav class=\"contents\"").unwrap();
        assert!(first.contains(&format!("Doubt: {wrong}")), "{first}");
    }
}

/// What the machine file's own model answers, read by absolute sensors.
#[test]
fn a_fit_takes_pressures_of_absolute_sensors_as_absolute_and_saves_that() {
    let folder = folder_with("time", |value| value);
    done(
        folder.path(),
        &["simulate", "--machine", "machine.toml", "--recording", "train-1.csv", "--out", "answer.csv"],
    );
    let answer = std::fs::read_to_string(folder.path().join("answer.csv")).unwrap();
    std::fs::write(folder.path().join("train-1.csv"), changed(&answer, "pressure", |value| value + 101_325.0)).unwrap();
    let output = super::run(folder.path(), &FIT);
    assert!(String::from_utf8_lossy(&output.stderr).contains("taken as absolute"), "{output:?}");
    let saved = std::fs::read_to_string(folder.path().join("fitted.toml")).unwrap();
    assert!(saved.contains("pressure = \"absolute\""), "{saved}");
}

#[test]
fn a_drive_that_lacks_physics_is_not_refused() {
    let folder = folder_with("position", |value| value);
    let fitted = done(folder.path(), &FIT);
    assert!(!fitted.contains("seems to"), "{fitted}");
}
