//! The FMU in another tool: `FMPy` finds nothing wrong with it, and simulates the same as `host-sim simulate`.

use std::path::Path;
use std::process::{Command, Output};

use recording::{ChannelMap, Signal};
use system_tests::python::python_with;

use super::{PUMP, done, leaking_press, library, text};

const SCRIPT: &str = include_str!("fmpy.py");

/// The compared outputs, each with its full scale: supply pressure, stroke, what a full opening gives.
const OUTPUTS: [(Signal, f64); 7] = [
    (Signal::Spool, 1.0),
    (Signal::Position, 0.3),
    (Signal::Velocity, 0.2),
    (Signal::PressureA, 7e6),
    (Signal::PressureB, 7e6),
    (Signal::Flow, 6e-4),
    (Signal::Force, 2.2e4),
];

fn asked(python: &Path, arguments: &[&str]) -> Output {
    Command::new(python).args(["-c", SCRIPT]).args(arguments).output().unwrap()
}

/// Rows of numbers that the script printed.
fn rows(output: &Output) -> Vec<Vec<f64>> {
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{printed}{}", String::from_utf8_lossy(&output.stderr));
    printed.lines().map(|line| line.split(' ').map(|number| number.parse().unwrap()).collect()).collect()
}

/// Simulates the drive in both tools, with this number of ticks a communication step.
fn assert_same(python: &Path, arithmetic: &str, every: usize) {
    let folder = tempfile::tempdir().unwrap();
    let [machine, simulated, fmu] = ["machine.toml", "s.csv", "drive.fmu"].map(|name| folder.path().join(name));
    std::fs::write(&machine, leaking_press()).unwrap();
    let given = ["--machine", text(&machine), "--arithmetic", arithmetic];
    let library = library();
    done(&[&["simulate"], &given[..], &["--input", "steps:4V", "--out", text(&simulated)]].concat());
    done(&[&["export"], &given[..], &["--out", text(&fmu), "--library", text(&library)]].concat());

    let here = recording::read(&simulated, &ChannelMap::default()).unwrap();
    let step_s = every as f64 * 1e-3;
    let there = rows(&asked(python, &["simulate", text(&fmu), text(&simulated), &step_s.to_string()]));
    let steps = (here.time_s().len() - 1) / every;
    assert_eq!(there.len(), steps + 1);
    let mut largest = 0.0_f64;
    for (step, row) in there.iter().enumerate() {
        let k = step * every;
        assert!((row[0] - here.time_s()[k]).abs() < 1e-9, "{} s is {} s", here.time_s()[k], row[0]);
        for ((signal, full), found) in OUTPUTS.into_iter().zip(&row[1..]) {
            let expected = here.signal(signal).unwrap()[k];
            let distance = (found - expected).abs() / full;
            assert!(distance <= 1e-9, "{signal} at {} s: {found}, and {expected} by simulate", row[0]);
            largest = largest.max(distance);
        }
    }
    println!("{arithmetic}, {every} ms: largest difference {largest:.1e} of full scale");
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
    let [machine, fmu] = ["machine.toml", "drive.fmu"].map(|name| folder.path().join(name));
    let library = library();
    for drive in [&leaking_press(), PUMP] {
        std::fs::write(&machine, drive).unwrap();
        done(&["export", "--machine", text(&machine), "--out", text(&fmu), "--library", text(&library)]);
        let output = asked(&python, &["validate", text(&fmu)]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(String::from_utf8_lossy(&output.stdout), "");
    }
}

#[test]
fn fmpy_goes_on_from_a_state_and_is_told_why_a_step_is_refused() {
    let Some(python) = python_with("fmpy") else { return };
    let folder = tempfile::tempdir().unwrap();
    let [machine, fmu] = ["machine.toml", "drive.fmu"].map(|name| folder.path().join(name));
    std::fs::write(&machine, leaking_press()).unwrap();
    let library = library();
    done(&["export", "--machine", text(&machine), "--out", text(&fmu), "--library", text(&library)]);
    let output = asked(&python, &["states", text(&fmu)]);
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{printed}{}", String::from_utf8_lossy(&output.stderr));
    let lines: Vec<&str> = printed.lines().collect();
    assert_eq!(lines[0], lines[1], "a kept state");
    assert_eq!(lines[0], lines[2], "a state written down, after a reset");
    assert!(lines[3].starts_with("a communication step of 0.0015 s; expected a whole number of ticks"), "{printed}");
}
