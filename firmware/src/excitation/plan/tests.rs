//! Is a plan played row by row, and refused where it does not fit?

use std::string::ToString;
use std::vec::Vec;

use model_core::control::SetPoint;
use model_core::machine::Tick;
use model_core::number::Number;

use super::*;
use crate::app::press::{self, PLAN};
use crate::control::Reference;
use crate::set_point::{Envelope, Followed};

const PIECES: &[Piece<'static>] =
    &[Piece::Held(2, 5), Piece::Rows(&[]), Piece::Held(0, 9), Piece::Rows(&[-1, i16::MIN])];

fn permitted() -> Permitted {
    let reference: Reference<64> = Reference::at_rest(&press::machine(), Tick::OneMillisecond, 0.5).unwrap();
    let (bases, bounds) = (*reference.bases(), press::BY_HAND);
    Permitted { fingerprint: fingerprint(&press::machine()), bases, bounds, most_v: 9.5 }
}

fn at(plan: &Plan<'_>, position_m: f64) -> Result<(), PlanError> {
    let from = PerUnit::saturated(position_m / permitted().bases.stroke_m);
    plan.at(from, &permitted()).map(|_| ())
}

#[test]
fn each_row_is_held_for_its_ticks_and_after_the_last_there_is_nothing() {
    for (tick_s, ticks) in [(0.5e-3, 4), (1e-3, 2), (2e-3, 1)] {
        let play = Plan { row_us: 2000, pieces: PIECES, ..*PLAN }.by(tick_s).unwrap();
        let mut along = PlayState::default();
        let bits: Vec<i32> = core::iter::from_fn(|| play.step(&mut along)).map(PerUnit::to_bits).collect();
        let expected: Vec<i32> =
            [5, 5, -1, -32_768].iter().flat_map(|word| core::iter::repeat_n(word << 13, ticks)).collect();
        assert_eq!(bits, expected);
        assert!(play.is_done(&along) && !play.is_done(&PlayState::default()));
        assert_eq!(play.step(&mut along), None);
    }
    // −32 768 are −10 V.
    assert_eq!(PerUnit::from_bits(-32_768 << 13), -PerUnit::ONE);
}

#[test]
fn the_shipped_plan_is_for_the_shipped_press_and_is_played_where_it_begins() {
    assert_eq!(PLAN.fingerprint, fingerprint(&press::machine()));
    assert_eq!(PLAN.machine, press::values::NAME);
    for away_m in [0.0, 4.9e-3, -4.9e-3] {
        assert_eq!(at(PLAN, PLAN.start_m + away_m), Ok(()));
    }
}

#[test]
fn what_does_not_fit_is_refused_with_what_was_found_and_what_is_expected() {
    let start_m = PLAN.start_m;
    let said = |plan: Plan<'_>, position_m| at(&plan, position_m).unwrap_err().to_string();
    assert_eq!(
        at(&Plan { fingerprint: 7, ..*PLAN }, start_m),
        Err(PlanError::Machine { found: 7, expected: PLAN.fingerprint })
    );
    for row_us in [0, 500, 1500, 2001] {
        assert_eq!(at(&Plan { row_us, ..*PLAN }, start_m), Err(PlanError::Rows { row_us, tick_us: 1000 }));
    }
    for largest_v in [9.6, f64::NAN, f64::INFINITY] {
        let said = said(Plan { largest_v, ..*PLAN }, start_m);
        assert!(said.contains("expected at most 9.5 V"), "{said}");
    }
    for fastest_m_per_s in [0.031, f64::NAN] {
        let said = said(Plan { fastest_m_per_s, ..*PLAN }, start_m);
        assert!(said.contains("expected at most 0.03 m/s"), "{said}");
    }
    for position_m in [0.0, start_m - 5.1e-3, start_m + 5.1e-3, 0.29] {
        assert!(said(*PLAN, position_m).contains("expected within 0.005 m of 0.15 m: go there first"));
    }
    // 1.2 mm are what it takes to come to rest from 26.6 mm/s at 0.3 m/s².
    for plan in [Plan { to_m: 0.2889, ..*PLAN }, Plan { from_m: 0.0111, ..*PLAN }, Plan { from_m: f64::NAN, ..*PLAN }] {
        assert!(said(plan, start_m).contains("expected 0.01 to 0.29 m"));
    }
    assert_eq!(at(&Plan { to_m: 0.2887, ..*PLAN }, start_m), Ok(()));
    assert!(said(Plan { to_m: 0.2887, ..*PLAN }, start_m + 1e-3).contains("0.2908"));
}

#[test]
fn a_fingerprint_tells_values_apart_and_not_how_they_were_stated() {
    let press = press::machine();
    assert_eq!(
        fingerprint(&press),
        fingerprint(&press.with(&[(Parameter::MovingMass, press.get(Parameter::MovingMass))]))
    );
    for &parameter in Parameter::ALL {
        let value = press.get(parameter);
        // A limit that is off is infinite.
        let other = press.with(&[(parameter, if value.is_finite() { 1.01 * value + 1e-9 } else { 1.0 })]);
        assert_ne!(fingerprint(&press), fingerprint(&other), "{parameter:?}");
    }
}

#[test]
fn the_model_stays_where_the_plan_says_and_rests_at_its_end() {
    let mut model: Reference<64> = Reference::at_rest(&press::machine(), Tick::OneMillisecond, 0.5).unwrap();
    let bases = *model.bases();
    let envelope = Envelope::new(&permitted().bounds, &bases, 0.0).unwrap();
    let (play, mut along) = (PLAN.by(bases.tick_s).unwrap(), PlayState::default());
    let (mut reach_m, mut fastest_m_per_s) = ([PLAN.start_m; 2], 0.0_f64);
    let mut followed = Followed::resting(model.predicted().position);
    while let Some(command) = play.step(&mut along) {
        let predicted = model.step(command);
        let motion = SetPoint { position: predicted.position, velocity: predicted.velocity };
        followed = envelope.driven(&followed, motion).unwrap();
        let position_m = predicted.position.to_f64() * bases.stroke_m;
        reach_m = [reach_m[0].min(position_m), reach_m[1].max(position_m)];
        fastest_m_per_s = fastest_m_per_s.max(predicted.velocity.to_f64().abs() * bases.velocity_m_per_s);
    }
    let near = |found: f64, stated: f64| (found - stated).abs() < 1e-9;
    assert!(near(reach_m[0], PLAN.from_m) && near(reach_m[1], PLAN.to_m), "{reach_m:?}");
    assert!(near(fastest_m_per_s, PLAN.fastest_m_per_s), "{fastest_m_per_s}");
    // A set point goes on from there.
    let rest = SetPoint { velocity: PerUnit::ZERO, ..followed.at };
    assert!(envelope.next(&followed, rest, PerUnit::ZERO).is_ok(), "{followed:?}");
}
