//! Where results go: what cannot be written, and what must not be, is said before a long run and leaves nothing.

use super::{MACHINE, TempDir, done, example, folder_with, refused};

/// A folder with the example's machine file and three of its recordings, cut short.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(example("machine.toml"), folder.path().join("machine.toml")).unwrap();
    for name in ["train-1.csv", "train-2.csv", "holdout-1.csv"] {
        let text = std::fs::read_to_string(example(name)).unwrap();
        let rows: Vec<&str> = text.lines().take(400).collect();
        std::fs::write(folder.path().join(name), rows.join("\n")).unwrap();
    }
    folder
}

const DIAGNOSE: [&str; 8] =
    ["diagnose", "--machine", "machine.toml", "--train", "train-1.csv", "train-2.csv", "--holdout", "holdout-1.csv"];
const COMPARE: [&str; 5] = ["compare", "--machine", "machine.toml", "--recording", "train-1.csv"];
const SIMULATE: [&str; 5] = ["simulate", "--machine", "machine.toml", "--recording", "train-1.csv"];
const FIT: [&str; 5] = ["fit", "--machine", "machine.toml", "--train", "train-1.csv"];

/// Every way to have a file written: the command, arguments that could be done, and the argument of the target.
fn outputs() -> Vec<(Vec<&'static str>, &'static str)> {
    let with = |command: &[&'static str], more: &[&'static str]| [command, more].concat();
    vec![
        (with(&DIAGNOSE, &["--json", "j.json"]), "--report"),
        (with(&DIAGNOSE, &["--json", "j.json"]), "--save-machine"),
        (with(&DIAGNOSE, &["--json", "j.json"]), "--plot"),
        (with(&DIAGNOSE, &["--report", "r.html"]), "--json"),
        (with(&COMPARE, &[]), "--plot"),
        (with(&SIMULATE, &["--plot", "p.svg"]), "--out"),
        (with(&SIMULATE, &["--out", "o.csv"]), "--plot"),
        (with(&FIT, &[]), "--save-machine"),
    ]
}

#[test]
fn a_target_that_cannot_be_written_leaves_no_other_result_either() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("results")).unwrap();
    for (command, argument) in outputs() {
        let message = refused(folder.path(), &[&command[..], &[argument, "no/such/target"]].concat());
        assert!(message.contains("no/such/target: cannot be written"), "{message}");
        assert!(!message.contains(".host-sim-"), "{message}");
        let message = refused(folder.path(), &[&command[..], &[argument, "results"]].concat());
        assert!(message.contains("results: cannot be written") && message.contains("this is a folder"), "{message}");
    }
}

#[test]
fn no_result_is_written_over_a_recording() {
    let folder = folder();
    let before = std::fs::read(folder.path().join("train-1.csv")).unwrap();
    for (command, argument) in outputs() {
        let message = refused(folder.path(), &[&command[..], &[argument, "./train-1.csv"]].concat());
        assert!(message.contains("./train-1.csv would be written over train-1.csv"), "{message}");
        assert_eq!(std::fs::read(folder.path().join("train-1.csv")).unwrap(), before);
    }
}

#[test]
fn only_a_machine_file_is_written_over_the_machine_file() {
    let folder = folder_with(MACHINE, "time [s],command [V],position [m]\n0,0,0\n0.1,4,0\n0.2,4,0.1\n");
    let simulate = ["simulate", "--machine", "machine.toml", "--input", "zero:10ms", "--out", "machine.toml"];
    assert!(refused(folder.path(), &simulate).contains("would be written over machine.toml"));
    done(folder.path(), &["fit", "--machine", "machine.toml", "--train", "run.csv", "--save-machine", "machine.toml"]);
}

#[test]
fn a_recording_tells_once() {
    let folder = folder();
    let copy = std::fs::read_to_string(folder.path().join("train-1.csv")).unwrap();
    std::fs::write(folder.path().join("copy.csv"), format!("# copied\n{copy}")).unwrap();
    let message_on = |train: &[&str], holdout: &[&str]| {
        let arguments =
            [&["diagnose", "--machine", "machine.toml", "--train"], train, &["--holdout"], holdout].concat();
        refused(folder.path(), &arguments)
    };
    for again in ["train-1.csv", "./train-1.csv", "copy.csv"] {
        let message = message_on(&["train-2.csv", "train-1.csv"], &["holdout-1.csv", again]);
        let expected = format!("train-1.csv and {again} hold the same recording; expected held-out recordings");
        assert!(message.contains(&expected), "{message}");
        let message = message_on(&["train-1.csv", "train-2.csv", again], &["holdout-1.csv"]);
        let expected = format!("train-1.csv and {again} hold the same recording; expected each recording once");
        assert!(message.contains(&expected), "{message}");
    }
}
