//! What happens once is a disturbance, not physics.

use host_sim::diagnose::Verdict;
use host_sim::testbed::{LoadProfile, PlantEffect};

use super::bed::{claimed, valve_case};

/// 3 kN against the rod for 0.4 s, as by a hand truck.
fn push() -> LoadProfile {
    LoadProfile::through(vec![(0.8, 0.0), (0.85, -3000.0), (1.25, -3000.0), (1.3, 0.0)]).unwrap()
}

#[test]
fn a_push_in_one_recording_is_located_there_and_not_called_physics() {
    let diagnosis = valve_case(11, None, true, Some(&(1, push()))).diagnose();
    assert_eq!(claimed(&diagnosis), "none");
    assert_eq!(diagnosis.verdict, Verdict::Unexplained);
    let located = diagnosis.located.unwrap();
    let inside = |interval: &host_sim::locate::Interval| {
        interval.recording == "train-2.csv" && interval.from_s < 1.3 && interval.to_s > 0.8
    };
    assert!(located.intervals.iter().any(inside), "{located:?}");
}

#[test]
fn a_push_in_one_recording_does_not_hide_an_effect_that_all_of_them_show() {
    let leak = PlantEffect::internal_leakage(4e-12);
    let diagnosis = valve_case(12, Some(leak), true, Some(&(0, push()))).diagnose();
    let found = claimed(&diagnosis);
    assert!(found == "internal-leakage" || found == "none", "{found}");
}
