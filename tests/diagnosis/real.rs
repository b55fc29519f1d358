//! The pump-controlled cylinder with 1–2 m of hose, measured on a real rig by others.

use std::path::{Path, PathBuf};
use std::time::Instant;

use host_sim::diagnose::{Diagnosis, Shown, diagnose};
use host_sim::machine_file;
use host_sim::recording::{self, ChannelMap, Recording, Signal};

use super::{done, root, text};

/// The recordings: `$HOST_SIM_SHARED/data/eha`, or beside the repository. Says why where they are not.
fn recordings() -> Option<PathBuf> {
    system_tests::at_hand::shared("data/eha")
}

fn machine() -> PathBuf {
    root().join("tests/diagnosis/eha.toml")
}

/// Root mean square error in mm from the start until the valve first turns back: the first extension and its hold.
fn first_extension_mm(recording: &Recording, shown: &Shown, after: bool) -> f64 {
    let direction = recording.signal(Signal::ValveDirection).unwrap();
    let rows = direction.iter().position(|direction| *direction < -0.5).unwrap();
    let channel = shown.prepared.channels.iter().find(|channel| channel.signal == Signal::Position).unwrap();
    let trajectory = if after { &shown.after } else { &shown.before };
    let simulated = trajectory.signal(Signal::Position).unwrap();
    let errors = channel.recorded.iter().zip(simulated).take(rows);
    1e3 * (errors.map(|(recorded, simulated)| (recorded - simulated).powi(2)).sum::<f64>() / rows as f64).sqrt()
}

/// Diagnoses with these recordings; prints the figures; gives the held-out fit of the position before and after.
fn diagnosed(folder: &Path, training: &[&str], held_out: &[&str]) -> (Diagnosis, f64, f64) {
    let file = machine_file::read(&machine()).unwrap();
    let read = |name: &&str| recording::read(&folder.join(format!("{name}.csv")), &ChannelMap::default()).unwrap();
    let training: Vec<Recording> = training.iter().map(read).collect();
    let held_out: Vec<Recording> = held_out.iter().map(read).collect();
    let start = Instant::now();
    let diagnosis = diagnose(&file, &training, &held_out, None, &|_| {}).unwrap();
    let (before, after) = (diagnosis.mean_fits(true, false)["position"], diagnosis.mean_fits(true, true)["position"]);
    println!("held-out position {before:.1} % → {after:.1} %, {:.0} s", start.elapsed().as_secs_f64());
    for finding in &diagnosis.findings {
        for estimate in &finding.parameters {
            println!("{}: {:.3e} ± {:.1e}", finding.effect.name, estimate.value, estimate.std);
        }
    }
    for (recording, shown) in held_out.iter().zip(diagnosis.shown.iter().filter(|shown| shown.held_out)) {
        let [before, after] = [false, true].map(|after| first_extension_mm(recording, shown, after));
        println!("{}, first extension and hold: {before:.2} mm → {after:.2} mm", recording.name());
    }
    (diagnosis, before, after)
}

fn finds_the_hoses(diagnosis: &Diagnosis) {
    let found: Vec<&str> = diagnosis.findings.iter().map(|finding| finding.effect.name).collect();
    assert!(found.contains(&"hose-compliance"), "{found:?}");
}

#[test]
fn the_hoses_of_a_real_drive_are_found_and_held_out_loads_are_followed_better() {
    let Some(folder) = recordings() else { return };
    let training = ["load1-stroke2", "load1-stroke3", "load5-stroke2", "load5-stroke3"];
    let (diagnosis, before, after) = diagnosed(&folder, &training, &["load3-stroke2", "load3-stroke3"]);
    finds_the_hoses(&diagnosis);
    assert!(after > before + 10.0, "{before} {after}");
}

/// All twelve recordings:
/// `cargo test --release -p system-tests --test diagnosis every_stroke -- --ignored --nocapture`
#[test]
#[ignore = "half a minute in release, many in a debug build"]
fn every_stroke_of_the_real_drive_tells_the_same() {
    let Some(folder) = recordings() else { return };
    let of = |load: u8| [1, 2, 3, 4].map(|stroke| format!("load{load}-stroke{stroke}"));
    let (one, three, five) = (of(1), of(3), of(5));
    let training: Vec<&str> = one.iter().chain(&five).map(String::as_str).collect();
    let held_out = three.each_ref().map(String::as_str);
    let (diagnosis, before, after) = diagnosed(&folder, &training, &held_out);
    finds_the_hoses(&diagnosis);
    assert!(after > before + 8.0, "{before} {after}");
}

#[test]
fn the_comparison_of_a_real_drive_prints_its_table() {
    let Some(folder) = recordings() else { return };
    let (machine, recording) = (machine(), folder.join("load3-stroke3.csv"));
    let printed = done(&["compare", "--machine", text(&machine), "--recording", text(&recording)]);
    println!("{printed}");
    assert!(printed.contains("position") && printed.contains("end to end"), "{printed}");
}
