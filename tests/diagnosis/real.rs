//! The pump-controlled cylinder with 1–2 m of hose, measured on a real rig by others.

use std::path::{Path, PathBuf};
use std::time::Instant;

use diagnosis::{Diagnosis, Shown, diagnose};
use recording::{ChannelMap, Recording, Signal};

use super::{done, root, text};

/// The recordings: `$HOST_SIM_SHARED/data/eha`, or beside the repository. Prints a reason where they are absent.
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

/// Results for the position on the held-out recordings, before and after.
struct HeldOut {
    /// Mean NRMSE fit, %.
    fit_percent: [f64; 2],
    /// RMSE of the first extension and hold of each recording, mm.
    first_mm: Vec<[f64; 2]>,
}

/// Diagnoses with these recordings and prints the figures.
fn diagnosed(folder: &Path, training: &[&str], held_out: &[&str]) -> (Diagnosis, HeldOut) {
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
    let mut first_mm = Vec::new();
    for (recording, shown) in held_out.iter().zip(diagnosis.shown.iter().filter(|shown| shown.held_out)) {
        let [before, after] = [false, true].map(|after| first_extension_mm(recording, shown, after));
        println!("{}, first extension and hold: {before:.2} mm → {after:.2} mm", recording.name());
        first_mm.push([before, after]);
    }
    (diagnosis, HeldOut { fit_percent: [before, after], first_mm })
}

fn finds_the_hoses(diagnosis: &Diagnosis) {
    let found: Vec<&str> = diagnosis.findings.iter().map(|finding| finding.effect.name).collect();
    assert!(found.contains(&"hose-compliance"), "{found:?}");
}

/// Trained on every stroke at loads 1 and 5, held out at load 3.
#[test]
fn the_hoses_of_a_real_drive_are_found_and_held_out_loads_are_followed_within_half_a_millimetre() {
    let Some(folder) = recordings() else { return };
    let of = |load: u8| [1, 2, 3, 4].map(|stroke| format!("load{load}-stroke{stroke}"));
    let (one, three, five) = (of(1), of(3), of(5));
    let training: Vec<&str> = one.iter().chain(&five).map(String::as_str).collect();
    let held_out = three.each_ref().map(String::as_str);
    let (diagnosis, told) = diagnosed(&folder, &training, &held_out);
    finds_the_hoses(&diagnosis);
    let pooled = |when: usize| {
        (told.first_mm.iter().map(|mm| mm[when].powi(2)).sum::<f64>() / told.first_mm.len() as f64).sqrt()
    };
    println!("all four: {:.2} mm → {:.2} mm", pooled(0), pooled(1));
    assert!(pooled(1) <= 0.5, "{:?}", told.first_mm);
    assert!(told.first_mm.iter().all(|mm| mm[1] < 0.6), "{:?}", told.first_mm);
    assert!(told.fit_percent[1] > told.fit_percent[0] + 3.0, "{:?}", told.fit_percent);
}

/// Half the recordings must give an equally good result:
/// `cargo test --release -p system-tests --test diagnosis two_strokes -- --ignored --nocapture`
#[test]
#[ignore = "not reached: of compliance and leakage together the first is dropped, though it alone does better"]
fn two_strokes_at_each_load_tell_of_the_hoses() {
    let Some(folder) = recordings() else { return };
    let training = ["load1-stroke2", "load1-stroke3", "load5-stroke2", "load5-stroke3"];
    let (diagnosis, _) = diagnosed(&folder, &training, &["load3-stroke2", "load3-stroke3"]);
    finds_the_hoses(&diagnosis);
}

#[test]
fn the_comparison_of_a_real_drive_prints_its_table() {
    let Some(folder) = recordings() else { return };
    let (machine, recording) = (machine(), folder.join("load3-stroke3.csv"));
    let printed = done(&["compare", "--machine", text(&machine), "--recording", text(&recording)]);
    println!("{printed}");
    assert!(printed.contains("position") && printed.contains("end to end"), "{printed}");
}
