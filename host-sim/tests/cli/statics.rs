//! `statics`: the kind of the curve, and sweeps compared.

use std::fmt::Write;
use std::path::Path;

use serde_json::Value;

use super::{done, refused};

/// A triangular sweep of −5 … 5 mA over a bell, read by a meter that lags by 2 s; with a clock if asked for.
fn leakage(folder: &Path, name: &str, period_s: f64, clock: bool) {
    let rows = 2000;
    let tick_s = period_s / f64::from(rows);
    let mut text = String::from(if clock { "time [s],I [mA],Q [l/min]\n" } else { "I [mA],Q [l/min]\n" });
    let mut read = 0.65;
    for row in 0..rows {
        let input = 5.0 - 10.0 * (2.0 * f64::from(row) / f64::from(rows - 1) - 1.0).abs();
        read += (1.0 - (-tick_s / 2.0).exp()) * (0.65 + 0.7 / (1.0 + input.powi(4)) - read);
        // What a meter leaves of noise, the same in each run.
        let flow = read + 0.002 * (12.9898 * f64::from(row)).sin();
        if clock {
            let _ = write!(text, "{},", tick_s * f64::from(row));
        }
        let _ = writeln!(text, "{input},{flow}");
    }
    std::fs::write(folder.join(name), text).unwrap();
}

const COLUMNS: [&str; 4] = ["--input", "I", "--output", "Q"];

fn statics(folder: &Path, arguments: &str) -> String {
    done(folder, &[&["statics"], &arguments.split(' ').collect::<Vec<_>>()[..], &COLUMNS].concat())
}

#[test]
fn a_bell_is_told_as_one_and_no_gain_is_read() {
    let folder = tempfile::tempdir().unwrap();
    leakage(folder.path(), "slow.csv", 500.0, false);
    let told = statics(folder.path(), "--recording slow.csv --json s.json --plot s.svg");
    assert!(
        told.contains("a peak of 1.3") && told.contains("null leakage") && told.contains("wide at half height"),
        "{told}"
    );
    assert!(!told.contains("\ngain") && !told.contains("extrapolated") && told.contains("no effect"), "{told}");
    let json: Value = serde_json::from_str(&std::fs::read_to_string(folder.path().join("s.json")).unwrap()).unwrap();
    let shape = &json["statics"]["shape"];
    assert!(
        shape["kind"] == "peak" && shape["output"].as_f64().unwrap() > 1.3 && json["statics"]["gain"].is_null(),
        "{json}"
    );
    assert!(std::fs::read_to_string(folder.path().join("s.svg")).unwrap().contains("peak"));
}

#[test]
fn sweeps_of_several_periods_are_compared_and_a_lag_is_told_with_its_time() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (name, period_s) in [("a.csv", 200.0), ("b.csv", 500.0), ("c.csv", 1000.0)] {
        leakage(folder, name, period_s, false);
        leakage(folder, &format!("clock-{name}"), period_s, true);
    }
    let told = statics(folder, "--recording a.csv b.csv c.csv --period 200 500 1000 --json s.json --plot s.svg");
    assert!(told.contains("the loop shrinks with the rate: a lag of") && !told.contains("valve-hysteresis"), "{told}");
    let json: Value = serde_json::from_str(&std::fs::read_to_string(folder.join("s.json")).unwrap()).unwrap();
    let compared = &json["comparison"];
    assert!(compared["cause"] == "lag" && json["sweeps"].as_array().unwrap().len() == 3, "{compared}");
    assert!((compared["lag"]["value"].as_f64().unwrap() - 2.0).abs() < 0.1, "{compared}");
    assert_eq!(json["statics"]["recording"], "c.csv", "the slowest");
    let drawn = std::fs::read_to_string(folder.join("s.svg")).unwrap();
    assert!(["a.csv, 200 s", "b.csv, 500 s", "c.csv, 1000 s"].iter().all(|name| drawn.contains(name)));

    let by_clock = statics(folder, "--recording clock-a.csv clock-b.csv clock-c.csv");
    assert!(by_clock.contains("shrinks with the rate: a lag of") && !by_clock.contains("--period"), "{by_clock}");
    let by_rows = statics(folder, "--recording a.csv b.csv c.csv");
    assert!(by_rows.contains("no clock and no --period") && by_rows.contains("give --period"), "{by_rows}");
    let alone = statics(folder, "--recording a.csv --period 200");
    assert!(alone.contains("one sweep cannot tell") && alone.contains("(as a lag: "), "{alone}");
}

#[test]
fn periods_that_do_not_belong_to_the_recordings_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    leakage(folder.path(), "a.csv", 20.0, false);
    let refuse = |arguments: &str| {
        refused(folder.path(), &[&["statics"], &arguments.split(' ').collect::<Vec<_>>()[..], &COLUMNS].concat())
    };
    let message = refuse("--recording a.csv a.csv --period 20");
    assert!(message.contains("1 periods for 2 recordings") && message.contains("expected one for each"), "{message}");
    let message = refuse("--recording a.csv --period 0");
    assert!(message.contains("--period") && message.contains("a time above zero"), "{message}");
}
