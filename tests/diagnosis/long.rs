//! Long recordings: searched on their first minute, judged as a whole.

use std::time::Instant;

use diagnosis::selection::excerpt::{AFFORDABLE_TICKS, Excerpt};
use model_core::machine::Parameter as P;
use recording::Recording;
use recording::excitation::signals::Excitation;
use virtual_plant::sensor::sensors::PositionSensor;
use virtual_plant::{Bench, Drive, InitialState, Plant, PlantEffect, Sensors, truth_near};

use super::bed::{Case, accepted, press};

/// The leakage that was put in, m³/s/Pa.
const LEAK: f64 = 2e-12;
/// Proportional control of the position, V/m.
const GAIN_V_PER_M: f64 = 80.0;

/// A press with internal leakage that a controller moves back and forth: steps within ±50 mm, each held for up to `rest_s`. Lengths
/// in s.
fn cycling(training_s: &[f64], held_out_s: &[f64], rest_s: f64) -> Case {
    let file = press();
    let truth = truth_near(&file.machine, &file.sigma, 1.0, 7);
    let initial = InitialState::at_rest(&truth, 0.5 * truth.get(P::Stroke));
    let record = |(index, (prefix, duration_s)): (usize, (&str, f64))| {
        let plant = Plant::new(&truth, 1e-7).unwrap().with_effects(&[PlantEffect::internal_leakage(LEAK)]);
        let mut sensors = Sensors::with_position(&truth, PositionSensor::Linear { resolution_m: 2e-5 });
        sensors.spool.noise_std = 5e-4;
        let seed = 7000 + index as u64;
        let bench = Bench { tick_s: 1e-3, seed, ..Bench::new(plant, sensors) };
        let excitation = Excitation::Random { amplitude_v: 4.0, shortest_s: 0.3, longest_s: rest_s, duration_s, seed };
        let reference = excitation.sample(bench.tick_s).into_iter();
        let reference_m = reference.map(|volts| initial.position_m + volts / GAIN_V_PER_M).collect();
        let recording = bench.record(&Drive::Closed { reference_m, gain_v_per_m: GAIN_V_PER_M }, &initial).unwrap();
        recording.rounded().to_recording(&format!("{prefix}-{index}.csv")).unwrap()
    };
    let all =
        training_s.iter().map(|length| ("train", *length)).chain(held_out_s.iter().map(|length| ("holdout", *length)));
    let mut training: Vec<Recording> = all.enumerate().map(record).collect();
    let held_out = training.split_off(training_s.len());
    Case { file, training, held_out }
}

/// Runs the diagnosis; returns how long it took, s.
fn leakage_is_named(case: &Case) -> f64 {
    let start = Instant::now();
    let diagnosis = case.diagnose();
    let ticks: usize = diagnosis.shown.iter().map(|shown| shown.prepared.stimulus.ticks()).sum();
    let took_s = start.elapsed().as_secs_f64();
    println!("{:6.1} min of recording: {took_s:6.1} s", ticks as f64 / 6e4);
    assert_eq!(accepted(&diagnosis), "internal-leakage");
    let found = diagnosis.findings[0].parameters[0].value;
    assert!((found / LEAK - 1.0).abs() < 0.05, "{found:e}");
    // Every row is judged, not only the rows that were searched.
    for (shown, recording) in diagnosis.shown.iter().zip(case.training.iter().chain(&case.held_out)) {
        assert_eq!(shown.after.series[0].1.len(), recording.rows());
    }
    took_s
}

#[test]
fn an_effect_is_found_in_the_first_minute_of_five_and_confirmed_by_the_rest() {
    let case = cycling(&[150.0, 150.0], &[40.0], 2.0);
    let excerpt =
        Excerpt::of(&case.training, &case.prepared(&case.training), &case.file.machine, case.file.load_source).unwrap();
    let searched = excerpt.expect("five minutes are more than a search affords");
    assert!(searched.cases.iter().map(|case| case.stimulus.ticks()).sum::<usize>() < AFFORDABLE_TICKS / 4);
    leakage_is_named(&case);
}

/// An hour of recording takes less than two minutes on two cores, and at most six times as long as ten minutes do, waiting phases included:
/// `cargo test --release -p system-tests --test diagnosis an_hour -- --ignored --nocapture`
#[test]
#[ignore = "minutes: an hour of recording at 1 kHz, four times"]
fn an_hour_of_recording_is_diagnosed_in_minutes() {
    let ten_minutes_s = leakage_is_named(&cycling(&[400.0], &[200.0], 6.0));
    let hours = [(&[2400.0][..], &[1200.0][..]), (&[600.0; 4], &[600.0; 2]), (&[10.0; 240], &[10.0; 120])];
    for hour in hours.map(|(training, held_out)| cycling(training, held_out, 6.0)) {
        let hour_s = leakage_is_named(&hour);
        assert!(hour_s < 120.0 && hour_s < 6.0 * ten_minutes_s, "{hour_s} s, ten minutes {ten_minutes_s} s");
    }
}
