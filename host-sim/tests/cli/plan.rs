//! What a recording will be able to show, before it is made.

use firmware::app::press::PLAN;
use firmware::excitation::plan::PlayState;
use recording::{ChannelMap, Signal};

use super::{done, example, folder_with, refused, root, run, text};

#[test]
fn a_plan_says_what_could_be_seen_and_writes_an_excitation_that_the_drive_can_play() {
    let folder = tempfile::tempdir().unwrap();
    let machine = example("machine.toml");
    let sensors = "position:0.05mm,pressure_a:0.2bar,pressure_b:0.2bar";
    let asked = ["plan", "--machine", &machine, "--sensors", sensors, "--seconds", "9", "--input", "steps:4V"];
    let outputs = ["--out", "excitation.csv", "--json", "plan.json", "--plot", "matrix.svg"];
    let printed = done(folder.path(), &[asked.as_slice(), &outputs].concat());
    assert!(printed.contains("seen by position (± 0.0500 mm), pressure_a (± 0.200 bar)"), "{printed}");
    assert!(printed.contains("with the excitation at hand, 1.80 s"), "{printed}");
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let plan: serde_json::Value = serde_json::from_str(&read("plan.json")).unwrap();
    assert_eq!(plan["schema"], "host-sim/plan/1");
    let effects = plan["best"]["outlook"]["effects"].as_array().unwrap();
    let leakage = effects.iter().find(|effect| effect["effect"] == "internal-leakage").unwrap();
    // The proposed excitation shows at least as much as the given one.
    let told = |outlook: &serde_json::Value| -> usize {
        let accepted = outlook["effects"].as_array().unwrap().iter().filter(|effect| effect["claimed"] == true);
        accepted.map(|effect| effects.len() - effect["passes_for"].as_array().unwrap().len()).sum()
    };
    assert!(told(&plan["best"]["outlook"]) > told(&plan["given"]));
    // The shipped case conceals this effect, and these sensors have shown it.
    assert_eq!(leakage["claimed"], true);
    assert_eq!(leakage["passes_for"].as_array().unwrap().len(), 0, "{leakage}");
    assert!(leakage["claimed_from_share_of_usual"].as_f64().unwrap() < 1.0, "{leakage}");
    assert!(plan["best"]["outlook"]["duration_s"].as_f64().unwrap() <= 9.0);
    // Every effect that would be accepted has a row and a column.
    let (matrix, effects) = (read("matrix.svg"), plan["best"]["outlook"]["effects"].as_array().unwrap());
    let accepted = effects.iter().filter(|effect| effect["claimed"] == true).count();
    assert!(accepted > 5 && matrix.matches("<rect").count() > accepted * accepted, "{accepted}");
    assert_eq!(matrix.matches("internal-leakage").count(), 2);
    assert!(done(folder.path(), &["plan", "--help"]).contains("Longest excitation, s [default: 20]"));
    assert!(read("excitation.csv").starts_with("time [s],command [V]\n"));
    let simulate = ["simulate", "--machine", &machine, "--recording", "excitation.csv", "--out", "played.csv"];
    let said = text(&run(folder.path(), &simulate).stderr);
    assert!(said.contains("excitation.csv: no position is recorded: the rod starts at mid-stroke"), "{said}");
    // The rod stays within its stroke, 300 mm, all the time.
    let played = recording::read(&folder.path().join("played.csv"), &ChannelMap::default()).unwrap();
    let position = played.signal(Signal::Position).unwrap();
    assert!((position[0] - 0.15).abs() < 1e-6, "{}", position[0]);
    assert!(position.iter().all(|position| (0.0..=0.3).contains(position)));
    assert!(position.iter().any(|position| (position - 0.15).abs() > 0.01));
}

#[test]
fn the_firmwares_own_plan_is_that_of_the_preset_and_holds_the_voltages_of_its_csv() {
    let folder = tempfile::tempdir().unwrap();
    let preset = root().join("presets/press-63-40.toml").display().to_string();
    let sensors = "spool,position,pressure_a,pressure_b";
    let asked = ["plan", "--machine", &preset, "--sensors", sensors, "--largest", "4", "--seconds", "6"];
    done(folder.path(), &[&asked[..], &["--out", "plan.csv", "--firmware", "plan.rs"]].concat());
    let written = std::fs::read_to_string(folder.path().join("plan.rs")).unwrap();
    let committed = std::fs::read_to_string(root().join("firmware/plan.rs")).unwrap();
    assert_eq!(
        written,
        committed,
        "host-sim {} --firmware firmware/plan.rs, at the repository's root, renews it",
        asked.join(" ").replace(&preset, "presets/press-63-40.toml")
    );
    // Row by row at the firmware's tick: within half a step of 10 V/2¹⁵. After the plan comes the neutral voltage.
    let planned = recording::read(&folder.path().join("plan.csv"), &ChannelMap::default()).unwrap();
    let (play, mut along) = (PLAN.by(planned.sample_interval_s()).unwrap(), PlayState::default());
    let mut played = std::iter::from_fn(|| play.step(&mut along)).map(|command| 10.0 * command.to_f64());
    let mut largest_v = 0.0_f64;
    for (row, planned_v) in planned.signal(Signal::Command).unwrap().iter().enumerate() {
        let played_v = played.next().unwrap();
        assert!((played_v - planned_v).abs() <= 0.5 * 10.0 / 32_768.0 + 1e-12, "row {row}: {played_v} {planned_v}");
        largest_v = largest_v.max(played_v.abs());
    }
    assert!((largest_v - PLAN.largest_v).abs() < 1e-12 && largest_v > 3.9, "{largest_v}");
    let rest: Vec<f64> = played.collect();
    assert!(rest.len() >= 50 && rest.iter().all(|volts| (volts + 0.6172).abs() < 2e-4), "{rest:?}");
}

#[test]
fn what_the_firmware_cannot_play_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let machine = example("machine.toml");
    let plan = |more: &[&str]| {
        let asked = ["plan", "--machine", &machine, "--sensors", "position", "--seconds", "5"];
        let message = refused(folder.path(), &[&asked[..], more].concat());
        assert!(!folder.path().join("plan.rs").exists());
        message
    };
    let message = plan(&["--firmware", "plan.rs", "--largest", "12"]);
    assert!(message.contains("--firmware: ") && message.contains("V in row "), "{message}");
    assert!(message.contains("expected at most 10 V, as the output of the firmware gives"), "{message}");
    let message = plan(&["--firmware", "plan.csv"]);
    assert!(message.contains("plan.csv") && message.contains(".rs"), "{message}");
    let message = plan(&["--firmware", "plan.rs", "--with-load"]);
    assert!(message.contains("--with-load"), "{message}");
}

#[test]
fn a_recording_brings_its_own_sensors_and_noise() {
    let folder = tempfile::tempdir().unwrap();
    let (machine, recording) = (example("machine.toml"), example("train-1.csv"));
    let printed = done(folder.path(), &["plan", "--machine", &machine, "--recording", &recording, "--seconds", "9"]);
    assert!(printed.contains("spool (± ") && printed.contains("position (± "), "{printed}");
    assert!(printed.contains("with the excitation at hand, 3.00 s"), "{printed}");
}

#[test]
fn what_cannot_be_planned_is_refused_with_what_would_do() {
    let folder = folder_with(super::MACHINE, "time [s],command [V]\n0,0\n1,0\n");
    let plan = |more: &[&str]| refused(folder.path(), &[&["plan", "--machine", "machine.toml"], more].concat());
    let message = plan(&["--sensors", "positon"]);
    assert!(message.contains("did you mean `position`?"), "{message}");
    let message = plan(&["--sensors", "position:0.05bar"]);
    assert!(message.contains("noise `0.05bar` of position") && message.contains("mm"), "{message}");
    let message = plan(&["--sensors", "position", "--seconds", "0.2"]);
    assert!(message.contains("no standard test is shorter than 0.2 s"), "{message}");
    let message = plan(&["--sensors", "position", "--seconds", "-1"]);
    assert!(message.contains("--seconds is -1\n") && message.contains("expected: a positive number"), "{message}");
}
