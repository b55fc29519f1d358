//! The program as a user runs it: what it prints, what it writes, and its exit status.
//!
//! These tests are in this package because only here cargo gives the path of the binary; exit status, closed pipes and
//! half-written files are properties of a process, not of a function.

mod agreement;
#[path = "../at_hand/mod.rs"]
mod at_hand;
#[cfg(unix)]
mod at_terminal;
mod bad_input;
mod compare;
mod export;
#[cfg(unix)]
mod first_minutes;
mod fleet;
mod import;
mod init;
mod inspect;
mod interrupted;
mod joint_angle;
#[cfg(target_os = "linux")]
mod long;
mod looks;
mod plan;
#[path = "../process/mod.rs"]
mod process;
mod processor;
mod readme;
mod report;
mod schemas;
mod shared;
mod shipped;
mod simulate;
mod since;
mod statics;
mod studio;
mod targets;
mod terminal;
mod testbed;
mod trend;
mod troubles;
mod watch;

use tempfile::TempDir;

use process::{MACHINE, PRESS, done, example, listing, program, refused, root, run, streamed, text};

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
