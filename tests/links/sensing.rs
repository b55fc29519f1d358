//! The sensing link: counts become a position and counts again.

use model_core::machine::{Machine, Parameter as P, Source};
use model_core::number::{PerUnit, Scalar};
use model_core::sensing::{Linkage, Lvdt};

fn every_count<N: Scalar<Real = f64>>() {
    let machine = Machine::with_defaults(Source::Valve);
    let linkage = Linkage::<N>::new(&machine).unwrap();
    let at = |strokes: f64| linkage.counts(N::saturated(strokes)).round();
    #[expect(clippy::cast_possible_truncation, reason = "a few thousand counts")]
    let (first, last) = (at(0.0) as i32, at(1.0) as i32);
    assert!((last - first).abs() > 300, "the encoder resolves the stroke: {first} to {last}");
    let mut before = None;
    for count in first.min(last) + 1..first.max(last) {
        let position = linkage.position(count);
        let again = linkage.counts(position);
        assert!((again - f64::from(count)).abs() < 0.02, "{count} becomes {again}");
        let moved = before.is_none_or(|before| (position > before) == (last > first));
        assert!(moved, "position runs one way at {count}");
        before = Some(position);
    }
}

#[test]
fn every_count_of_the_encoder_becomes_a_position_and_that_count_again() {
    every_count::<PerUnit>();
    every_count::<f64>();
}

#[test]
fn every_count_of_the_lvdt_becomes_its_own_spool_position() {
    let machine = Machine::with_defaults(Source::Valve);
    let (fixed, real) = (Lvdt::<PerUnit>::new(&machine).unwrap(), Lvdt::<f64>::new(&machine).unwrap());
    let per_unit = machine.get(P::LvdtCounts);
    for count in -32768..32768 {
        let exact = f64::from(count) / per_unit;
        assert!((real.spool(count) - exact).abs() < 1e-15, "{count}");
        assert!((fixed.spool(count).to_f64() - exact).abs() < 4e-9, "{count}");
    }
}

#[test]
fn fixed_point_and_f64_read_the_same_position() {
    let machine = Machine::with_defaults(Source::Valve);
    let (fixed, real) = (Linkage::<PerUnit>::new(&machine).unwrap(), Linkage::<f64>::new(&machine).unwrap());
    for count in -3600..3600 {
        let apart = (fixed.position(count).to_f64() - real.position(count)).abs();
        assert!(apart < 2e-7, "{count}: {apart:e}");
    }
}
