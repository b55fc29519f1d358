//! Ctrl-C, a termination request, a terminal that closes: exit status 130, and no file that is half-written.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use super::{MACHINE, at_hand, example, folder_with, listing, root, text};

/// Runs with --verbose, sends a signal once `said` appears on standard error, and returns exit status and standard output.
///
/// The signal may be ignored where the tests run in the background: `env` restores its default action; `None` where this is not possible.
fn interrupted(folder: &Path, arguments: &[&str], said: &str, signal: &str) -> Option<(Option<i32>, String)> {
    const AS_USUAL: &str = "--default-signal=INT,HUP,TERM";
    if !Command::new("env").args([AS_USUAL, "true"]).output().is_ok_and(|output| output.status.success()) {
        at_hand::skipped("this `env` cannot give signals their usual meaning");
        return None;
    }
    let mut command = Command::new("env");
    command.args([AS_USUAL, env!("CARGO_BIN_EXE_host-sim"), "--verbose"]).args(arguments).current_dir(folder);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut errors = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.starts_with(said) {
        line.clear();
        assert!(errors.read_line(&mut line).unwrap() > 0, "{arguments:?} never says `{said}`");
    }
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
    let mut rest = String::new();
    errors.read_to_string(&mut rest).unwrap();
    assert!(!rest.contains('\u{1b}'), "no terminal is there to obey {rest:?}");
    let output = child.wait_with_output().unwrap();
    Some((output.status.code(), text(&output.stdout)))
}

#[test]
fn an_interrupted_diagnosis_leaves_its_results_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("d.json"), "old").unwrap();
    let case = root().join("examples/press-63-40").display().to_string();
    let results = ["--json", "d.json", "--save-machine", "f.toml", "--report", "d.html"];
    let diagnose = [&["diagnose", &case][..], &results].concat();
    let Some(found) = interrupted(folder.path(), &diagnose, "read: 4 training", "-INT") else { return };
    assert_eq!(found, (Some(130), String::new()));
    assert_eq!(listing(folder.path()), [folder.path().join("d.json")]);
    assert_eq!(std::fs::read_to_string(folder.path().join("d.json")).unwrap(), "old");
}

#[test]
fn writing_can_be_interrupted_too() {
    let folder = folder_with(MACHINE, "");
    // Nobody reads the pipe: the program waits in the middle of writing.
    assert!(Command::new("mkfifo").arg(folder.path().join("pipe")).status().unwrap().success());
    let before = listing(folder.path());
    let recording = example("train-1.csv");
    let simulate = ["simulate", "--machine", "machine.toml", "--recording", &recording, "--out", "pipe"];
    for signal in ["-INT", "-HUP", "-TERM"] {
        let Some(found) = interrupted(folder.path(), &simulate, "read: the first", signal) else { return };
        assert_eq!(found, (Some(130), String::new()), "{signal}");
        assert_eq!(listing(folder.path()), before);
    }
}

/// The action of the signal's handler while a file is being written. Nothing else in this process writes a file in this way.
#[test]
fn a_file_that_is_being_written_goes_and_the_one_before_stays() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("d.json");
    std::fs::write(&target, "old").unwrap();
    let (done, written) = std::sync::mpsc::channel();
    let path = target.clone();
    // The writer never returns: after this, no file is finished.
    std::thread::spawn(move || {
        recording::files::atomic::write(&path, |out: &mut dyn Write| {
            out.write_all(&vec![b'x'; 100_000])?;
            let temporary = path.parent().map(|folder| listing(folder).len());
            recording::files::atomic::abandon();
            done.send(temporary).unwrap();
            loop {
                std::thread::park();
            }
        })
    });
    assert_eq!(written.recv().unwrap(), Some(2), "old and temporary");
    assert_eq!(listing(folder.path()), std::slice::from_ref(&target));
    assert_eq!(std::fs::read_to_string(&target).unwrap(), "old");
}
