//! The FMU in another tool: `FMPy` finds nothing wrong with it, and simulates the same as `host-sim simulate`.

use std::path::Path;
use std::process::{Command, Output};

use recording::{ChannelMap, Signal};
use system_tests::python::python_with;

use super::{MASS, PUMP, VERSIONS, done, exported, leaking_press, text};

const SCRIPT: &str = include_str!("fmpy.py");

/// The compared outputs.
const OUTPUTS: [Signal; 7] = [
    Signal::Spool,
    Signal::Position,
    Signal::Velocity,
    Signal::PressureA,
    Signal::PressureB,
    Signal::Flow,
    Signal::Force,
];

fn asked(python: &Path, arguments: &[&str]) -> Output {
    Command::new(python).args(["-c", SCRIPT]).args(arguments).output().unwrap()
}

/// What the script printed.
fn printed(output: &Output) -> String {
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{printed}{}", String::from_utf8_lossy(&output.stderr));
    printed
}

/// Simulates the drive in both tools by each version of the standard, with this number of ticks a communication step.
fn assert_same(python: &Path, arithmetic: &str, every: usize) {
    let folder = tempfile::tempdir().unwrap();
    let given = ["--arithmetic", arithmetic];
    let step_s = every as f64 * 1e-3;
    let simulated = folder.path().join("s.csv");
    let there = VERSIONS.map(|version| {
        let fmu = exported(folder.path(), "drive", &leaking_press(), &[&given[..], &["--fmi", version]].concat());
        let machine = folder.path().join("drive.toml");
        let input = ["simulate", "--machine", text(&machine), "--input", "steps:4V", "--out", text(&simulated)];
        done(&[&input, &given[..]].concat());
        printed(&asked(python, &["simulate", text(&fmu), text(&simulated), &step_s.to_string()]))
    });
    assert_eq!(there[0], there[1], "both versions give every digit alike");

    let here = recording::read(&simulated, &ChannelMap::default()).unwrap();
    let row = |line: &str| line.split(' ').map(|number| number.parse().unwrap()).collect::<Vec<f64>>();
    let there: Vec<Vec<f64>> = there[0].lines().map(row).collect();
    let steps = (here.time_s().len() - 1) / every;
    assert_eq!(there.len(), steps + 1);
    for (step, row) in there.iter().enumerate() {
        let k = step * every;
        assert!((row[0] - here.time_s()[k]).abs() < 1e-9, "{} s is {} s", here.time_s()[k], row[0]);
        for (signal, found) in OUTPUTS.into_iter().zip(&row[1..]) {
            let expected = here.signal(signal).unwrap()[k];
            assert_eq!(
                found.to_bits(),
                expected.to_bits(),
                "{signal} at {} s: {found}, {expected} by simulate",
                row[0]
            );
        }
    }
}

#[test]
fn fmpy_simulates_in_fixed_point_what_simulate_does() {
    let Some(python) = python_with("fmpy") else { return };
    assert_same(&python, "fixed", 1);
    assert_same(&python, "fixed", 10);
}

#[test]
fn fmpy_simulates_in_float_what_simulate_does() {
    let Some(python) = python_with("fmpy") else { return };
    assert_same(&python, "float", 1);
    assert_same(&python, "float", 10);
}

#[test]
fn fmpy_finds_nothing_wrong_with_an_fmu() {
    let Some(python) = python_with("fmpy") else { return };
    let folder = tempfile::tempdir().unwrap();
    for version in VERSIONS {
        for drive in [&leaking_press(), PUMP, MASS] {
            let fmu = exported(folder.path(), "drive", drive, &["--fmi", version]);
            assert_eq!(printed(&asked(&python, &["validate", text(&fmu)])), "", "{version}");
        }
    }
}

#[test]
fn fmpy_goes_on_from_a_state() {
    let Some(python) = python_with("fmpy") else { return };
    let folder = tempfile::tempdir().unwrap();
    for version in VERSIONS {
        let fmu = exported(folder.path(), "drive", &leaking_press(), &["--fmi", version]);
        let printed = printed(&asked(&python, &["states", text(&fmu)]));
        let lines: Vec<&str> = printed.lines().collect();
        assert_eq!(lines[0], lines[1], "a kept state");
        assert_eq!(lines[0], lines[2], "a state written down, after a reset");
    }
}

#[test]
fn fmpy_is_told_why_a_start_a_step_or_a_state_is_refused() {
    let Some(python) = python_with("fmpy") else { return };
    let folder = tempfile::tempdir().unwrap();
    let stiffer = leaking_press().replace("2.0e-12", "2.1e-12");
    for version in VERSIONS {
        let fmu = exported(folder.path(), "drive", &leaking_press(), &["--fmi", version]);
        let other = exported(folder.path(), "other", &stiffer, &["--fmi", version]);
        let printed = printed(&asked(&python, &["refusals", text(&fmu), text(&other)]));
        let lines: Vec<&str> = printed.lines().collect();
        let said = [
            "position_start = -0.001: expected 0 to 0.3",
            "position_start = 0.301: expected 0 to 0.3",
            "position_start: set in mode Step; expected it before the simulation begins",
            "DoStep: a communication step of 0.0015 s; expected a whole number of ticks of 0.001 s",
            "the serialized state is of \"drive-fmu/",
            "0.3",
        ];
        assert_eq!(lines.len(), said.len(), "{printed}");
        for (line, said) in lines.iter().zip(said) {
            assert!(line.contains(said), "{line}: {said}");
        }
    }
}
