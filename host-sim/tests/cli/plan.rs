//! What a recording will be able to show, before it is made.

use recording::{ChannelMap, Signal};

use super::{done, example, folder_with, refused, run, text};

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
