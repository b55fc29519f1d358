//! An event that happens once is a disturbance, not physics; and held-out recordings are used once, after the choice.

use diagnosis::{Verdict, diagnose};
use recording::Recording;
use virtual_plant::{LoadProfile, PlantEffect};

use super::bed::{accepted, valve_case};

/// 3 kN against the rod for 0.4 s, as by a hand truck.
pub(crate) fn push() -> LoadProfile {
    LoadProfile::through(vec![(0.8, 0.0), (0.85, -3000.0), (1.25, -3000.0), (1.3, 0.0)]).unwrap()
}

#[test]
fn a_push_in_one_recording_is_located_there_and_not_called_physics() {
    let diagnosis = valve_case(11, None, true, Some(&(1, push()))).diagnose();
    assert_eq!(accepted(&diagnosis), "none");
    assert_eq!(diagnosis.verdict, Verdict::Unexplained);
    let located = diagnosis.located.unwrap();
    let inside = |interval: &diagnosis::localisation::Interval| {
        interval.recording == "train-2.csv" && interval.from_s < 1.3 && interval.to_s > 0.8
    };
    assert!(located.intervals.iter().any(inside), "{located:?}");
}

/// True for this case, not in general: in other draws the push hides the leak (seed 13) or is itself taken for dry friction beside it (seed 15).
#[test]
fn a_leak_in_all_recordings_beside_a_push_in_one_is_named_alone_or_not_at_all() {
    let leak = PlantEffect::internal_leakage(4e-12);
    let diagnosis = valve_case(12, Some(leak), true, Some(&(0, push()))).diagnose();
    let found = accepted(&diagnosis);
    assert!(found == "internal-leakage" || found == "none", "{found}");
}

#[test]
fn what_is_held_out_helps_no_choice() {
    let case = valve_case(14, Some(PlantEffect::internal_leakage(4e-12)), true, None);
    let chosen = |held_out: &[Recording]| {
        let diagnosis = diagnose(&case.file, &case.training, held_out, None, &|_| {}).unwrap();
        (format!("{:?}", diagnosis.selection), diagnosis.confirmation.map(|confirmation| confirmation.recordings))
    };
    let (first, second) = case.held_out.split_at(1);
    let [(none, unconfirmed), (one, confirmed), (other, also_confirmed)] = [&[], first, second].map(chosen);
    assert_eq!((unconfirmed, confirmed, also_confirmed), (None, Some(1), Some(1)));
    assert!(none == one && one == other);
}
