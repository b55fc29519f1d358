//! Ctrl-C: exit status 130, and no file that is half-written.
#![cfg(unix)]

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use super::{MACHINE, example, folder_with, listing, program, root, text};

/// Runs, sends SIGINT after a while, and waits.
fn interrupted(folder: &Path, arguments: &[&str]) -> Output {
    let mut child = program(folder, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(1500));
    assert_eq!(child.try_wait().unwrap(), None, "{arguments:?} should take longer");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

#[test]
fn an_interrupted_diagnosis_leaves_its_results_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("d.json"), "old").unwrap();
    let case = root().join("examples/press-63-40").display().to_string();
    let results = ["--json", "d.json", "--save-machine", "f.toml", "--report", "d.html"];
    let output = interrupted(folder.path(), &[&["diagnose", &case][..], &results].concat());
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    assert_eq!(text(&output.stdout), "");
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
    let output = interrupted(folder.path(), &simulate);
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    assert_eq!(listing(folder.path()), before);
}

/// What the handler of the signal does, in the middle of a file. Nothing else in this process writes one so.
#[test]
fn a_file_that_is_being_written_goes_and_the_one_before_stays() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("d.json");
    std::fs::write(&target, "old").unwrap();
    let (done, written) = std::sync::mpsc::channel();
    let path = target.clone();
    // The writer never comes back: after this, no file is finished.
    std::thread::spawn(move || {
        host_sim::atomic::write(&path, |out: &mut dyn Write| {
            out.write_all(&vec![b'x'; 100_000])?;
            let temporary = path.parent().map(|folder| listing(folder).len());
            host_sim::atomic::abandon();
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
