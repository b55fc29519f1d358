//! The kind of a curve is told, and nothing is read from one that does not have it: 200 drawn curves of each kind.

use super::draws::{Bench, Random};
use super::*;

const DRAWS: usize = 200;

type Curve = Box<dyn Fn(f64) -> f64>;

/// What is found on drawn curves of one kind; some of them lag or have play.
fn drawn(seed: u64, curve: fn(&mut Random) -> Curve) -> Vec<Statics> {
    let mut random = Random(seed);
    let one = |_| {
        let mut bench = Bench::drawn(&mut random);
        match random.of(&[0, 1, 2]) {
            0 => {}
            1 => bench.play = random.between(0.0, 0.6),
            _ => bench.lag_s = random.between(0.0, 1.5),
        }
        let curve = curve(&mut random);
        analyse(&bench.sweep(&mut random, curve), &columns()).unwrap()
    };
    (0..DRAWS).map(one).collect()
}

fn count(found: &[Statics], which: impl Fn(&Statics) -> bool) -> usize {
    found.iter().filter(|one| which(one)).count()
}

/// Whether any figure or finding of a monotone curve was read.
fn read_as_monotone(found: &Statics) -> bool {
    let edges = found.positive.is_some() || found.negative.is_some() || found.null.is_some() || found.gain.is_some();
    edges || !found.saturation.is_empty() || !found.gains.is_empty() || !found.indications.is_empty()
}

fn bell(random: &mut Random) -> (f64, f64, f64) {
    (random.between(-3.0, 3.0), random.between(0.7, 2.0), random.between(0.0, 1.0))
}

#[test]
fn a_bell_is_a_peak_with_its_place_and_width_and_has_no_gain() {
    let gaussian: fn(&mut Random) -> Curve = |random| {
        let (at, width, floor) = bell(random);
        Box::new(move |x| floor + (-0.5 * ((x - at) / width).powi(2)).exp())
    };
    let found = drawn(1, gaussian);
    assert_eq!(count(&found, read_as_monotone), 0);
    let told = count(&found, |one| matches!(one.shape, Shape::Peak(_)));
    assert!(told >= 196, "{told}");
    // One whose figures are known: 0.63 and 0.72 above it at 0.4, 2.355 standard deviations wide.
    let bench = Bench { rows: 4000, period_s: 100.0, lag_s: 0.0, play: 0.0, noise: 0.01, alike: 0.0 };
    let curve = |x: f64| 0.63 + 0.72 * (-0.5 * (x - 0.4) * (x - 0.4)).exp();
    let one = analyse(&bench.sweep(&mut Random(2), curve), &columns()).unwrap();
    let Shape::Peak(peak) = one.shape else { panic!("{one:?}") };
    assert!((peak.output - 1.35).abs() < 0.02 && (peak.input - 0.4).abs() < 0.2, "{peak:?}");
    assert!((peak.width_at_half_height - 2.355).abs() < 0.2 && (peak.lower_end - 0.63).abs() < 0.01, "{peak:?}");
}

#[test]
fn a_valley_is_told_and_has_no_gain() {
    let found = drawn(3, |random| {
        let (at, width, floor) = bell(random);
        Box::new(move |x| floor + 1.0 - 1.0 / (1.0 + ((x - at) / width).powi(2)))
    });
    assert_eq!(count(&found, read_as_monotone), 0);
    let told = count(&found, |one| matches!(one.shape, Shape::Valley(_)));
    assert!(told >= 196, "{told}");
}

#[test]
fn a_characteristic_that_folds_back_through_small_outputs_has_no_gain() {
    let found = drawn(4, |random| {
        let (turns, from) = (random.between(1.5, 4.0), random.between(0.0, 6.0));
        Box::new(move |x| 0.5 * (0.05 * x * std::f64::consts::TAU * turns + from).sin())
    });
    assert_eq!(count(&found, read_as_monotone), 0);
    let told = count(&found, |one| !one.shape.has_edges() && !matches!(one.shape, Shape::Constant { .. }));
    assert!(told >= 196, "{told}");
}

#[test]
fn noise_about_a_constant_is_no_characteristic() {
    let found = drawn(5, |random| {
        let level = random.between(-1.0, 1.0);
        Box::new(move |_| level)
    });
    let read = count(&found, read_as_monotone);
    assert!(read <= 2, "{read}");
    let told = count(&found, |one| matches!(one.shape, Shape::Constant { .. }));
    let extreme = count(&found, |one| one.shape.extreme().is_some());
    assert!(told >= 180 && extreme <= 2, "{told} {extreme}");
}

#[test]
fn a_straight_valve_in_noise_has_a_gain_and_no_effect() {
    let found = drawn(6, |random| {
        let (gain, offset) = (random.between(0.05, 0.2), random.between(-1.0, 1.0));
        Box::new(move |x| gain * (x - offset))
    });
    let named = count(&found, |one| !one.indications.is_empty());
    let fallen = count(&found, |one| !one.saturation.is_empty());
    let told = count(&found, |one| one.shape == Shape::Monotone { rising: true } && one.null.is_some());
    assert!(named <= 1 && fallen <= 1 && told >= 196, "{named} {fallen} {told}");
}

#[test]
fn a_valve_with_dead_zone_and_saturation_keeps_its_figures_in_noise() {
    let found = drawn(7, |random| {
        let (dead_zone, end) = (random.between(0.5, 2.0), random.between(6.0, 8.0));
        Box::new(move |x: f64| -0.1 * x.signum() * (x.abs().min(end) - dead_zone).max(0.0))
    });
    let told = count(&found, |one| one.shape == Shape::Monotone { rising: false } && one.null.is_some());
    let others = count(&found, |one| names(one).iter().any(|name| *name != "flow-gain-nonlinearity"));
    let null = count(&found, |one| one.null.is_some_and(|null| null.input.abs() < 0.4));
    assert!(told >= 196 && others == 0 && null >= 180, "{told} {others} {null}");
}

#[test]
fn a_curve_that_falls_back_at_its_end_keeps_null_and_dead_zone_only() {
    let bench = Bench { rows: 4000, period_s: 100.0, lag_s: 0.0, play: 0.0, noise: 0.002, alike: 0.0 };
    let droops = |x: f64| x.signum() * ((x.abs() - 1.0).max(0.0) - 2.0 * (x.abs() - 8.0).max(0.0));
    let found = analyse(&bench.sweep(&mut Random(8), droops), &columns()).unwrap();
    assert!(matches!(found.shape, Shape::TurnsBack { small_once: true, .. }), "{:?}", found.shape);
    assert!(
        (found.positive.unwrap().extrapolated - 1.0).abs() < 0.05 && found.null.unwrap().input.abs() < 0.05,
        "{found:?}"
    );
    assert!(found.gains.is_empty() && found.saturation.is_empty() && found.indications.is_empty(), "{found:?}");
}

#[test]
fn an_output_that_is_nowhere_small_gets_no_null_and_no_gain_at_small_outputs() {
    let bench = Bench { rows: 1000, period_s: 100.0, lag_s: 0.0, play: 0.0, noise: 0.01, alike: 0.0 };
    let found = analyse(&bench.sweep(&mut Random(9), |x| 5.0 + 0.1 * x), &columns()).unwrap();
    assert_eq!(found.shape, Shape::Monotone { rising: true });
    assert!(!read_as_monotone(&found) && found.remarks.contains(&Remark::NowhereSmall), "{found:?}");
}
