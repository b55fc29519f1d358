//! The commands with every format.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;

use host_sim::cli::{self, Cli, Console};

use crate::fixture;

/// Runs the program; returns what it prints, or its error.
fn run(arguments: &[&str]) -> Result<String, String> {
    let cli = Cli::try_parse_from(["host-sim"].iter().chain(arguments)).map_err(|error| error.to_string())?;
    let mut out = Vec::new();
    let outcome = cli::run(&cli.command, &mut Console::into_buffer(&mut out));
    outcome.map(|_| String::from_utf8(out).unwrap()).map_err(|error| error.render())
}

fn press() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/press-63-40/machine.toml")
}

#[test]
pub(crate) fn a_simulation_is_the_same_from_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let machine = press().display().to_string();
    let simulated = |name: &str| {
        let out = folder.path().join(format!("{name}.csv"));
        let recording = fixture(name).display().to_string();
        run(&["simulate", "--machine", &machine, "--recording", &recording, "--out", &out.display().to_string()])
            .unwrap();
        fs::read_to_string(out).unwrap()
    };
    let expected = simulated("run.csv");
    assert_eq!(expected.lines().count(), 201);
    for name in ["vectors.mat", "vectors_packed.mat", "packed_2.mf4", "pandas.parquet"] {
        // The columns have the file's own order, here that of the CSV, and a number of unit 1 needs no unit.
        assert_eq!(simulated(name).replace("spool,", "spool [1],"), expected, "{name}");
    }
}

#[test]
pub(crate) fn a_simulation_is_written_in_the_format_of_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let machine = press().display().to_string();
    for (name, magic) in
        [("s.csv", "time [s]"), ("s.mat", "MATLAB 5.0 MAT-file"), ("s.parquet", "PAR1"), ("s", "time [s]")]
    {
        let out = folder.path().join(name);
        run(&["simulate", "--machine", &machine, "--input", "step:4V,0.1s", "--out", &out.display().to_string()])
            .unwrap();
        assert!(fs::read(out).unwrap().starts_with(magic.as_bytes()), "{name}");
    }
    // This ending stands for a format that is never written.
    let out = folder.path().join("s.xlsx").display().to_string();
    let refused = run(&["simulate", "--machine", &machine, "--input", "step:4V,0.1s", "--out", &out]).unwrap_err();
    assert!(refused.contains("expected one that ends in .csv, .txt, .mat, .parquet"), "{refused}");
    assert!(!folder.path().join("s.xlsx").exists());
}

#[test]
pub(crate) fn recordings_are_compared_in_every_format() {
    let machine = press().display().to_string();
    let compared = |name: &str| {
        let recording = fixture(name).display().to_string();
        run(&["compare", "--machine", &machine, "--recording", &recording]).unwrap().replace(name, "the recording")
    };
    let expected = compared("run.csv");
    for name in ["vectors.mat", "packed_1.mf4", "plain.parquet"] {
        let told = compared(name);
        let lines =
            |text: &str| text.lines().filter(|line| line.contains("position")).map(str::to_owned).collect::<Vec<_>>();
        assert!(!lines(&told).is_empty(), "{told}");
        let numbers = |text: &str| lines(text).join(" ").split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(numbers(&told), numbers(&expected), "{name}");
    }
}

#[test]
pub(crate) fn a_folder_may_hold_recordings_of_every_format_but_each_once() {
    let folder = tempfile::tempdir().unwrap();
    let put = |from: PathBuf, name: &str| fs::copy(from, folder.path().join(name)).map(drop).unwrap();
    put(press(), "machine.toml");
    let path = folder.path().display().to_string();
    let diagnosed = || run(&["diagnose", &path, "--report", &folder.path().join("r.html").display().to_string()]);
    let nothing = diagnosed().unwrap_err();
    assert!(nothing.contains("no train-*.csv (.txt, .xlsx, .mat, .mf4, .parquet, .gz)"), "{nothing}");
    put(fixture("vectors.mat"), "train-1.mat");
    put(fixture("packed_0.mf4"), "train-2.MF4");
    // Both files are found and read, and hold the same rows.
    let twice = diagnosed().unwrap_err();
    assert!(
        twice.contains("train-1.mat") && twice.contains("train-2.MF4") && twice.contains("each recording once"),
        "{twice}"
    );
    put(fixture("run.csv"), "train-2.csv");
    let formats = diagnosed().unwrap_err();
    assert!(formats.contains("train-2.csv") && formats.contains("each recording in one format"), "{formats}");
    std::fs::remove_file(folder.path().join("train-2.MF4")).unwrap();
    put(fixture("run.csv.gz"), "train-2.csv.gz");
    let packed = diagnosed().unwrap_err();
    assert!(packed.contains("train-2.csv.gz") && packed.contains("each recording in one format"), "{packed}");
}
