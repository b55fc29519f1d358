//! The program run as a process, and what most tests give it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use firmware::recorder::frame::FrameWriter;
use firmware::recorder::{Channel, Progress, Range, Recorder, Stream};
use model_core::number::{Number, PerUnit};

/// The top of the repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

pub(crate) fn example(name: &str) -> String {
    root().join("examples/press-63-40").join(name).display().to_string()
}

pub(crate) fn program(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    // What is written twice is compared, and a page says when it was written.
    command.current_dir(folder).args(arguments).env("SOURCE_DATE_EPOCH", "1767225600");
    command
}

pub(crate) fn run(folder: &Path, arguments: &[&str]) -> Output {
    program(folder, arguments).output().unwrap()
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Runs a command that must succeed, and returns what it printed.
pub(crate) fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Runs a command that must fail; returns its message, behind notes if there are any, and checks that the folder is unchanged.
pub(crate) fn refused(folder: &Path, arguments: &[&str]) -> String {
    let before = listing(folder);
    let output = run(folder, arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert_eq!(text(&output.stdout), "", "{arguments:?}");
    let first = message.lines().find(|line| !line.starts_with("note: "));
    assert!(first.is_some_and(|line| line.starts_with("error: ")) && !message.contains("panicked"), "{message}");
    assert_eq!(listing(folder), before, "{arguments:?}");
    message
}

pub(crate) fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

pub(crate) const MACHINE: &str = "\
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

/// The press of the presets as a catalogue would print it: 5 l/min at 5 bar over one edge, 17.7 % overlap, 96 ms to 90 %.
pub(crate) const PRESS: [&str; 28] = [
    "init",
    "--out",
    "press.toml",
    "--bore",
    "63mm",
    "--rod",
    "40mm",
    "--stroke",
    "300mm",
    "--mass",
    "18.3kg",
    "--supply",
    "70bar",
    "--rated-flow",
    "5l/min",
    "--rated-drop",
    "5bar",
    "--rated-signal",
    "10V",
    "--valve-response",
    "96ms",
    "--overlap",
    "17.7%",
    "--spool-at-rated",
    "59.35%",
    "--valve-stroke-time",
    "50ms",
    "--dead-volume=50cm3",
];

/// A second of recording: the command rises, and the rod stays in place.
pub(crate) fn streamed() -> Vec<u8> {
    let channel = |name, unit, base| Channel { name, unit, base, range: Range::One };
    let channels = [channel("command", "V", 10.0), channel("position", "m", 0.3)];
    let mut recorder: Recorder<2, 1000> = Recorder::new(channels, 999).unwrap();
    for tick in 0..1000 {
        if tick == 999 {
            recorder.trigger();
        }
        recorder.record(&[Some(PerUnit::saturated(f64::from(tick) * 2e-4)), Some(PerUnit::saturated(0.5))]);
    }
    let (mut bytes, mut stream, mut frames) = (Vec::new(), Stream::new(), FrameWriter::default());
    while stream.write(&recorder, "press", 1_000_000, &mut frames, &mut bytes).unwrap() == Progress::More {}
    bytes
}
