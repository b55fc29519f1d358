//! Axes that a measured force moves, of equations of this file's own: their guides are rough, so no model follows them to the sensors' noise, and the free
//! run drifts for seconds after each newton that it lacks.

use std::f64::consts::TAU;

use diagnosis::{Diagnosis, Verdict, diagnose};
use machine_file::MachineFile;
use model_core::effects::Effect;
use model_core::machine::{Parameter, Source};
use recording::{ChannelMap, Column, Recording, Signal};
use report::evidence::Exhibits;
use report::plot::{Marks, RangeBin};

use super::bed::Dice;

/// An axis: a mass on a guide.
#[derive(Clone, Copy)]
struct Axis {
    mass_kg: f64,
    viscous_n_s_per_m: f64,
    coulomb_n: f64,
    /// What the guide's force differs by along the way.
    rough_n: f64,
    seed: u64,
}

impl Axis {
    /// Follows strokes of a trapezoidal speed under a position controller for eight seconds; time, measured force, position and velocity at 1 kHz.
    fn recorded(&self, run: u64, judged: &[Signal]) -> Recording {
        const STEP_S: f64 = 1e-4;
        let mut dice = Dice::new(self.seed);
        let waves: Vec<(f64, f64)> = [7e-3, 0.019, 0.053].map(|length| (length, dice.between(0.0, TAU))).to_vec();
        let mut dice = Dice::new(100 * self.seed + run);
        let strokes: Vec<(f64, f64)> = (0..8).map(|_| (dice.between(0.01, 0.24), dice.between(0.08, 0.35))).collect();
        let (mut at, mut v, mut wanted) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut rows = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for step in 0..80_000_u32 {
            let time_s = f64::from(step) * STEP_S;
            let (to, speed) = strokes[(step / 10_000) as usize];
            wanted += (to - wanted).clamp(-speed * STEP_S, speed * STEP_S);
            let applied = 1.5e4 * (wanted - at) - 900.0 * v;
            let rough = waves.iter().map(|(length, phase)| (TAU * at / length + phase).sin()).sum::<f64>();
            let pushed = applied - self.viscous_n_s_per_m * v - self.rough_n * rough / 1.2;
            if step % 10 == 0 {
                rows.0.push(time_s);
                rows.1.push(applied + dice.between(-0.5, 0.5));
                rows.2.push((at / 1e-6).round() * 1e-6);
                rows.3.push(v + dice.between(-2e-4, 2e-4));
            }
            if v.abs() < 1e-9 && pushed.abs() <= self.coulomb_n {
                v = 0.0;
            } else {
                let way = if v.abs() < 1e-9 { pushed.signum() } else { v.signum() };
                let next = v + (pushed - self.coulomb_n * way) / self.mass_kg * STEP_S;
                // Dry friction stops a rod and does not turn it.
                v = if next * v < 0.0 { 0.0 } else { next };
            }
            at += v * STEP_S;
        }
        let (time_s, force, position, velocity) = rows;
        let mut columns = vec![Column::si(Signal::Time, time_s), Column::si(Signal::Force, force)];
        for signal in judged {
            columns.push(Column::si(
                *signal,
                if *signal == Signal::Position { position.clone() } else { velocity.clone() },
            ));
        }
        Recording::new(&format!("run-{run}"), columns).unwrap()
    }

    /// Two recordings to train on, and two that are held out.
    fn recordings(&self, judged: &[Signal]) -> [[Recording; 2]; 2] {
        [[1, 2], [3, 4]].map(|runs| runs.map(|run| self.recorded(run, judged)))
    }

    fn diagnosed(&self, file: &MachineFile, judged: &[Signal]) -> Diagnosis {
        let [training, held_out] = self.recordings(judged);
        diagnose(file, &training, &held_out, None, &|_| {}).unwrap()
    }
}

fn sheet() -> String {
    std::fs::read_to_string(super::root().join("tests/diagnosis/axis.toml")).unwrap()
}

/// A machine file in which viscous friction is guessed.
fn file(viscous_n_s_per_m: f64) -> MachineFile {
    machine_file::read_text("axis.toml", &sheet().replace("= 250.0", &format!("= {viscous_n_s_per_m:?}"))).unwrap()
}

/// The names of the findings, and dry friction, viscous friction and mass after them.
fn found(diagnosis: &Diagnosis) -> (Vec<&'static str>, [f64; 3]) {
    let value = |parameter| diagnosis.machine_after.get(parameter);
    let values = [Parameter::CoulombFriction, Parameter::ViscousFriction, Parameter::MovingMass].map(value);
    (diagnosis.findings.iter().map(|finding| finding.effect.name).collect(), values)
}

/// Standard deviations of dry friction, viscous friction and mass.
fn deviations(diagnosis: &Diagnosis) -> [f64; 3] {
    let estimates =
        || diagnosis.refitted.iter().chain(diagnosis.findings.iter().flat_map(|finding| &finding.parameters));
    let of =
        |parameter| estimates().find(|estimate| estimate.parameter == parameter).map_or(0.0, |estimate| estimate.std);
    [Parameter::CoulombFriction, Parameter::ViscousFriction, Parameter::MovingMass].map(of)
}

const RUBS: Axis = Axis { mass_kg: 90.0, viscous_n_s_per_m: 210.0, coulomb_n: 22.0, rough_n: 1.5, seed: 5 };

#[test]
fn dry_friction_of_a_rough_guide_is_told_from_position_velocity_or_both_and_from_any_guess_of_the_viscous_one() {
    let both = [Signal::Position, Signal::Velocity];
    for (judged, guessed) in [(&both[..1], 90.0), (&both[..1], 400.0), (&both[1..], 250.0), (&both[..], 250.0)] {
        let diagnosis = RUBS.diagnosed(&file(guessed), judged);
        let (names, found) = found(&diagnosis);
        println!("{judged:?}, {guessed} N s/m: {names:?}, {found:.1?}");
        assert_eq!(names, ["coulomb-friction"], "{judged:?}");
        // Both frictions trade against each other: where the recordings leave more open, within two standard deviations.
        let truths = [RUBS.coulomb_n, RUBS.viscous_n_s_per_m, RUBS.mass_kg];
        for ((found, truth), std) in found.into_iter().zip(truths).zip(deviations(&diagnosis)) {
            let most = (0.06 * truth).max(2.0 * std);
            assert!((found - truth).abs() < most, "{judged:?}, {guessed} N s/m: {found} ± {std} instead of {truth}");
        }
    }
}

/// The measured force less that of mass and viscous friction is what the guide brakes with, and the page draws it without any pressure.
#[test]
fn the_picture_of_friction_below_a_measured_force_shows_what_was_recorded() {
    let file = file(250.0);
    let [training, held_out] = RUBS.recordings(&[Signal::Position]);
    let diagnosis = diagnose(&file, &training, &held_out, None, &|_| {}).unwrap();
    let exhibits = Exhibits::of(&file, &training, &held_out, &diagnosis, true).unwrap();
    let picture = exhibits.pictures.iter().find(|picture| picture.effect == "coulomb-friction").unwrap();
    let bins: Vec<&RangeBin> = picture
        .figure
        .layers
        .iter()
        .filter_map(|layer| if let Marks::Bins(bins) = &layer.marks { Some(bins) } else { None })
        .flatten()
        .filter(|bin| bin.x.abs() > 40.0)
        .collect();
    assert!(bins.len() > 4, "{picture:?}");
    for bin in bins {
        assert!((bin.quartiles[1] - RUBS.coulomb_n * bin.x.signum()).abs() < 4.0, "{bin:?}");
    }
    assert!(!picture.caption.contains("lack a channel") && diagnosis.level_at_rest.is_none(), "{}", picture.caption);
}

#[test]
fn a_rough_guide_without_dry_friction_is_not_said_to_have_any() {
    for seed in 1..=4 {
        let rough_n = if seed % 2 == 0 { 3.0 } else { 1.5 };
        let axis = Axis { coulomb_n: 0.0, rough_n, seed, ..RUBS };
        let diagnosis = axis.diagnosed(&file(250.0), &[Signal::Position]);
        let names: Vec<&str> = diagnosis.findings.iter().map(|finding| finding.effect.name).collect();
        println!("seed {seed}: {names:?}, {:?}", diagnosis.verdict);
        assert_ne!(diagnosis.verdict, Verdict::MissingPhysics, "seed {seed}: {names:?}");
    }
}

/// What a machine file needs of a cylinder for both its pressures to be the force, and of a valve-controlled drive around it.
const AREAS: &str = "area_a_m2 = 1e-3\narea_b_m2 = 8e-4\n";
const HYDRAULICS: &str = "[supply]\npressure_pa = 1e6\n[valve]\ngain_per_v = 0.1\n";

/// The same answer from a force, from the two pressures that make it, and with a valve and a supply in the file that take no part.
#[test]
fn a_valve_that_takes_no_part_and_pressures_in_place_of_the_force_change_no_answer() {
    let with_areas = sheet().replace("stroke_m", &format!("{AREAS}stroke_m"));
    let hydraulic = with_areas.replace("[cylinder]", &format!("{HYDRAULICS}[cylinder]"));
    let read = |text: &str| machine_file::read_text("axis.toml", text).unwrap();
    let [training, held_out] = RUBS.recordings(&[Signal::Position]);
    let by_pressures = |recording: &Recording| {
        const PRESSURE_B_PA: f64 = 2e6;
        let force = recording.signal(Signal::Force).unwrap();
        let pressure_a = force.iter().map(|force_n| (force_n + 8e-4 * PRESSURE_B_PA) / 1e-3).collect();
        let as_recorded = |signal| Column::si(signal, recording.signal(signal).unwrap().to_vec());
        let pressure_b = vec![PRESSURE_B_PA; force.len()];
        let pressures = [Column::si(Signal::PressureA, pressure_a), Column::si(Signal::PressureB, pressure_b)];
        let columns = [as_recorded(Signal::Time)].into_iter().chain(pressures).chain([as_recorded(Signal::Position)]);
        Recording::new(recording.name(), columns.collect()).unwrap()
    };
    let diagnosis = diagnose(&read(&sheet()), &training, &held_out, None, &|_| {}).unwrap();
    let (alone, deviations) = (found(&diagnosis), deviations(&diagnosis));
    let beside = found(&diagnose(&read(&hydraulic), &training, &held_out, None, &|_| {}).unwrap());
    let [training, held_out] = [training, held_out].map(|recordings| recordings.map(|one| by_pressures(&one)));
    let pressures = found(&diagnose(&read(&with_areas), &training, &held_out, None, &|_| {}).unwrap());
    println!("{alone:.3?}, {beside:.3?}, {pressures:.3?}");
    for (names, values) in [beside, pressures] {
        assert_eq!(names, ["coulomb-friction"]);
        for ((value, expected), std) in values.into_iter().zip(alone.1).zip(deviations) {
            assert!((value - expected).abs() < std, "{value} instead of {expected} ± {std}");
        }
    }
    // Pressures without areas are no force.
    let refused = diagnose(&read(&sheet()), &training, &held_out, None, &|_| {}).unwrap_err().to_string();
    assert!(refused.contains("cylinder.area_a_m2") && refused.contains("`force`"), "{refused}");
}

#[test]
fn of_an_axis_no_effect_of_valve_and_oil_is_tried_or_listed_and_no_word_of_them_is_told() {
    let file = file(250.0);
    let [training, held_out] = RUBS.recordings(&[Signal::Position]);
    let diagnosis = diagnose(&file, &training, &held_out, None, &|_| {}).unwrap();
    let tried = diagnosis.selection.rounds.iter().flatten().flat_map(|trial| &trial.effects);
    let foreign: Vec<&str> = tried
        .chain(&diagnosis.not_testable)
        .filter(|effect| !Source::Force.has_effect(Effect::named(effect.name).unwrap()))
        .map(|effect| effect.name)
        .collect();
    assert_eq!(foreign, Vec::<&str>::new());
    let exhibits = Exhibits::of(&file, &training, &held_out, &diagnosis, true).unwrap();
    let told = report::terminal::text(&diagnosis, &exhibits);
    for word in ["valve", "pressure", "supply", "spool", "leakage", "full force", "full flow"] {
        assert!(!told.contains(word), "{word}: {told}");
    }
    assert!(told.contains("size       2") && told.contains("constant-speed strokes below 10 mm/s"), "{told}");
}

/// A machine file of each benchmark, as a user would write it.
const EMPS: &str = "[cylinder]\nmoving_mass_kg = 95.0\nviscous_friction_n_s_per_m = 288.557\n[fit.sigma]\n\"cylinder.moving_mass_kg\" = 20.0\n\
    \"cylinder.viscous_friction_n_s_per_m\" = 200.0\n\"load.force_n\" = 10.0\n";
const RACK: &str = "[cylinder]\nmoving_mass_kg = 24.7\nviscous_friction_n_s_per_m = 60.0\n[fit.sigma]\n\"cylinder.moving_mass_kg\" = 1.2\n\
    \"cylinder.viscous_friction_n_s_per_m\" = 60.0\n";

/// The published values of two benchmarks of friction, see `../shared/data/README.md`, with and without the fictitious valve of their files there.
#[test]
fn friction_of_real_axes_is_as_published_in_every_form_of_the_recordings() {
    let read = |folder: &std::path::Path, names: &[&str]| -> Vec<Recording> {
        let of = |name: &&str| recording::read(&folder.join(name), &ChannelMap::default()).unwrap();
        names.iter().map(of).collect()
    };
    if let Some(folder) = system_tests::at_hand::shared("data/emps") {
        let with_valve = std::fs::read_to_string(folder.join("load3.toml")).unwrap();
        let (training, held_out) = (["tz-1.csv", "tz-2.csv", "tz-3.csv"], ["hz-1.csv", "hz-2.csv", "hz-3.csv"]);
        let (training, held_out) = (read(&folder, &training), read(&folder, &held_out));
        for (sheet, guessed) in [(EMPS, "87.0"), (EMPS, "203.0"), (EMPS, "400.0"), (&*with_valve, "400.0")] {
            let file = machine_file::read_text("emps.toml", &sheet.replace("288.557", guessed)).unwrap();
            let diagnosis = diagnose(&file, &training, &held_out, None, &|_| {}).unwrap();
            let (names, found) = found(&diagnosis);
            let fit = diagnosis.mean_fits(true, true)["position"];
            println!("emps, {:?}, from {guessed} N s/m: {found:.2?}, held out {fit:.2} %", file.machine.source);
            assert_eq!(names, ["coulomb-friction"]);
            for (found, published) in found.into_iter().zip([20.39, 203.5, 95.11]) {
                assert!((found / published - 1.0).abs() < 0.06, "{found} instead of {published}");
            }
            assert!(fit >= 91.0, "{fit}");
        }
    }
    if let Some(folder) = system_tests::at_hand::shared("data/rack") {
        let with_valve = std::fs::read_to_string(folder.join("m.toml")).unwrap();
        for (sheet, name) in [(RACK, "rack.csv"), (RACK, "vel.csv"), (RACK, "pos.csv"), (&*with_valve, "rack.csv")] {
            let file = machine_file::read_text("rack.toml", sheet).unwrap();
            let diagnosis = diagnose(&file, &read(&folder, &[name]), &[], None, &|_| {}).unwrap();
            let (names, [friction_n, ..]) = found(&diagnosis);
            println!("rack, {:?}, {name}: Coulomb friction {friction_n:.2} N", file.machine.source);
            assert_eq!(names, ["coulomb-friction"]);
            assert!((17.0..19.0).contains(&friction_n), "{name}: {friction_n}");
        }
    }
}
