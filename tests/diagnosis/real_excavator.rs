//! A radio-controlled excavator's boom, recorded by others at 18.8 Hz, uneven, position alone; three cylinders share a pump.

use diagnosis::{Verdict, diagnose};
use recording::Recording;

/// Whole diagnoses of it take a minute: `cargo test --release -p system-tests --test diagnosis excavator -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes"]
fn the_excavators_boom_ends_within_a_minute_of_processor_time_with_either_machine_file() {
    let Some(folder) = system_tests::at_hand::shared("data/excavator-boom") else { return };
    for machine in ["boom.toml", "b-flow.toml"] {
        let file = machine_file::read(&folder.join(machine)).unwrap();
        let read = |names: &[&str]| -> Vec<Recording> {
            let path = |name: &&str| folder.join(format!("boom-{name}.csv"));
            names.iter().map(|name| recording::read(&path(name), &file.channels).unwrap()).collect()
        };
        let training = read(&["train-11", "train-12", "train-21", "train-22", "train-31", "train-41"]);
        let held_out = read(&["holdout-1", "holdout-2", "holdout-3", "holdout-4"]);
        let found = diagnose(&file, &training, &held_out, None, &|_| {}).unwrap();
        let searched = &found.selection.searched;
        // Counted, so that the machine that runs it does not matter.
        let processor_s = 2.0 * searched.all_s();
        let fit = found.mean_fits(true, true)["position"];
        println!("{machine}: {:?}, held out {fit:.2} %, counted {processor_s:.1} s of one core", found.verdict);
        assert!(searched.is_finished() && found.verdict == Verdict::Unexplained && found.findings.is_empty());
        assert!(fit > 86.7 && processor_s < 60.0, "{machine}: {fit} {processor_s}");
    }
}
