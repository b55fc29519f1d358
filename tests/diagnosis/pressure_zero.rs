//! Pressures that were read by absolute sensors.

use diagnosis::{Verdict, read_absolute};
use recording::{ATMOSPHERE_PA, Recording, Signal};
use virtual_plant::PlantEffect;

use super::bed::{Case, valve_case};

/// Every recording with this much more on some pressures.
fn raised(case: &mut Case, signals: &[Signal], by_pa: f64) {
    for recording in case.training.iter_mut().chain(&mut case.held_out) {
        for &signal in signals {
            let read: Vec<f64> = recording.signal(signal).unwrap().iter().map(|pa| pa + by_pa).collect();
            recording.replace(signal, &read);
        }
    }
}

fn is_absolute(case: &Case) -> bool {
    read_absolute(&case.file, &case.training, None).unwrap()
}

#[test]
fn absolute_sensors_are_found_and_without_the_air_nothing_is_missing() {
    let mut case = valve_case(2, None, true, None);
    assert!(!is_absolute(&case));
    raised(&mut case, &[Signal::PressureA, Signal::PressureB], ATMOSPHERE_PA);
    assert!(is_absolute(&case));
    case.training.iter_mut().chain(&mut case.held_out).for_each(Recording::take_as_absolute);
    assert_eq!(case.diagnose().verdict, Verdict::NothingMissing);
}

#[test]
fn one_sensors_offset_and_a_missing_force_are_no_absolute_sensors() {
    for (signal, by_pa) in [(Signal::PressureA, 1.0e5), (Signal::PressureA, 2.5e5), (Signal::PressureB, 1.5e5)] {
        let mut case = valve_case(4, None, true, None);
        raised(&mut case, &[signal], by_pa);
        assert!(!is_absolute(&case), "{signal} {by_pa}");
    }
    for force_n in [80.0, 200.0, 500.0] {
        let case = valve_case(5, Some(PlantEffect::coulomb_friction(force_n)), true, None);
        assert!(!is_absolute(&case), "{force_n}");
    }
}
