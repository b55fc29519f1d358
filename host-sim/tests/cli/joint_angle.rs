//! A joint angle in place of a position, as a user meets it.

use std::fmt::Write as _;
use std::path::Path;

use tempfile::TempDir;

use super::{MACHINE, done, example, folder_with, refused, run, text};

const LINKAGE: &str = "\n[linkage]\nbase_m = 0.6\narm_m = 0.5\nlength_retracted_m = 0.45\nangle_at_zero_rad = 0.5\n";
const SIMULATE: [&str; 5] = ["simulate", "--machine", "machine.toml", "--out", "out.csv"];

/// A column of a file by its header.
fn column(path: &Path, header: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(path).unwrap();
    let at = text.lines().next().unwrap().split(',').position(|own| own == header).unwrap_or_else(|| panic!("{text}"));
    text.lines().skip(1).map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

/// The law of cosines once more.
fn position_m(angle_rad: f64) -> f64 {
    (0.61 - 0.6 * (0.5 + angle_rad).cos()).sqrt() - 0.45
}

/// Four seconds of the drive, simulated, of which the joint's angle is recorded, changed in this way; rad.
fn recorded(machine: &str, changed: impl Fn(f64) -> f64) -> TempDir {
    let folder = folder_with(&format!("{MACHINE}{LINKAGE}"), "");
    done(folder.path(), &[&SIMULATE[..], &["--input", "random:6V,0.1s,0.5s,4s,seed=2"]].concat());
    let of = |header| column(&folder.path().join("out.csv"), header);
    let mut csv = "time [s],command [V],angle [deg]\n".to_owned();
    for ((time, command), angle) in of("time [s]").iter().zip(of("command [V]")).zip(of("angle [rad]")) {
        writeln!(csv, "{time},{command},{:.4}", changed(angle).to_degrees()).unwrap();
    }
    std::fs::write(folder.path().join("run.csv"), csv).unwrap();
    std::fs::write(folder.path().join("machine.toml"), machine).unwrap();
    folder
}

#[test]
fn a_simulation_has_the_angle_that_the_logger_would_show() {
    let machine = format!("{MACHINE}{LINKAGE}");
    let folder = recorded(&machine, |angle| angle);
    let out = folder.path().join("out.csv");
    for (angle, position) in column(&out, "angle [rad]").iter().zip(column(&out, "position [m]")) {
        assert!((position_m(*angle) - position).abs() < 1e-12);
    }
    // Of a recording in its own unit, whether in parts or at once.
    for more in [&["--recording", "run.csv"][..], &["--recording", "run.csv", "--plot", "p.svg"]] {
        let ran = run(folder.path(), &[&SIMULATE[..], more].concat());
        assert!(text(&ran.stderr).contains("it comes from the joint's angle by the linkage"), "{}", text(&ran.stderr));
        let header = std::fs::read_to_string(&out).unwrap().lines().next().unwrap().to_owned();
        assert_eq!(header, "time [s],command [V],angle [deg],position [m]");
        let recorded = column(&folder.path().join("run.csv"), "angle [deg]");
        for ((angle, position), recorded) in
            column(&out, "angle [deg]").iter().zip(column(&out, "position [m]")).zip(recorded)
        {
            assert!((position_m(angle.to_radians()) - position).abs() < 1e-9);
            assert!((angle - recorded).abs() < 0.01, "the same model: {angle} {recorded}");
        }
    }
}

#[test]
fn a_position_stays_and_the_angle_comes_beside_it() {
    let folder = folder_with(
        &format!("{MACHINE}{LINKAGE}"),
        "time [s],command [V],position [mm]\n0,0,150\n0.5,0,150\n1,0,150\n",
    );
    done(folder.path(), &[&SIMULATE[..], &["--recording", "run.csv"]].concat());
    let header = std::fs::read_to_string(folder.path().join("out.csv")).unwrap();
    assert!(header.starts_with("time [s],command [V],position [mm],angle [rad]\n"), "{header}");
}

#[test]
fn inspect_says_where_the_position_comes_from_or_what_is_missing_for_it() {
    let folder = recorded(&format!("{MACHINE}{LINKAGE}"), |angle| angle);
    let printed = done(folder.path(), &["inspect", "run.csv", "--machine", "machine.toml", "--json", "i.json"]);
    assert!(printed.contains("note: the position is not recorded: it comes from the joint's angle"), "{printed}");
    assert!(printed.lines().any(|line| line.contains(" position ") && line.contains(" from the angle ")), "{printed}");
    assert!(std::fs::read_to_string(folder.path().join("i.json")).unwrap().contains("it comes from the joint's angle"));
    let bare = done(folder.path(), &["inspect", "run.csv"]);
    assert!(bare.contains("no [linkage] that turns one into the other"), "{bare}");
}

#[test]
fn an_angle_without_linkage_or_beyond_it_is_told() {
    let folder = recorded(MACHINE, |angle| angle);
    let ran = run(folder.path(), &["diagnose", "--machine", "machine.toml", "--train", "run.csv"]);
    assert!(!ran.status.success());
    assert!(text(&ran.stderr).contains("the angle is not used"), "{}", text(&ran.stderr));
    // An encoder with its zero elsewhere: the first row is not reached.
    let folder = recorded(&format!("{MACHINE}{LINKAGE}"), |angle| angle + 2.6);
    let message = refused(folder.path(), &["compare", "--machine", "machine.toml", "--recording", "run.csv"]);
    assert!(message.contains("run.csv:") && message.contains("a joint angle of 18"), "{message}");
    assert!(message.contains("expected: -28.6479 to 151.3521 deg"), "{message}");
}

#[test]
fn a_wrong_zero_and_a_turned_joint_are_doubted_as_those_of_a_position_are() {
    let machine = format!("{MACHINE}{LINKAGE}");
    let folder = recorded(&machine, |angle| angle + 0.8);
    let printed = done(folder.path(), &["inspect", "run.csv", "--machine", "machine.toml"]);
    assert!(printed.contains("beyond the stroke of the machine file: are its unit and its zero right?"), "{printed}");
    // Turned round about the middle of its range: it stays within the stroke.
    let folder = recorded(&machine, |angle| 1.3 - angle);
    let message = refused(folder.path(), &["diagnose", "--machine", "machine.toml", "--train", "run.csv"]);
    assert!(message.contains("position seems to run the other way"), "{message}");
    assert!(message.contains("comes from the joint's angle"), "{message}");
}

#[test]
fn a_fitted_machine_file_keeps_its_linkage() {
    for linkage in [
        LINKAGE.to_owned(),
        "\n[linkage]\nangles_deg = [10, 40, 80]   # by hand\npositions_m = [-0.05, 0.15, 0.4]\n".to_owned(),
    ] {
        let folder = recorded(&format!("{MACHINE}{linkage}"), |angle| angle);
        done(
            folder.path(),
            &["fit", "--machine", "machine.toml", "--train", "run.csv", "--save-machine", "fitted.toml"],
        );
        let fitted = std::fs::read_to_string(folder.path().join("fitted.toml")).unwrap();
        assert!(fitted.contains(&linkage), "{fitted}");
    }
}

/// The shipped case with an encoder of 17 bits at a joint in place of the position's sensor: the same leak, within 2 %.
#[test]
fn the_shipped_case_recorded_at_a_joint_has_the_same_finding_by_sides_and_by_table() {
    const SIDES: &str = "[linkage]\nbase_m = 0.5\narm_m = 0.35\nlength_retracted_m = 0.16\nangle_at_zero_rad = 0.2\nangle_rises = \"retracting\"\n";
    let angle_deg = |position_m: f64| {
        let cosine = (0.25 + 0.1225 - (0.16 + position_m).powi(2)) / 0.35;
        (0.2 - cosine.acos()).to_degrees()
    };
    let positions: Vec<f64> = (0..=30).map(|k| 0.01 * f64::from(k)).collect();
    let angles: Vec<f64> = positions.iter().map(|position| (1e3 * angle_deg(*position)).round() * 1e-3).collect();
    let table = format!("[linkage]\nangles_deg = {angles:?}\npositions_m = {positions:?}\n");
    let machine = std::fs::read_to_string(example("machine.toml")).unwrap();
    for linkage in [SIDES, &table] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("machine.toml"), format!("{machine}\n{linkage}")).unwrap();
        for name in ["train-1.csv", "train-2.csv", "train-3.csv", "train-4.csv", "holdout-1.csv", "holdout-2.csv"] {
            let Ok(text) = std::fs::read_to_string(example(name)) else { continue };
            let mut csv = text.lines().next().unwrap().replace("position [m]", "angle [deg]") + "\n";
            for line in text.lines().skip(1) {
                let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
                let steps = (angle_deg(cells[3].parse().unwrap()) * 131_072.0 / 360.0).round();
                cells[3] = format!("{:.4}", steps * 360.0 / 131_072.0);
                writeln!(csv, "{}", cells.join(",")).unwrap();
            }
            std::fs::write(folder.path().join(name), csv).unwrap();
        }
        done(folder.path(), &["diagnose", ".", "--json", "d.json"]);
        let found: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(folder.path().join("d.json")).unwrap()).unwrap();
        assert_eq!(found["findings"].as_array().unwrap().len(), 1, "{}", found["findings"]);
        assert_eq!(found["findings"][0]["effect"], "internal-leakage");
        let leak = found["findings"][0]["parameters"][0]["value"].as_f64().unwrap();
        println!("{leak:e} m3/s/Pa");
        assert!((leak / 1.9878e-12 - 1.0).abs() < 0.02, "{leak}");
    }
}
