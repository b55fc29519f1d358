//! Two cascaded tanks, measured by others: no hydraulic drive at all. The level follows the pump's voltage instead of integrating it.

use diagnosis::agreement::{doubts, follower};
use diagnosis::base_parameters;
use recording::Recording;

/// Whole diagnoses of it take minutes: `cargo test --release -p system-tests --test diagnosis a_tank -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes"]
fn the_diagnosis_of_a_tank_says_that_the_level_follows_the_command() {
    let Some(folder) = system_tests::at_hand::shared("data/slow-tank") else { return };
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let [machine, a1, a2, a3, h1] = ["machine.toml", "a1.csv", "a2.csv", "a3.csv", "h1.csv"].map(path);
    let said = super::done(&["diagnose", "--machine", &machine, "--train", &a1, &a2, &a3, "--holdout", &h1]);
    println!("{said}");
    let first = said.lines().next().unwrap();
    assert!(first.contains("position follows the command instead of integrating it"), "{first}");
    assert!(!said.contains("far value") && !said.contains("doubt "), "{said}");
}

#[test]
fn of_a_tank_no_channel_is_doubted_for_its_level_follows_the_command() {
    let Some(folder) = system_tests::at_hand::shared("data/slow-tank") else { return };
    let file = machine_file::read(&folder.join("machine.toml")).unwrap();
    let read = |name| recording::read(&folder.join(name), &file.channels).unwrap();
    let recordings = ["a1.csv", "a2.csv", "a3.csv", "h1.csv"].map(read);
    let recordings: Vec<&Recording> = recordings.iter().collect();
    let free = base_parameters(&file);
    let found = follower(&file, &free, &recordings).unwrap().unwrap();
    assert!(found.follows_percent > 65.0, "{found:?}");
    assert_eq!(doubts(&file, &free, &recordings).unwrap(), []);
}
