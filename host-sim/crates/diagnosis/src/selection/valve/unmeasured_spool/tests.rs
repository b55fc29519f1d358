use identification::fit::{Free, Freedom};
use machine_file::LoadSource;
use test_press::{press, recorded_for};

use super::*;
use crate::catalogue::CATALOGUE;
use crate::test_scene::scene;

const POSITION: [(Signal, f64); 1] = [(Signal::Position, 1e-5)];

/// The effects that `find_jumps` adds to an empty selection for a spool with these parameters, the one that `without_unconfirmed_jumps` removes where held-out recordings
/// have other spool parameters, and the effects that remain.
fn jumps(
    truth: &[(Parameter, f64)],
    held_out: &[(Parameter, f64)],
) -> (Vec<&'static str>, Option<&'static str>, Vec<&'static str>) {
    let machine = press(&[(Parameter::ViscousFriction, 2e4), (Parameter::DeadZone, 0.03)]);
    let prepared = |spools: &[(Parameter, f64)], rows| {
        let recording = recorded_for(&machine.with(spools), &POSITION, rows);
        Prepared::new(&recording, &machine, LoadSource::Constant, None).unwrap()
    };
    let (one, other, held_out) = (prepared(truth, 3000), prepared(truth, 2500), prepared(held_out, 3500));
    let training = [&one, &other];
    let judged = [Signal::Position];
    let scene = scene(&machine, &judged);
    let around =
        |parameter, nominal: f64| Free { parameter, freedom: Freedom::Around { nominal, sigma: 0.1 * nominal } };
    let base_parameters = [around(Parameter::ValveGain, 0.0559), around(Parameter::DeadZone, 0.03)];
    let question =
        Question { scene: &scene, base_parameters: &base_parameters, hypotheses: CATALOGUE, training: &training };
    let base = Candidate::rough(&question, None).unwrap();
    let mut selection = Selection {
        chosen: base.clone(),
        inflated: base.fit.clone(),
        base,
        rounds: Vec::new(),
        joined: Vec::new(),
        jumps: None,
        searched: crate::selection::Searched::default(),
    };
    selection.find_jumps(&question, &|_| ()).unwrap();
    let names = selection.chosen.names();
    let gone = selection.without_unconfirmed_jumps(&[&held_out]).unwrap().map(|effect| effect.name);
    (names, gone, selection.chosen.names())
}

const STICKS: [(Parameter, f64); 2] = [(Parameter::StictionBand, 0.02), (Parameter::StictionKept, 0.2)];
const PLAYS: [(Parameter, f64); 1] = [(Parameter::HysteresisWidth, 0.024)];

#[test]
fn a_spool_that_sticks_unseen_is_named_and_a_held_out_recording_that_holds_its_jumps_agrees() {
    let (names, gone, left) = jumps(&STICKS, &STICKS);
    assert_eq!((names.as_slice(), gone, left.as_slice()), (&["spool-stiction"][..], None, &["spool-stiction"][..]));
}

#[test]
fn what_was_chosen_before_comes_back_where_held_out_recordings_hold_no_jumps() {
    let (names, gone, left) = jumps(&STICKS, &PLAYS);
    assert_eq!((names.as_slice(), gone), (&["spool-stiction"][..], Some("spool-stiction")));
    assert!(left.is_empty());
}

#[test]
fn a_play_that_follows_is_not_taken_for_stiction() {
    let (names, gone, _) = jumps(&PLAYS, &PLAYS);
    assert!(names.is_empty() && gone.is_none());
}

#[test]
fn what_a_play_and_a_stiction_lag_by_is_shared_between_both() {
    let Sticks { band, kept, width } = Sticks::beside(0.01, 0.2, 0.03).unwrap();
    assert!((band * (1.0 - kept) - 0.01).abs() < 1e-15 && (width + band * (1.0 + kept) - 0.03).abs() < 1e-15);
    assert!(Sticks::beside(0.01, 0.6, 0.03).is_none());
    let alone = Sticks::alone(0.01, 0.03);
    assert!(
        (alone.band * (1.0 - alone.kept) - 0.01).abs() < 1e-15
            && (alone.band * (1.0 + alone.kept) - 0.03).abs() < 1e-15
    );
    // For jumps longer than the lag allows, the kept share is 0.
    assert!(Sticks::alone(0.03, 0.01).kept.abs() < 1e-15);
}
