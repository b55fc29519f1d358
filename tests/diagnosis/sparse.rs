//! Recordings below 50 Hz, position alone: simulated at 2 ms, and first fitted in stages.

use diagnosis::base_parameters;
use identification::experiment::Prepared;
use identification::fit::{Fit, Free, staged};
use model_core::machine::{Parameter as P, Tick};
use recording::{Column, Recording, Signal};
use virtual_plant::sensor::sensors::PositionSensor;
use virtual_plant::{Bench, Drive, InitialState, Plant, PlantEffect, Sensors, truth_near};

use super::bed::{Case, Dice, effect, press};

/// Ticks of the test bed, and of them those between two rows: 20 Hz.
const TICK_S: f64 = 2e-3;
const APART: usize = 25;
/// Times the standard deviations of the example: a drive by data sheet.
const UNCERTAIN: f64 = 4.0;
/// As the command's first search ends.
const SETTLED: f64 = 1e-3;

/// A drive that deviates from its file, recorded at 20 Hz: a command that changes from row to row at drawn times, and the position.
fn slow_case(seed: u64, effect: Option<PlantEffect>) -> Case {
    let mut file = press();
    for sigma in file.sigma.values_mut() {
        *sigma *= UNCERTAIN;
    }
    let truth = truth_near(&file.machine, &file.sigma, 1.0, seed);
    let mut dice = Dice::new(seed);
    let mut record = |name: &str, rows: usize| {
        let (mut volts, mut held) = (Vec::new(), 0);
        while volts.len() < rows {
            // To and fro, so that the rod stays within its stroke.
            let (amplitude_v, lasts) = (dice.between(1.8, 3.5), 4 + dice.below(6));
            let sign = if held % 2 == 0 { 1.0 } else { -1.0 };
            volts.extend(std::iter::repeat_n(sign * amplitude_v, lasts));
            volts.extend(std::iter::repeat_n(0.0, dice.below(3)));
            held += 1;
        }
        volts.truncate(rows);
        let plant = Plant::new(&truth, 1e-7).unwrap().with_effects(effect.as_slice());
        let mut sensors = Sensors::with_position(&truth, PositionSensor::Linear { resolution_m: 1e-4 });
        sensors.spool.noise_std = 0.0;
        let bench = Bench { tick_s: TICK_S, seed: 1000 * seed + rows as u64, ..Bench::new(plant, sensors) };
        let commands = volts.iter().flat_map(|&volts| std::iter::repeat_n(volts, APART)).collect();
        let initial = InitialState::at_rest(&truth, 0.5 * truth.get(P::Stroke));
        let made = bench.record(&Drive::Commands(commands), &initial).unwrap();
        let of = |values: &[f64]| values.iter().step_by(APART).copied().collect::<Vec<f64>>();
        let columns = vec![
            Column::si(Signal::Time, of(&made.time_s)),
            Column::si(Signal::Command, of(&made.command_v)),
            Column::si(Signal::Position, of(&made.position_m)),
        ];
        Recording::new(name, columns).unwrap()
    };
    let training = vec![record("train-1", 240), record("train-2", 200)];
    let held_out = vec![record("holdout-1", 220)];
    Case { file, training, held_out }
}

fn prepared(case: &Case, recordings: &[Recording], tick: Option<Tick>) -> Vec<Prepared> {
    let prepare = |recording| Prepared::new(recording, &case.file.machine, case.file.load_source, tick).unwrap();
    recordings.iter().map(prepare).collect()
}

fn fitted(case: &Case, free: &[Free], tick: Option<Tick>) -> Fit {
    let cases = prepared(case, &case.training, tick);
    staged(&case.file.machine, free, &cases.iter().collect::<Vec<_>>(), SETTLED).unwrap()
}

#[test]
fn sparse_rows_are_simulated_at_2_ms_and_fitted_as_at_1_ms() {
    for seed in [1, 2] {
        let case = slow_case(seed, None);
        let free = base_parameters(&case.file);
        assert!(prepared(&case, &case.training, None).iter().all(|case| case.tick == Tick::TwoMilliseconds));
        let [coarse, fine] = [None, Some(Tick::OneMillisecond)].map(|tick| fitted(&case, &free, tick));
        // On held-out rows, simulated at 1 ms both: the fits are the same within a tenth of a per cent.
        let held = prepared(&case, &case.held_out, Some(Tick::OneMillisecond));
        let [by_coarse, by_fine] = [&coarse, &fine].map(|fit| {
            let residuals = identification::fit::standardised(&fit.machine, &held[0], fit.starts[0]).unwrap();
            held[0].channels[0].fit_percent(&residuals[0])
        });
        println!("{seed}: held out {by_coarse:.3} % at 2 ms, {by_fine:.3} % at 1 ms");
        assert!((by_coarse - by_fine).abs() < 0.1, "{seed}: {by_coarse} {by_fine}");
    }
}

/// The loss has the priors in it, so that a value that is free and stays at its nominal one costs nothing.
#[test]
fn of_sparse_rows_a_file_with_one_more_free_value_never_fits_worse() {
    for (seed, name) in [(1, "none"), (2, "none"), (3, "coulomb-friction"), (4, "internal-leakage")] {
        let case = slow_case(seed, effect(name, &mut Dice::new(seed)));
        let free = base_parameters(&case.file);
        let losses: Vec<f64> = (4..=free.len()).map(|count| fitted(&case, &free[..count], None).loss).collect();
        println!("{seed}: {losses:.1?}");
        for pair in losses.windows(2) {
            // Within what the search leaves: it ends where a step gains less than a thousandth.
            assert!(pair[1] < (1.0 + 5.0 * SETTLED) * pair[0], "{seed}: {losses:?}");
        }
    }
}
