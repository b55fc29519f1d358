//! The order of the step: halving the tick quarters the error.

use std::f64::consts::TAU;

use model_core::machine::Tick;
use system_tests::drives;
use system_tests::simulate::{Row, core, distance, oracle};
use virtual_plant::InitialState;

/// Least ratio of the errors at a tick and at half of it; 4 is second order.
const LEAST_RATIO: f64 = 2.5;

/// A slow sine to one side, which starts and ends gently; held for 2 ms, so that all ticks get the same signal. V.
fn command_v(time_s: f64) -> f64 {
    let rising = (time_s / 0.4).min(1.0);
    let gently = rising * rising * (3.0 - 2.0 * rising);
    gently * (5.0 + 2.0 * (TAU * 2.0 * time_s).sin())
}

#[test]
fn halving_the_tick_divides_the_error_by_four() {
    let held: Vec<f64> = (0..600).map(|k| command_v(f64::from(k) * 2e-3)).collect();
    let repeated = |times: usize| -> Vec<f64> { held.iter().flat_map(|&volts| vec![volts; times]).collect() };
    for drive in drives::named() {
        let initial = InitialState::at_rest(&drive.machine, 0.15);
        let truth = oracle(&drive.machine, Tick::TwoMilliseconds, &held, &initial);
        let error = |tick: Tick, times: usize| {
            let rows = core::<f64>(&drive.machine, tick, &repeated(times), &initial);
            let rows: Vec<Row> = rows.into_iter().step_by(times).collect();
            distance(&rows, &truth)
        };
        let errors = [error(Tick::TwoMilliseconds, 1), error(Tick::OneMillisecond, 2), error(Tick::HalfMillisecond, 4)];
        for pair in errors.windows(2) {
            let ratios = (pair[0].position / pair[1].position, pair[0].pressure / pair[1].pressure);
            println!(
                "{:<8} position {:.2}, pressure {:.2}: {:?} {:?}",
                drive.name, ratios.0, ratios.1, pair[0], pair[1]
            );
            assert!(ratios.0 > LEAST_RATIO && ratios.1 > LEAST_RATIO, "{}: {ratios:?}", drive.name);
        }
    }
}
