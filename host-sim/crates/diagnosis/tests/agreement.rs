//! Recordings and a machine file that do not belong together are told apart from drives that only lack physics.

use std::path::Path;

use diagnosis::agreement::{Change, Doubt, doubts};
use diagnosis::base_parameters;
use recording::Signal;
use recording::seeded_noise::Noise;

/// The shipped example with these changes in all of its recordings.
fn with(changes: &[Change]) -> Vec<Doubt> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../examples/press-63-40");
    let (file, mut recordings) = test_press::folder(&folder);
    for recording in &mut recordings {
        for change in changes {
            *recording = change.of(recording, &file.machine);
        }
    }
    doubts(&file, &base_parameters(&file), &recordings.iter().collect::<Vec<_>>()).unwrap()
}

/// The one doubt, which has to be certain, and the changes that it tells.
fn certain(changes: &[Change]) -> Vec<Change> {
    let found = with(changes);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].is_certain, "{found:#?}");
    found[0].changed.changes.clone()
}

#[test]
fn an_example_that_lacks_physics_raises_no_doubt() {
    assert_eq!(with(&[]), []);
}

#[test]
fn what_runs_the_other_way_is_told() {
    for signal in [Signal::Position, Signal::Command, Signal::Spool] {
        assert_eq!(certain(&[Change::Reversed(signal)]), [Change::Reversed(signal)]);
    }
    assert_eq!(certain(&[Change::PressuresExchanged]), [Change::PressuresExchanged]);
}

#[test]
fn a_wrong_scale_is_told_although_a_refit_follows_much_of_it() {
    for (signal, factor) in [
        (Signal::Position, 0.1),
        (Signal::Position, 10.0),
        (Signal::Position, 1e-3),
        (Signal::Command, 0.1),
        (Signal::Command, 10.0),
        (Signal::Command, 1e3),
        (Signal::Spool, 100.0),
        (Signal::PressureA, 0.1),
        (Signal::PressureA, 1e5),
    ] {
        let found = certain(&[Change::Scaled(signal, factor)]);
        let [Change::Scaled(told, by)] = found[..] else { panic!("{found:?}") };
        assert!(told == signal && (by * factor - 1.0).abs() < 1e-9, "{signal} {factor}: {found:?}");
    }
}

#[test]
fn two_factors_that_were_left_out_are_told_together() {
    let left_out = [Change::Scaled(Signal::Position, 1e-3), Change::Scaled(Signal::PressureA, 1e5)];
    let found = certain(&left_out);
    assert_eq!(found, [Change::Scaled(Signal::PressureA, 1e-5), Change::Scaled(Signal::Position, 1e3)]);
}

#[test]
fn a_tenth_of_a_position_is_told_where_it_hardly_exceeds_its_noise() {
    // A refit follows it within the noise, by a tenfold bulk modulus and friction and a tenth of the flow.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../examples/press-63-40");
    let (file, mut recordings) = test_press::folder(&folder);
    for recording in &mut recordings {
        let mut noise = Noise::new(5, 1);
        let noisy: Vec<f64> = recording
            .signal(Signal::Position)
            .unwrap()
            .iter()
            .map(|value| 0.1 * value + noise.gaussian(2e-5))
            .collect();
        recording.replace(Signal::Position, &noisy);
    }
    let found = doubts(&file, &base_parameters(&file), &recordings.iter().collect::<Vec<_>>()).unwrap();
    assert!(found.len() == 1 && found[0].is_certain, "{found:#?}");
    assert_eq!(found[0].changed.changes, [Change::Scaled(Signal::Position, 10.0)]);
}

/// What is doubtful about the example where its machine file has the areas of another cylinder.
fn stated_as(bore_mm: f64, rod_mm: f64) -> Vec<Doubt> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../examples/press-63-40");
    let (mut file, recordings) = test_press::folder(&folder);
    file.machine = Change::Cylinder { bore_mm, rod_mm }.on(&file.machine);
    doubts(&file, &base_parameters(&file), &recordings.iter().collect::<Vec<_>>()).unwrap()
}

#[test]
fn areas_of_another_cylinder_are_told_by_the_pressures_that_balance_its_load() {
    for (bore_mm, rod_mm) in [(63.0, 28.0), (63.0, 45.0), (50.0, 22.0), (80.0, 36.0)] {
        let found = stated_as(bore_mm, rod_mm);
        let of = |doubt: &Doubt| doubt.changed.changes.clone();
        let cylinders: Vec<Change> = found.iter().flat_map(of).collect();
        assert!(
            cylinders.contains(&Change::Cylinder { bore_mm: 63.0, rod_mm: 40.0 }),
            "{bore_mm}/{rod_mm}: {found:#?}"
        );
    }
    assert_eq!(stated_as(63.0, 40.0), []);
}
