//! What `compare` says about a drive: where physics is missing, and that noise is not missing physics.

use std::path::Path;

use super::{done, root};

/// A recording of the press with this effect in addition to its exact machine file, and what `compare` says about it.
fn told(folder: &Path, effect: &[&str], spool: bool) -> String {
    let preset = root().join("presets/press-63-40.toml").display().to_string();
    let exact = ["testbed", "--machine", &preset, "--spread", "0", "--noise", "2", "--position-step", "0.005"];
    done(folder, &[&exact[..], &["--seed", "5", "--out", ".", "--train", "triangle:4V,0.5Hz,4s"], effect].concat());
    if !spool {
        let text = std::fs::read_to_string(folder.join("train-1.csv")).unwrap();
        let without = |line: &str| {
            let mut cells: Vec<&str> = line.split(',').collect();
            cells.remove(2);
            cells.join(",")
        };
        let lines: Vec<String> = text.lines().map(without).collect();
        std::fs::write(folder.join("train-1.csv"), lines.join("\n")).unwrap();
    }
    done(folder, &["compare", "--machine", "machine.toml", "--recording", "train-1.csv"])
}

#[test]
fn noise_that_a_position_adds_up_is_no_missing_physics() {
    let folder = tempfile::tempdir().unwrap();
    let exact = told(folder.path(), &[], true);
    // Thirty times the noise of the position, caused by the noise of the pressures.
    assert!(exact.contains("weakest is mechanics") && exact.contains("Every part follows its recordings"), "{exact}");
    let rubbed = told(folder.path(), &["--effect", "coulomb-friction=800"], true);
    assert!(rubbed.contains("weakest is mechanics") && rubbed.contains("This part does not follow"), "{rubbed}");
}

#[test]
fn parts_that_follow_do_not_speak_for_those_that_could_not_be_judged() {
    let folder = tempfile::tempdir().unwrap();
    let leaking = told(folder.path(), &["--effect", "internal-leakage=3e-12"], false);
    assert!(leaking.contains("weakest is mechanics") && !leaking.contains("Every part follows"), "{leaking}");
    assert!(leaking.contains("But end to end ") && leaking.contains("record `spool` for this"), "{leaking}");
}

#[test]
fn a_part_that_an_offset_moves_as_far_is_not_accused() {
    let folder = tempfile::tempdir().unwrap();
    let exact = told(folder.path(), &[], true);
    assert!(exact.contains("Every part follows"), "{exact}");
    let text = std::fs::read_to_string(folder.path().join("train-1.csv")).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    let at = header.split(',').position(|name| name.starts_with("pressure_a")).unwrap();
    let offset = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        cells[at] = (cells[at].parse::<f64>().unwrap() + 2e4).to_string();
        cells.join(",")
    };
    let rows: Vec<String> = rows.lines().map(offset).collect();
    std::fs::write(folder.path().join("train-1.csv"), format!("{header}\n{}\n", rows.join("\n"))).unwrap();
    let moved = done(folder.path(), &["compare", "--machine", "machine.toml", "--recording", "train-1.csv"]);
    assert!(
        moved.contains("mechanics cannot be judged by position") && moved.contains("in open loop an offset"),
        "{moved}"
    );
    assert!(!moved.contains("does not follow"), "{moved}");
}
