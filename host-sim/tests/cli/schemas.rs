//! Every document for programs, against the schema that is published for it in docs/schemas.

use std::collections::BTreeSet;
use std::path::Path;

use jsonschema::Validator;
use serde_json::{Value, json};

use super::{done, example, root, run, text};

/// Every published schema by its file's name.
fn schemas() -> Vec<(String, Value)> {
    let files = std::fs::read_dir(root().join("docs/schemas")).unwrap();
    let mut found: Vec<(String, Value)> = files
        .map(|file| {
            let path = file.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().trim_end_matches(".schema.json").to_owned();
            (name, serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap())
        })
        .collect();
    found.sort_by(|a, b| a.0.cmp(&b.0));
    found
}

/// The schema with the name that a document states: `host-sim/fit/1`.
fn schema_of(document: &Value) -> (String, Validator) {
    let stated = document["schema"].as_str().unwrap();
    let name = stated.split('/').nth(1).unwrap();
    let path = root().join(format!("docs/schemas/{name}.schema.json"));
    let schema: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    assert_eq!(schema["properties"]["schema"]["const"], stated);
    (name.to_owned(), jsonschema::draft202012::new(&schema).unwrap())
}

/// The document that this command prints; it holds to its schema, and the name of that is told.
fn printed(folder: &Path, arguments: &[&str]) -> (String, Value) {
    let text = done(folder, &[arguments, &["--json", "-"]].concat());
    let document: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{arguments:?}: {error}: {text}"));
    let (name, schema) = schema_of(&document);
    let faults: Vec<String> =
        schema.iter_errors(&document).map(|fault| format!("{}: {fault}", fault.instance_path())).take(5).collect();
    assert!(faults.is_empty(), "{arguments:?}: {faults:#?}");
    (name, document)
}

/// A sweep with a loop, as a bench records it.
fn sweep(folder: &Path, name: &str) {
    let rows = (0..800).map(|row| {
        let input = 5.0 - 10.0 * (2.0 * f64::from(row) / 799.0 - 1.0).abs();
        let late = if row < 400 { -0.1 } else { 0.1 };
        format!("{input},{}\n", 2.0 * (input + late) + 0.01 * (12.9898 * f64::from(row)).sin())
    });
    let text = std::iter::once("I [mA],Q [l/min]\n".to_owned()).chain(rows).collect::<String>();
    std::fs::write(folder.join(name), text).unwrap();
}

#[test]
fn the_document_of_every_command_holds_to_its_published_schema() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let (machine, train, other, holdout) =
        (example("machine.toml"), example("train-1.csv"), example("train-2.csv"), example("holdout-1.csv"));
    let drive = ["--machine", machine.as_str()];
    let mut seen = BTreeSet::new();
    let mut check = |arguments: &[&str]| {
        let (name, document) = printed(here, arguments);
        seen.insert(name);
        document
    };
    let sheet = "--bore 63mm --rod 40mm --stroke 300mm --mass 40kg --supply 150bar --pump-displacement 16cm3/rev";
    check(&[&["init", "--out", "sheet.toml"][..], &sheet.split(' ').collect::<Vec<_>>()].concat());
    check(&["inspect", &train, &other]);
    check(&[&["inspect", &train][..], &drive].concat());
    check(&[&["simulate", "--input", "step:4V", "--out", "s.csv"][..], &drive].concat());
    check(&[&["simulate", "--recording", &train, "--out", "r.csv"][..], &drive].concat());
    check(&[&["compare", &train, &holdout][..], &drive].concat());
    let several = check(&[&["compare", &train, "--machine", "sheet.toml", "--judge", "position"][..], &drive].concat());
    assert_eq!(several["machines"].as_array().unwrap().len(), 2);
    check(&[&["fit", &train, "--save-machine", "f.toml"][..], &drive].concat());
    check(&[&["fit", &train, "--holdout", &holdout][..], &drive].concat());
    check(&[&["plan", &train][..], &drive].concat());
    check(&[&["plan", "--sensors", "position:0.05mm"][..], &drive].concat());
    check(&[&["export", "--out", "p.rs", "--bake"][..], &drive].concat());
    check(&[&["testbed", "--train", "steps:6V", "--holdout", "sweep:5V", "--out", "case"][..], &drive].concat());
    check(&["testbed", "draw", "--count", "2", "--out", "cases"]);
    check(&["testbed", "hall", "--drives", "1", "--nights", "1", "--out", "drawn-hall"]);
    check(&["paper"]);
    let healthy = ["1", "2", "3"].map(|k| example(&format!("train-{k}.csv")));
    let healthy: Vec<&str> = healthy.iter().map(String::as_str).collect();
    std::fs::create_dir_all(here.join("hall/press/2026-11-30")).unwrap();
    std::fs::copy(&holdout, here.join("hall/press/2026-11-30/1.csv")).unwrap();
    let saved = ["--save-machine", "hall/press/machine.toml"];
    check(&[&["watch", &holdout, "--healthy"][..], &healthy, &drive, &saved].concat());
    check(&["fleet", "hall", "--upto", "watch", "--out", "rows"]);
    super::trend::worn(&here.join("worn"));
    check(&["trend", "worn", "--limit", "internal_leakage_conductance_m3_per_s_pa=6e-12"]);
    sweep(here, "a.csv");
    sweep(here, "b.csv");
    let columns = ["--input", "I", "--output", "Q"];
    check(&[&["statics", "--recording", "a.csv"][..], &columns].concat());
    check(&[&["statics", "--recording", "a.csv", "b.csv", "--period", "20", "200"][..], &columns].concat());
    std::fs::write(here.join("capture.bin"), super::streamed()).unwrap();
    check(&["import", "--frames", "capture.bin", "--out", "i.csv"]);
    check(&["diagnose", &root().join("examples/press-63-40").display().to_string()]);

    let published: BTreeSet<String> = schemas().into_iter().map(|(name, _)| name).collect();
    assert_eq!(seen, published, "every schema has a command that is tested here, and every command a schema");
}

#[test]
fn what_a_diagnosis_finds_or_does_not_find_holds_to_the_schema() {
    let folder = tempfile::tempdir().unwrap();
    let verdict = |lot: &str, seed: &str| {
        let draw = ["testbed", "draw", "--count", "1", "--seed", seed, "--effects", lot, "--out", lot];
        done(folder.path(), &draw);
        let (_, document) = printed(folder.path(), &["diagnose", &format!("{lot}/c000")]);
        document["verdict"].as_str().unwrap().to_owned()
    };
    assert_eq!(verdict("none", "3"), "nothing-missing");
    // Whatever this one ends with: a cause that the catalogue does not have.
    assert_ne!(verdict("outside", "3"), "nothing-missing");
    // A search that its limit has ended.
    let (_, cut) = printed(folder.path(), &["diagnose", "outside/c000", "--time-limit", "0.05"]);
    assert!(!cut["unfinished"].is_null(), "{}", cut["unfinished"]);
}

#[test]
fn a_document_that_is_wrong_is_refused_by_the_schema() {
    let folder = tempfile::tempdir().unwrap();
    let (machine, train) = (example("machine.toml"), example("train-1.csv"));
    for (arguments, path) in [
        (vec!["inspect", &train], "/recordings/0/rows"),
        (vec!["compare", &train, "--machine", &machine], "/recordings/0/sections/0/section"),
        (vec!["simulate", "--machine", &machine, "--input", "step:4V", "--out", "s.csv"], "/signals/0/unit"),
    ] {
        let (_, document) = printed(folder.path(), &arguments);
        let (_, schema) = schema_of(&document);
        let mut wrong = document.clone();
        *wrong.pointer_mut(path).unwrap() = json!(["something else"]);
        assert!(!schema.is_valid(&wrong), "{path} is not checked");
        let (parent, key) = path.rsplit_once('/').unwrap();
        let mut lacking = document.clone();
        lacking.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(key);
        assert!(!schema.is_valid(&lacking), "{path} may be missing");
        let mut more = document.clone();
        more.pointer_mut(parent).unwrap()["unheard_of"] = json!(1);
        assert!(!schema.is_valid(&more), "{parent} may hold anything");
    }
}

#[test]
fn every_schema_describes_every_field_and_has_a_name_of_its_own() {
    fn undescribed(schema: &Value, at: &str, found: &mut Vec<String>) {
        if let Some(properties) = schema["properties"].as_object() {
            for (name, property) in properties {
                if property["description"].is_null() && property["$ref"].is_null() {
                    found.push(format!("{at}/{name}"));
                }
                undescribed(property, &format!("{at}/{name}"), found);
            }
            assert_eq!(schema["additionalProperties"], false, "{at}");
        }
        for key in ["items", "additionalProperties"].into_iter().filter(|key| schema[*key].is_object()) {
            undescribed(&schema[key], at, found);
        }
        let alternatives = ["oneOf", "anyOf"].into_iter().filter_map(|key| schema[key].as_array()).flatten();
        for alternative in alternatives {
            undescribed(alternative, at, found);
        }
    }
    let listed = std::fs::read_to_string(root().join("docs/json.md")).unwrap();
    for (name, schema) in schemas() {
        assert!(jsonschema::meta::is_valid(&schema), "{name}");
        assert_eq!(schema["$id"], format!("urn:host-sim:{name}:1"));
        let mut found = Vec::new();
        undescribed(&schema, &name, &mut found);
        let parts = schema["$defs"].as_object();
        parts.into_iter().flatten().for_each(|(part, schema)| undescribed(schema, part, &mut found));
        assert!(found.is_empty(), "{found:?}");
        let row = format!("| [{name}.schema.json](schemas/{name}.schema.json) | `urn:host-sim:{name}:1` |");
        assert!(listed.contains(&row), "docs/json.md has no line with {row}");
    }
}

#[test]
fn a_document_on_standard_output_is_alone_there() {
    let folder = tempfile::tempdir().unwrap();
    let machine = example("machine.toml");
    let output =
        run(folder.path(), &["simulate", "--machine", &machine, "--input", "step:4V", "--out", "-", "--json", "-"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(text(&output.stderr).trim(), "error: --out and --json both name -; expected two files");
    assert!(output.stdout.is_empty());
}
