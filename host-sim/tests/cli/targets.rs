//! Targets of results: a target that cannot be written, or must not be, is refused before a long run and leaves nothing.

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

/// Every way to write a file: the command, arguments that would succeed, and the argument of the target.
fn outputs() -> Vec<(Vec<&'static str>, &'static str)> {
    let with = |command: &[&'static str], more: &[&'static str]| [command, more].concat();
    vec![
        (with(&DIAGNOSE, &["--json", "j.json"]), "--report"),
        (with(&DIAGNOSE, &["--json", "j.json"]), "--save-machine"),
        (with(&DIAGNOSE, &["--json", "j.json"]), "--plot"),
        (with(&DIAGNOSE, &["--report", "r.html"]), "--json"),
        (vec!["inspect", "train-1.csv"], "--json"),
        (with(&COMPARE, &[]), "--plot"),
        (with(&COMPARE, &["--plot", "p.svg"]), "--json"),
        (with(&SIMULATE, &["--plot", "p.svg"]), "--out"),
        (with(&SIMULATE, &["--out", "o.csv"]), "--plot"),
        (with(&FIT, &[]), "--save-machine"),
        (with(&FIT, &["--save-machine", "f.toml"]), "--json"),
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
fn a_name_that_promises_another_format_is_refused_with_the_endings_known() {
    let folder = folder();
    let outputs = outputs().into_iter().map(|(command, argument)| {
        let (wrong, known) = match (command[0], argument) {
            (_, "--plot") => ("out.png", ".svg"),
            (_, "--report") => ("out.pdf", ".html, .htm"),
            (_, "--json") => ("out.csv", ".json"),
            (_, "--save-machine") => ("out.json", ".toml"),
            _ => ("out.xlsx", ".csv, .txt, .mat, .parquet"),
        };
        (command, argument, wrong, known)
    });
    let frames = "import --frames train-1.csv";
    let further = [
        ("init", "--out", "press.yaml", ".toml"),
        ("plan --machine machine.toml --sensors position", "--out", "e.mat", ".csv, .txt"),
        ("inspect train-1.csv", "--json", "i.toml", ".json"),
        ("statics --recording train-1.csv --input command --output position", "--plot", "s.pdf", ".svg"),
        (frames, "--out", "r.xlsx", ".csv, .txt"),
    ];
    let further =
        further.map(|(command, argument, wrong, known)| (command.split(' ').collect(), argument, wrong, known));
    for (command, argument, wrong, known) in outputs.chain(further) {
        let message = refused(folder.path(), &[&command[..], &[argument, wrong]].concat());
        assert!(
            message.contains(&format!("{wrong}: ")) && message.contains("does not match the file name's ending"),
            "{message}"
        );
        assert!(message.contains(&format!("expected: one that ends in {known}\n")), "{message}");
    }
}

#[test]
fn a_name_that_promises_nothing_is_taken() {
    let folder = folder();
    for name in ["found", "found.json.new", "found.v2"] {
        done(folder.path(), &["inspect", "train-1.csv", "--json", name]);
        let text = std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert!(text.starts_with('{'), "{text}");
    }
}

#[test]
fn a_dash_is_standard_output_where_nothing_else_is_printed() {
    let folder = folder();
    let printed = done(folder.path(), &[&SIMULATE[..], &["--out", "-"]].concat());
    done(folder.path(), &[&SIMULATE[..], &["--out", "s.csv"]].concat());
    assert_eq!(printed, std::fs::read_to_string(folder.path().join("s.csv")).unwrap());
    let input = ["simulate", "--machine", "machine.toml", "--input", "zero:10ms", "--out", "-"];
    assert_eq!(done(folder.path(), &input).lines().count(), 12);
    let export = ["export", "--machine", "machine.toml", "--out", "-", "--format"];
    assert!(done(folder.path(), &[&export[..], &["c99"]].concat()).contains("#define"));
    assert!(refused(folder.path(), &[&export[..], &["fmu"]].concat()).contains("an FMU is a binary file"));
    for (command, argument) in outputs().into_iter().filter(|(_, argument)| !["--out", "--json"].contains(argument)) {
        let message = refused(folder.path(), &[&command[..], &[argument, "-"]].concat());
        assert!(message.contains("expected: the name of a file"), "{message}");
        assert!(!folder.path().join("-").exists());
    }
}

#[test]
fn a_document_that_goes_to_standard_output_is_alone_there_and_the_same_as_in_a_file() {
    let folder = folder();
    for (command, argument) in outputs().into_iter().filter(|(_, argument)| *argument == "--json") {
        let printed = done(folder.path(), &[&command[..], &[argument, "-"]].concat());
        done(folder.path(), &[&command[..], &[argument, "found.json"]].concat());
        let written = std::fs::read_to_string(folder.path().join("found.json")).unwrap();
        assert!(written.starts_with('{') && printed == written, "{command:?}: {printed}");
        assert!(!folder.path().join("-").exists());
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
