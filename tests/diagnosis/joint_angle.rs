//! A drive whose position is the angle of a joint: the same answer as from a sensor at the rod, by the sides of the linkage and by a table.

use std::fmt::Write as _;

use rayon::prelude::*;

use diagnosis::Verdict;
use identification::experiment::Prepared;
use machine_file::MachineFile;
use model_core::machine::Parameter as P;
use recording::{Note, Recording, Signal, read_from};
use virtual_plant::{PlantEffect, SyntheticRecording};

use super::bed::{Case, accepted, valve_case, valve_case_as};
use super::root;

/// Sides of the linkage, m: at the retracted end the joint turns 2.3 times as far for a millimetre as at the other.
const BASE_M: f64 = 0.5;
const ARM_M: f64 = 0.35;
const RETRACTED_M: f64 = 0.16;
/// Between the sides where the encoder reads 0, which falls as the rod extends; rad.
const ZERO_RAD: f64 = 0.2;
/// Steps of the encoder in a turn: 15 bits are 20 to 60 µm of the rod, 12 bits 0.2 to 0.5 mm.
const FINE: f64 = 32_768.0;
const COARSE: f64 = 4096.0;

/// The angle that an ideal encoder reads, deg; the law of cosines in this file's own words.
fn angle_deg(position_m: f64) -> f64 {
    let length_m = RETRACTED_M + position_m;
    let cosine = (BASE_M.powi(2) + ARM_M.powi(2) - length_m.powi(2)) / (2.0 * BASE_M * ARM_M);
    (ZERO_RAD - cosine.acos()).to_degrees()
}

/// The press with this linkage, by its sides.
fn by_sides() -> MachineFile {
    with(&format!(
        "base_m = {BASE_M}\narm_m = {ARM_M}\nlength_retracted_m = {RETRACTED_M}\nangle_at_zero_rad = {ZERO_RAD}\n\
         angle_rises = \"retracting\"\n"
    ))
}

/// The press with a table of the same linkage, an entry every 10 mm.
fn by_table() -> MachineFile {
    let positions: Vec<f64> = (0..=30).map(|k| 0.01 * f64::from(k)).collect();
    let angles: Vec<f64> = positions.iter().map(|position| (1e3 * angle_deg(*position)).round() * 1e-3).collect();
    with(&format!("angles_deg = {angles:?}\npositions_m = {positions:?}\n"))
}

fn with(linkage: &str) -> MachineFile {
    let press = std::fs::read_to_string(root().join("examples/press-63-40/machine.toml")).unwrap();
    machine_file::read_text("machine.toml", &format!("{press}\n[linkage]\n{linkage}")).unwrap()
}

/// What a logger writes of a drive with such an encoder.
fn logged(made: SyntheticRecording, steps: f64, name: &str, file: &MachineFile) -> Recording {
    let made = made.rounded();
    let sensed = made.clone().to_recording(name).unwrap();
    let column = |signal| sensed.signal(signal).unwrap();
    let [time, command, spool, a, b] =
        [Signal::Time, Signal::Command, Signal::Spool, Signal::PressureA, Signal::PressureB].map(column);
    let mut text = "time [s],command [V],spool [1],angle [deg],pressure_a [Pa],pressure_b [Pa]\n".to_owned();
    for (row, state) in made.truth.iter().enumerate() {
        let read = (angle_deg(state.position_m) * steps / 360.0).round() * 360.0 / steps;
        writeln!(text, "{},{},{},{read:.5},{},{}", time[row], command[row], spool[row], a[row], b[row]).unwrap();
    }
    read_from(name, text.as_bytes(), &file.channels).unwrap()
}

fn case(file: &MachineFile, steps: f64, seed: u64, effect: Option<PlantEffect>) -> Case {
    let case = valve_case_as(2e-3, seed, effect, None, |made, name| logged(made, steps, name, file));
    Case { file: file.clone(), ..case }
}

/// The bound is the one of two recordings with sensors of this kind: 2 %, a few standard deviations of the parameter.
#[test]
fn a_joint_angle_gives_the_finding_and_the_size_that_the_position_gives() {
    let draws = [
        ("none", 0.0, 1, P::InternalLeakage),
        ("internal-leakage", 3e-12, 3, P::InternalLeakage),
        ("coulomb-friction", 600.0, 4, P::CoulombFriction),
    ];
    let cases: Vec<(usize, &str, Case)> = draws
        .iter()
        .enumerate()
        .flat_map(|(draw, &(name, amount, seed, _))| {
            let effect = || PlantEffect::named(name, amount);
            [
                (draw, "position", valve_case(seed, effect(), true, None)),
                (draw, "sides", case(&by_sides(), FINE, seed, effect())),
                (draw, "table", case(&by_table(), FINE, seed, effect())),
            ]
        })
        .collect();
    let found: Vec<_> = cases.par_iter().map(|(draw, by, case)| (*draw, *by, case.diagnose())).collect();
    for (draw, (name, _, _, parameter)) in draws.iter().enumerate() {
        let of = |wanted: &str| &found.iter().find(|(of, by, _)| (*of, *by) == (draw, wanted)).unwrap().2;
        let by_position = of("position").machine_after.get(*parameter);
        for by in ["position", "sides", "table"] {
            let (diagnosis, value) = (of(by), of(by).machine_after.get(*parameter));
            println!("{name} by {by}: {}, {:?}, {value:.5e}", accepted(diagnosis), diagnosis.verdict);
            assert_eq!(accepted(diagnosis), *name, "{by}");
            assert_eq!(diagnosis.verdict == Verdict::NothingMissing, *name == "none", "{by}: {:?}", diagnosis.verdict);
            assert!((value - by_position).abs() <= 0.02 * by_position.abs(), "{name} by {by}: {value}, {by_position}");
        }
    }
}

#[test]
fn a_coarse_encoder_hides_nothing_and_makes_nothing_up() {
    for (name, amount, seed) in [("none", 0.0, 1), ("internal-leakage", 3e-12, 3)] {
        let diagnosis = case(&by_sides(), COARSE, seed, PlantEffect::named(name, amount)).diagnose();
        println!("{name}: {}, {:?}", accepted(&diagnosis), diagnosis.verdict);
        assert_eq!(accepted(&diagnosis), name);
    }
}

/// The noise of the position is that of rounding the angle, though its steps grow along the stroke, and every recording says where it comes from.
#[test]
fn the_noise_of_the_position_is_that_of_the_encoders_rounding() {
    for steps in [FINE, COARSE] {
        let case = case(&by_sides(), steps, 1, None);
        for recording in &case.training {
            assert!(recording.notes().contains(&Note::PositionFromAngle));
            let prepared = Prepared::new(recording, &case.file.machine, case.file.load_source, None).unwrap();
            let channel = prepared.channels.iter().find(|channel| channel.signal == Signal::Position).unwrap();
            let slope = |y: &f64| 1e-6 / (angle_deg(y + 1e-6) - angle_deg(*y)).abs();
            let squares: f64 = channel.recorded.iter().map(|y| (slope(y) * 360.0 / steps).powi(2)).sum();
            let rounding = (squares / 12.0 / channel.recorded.len() as f64).sqrt();
            println!("{}: {:.2} of the rounding, {rounding:.1e} m", recording.name(), channel.own_noise() / rounding);
            assert!((0.7..1.4).contains(&(channel.own_noise() / rounding)), "{}", recording.name());
        }
    }
}

#[test]
fn the_linkages_of_the_book_are_read() {
    let page = std::fs::read_to_string(root().join("docs/diagnosis.md")).unwrap();
    let blocks: Vec<&str> =
        page.split("```toml\n[linkage]\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert_eq!(blocks.len(), 2);
    for block in blocks {
        assert!(with(block).channels.linkage.is_some(), "{block}");
    }
}
