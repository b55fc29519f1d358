//! The program as a user runs it: what it prints, what it writes, and its exit status.
//!
//! These tests are in this package because only here cargo gives the path of the binary; exit status, closed pipes and
//! half-written files are properties of a process, not of a function.

#[path = "../at_hand/mod.rs"]
mod at_hand;
#[cfg(unix)]
mod at_terminal;
mod bad_input;
mod compare;
mod export;
mod faults;
#[cfg(unix)]
mod first_minutes;
mod import;
mod init;
mod inspect;
mod interrupted;
#[cfg(target_os = "linux")]
mod long;
mod outside;
mod plan;
mod processor;
mod readme;
mod report;
mod shared;
mod shipped;
mod simulate;
mod targets;
mod terminal;
mod testbed;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// The top of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn example(name: &str) -> String {
    root().join("examples/press-63-40").join(name).display().to_string()
}

fn program(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command.current_dir(folder).args(arguments);
    command
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    program(folder, arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Runs a command that must succeed, and returns what it printed.
fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Runs a command that must fail; returns its message, and checks that the folder is unchanged.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let before = listing(folder);
    let output = run(folder, arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert_eq!(text(&output.stdout), "", "{arguments:?}");
    assert!(message.starts_with("error: ") && !message.contains("panicked"), "{message}");
    assert_eq!(listing(folder), before, "{arguments:?}");
    message
}

fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

const MACHINE: &str = "\
[supply]
pressure_pa = 7.0e6
[valve]
gain_per_v = 0.0559
dead_zone = 0.1049
time_constants_s = [0.018, 0.0279]
flow_coefficient = 2.4e-7
[cylinder]
area_a_m2 = 3.117e-3
area_b_m2 = 1.861e-3
";

/// A folder with `machine.toml` and `run.csv`.
fn folder_with(machine: &str, recording: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("machine.toml"), machine).unwrap();
    std::fs::write(folder.path().join("run.csv"), recording).unwrap();
    folder
}

#[test]
fn help_shows_an_example_and_the_version_is_told() {
    let folder = tempfile::tempdir().unwrap();
    for command in ["simulate", "compare", "paper", "testbed"] {
        assert!(done(folder.path(), &[command, "--help"]).contains("Example"), "{command}");
    }
    assert!(done(folder.path(), &["--version"]).starts_with("host-sim "));
    assert_eq!(run(folder.path(), &["compare"]).status.code(), Some(2));
    assert_eq!(run(folder.path(), &["no-such-command"]).status.code(), Some(2));
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    use std::process::Stdio;
    let folder = tempfile::tempdir().unwrap();
    let (machine, recording) = (example("machine.toml"), example("train-1.csv"));
    for arguments in [vec!["compare", "--machine", &machine, "--recording", &recording], vec!["paper"], vec!["--help"]]
    {
        let mut child =
            program(folder.path(), &arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert_eq!(text(&output.stderr), "", "{arguments:?}");
    }
}

#[test]
fn there_is_no_colour_and_no_progress_in_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["compare", "--machine", &example("machine.toml"), "--recording", &example("train-1.csv")];
    let output = run(folder.path(), &arguments);
    assert_eq!(text(&output.stderr), "");
    assert!(!text(&output.stdout).contains('\u{1b}'));
}
