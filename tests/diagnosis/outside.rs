//! Causes outside the drive: said as what they are, and never a finding.

use diagnosis::outside::{Cause, Outside};
use diagnosis::{Diagnosis, Verdict};
use virtual_plant::{LoadEffect, LoadProfile, PlantEffect};

use super::bed::{Case, accepted, valve_case, valve_case_loaded};
use super::once::push;

/// With a load in each recording, position and pressures recorded.
fn loaded(seed: u64, load: impl Fn(usize) -> LoadProfile) -> Case {
    valve_case_loaded(2e-3, seed, &[], load, |made, name| made.rounded().to_recording(name).unwrap())
}

/// No effect is named, and this cause is.
fn outside(diagnosis: &Diagnosis) -> &Outside {
    assert_eq!((accepted(diagnosis).as_str(), diagnosis.verdict), ("none", Verdict::Unexplained));
    let outside = diagnosis.outside.as_ref().unwrap();
    println!("{outside:?}");
    outside
}

#[test]
fn a_push_is_told_with_its_time_and_its_force() {
    let diagnosis = valve_case(11, None, true, Some(&(1, push()))).diagnose();
    let Cause::Push(pushes) = &outside(&diagnosis).cause else { panic!("{:?}", diagnosis.outside) };
    assert_eq!(pushes.len(), 1);
    let push = &pushes[0];
    assert_eq!(push.recording, "train-2.csv");
    assert!((push.from_s - 0.8).abs() < 0.1 && (push.to_s - 1.3).abs() < 0.1, "{push:?}");
    assert!((push.mean_n / -2700.0 - 1.0).abs() < 0.15, "{push:?}");
    // 3 kN for 0.4 s, and two ramps of 50 ms.
    assert!((push.impulse_n_s / -1350.0 - 1.0).abs() < 0.1, "{push:?}");
}

#[test]
fn a_periodic_force_is_told_with_its_frequency_and_confirmed() {
    let (hertz, force_n) = (9.3, 1500.0);
    let wave = |index: usize| {
        let at = |step: i32| {
            let time_s = -1.0 + 2.5e-3 * f64::from(step);
            (time_s, force_n * (std::f64::consts::TAU * (hertz * time_s + 0.31 * index as f64)).sin())
        };
        LoadProfile::through((0..3000).map(at).collect()).unwrap()
    };
    let diagnosis = loaded(21, wave).diagnose();
    let outside = outside(&diagnosis);
    let Cause::Periodic { hz, amplitude_n } = &outside.cause else { panic!("{outside:?}") };
    assert!((hz / hertz - 1.0).abs() < 0.01, "{hz}");
    assert!(amplitude_n.iter().all(|(_, amplitude_n)| (amplitude_n / force_n - 1.0).abs() < 0.15), "{amplitude_n:?}");
    assert!(outside.explains > 0.9 && outside.explains_held_out.unwrap() > 0.7, "{outside:?}");
}

#[test]
fn another_load_in_each_recording_is_told_with_its_differences() {
    let loads_n = [1200.0, -900.0, 400.0, -1500.0, 800.0, -300.0];
    let diagnosis = loaded(22, |index| LoadProfile::through(vec![(0.0, loads_n[index])]).unwrap()).diagnose();
    let outside = outside(&diagnosis);
    let Cause::Load(found) = &outside.cause else { panic!("{outside:?}") };
    // What all have in common is the load of the machine file.
    let apart = |of: &[f64]| -> Vec<f64> { of.iter().map(|one| one - of[0]).collect() };
    let found: Vec<f64> = found.iter().map(|(_, force_n)| *force_n).collect();
    let pairs = apart(&found).into_iter().zip(apart(&loads_n[..4]));
    assert!(pairs.clone().all(|(found, put)| (found - put).abs() < 150.0), "{:?}", pairs.collect::<Vec<_>>());
}

#[test]
fn a_structure_that_rings_is_told_with_its_frequency() {
    let hung = PlantEffect::Load(LoadEffect::HungMass { mass_kg: 800.0, frequency_hz: 9.0, damping: 0.03 });
    let diagnosis = valve_case(23, Some(hung), true, None).diagnose();
    let outside = outside(&diagnosis);
    let Cause::Structure { hz, mass_kg, .. } = outside.cause else { panic!("{outside:?}") };
    assert!((hz / 9.0 - 1.0).abs() < 0.05 && (mass_kg / 800.0 - 1.0).abs() < 0.25, "{outside:?}");
}

#[test]
fn a_drive_whose_physics_is_named_has_no_cause_outside() {
    let diagnosis = valve_case(24, Some(PlantEffect::coulomb_friction(900.0)), true, None).diagnose();
    assert_eq!((accepted(&diagnosis).as_str(), diagnosis.outside), ("coulomb-friction", None));
}
