//! `diagnose --since`: what has changed since a machine file was written.
#![cfg(feature = "virtual-plant")]

use std::path::Path;

use serde_json::Value;

use super::{done, refused, root, run, text};

/// A case of the press with these effects, recorded at another time.
fn case(folder: &Path, name: &str, seed: &str, effects: &[&str]) {
    let machine = root().join("presets/press-63-40-installed.toml").display().to_string();
    let training = ["--train", "random:8V,0.08s,0.5s,3s,seed=1", "--train", "steps:7V"];
    let held_out = ["--holdout", "sweep:6V,0.5Hz,4Hz,3s"];
    let effects = effects.iter().flat_map(|effect| ["--effect", effect]);
    let first = ["testbed", "--machine", &machine, "--tick", "2", "--seed", seed, "--out", name];
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
    ] {
        let arguments = [&["diagnose", "--train", "c.csv", "--since"][..], since].concat();
        let error = refused(folder.path(), &arguments);
        assert!(error.starts_with(&format!("error: --since: {found}; expected the machine file of then")), "{error}");
    }
}
