//! Cases drawn on the virtual test bed, eighty in the long test, whose effects have other forms than the hypotheses: single effects, pairs,
//! none, and effects out of the catalogue. The truth against the answer, with how the cases were recorded and driven, as a
//! snapshot beside this file (`RENEW=1` writes it anew), and the rate of false alarms. Hard cases that were once confused, each with what ended it; those that take a
//! minute are a study of their own: `cargo test --release -p system-tests --test diagnosis confusion -- --ignored`.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use rayon::prelude::*;

use diagnosis::{Diagnosis, Verdict};
use system_tests::snapshot;
use virtual_plant::concealed::{Concealed, Lot, draw};

use super::bed::Case;

/// What was drawn and what the diagnosis answered.
struct Said {
    truth: String,
    answer: String,
    /// Whether this may be an honest answer.
    right: bool,
    verdict: Verdict,
    suspected: bool,
    /// How the drive was commanded, which states were measured, and how little of the effects is visible.
    recorded: Recorded,
}

/// What makes a case easy or hard.
#[derive(Clone, Copy)]
struct Recorded {
    mode: &'static str,
    channels: &'static str,
    /// Misfit of a refit without the smallest of the effects, as a multiple of the noise.
    visible: Option<f64>,
}

/// Limit of a small effect: a refit without it leaves less than twice the noise.
const SMALL: f64 = 2.0;

fn lot(seed: u64, concealed: Concealed, hard: bool) -> Lot {
    Lot { seed, concealed, hard, only: Vec::new(), thermometer: false }
}

/// One case of a lot, diagnosed; nothing where none could be drawn.
fn said(lot: &Lot, index: u64) -> Option<Said> {
    let drawn = draw(lot, index).unwrap()?;
    let diagnosis = Case::of(&drawn).diagnose();
    let effects = &drawn.truth.effects;
    let outside = effects.iter().any(|name| name.starts_with('~'));
    let mut findings: Vec<&str> = diagnosis.findings.iter().map(|finding| finding.effect.name).collect();
    findings.sort_unstable();
    let accepted = drawn.truth.accept().into_iter().any(|mut set| {
        set.sort_unstable();
        set == findings
    });
    let right = if outside {
        findings.is_empty()
    } else if effects.is_empty() {
        diagnosis.verdict == Verdict::NothingMissing
    } else {
        accepted
    };
    Some(Said {
        truth: joined(effects),
        answer: named(&diagnosis, &findings),
        right,
        verdict: diagnosis.verdict,
        suspected: diagnosis.suspected.is_some(),
        recorded: Recorded {
            mode: drawn.truth.mode,
            channels: drawn.truth.channels,
            visible: drawn.truth.visible.iter().copied().reduce(f64::min),
        },
    })
}

/// A drawn hard pair; the truth must be this one.
fn pair(seed: u64, index: u64, truth: &str) -> Said {
    let said = said(&lot(seed, Concealed::Pair, true), index).unwrap();
    assert_eq!(said.truth, truth);
    said
}

/// Asserts that a drawn hard pair, whose truth must be this one, is named.
fn is_named(seed: u64, index: u64, truth: &str) {
    let said = pair(seed, index, truth);
    assert!(said.right, "{} said", said.answer);
}

fn joined(names: &[&str]) -> String {
    if names.is_empty() { "nothing".to_owned() } else { names.join(" + ") }
}

fn named(diagnosis: &Diagnosis, findings: &[&str]) -> String {
    match diagnosis.verdict {
        Verdict::MissingPhysics => joined(findings),
        Verdict::NothingMissing => "nothing".to_owned(),
        Verdict::Unexplained => "unexplained".to_owned(),
    }
}

fn all(lots: &[(Lot, u64)]) -> Vec<Said> {
    let cases: Vec<(&Lot, u64)> =
        lots.iter().flat_map(|(lot, count)| (0..*count).map(move |index| (lot, index))).collect();
    cases.into_par_iter().filter_map(|(lot, index)| said(lot, index)).collect()
}

fn table(cases: &[Said]) -> String {
    let mut counts: BTreeMap<(&str, &str, bool), usize> = BTreeMap::new();
    for case in cases {
        *counts.entry((&case.truth, &case.answer, case.right)).or_default() += 1;
    }
    let mut text = String::from(
        "put in                                                 said                                                   cases\n",
    );
    for ((truth, said, right), count) in counts {
        let mark = if right { "" } else { "  wrong" };
        let _ = writeln!(text, "{truth:<54} {said:<54} {count:>5}{mark}");
    }
    let right = cases.iter().filter(|case| case.right).count();
    let _ = writeln!(text, "{right} of {} right", cases.len());
    text
}

/// The number of cases of each kind, and how many of them were answered right.
fn kinds(cases: &[Said]) -> String {
    type Kind = (&'static str, fn(&Said) -> bool);
    const KINDS: [Kind; 11] = [
        ("single effects", |said| is_inside(said) && !said.truth.contains(" + ")),
        ("pairs", |said| is_inside(said) && said.truth.contains(" + ")),
        ("nothing", |said| said.truth == "nothing"),
        ("outside the vocabulary", |said| said.truth.starts_with('~')),
        ("small: less than twice the noise", |said| said.recorded.visible.is_some_and(|left| left < SMALL)),
        ("open loop", |said| said.recorded.mode == "open"),
        ("dither", |said| said.recorded.mode == "dither"),
        ("closed loop", |said| said.recorded.mode == "closed"),
        ("position alone measured", |said| said.recorded.channels == "uy"),
        ("spool and position", |said| said.recorded.channels == "uxy"),
        ("spool, pressures and position", |said| matches!(said.recorded.channels, "uxpy" | "full")),
    ];
    let mut text = String::from("of which                                     cases  right\n");
    for (name, is) in KINDS {
        let of: Vec<&Said> = cases.iter().filter(|said| is(said)).collect();
        let right = of.iter().filter(|said| said.right).count();
        let _ = writeln!(text, "{name:<44} {:>5} {right:>6}", of.len());
    }
    text
}

fn is_inside(said: &Said) -> bool {
    said.truth != "nothing" && !said.truth.starts_with('~')
}

#[test]
fn of_a_dozen_drawn_cases_most_are_named_and_nothing_is_accepted_where_nothing_was_put_in() {
    let cases = all(&[
        (lot(101, Concealed::Single, false), 7),
        (lot(103, Concealed::None, true), 4),
        (lot(104, Concealed::Outside, false), 1),
    ]);
    println!("{}", table(&cases));
    for case in cases.iter().filter(|case| case.truth == "nothing") {
        assert_ne!(case.verdict, Verdict::MissingPhysics, "{} accepted where nothing was put in", case.answer);
    }
    assert!(cases.iter().filter(|case| case.right).count() >= 8);
}

/// While the rod rests at the stop, the model's rod goes on: a residual of one independent sample, which only the stop explains. For the
/// first drive the rough refit explains all of it with an impossible damping.
#[test]
#[ignore = "a minute: one of the study of once confused cases"]
fn a_stop_that_a_rod_rests_at_is_named() {
    let stop = Lot { only: vec!["end-stop".to_owned()], ..lot(77, Concealed::Single, false) };
    for index in [1, 2] {
        let said = said(&stop, index).unwrap();
        assert!(said.right, "{} put in, {} said", said.truth, said.answer);
    }
}

/// An oil that warms up, in two recordings of the position: after a single Newton step the model with this effect follows one of them worse.
#[test]
#[ignore = "a minute: one of the study of once confused cases"]
fn what_one_newton_step_tells_too_little_of_is_refitted() {
    let said = said(&lot(102, Concealed::Single, true), 8).unwrap();
    assert_eq!(said.truth, "oil-temperature");
    assert!(said.right, "{} said", said.answer);
}

/// Where the neutral drifts a little, nearly all of the whole model's misfit comes from a late position.
#[test]
#[ignore = "a minute: one of the study of once confused cases"]
fn a_late_position_does_not_hide_a_neutral_that_drifts() {
    is_named(9102, 14, "null-drift + position-sensor-lag");
}

/// The error that the form of a saturated valve leaves reaches every signal below; the air below it is found with the recorded spool as drive input.
#[test]
#[ignore = "a minute: one of the study of once confused cases"]
fn a_saturated_valve_does_not_hide_the_air_below_it() {
    is_named(9204, 3, "solenoid-saturation + entrained-air");
}

/// Below the spool, a spool sensor with an offset and unequal edges look alike; what is found on the rod's side remains with either of them.
#[test]
#[ignore = "a minute: one of the study of once confused cases"]
fn a_misread_spool_is_not_taken_for_unequal_edges_beside_a_leak() {
    is_named(9204, 27, "external-leakage + sensor-offset");
}

/// A spool with flow force is followed to three times its noise only. That neither pulls a base parameter from its nominal value, nor makes
/// unequal edges look like an offset of the spool sensor.
#[test]
#[ignore = "a minute: one of the study of once confused cases"]
fn unequal_edges_are_found_below_a_spool_with_flow_force() {
    is_named(9204, 9, "flow-force + dead-zone-asymmetry");
}

/// The rod integrates a misfit of a curved flow gain that is below the noise: this must not turn unequal edges into an offset of the spool sensor.
#[test]
#[ignore = "a minute: one of the study of once confused cases"]
fn unequal_edges_are_found_beside_a_curved_flow_gain() {
    is_named(9102, 10, "flow-gain-nonlinearity + dead-zone-asymmetry");
}

/// A load that begins inside the stroke yields by centimetres; a stop is never that soft.
#[test]
#[ignore = "a minute: one of the study of once confused cases"]
fn a_load_that_begins_inside_the_stroke_is_not_called_a_stop() {
    let said = pair(9102, 7, "position-dependent-friction + position-dependent-load");
    assert!(!said.answer.contains("end-stop"), "{} said", said.answer);
}

/// Slow: `cargo test --release -p system-tests --test diagnosis eighty -- --ignored --nocapture`.
#[test]
#[ignore = "some minutes"]
fn eighty_drawn_cases_are_named_as_the_table_says() {
    let cases = all(&[
        (lot(101, Concealed::Single, false), 27),
        (lot(102, Concealed::Single, true), 21),
        (lot(105, Concealed::Pair, false), 10),
        (lot(106, Concealed::Pair, true), 10),
        (lot(103, Concealed::None, true), 8),
        (lot(104, Concealed::Outside, false), 4),
    ]);
    assert_eq!(cases.len(), 80);
    let tables = format!("{}\n{}", table(&cases), kinds(&cases));
    snapshot::compare("diagnosis/confusion.txt", &tables, |found, kept| found == kept);
    for case in cases.iter().filter(|case| case.truth == "nothing") {
        assert_ne!(case.verdict, Verdict::MissingPhysics, "{} accepted where nothing was put in", case.answer);
    }
}

/// The rate of false alarms on somewhat more than 200 drives without an effect, half of them with rough nominal values and poor recordings.
/// Slow: `cargo test --release -p system-tests --test diagnosis false_alarms -- --ignored --nocapture`.
#[test]
#[ignore = "some minutes"]
fn false_alarms_are_at_most_two_in_a_hundred() {
    let cases = all(&[(lot(201, Concealed::None, true), 105), (lot(202, Concealed::None, false), 105)]);
    println!("{}", table(&cases));
    let alarms = cases.iter().filter(|case| case.verdict == Verdict::MissingPhysics).count();
    let suspicions = cases.iter().filter(|case| case.suspected).count();
    println!("false findings: {alarms}, suspicions: {suspicions}, of {}", cases.len());
    assert!(cases.len() >= 200 && alarms * 50 <= cases.len());
}
