//! Sweeps at several rates: a lag, hysteresis, both, on monotone curves and on bells.

use super::draws::{Bench, Random};
use super::*;

fn compared(
    random: &mut Random,
    bench: Bench,
    periods: &[f64],
    curve: fn(f64) -> f64,
    rate_from: RateFrom,
) -> Comparison {
    let sweep = |period_s: &f64| {
        let bench = Bench { period_s: *period_s, ..bench };
        (analyse(&bench.sweep(random, curve), &columns()).unwrap(), *period_s)
    };
    let mut found: Vec<(Statics, f64)> = Vec::new();
    found.extend(periods.iter().map(sweep));
    compare(&found.iter().map(|(statics, period)| (statics, *period)).collect::<Vec<_>>(), rate_from)
}

fn bell(x: f64) -> f64 {
    0.7 + 0.7 / (1.0 + x * x / 4.0)
}

fn valve(x: f64) -> f64 {
    0.1 * x.signum() * (x.abs().min(8.0) - 1.0).max(0.0)
}

fn straight(x: f64) -> f64 {
    0.1 * x
}

/// Draws for each curve.
const DRAWS: usize = 40;
const CURVES: [fn(f64) -> f64; 3] = [bell, valve, straight];

#[derive(Default, Debug)]
struct Counted {
    named: usize,
    lag: usize,
    near: usize,
    all: usize,
}

/// On 40 draws for each curve: how often hysteresis is named, a lag is told, and what is told is within a quarter (or 0.05).
fn counted(seed: u64, periods: &[f64], draw: fn(&mut Random, &mut Bench)) -> Counted {
    let mut random = Random(seed);
    let mut counted = Counted::default();
    for curve in CURVES {
        for _ in 0..DRAWS {
            let mut bench = Bench { rows: 2000, ..Bench::drawn(&mut random) };
            bench.noise *= 0.2;
            draw(&mut random, &mut bench);
            let found = compared(&mut random, bench, periods, curve, RateFrom::Period);
            let near = |found: Option<Estimate>, real: f64| {
                found.is_some_and(|found| (found.value - real).abs() < 0.05 + 0.25 * real)
            };
            let lag = matches!(found.cause, Cause::Lag | Cause::Both);
            let named = !found.indications().is_empty();
            counted.all += 1;
            counted.named += usize::from(named);
            counted.lag += usize::from(lag);
            counted.near +=
                usize::from((!named || near(found.hysteresis, bench.play)) && (!lag || near(found.lag, bench.lag_s)));
        }
    }
    counted
}

#[test]
fn a_loop_that_shrinks_with_the_rate_is_a_lag_and_never_hysteresis() {
    let found = counted(11, &[20.0, 50.0, 200.0], |random, bench| bench.lag_s = random.between(0.4, 1.2));
    assert!(found.named == 0 && found.lag >= 114 && found.near >= 108, "{found:?}");
    // The fastest sweeps have loops wider than the curve is.
    let fast = counted(12, &[4.0, 10.0, 25.0], |random, bench| bench.lag_s = random.between(0.4, 1.2));
    assert!(fast.named == 0, "{fast:?}");
}

#[test]
fn a_loop_that_stays_is_hysteresis_and_no_lag() {
    let found = counted(13, &[20.0, 60.0], |random, bench| bench.play = random.between(0.3, 0.7));
    assert!(found.lag <= 1 && found.named >= 108 && found.near >= 117, "{found:?}");
}

#[test]
fn both_are_told_apart() {
    let found = counted(14, &[30.0, 60.0, 120.0, 300.0], |random, bench| {
        bench.play = random.between(0.3, 0.6);
        bench.lag_s = random.between(0.3, 0.8);
    });
    assert!(found.lag >= 108 && found.named >= 96 && found.near >= 108, "{found:?}");
}

#[test]
fn without_a_loop_nothing_is_told() {
    let found = counted(15, &[20.0, 50.0, 200.0], |_, _| {});
    assert!(found.named <= 1 && found.lag <= 1, "{found:?}");
}

#[test]
fn rates_that_are_only_supposed_name_nothing() {
    let bench = Bench { rows: 2000, period_s: 0.0, lag_s: 0.0, play: 0.5, noise: 0.001, alike: 0.0 };
    let found = compared(&mut Random(16), bench, &[2000.0, 5000.0], valve, RateFrom::Rows);
    assert_eq!(found.cause, Cause::Hysteresis);
    assert!(found.indications().is_empty());
    let same = compared(&mut Random(17), bench, &[2000.0, 2000.0], valve, RateFrom::Rows);
    assert_eq!((same.cause, same.lag, same.hysteresis), (Cause::Undecided, None, None));
}
