//! `diagnose --since`: what has changed since a machine file was written.
#![cfg(feature = "virtual-plant")]

use std::path::Path;

use serde_json::Value;

use super::{done, refused, root, run, text};

/// A case of the press with these effects, recorded at another time.
fn case(folder: &Path, name: &str, seed: &str, effects: &[&str]) {
    let machine = root().join("presets/press-63-40-installed.toml").display().to_string();
    case_of(folder, name, seed, &machine, effects);
}

/// The same of the drive of another machine file.
fn case_of(folder: &Path, name: &str, seed: &str, machine: &str, effects: &[&str]) {
    let training = ["--train", "random:8V,0.08s,0.5s,3s,seed=1", "--train", "steps:7V"];
    let held_out = ["--holdout", "sweep:6V,0.5Hz,4Hz,3s"];
    let effects = effects.iter().flat_map(|effect| ["--effect", effect]);
    let first = ["testbed", "--machine", machine, "--tick", "2", "--seed", seed, "--out", name];
    let arguments: Vec<&str> = first.into_iter().chain(effects).chain(training).chain(held_out).collect();
    done(folder, &arguments);
}

/// What is said of a case since a machine file was written: the headline, and for programs.
fn since(folder: &Path, file: &str, case: &str) -> (String, Value) {
    let told = done(folder, &["diagnose", case, "--since", file, "--json", "d.json"]);
    let json = std::fs::read_to_string(folder.join("d.json")).unwrap();
    (told.lines().next().unwrap().to_owned(), serde_json::from_str(&json).unwrap())
}

#[test]
fn an_effect_of_the_file_that_has_changed_is_named_with_what_it_was_and_is_and_one_that_has_not_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    case(folder, "then", "1", &["internal-leakage=2e-12"]);
    done(folder, &["diagnose", "then", "--save-machine", "then.toml"]);

    case(folder, "same", "2", &["internal-leakage=2e-12"]);
    let (headline, same) = since(folder, "then.toml", "same");
    assert!(headline.starts_with("press-63-40-installed: unchanged: "), "{headline}");
    assert!(same["findings"].as_array().unwrap().is_empty() && same["since"][0] == "internal-leakage", "{same}");

    // The folder's own machine file knows nothing of the leak.
    case(folder, "now", "3", &["internal-leakage=4e-12"]);
    done(folder, &["diagnose", "now", "--save-machine", "now.toml"]);
    for (file, case, verb, ratio) in [("then.toml", "now", "rose", 2.0), ("now.toml", "same", "fell", 0.5)] {
        let (headline, told) = since(folder, file, case);
        let expected = format!("press-63-40-installed: changed: internal-leakage {verb} from ");
        assert!(headline.starts_with(&expected) && headline.contains(" l/min → "), "{headline}");
        let change = &told["findings"][0]["change"];
        assert_eq!(change["name"], "conductance_m3_per_s_pa");
        assert!((change["ratio"].as_f64().unwrap() / ratio - 1.0).abs() < 0.05, "{change}");
        assert_eq!(told["findings"][0]["parameters"][0]["before"], change["before"]);
    }
}

#[test]
fn an_effect_that_the_file_has_not_is_new() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    case(folder, "then", "1", &["valve-hysteresis=0.02"]);
    done(folder, &["diagnose", "then", "--save-machine", "then.toml"]);
    case(folder, "now", "2", &["valve-hysteresis=0.02", "internal-leakage=4e-12"]);
    let (headline, told) = since(folder, "then.toml", "now");
    assert!(headline.starts_with("press-63-40-installed: changed: internal-leakage is new; confirmed"), "{headline}");
    assert!(told["findings"][0].get("change").is_none());
}

/// What was found then is known as well as the recordings of then tell it, and is saved with what has become of it.
#[test]
fn recordings_of_then_are_diagnosed_first() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    case(folder, "then", "1", &["internal-leakage=2e-12"]);
    case(folder, "now", "3", &["internal-leakage=4e-12"]);
    let then = ["then/train-1.csv", "then/train-2.csv", "then/holdout-1.csv"];
    let arguments = [&["diagnose", "now", "--save-machine", "now.toml", "--since"][..], &then].concat();
    let output = run(folder, &arguments);
    let (told, notes) = (text(&output.stdout), text(&output.stderr));
    assert!(told.starts_with("press-63-40-installed: changed: internal-leakage rose from 1.9"), "{told}");
    assert!(
        notes.contains("note: then: press-63-40-installed: missing physics: internal-leakage; not confirmed"),
        "{notes}"
    );
    let saved = std::fs::read_to_string(folder.join("now.toml")).unwrap();
    assert!(saved.contains("[effects.internal-leakage]\nconductance_m3_per_s_pa = 3.9"), "{saved}");
    assert!(!saved.contains("[fit.sigma]"), "what is known for this diagnosis is not written into the file: {saved}");
}

#[test]
fn what_does_not_say_one_time_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (since, found) in [
        (&["a.toml", "--machine", "b.toml"][..], "found a machine file beside that of --machine"),
        (&["a.toml", "d.csv", "--machine", "b.toml"], "found a machine file among others"),
        (&["d.csv", "e.csv"], "found recordings and no machine file"),
        (&["d.csv", "."], "found the folder ."),
    ] {
        let arguments = [&["diagnose", "--train", "c.csv", "--since"][..], since].concat();
        let error = refused(folder.path(), &arguments);
        assert!(error.starts_with(&format!("error: --since: {found}; expected the machine file of then")), "{error}");
    }
    // Before anything of then is diagnosed, or even read.
    for since in [&["a.toml"][..], &["a.csv", "b.csv"], &["."]] {
        let error = refused(folder.path(), &[&["diagnose", "--since"], since].concat());
        let now = "error: --since: found no recording of now; expected a FOLDER or --train";
        assert!(error.starts_with(now) || error.starts_with("error: --since: found the folder ."), "{error}");
    }
}

/// The folder may stand behind what is of then.
#[test]
fn a_folder_behind_the_file_of_then_is_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    case(folder, "then", "1", &["internal-leakage=2e-12"]);
    let told = done(folder, &["diagnose", "--since", "then/machine.toml", "then"]);
    assert!(told.starts_with("press-63-40-installed: changed: internal-leakage is new"), "{told}");
    let output = run(folder, &["diagnose", "--since", "then/train-1.csv", "then/train-2.csv", "then"]);
    assert!(text(&output.stderr).contains("same"), "the recordings of then are those of now: {}", text(&output.stderr));
}

/// A pressure sensor jumped to and fro then: the model does not follow, and that is told with the verdict of now.
#[test]
fn a_then_that_is_unexplained_is_told_first() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    case(folder, "then", "1", &[]);
    case(folder, "now", "3", &[]);
    for name in ["train-1.csv", "train-2.csv"] {
        let path = folder.join("then").join(name);
        let mut rows = csv_rows(&path);
        let at = rows[0].iter().position(|header| header.starts_with("pressure_b")).unwrap();
        for (index, row) in rows.iter_mut().skip(1).enumerate() {
            let value: f64 = row[at].parse().unwrap();
            let swing = if index / 50 % 2 == 0 { 1.2 } else { 0.8 };
            row[at] = (swing * value).to_string();
        }
        write_rows(&path, &rows);
    }
    let then = ["then/train-1.csv", "then/train-2.csv"];
    let output =
        run(folder, &[&["diagnose", "now", "--as-recorded", "--json", "d.json", "--since"][..], &then].concat());
    let (told, notes) = (text(&output.stdout), text(&output.stderr));
    assert!(notes.contains("note: then: press-63-40-installed: unexplained"), "{notes}");
    assert!(told.lines().next().unwrap().contains("; but then is unexplained"), "{told}");
    let json: Value = serde_json::from_str(&std::fs::read_to_string(folder.join("d.json")).unwrap()).unwrap();
    assert_eq!(json["then"], "unexplained");
}

/// Warm oil halves the friction and doubles the leak. With its temperature recorded at both times the drive is told to be unchanged, and what has changed
/// beside the oil is found.
#[test]
fn a_drive_that_is_only_warmer_is_unchanged_where_the_oils_temperature_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let thin = (-0.035_f64 * 20.0).exp();
    let preset = std::fs::read_to_string(root().join("presets/press-63-40-installed.toml")).unwrap();
    let warm =
        preset.replace("viscous_friction_n_s_per_m = 1.0e5", &format!("viscous_friction_n_s_per_m = {:e}", thin * 1e5));
    assert_ne!(warm, preset);
    std::fs::write(folder.join("warm.toml"), warm).unwrap();
    let leak = |conductance: f64| format!("internal-leakage={conductance:e}");
    case(folder, "then", "1", &[&leak(2e-12)]);
    case(folder, "leaks", "2", &[&leak(4e-12)]);
    let warm = folder.join("warm.toml").display().to_string();
    case_of(folder, "warm", "3", &warm, &[&leak(2e-12 / thin)]);
    case_of(folder, "both", "4", &warm, &[&leak(4e-12 / thin)]);
    for (case, celsius) in [("then", 35.0), ("leaks", 37.0), ("warm", 55.0), ("both", 55.0)] {
        for name in ["train-1.csv", "train-2.csv", "holdout-1.csv"] {
            let path = folder.join(case).join(name);
            let mut rows = csv_rows(&path);
            rows[0].push("oil_temperature [°C]".to_owned());
            rows.iter_mut().skip(1).for_each(|row| row.push(format!("{celsius}")));
            write_rows(&path, &rows);
        }
    }
    done(folder, &["diagnose", "then", "--save-machine", "then.toml"]);
    let saved = std::fs::read_to_string(folder.join("then.toml")).unwrap();
    assert!(saved.contains("reference_temperature_c = 35.0"), "{saved}");

    let (headline, told) = since(folder, "then.toml", "warm");
    let unchanged = "press-63-40-installed: unchanged: the model of then, refitted, with oil 20 K warmer, follows";
    assert!(headline.starts_with(unchanged), "{headline}");
    let viscosity = told["oil"]["viscosity"].as_f64().unwrap();
    assert!((viscosity / thin - 1.0).abs() < 0.05, "{viscosity}");
    for case in ["leaks", "both"] {
        let (headline, told) = since(folder, "then.toml", case);
        assert!(headline.starts_with("press-63-40-installed: changed: internal-leakage rose from "), "{headline}");
        let ratio = told["findings"][0]["change"]["ratio"].as_f64().unwrap();
        assert!((ratio / 2.0 - 1.0).abs() < 0.1, "{case}: {ratio}");
    }
}

/// The cells of a recording, its header first.
fn csv_rows(path: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn write_rows(path: &Path, rows: &[Vec<String>]) {
    let lines: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    std::fs::write(path, lines.join("\n") + "\n").unwrap();
}
