//! What `testbed` makes and refuses.

use super::{MACHINE, done, folder_with, listing, refused};

const TESTBED: [&str; 7] = ["testbed", "--machine", "machine.toml", "--out", "case", "--train", "step:4V,0.1s"];

#[test]
fn a_case_holds_the_machine_file_as_it_is_and_its_recordings() {
    let folder = folder_with(MACHINE, "");
    let more = ["--holdout", "zero:0.1s", "--dither", "0.1", "80", "--effect", "coulomb-friction=800", "--tick", "2"];
    done(folder.path(), &[&TESTBED[..], &more].concat());
    let case = folder.path().join("case");
    let names: Vec<_> = listing(&case).iter().map(|path| path.file_name().unwrap().to_owned()).collect();
    assert_eq!(names, ["holdout-1.csv", "machine.toml", "train-1.csv"]);
    assert_eq!(std::fs::read_to_string(case.join("machine.toml")).unwrap(), MACHINE);
    let train = std::fs::read_to_string(case.join("train-1.csv")).unwrap();
    assert!(train.starts_with("time [s],command [V],spool [1],position [m],pressure_a [Pa],pressure_b [Pa]\n0,0,"));
    assert_eq!(train.lines().count(), 2 + 275);
    assert!(train.contains("\n0.002,0.0844,"), "the dither is part of the command");
}

#[test]
fn a_closed_loop_records_its_set_value() {
    let folder = folder_with(MACHINE, "");
    done(folder.path(), &[&TESTBED[..], &["--closed-loop", "400", "--position-step", "0.01"]].concat());
    let train = std::fs::read_to_string(folder.path().join("case/train-1.csv")).unwrap();
    assert!(train.lines().next().unwrap().ends_with("reference [m]"));
    assert!(train.contains(",0.16\n"), "4 V / 400 V/m = 10 mm about mid-stroke");
}

#[test]
fn what_the_test_bed_cannot_do_is_said_and_nothing_is_written() {
    let folder = folder_with(MACHINE, "");
    for (more, expected) in [
        (&["--effect", "rust=3"][..], "expected: one of hose-compliance [m3/Pa]"),
        (&["--effect", "coulomb-friction=-3"], "expected: one of"),
        (&["--train", "step:9V,20s"], "expected it to stay within 0 to 300.0 mm"),
        (&["--noise", "NaN"], "--noise is NaN"),
        (&["--dither", "1", "900"], "half of the control rate"),
        (&["--spread=-1"], "--spread is -1"),
    ] {
        let message = refused(folder.path(), &[&TESTBED[..], more].concat());
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn recordings_of_another_case_are_not_mixed_in() {
    let folder = folder_with(MACHINE, "");
    done(folder.path(), &[&TESTBED[..], &["--train", "zero:0.1s"]].concat());
    let message = refused(folder.path(), &TESTBED);
    assert!(message.contains("train-2.csv is there already"), "{message}");
}

#[test]
fn a_place_that_cannot_be_written_to_is_told_before_the_test_bed_runs() {
    let folder = folder_with(MACHINE, "");
    // The excitation leaves the stroke, which is found only in the run.
    let leaves = ["--train", "step:9V,20s"];
    let case = ["testbed", "--machine", "machine.toml", "--out", "run.csv/case"];
    let message = refused(folder.path(), &[&case[..], &leaves].concat());
    assert!(message.contains("run.csv/case: cannot be written"), "{message}");
    let draw = ["testbed", "draw", "--count", "1", "--out", "run.csv/cases"];
    let message = refused(folder.path(), &draw);
    assert!(message.contains("run.csv/cases: cannot be written"), "{message}");

    done(folder.path(), &[&TESTBED[..], &["--train", "zero:0.1s"]].concat());
    let message = refused(folder.path(), &[&TESTBED[..5], &leaves].concat());
    assert!(message.contains("train-2.csv is there already"), "{message}");
}

#[test]
fn drawn_cases_have_their_files_and_the_truth_beside_them() {
    let folder = folder_with(MACHINE, "");
    let draw = ["testbed", "draw", "--seed", "3", "--count", "2", "--effects", "none", "--hard", "--out", "cases"];
    done(folder.path(), &draw);
    let cases = folder.path().join("cases");
    let truth: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(cases.join("truth.json")).unwrap()).unwrap();
    for id in ["c000", "c001"] {
        assert_eq!(truth[id]["effects"], serde_json::json!([]));
        assert_eq!(truth[id]["accept"], serde_json::json!([[]]));
        let floor = truth[id]["noise_floor_nrmse"].as_object().unwrap();
        for (stem, channels) in floor {
            assert!(cases.join(id).join(format!("{stem}.csv")).exists());
            assert!((0.0..0.5).contains(&channels["y"].as_f64().unwrap()));
        }
        assert!(floor.contains_key("train-1") && floor.contains_key("holdout-2"));
        let machine = std::fs::read_to_string(cases.join(id).join("machine.toml")).unwrap();
        assert!(machine.contains("[fit.sigma]") && machine.contains("\"load.force_n\""));
    }
    done(folder.path(), &["diagnose", "cases/c000", "--json", "d.json"]);
}

#[test]
fn a_name_that_cannot_be_drawn_is_refused_with_those_that_can() {
    let folder = folder_with(MACHINE, "");
    let message = refused(folder.path(), &["testbed", "draw", "--only", "rust", "--out", "cases"]);
    assert!(message.contains("expected: one of valve-hysteresis"), "{message}");
    assert!(!folder.path().join("cases").exists());
}

#[test]
fn a_lot_is_not_written_over_recordings_of_another() {
    let folder = folder_with(MACHINE, "");
    let draw =
        |seed: &'static str| ["testbed", "draw", "--seed", seed, "--count", "2", "--effects", "none", "--out", "cases"];
    done(folder.path(), &draw("3"));
    let cases = folder.path().join("cases");
    let kept = || ["truth.json", "c000/train-1.csv"].map(|name| std::fs::read(cases.join(name)).unwrap());
    let before = kept();
    // In any format that a diagnosis would read.
    std::fs::write(cases.join("c001/train-99.mat"), "").unwrap();
    let message = refused(folder.path(), &draw("4"));
    assert!(message.contains("train-99.mat is there already"), "{message}");
    assert!(kept() == before, "and nothing of the first lot is another's");
}
