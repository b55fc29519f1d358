//! One hour at 1 kHz: nothing drifts, and no small change is lost.

use std::thread;

use model_core::drive::{DriveInput, Load};
use model_core::machine::Parameter::{DeadZone, InternalLeakage, LoadForce, SupplyPressure, ValveGain, ValveOffset};
use model_core::machine::{Machine, Tick};
use model_core::number::{PerUnit, Scalar, Single};
use system_tests::drives::{self, NamedDrive};
use system_tests::simulate::{Distance, Row, at_rest, command, core, drive, oracle, row};
use virtual_plant::InitialState;

use crate::tolerances::{Case, of};

const TICK: Tick = Tick::OneMillisecond;
const HOUR: usize = 3_600_000;
/// A cycle of the command, ticks.
const CYCLE: usize = 2000;
/// Cycles after which the oracle repeats itself.
const SETTLED: usize = 6;
/// One step of the output card, V: commands are whole steps, so that both sides get exactly the same values.
const CARD_V: f64 = 10.0 / 32768.0;

/// Largest creep of a drive with closed valve in an hour, % of stroke: its oil balance has no loss, so that only the pressures'
/// step is left.
const CREEP_PERCENT: f64 = 1e-5;
/// Largest difference from f64 in an hour with leakage past the piston, % of stroke: at a velocity of one step, the flow displaced in B is
/// α·v after rounding.
const LEAKING_PERCENT: f64 = 0.002;
/// Error of a small opening: dead zone, offset, command and flow are each rounded to steps of 4e-9.
const OPENING_STEPS: f64 = 2e-8;

/// A trapezoid: 0.2 s up, 0.5 s held, 0.2 s down, 0.1 s at zero, and the same in the other direction. V.
fn trapezoid(out_v: f64, back_v: f64) -> Vec<f64> {
    let half = |volts: f64| {
        (0..CYCLE / 2).map(move |tick| {
            let tick = tick as f64;
            let share = (tick / 200.0).min((900.0 - tick) / 200.0).clamp(0.0, 1.0);
            (volts * share / CARD_V).round() * CARD_V
        })
    };
    half(out_v).chain(half(-back_v)).collect()
}

fn cycles(cycle: &[f64], count: usize) -> Vec<f64> {
    cycle.iter().copied().cycle().take(CYCLE * count + 1).collect()
}

/// The oracle at the end of its settled cycles, and the travel of a further cycle.
///
/// With constant volumes and no stops nothing depends on the position, so once the pressures repeat, every cycle adds the same.
fn periodic(machine: &Machine<f64>, cycle: &[f64]) -> (Row, f64) {
    let rows = oracle(machine, TICK, &cycles(cycle, SETTLED), &InitialState::at_rest(machine, 0.15));
    let at = |cycle: usize| rows[CYCLE * cycle];
    let travel = at(SETTLED).position - at(SETTLED - 1).position;
    let before = at(SETTLED - 1).position - at(SETTLED - 2).position;
    assert!((travel - before).abs() < 2e-9, "the oracle does not repeat itself yet: {travel:e} {before:e}");
    assert!((at(SETTLED).pressure_a - at(SETTLED - 1).pressure_a).abs() < 1e-8);
    (at(SETTLED), travel)
}

/// The trapezoid of 5 V outwards that returns to its start, except for a step of the output card.
fn closed_cycle(machine: &Machine<f64>) -> Vec<f64> {
    let (mut low_v, mut high_v) = (3.0, 9.0);
    for _ in 0..10 {
        let middle_v = f64::midpoint(low_v, high_v);
        let (_, travel) = periodic(machine, &trapezoid(5.0, middle_v));
        if travel > 0.0 { low_v = middle_v } else { high_v = middle_v }
    }
    trapezoid(5.0, f64::midpoint(low_v, high_v))
}

fn cycling<N: Scalar<Real = f64>>(named: &NamedDrive, ticks: usize, cycle: &[f64]) -> Row {
    let drive = drive::<N>(&named.machine, TICK);
    let mut state = at_rest(&drive, cycle[0], &InitialState::at_rest(&named.machine, 0.15));
    let commands: Vec<N> = cycle.iter().map(|&volts| command(volts)).collect();
    for &command in commands.iter().cycle().take(ticks) {
        drive.step(&mut state, DriveInput::Command(command), Load::NONE);
    }
    row(&state)
}

fn an_hour_of_cycling(named: &NamedDrive) {
    let cycle = closed_cycle(&named.machine);
    let (settled, travel) = periodic(&named.machine, &cycle);
    let rest = (HOUR / CYCLE - SETTLED) as f64;
    let truth = Row { position: settled.position + rest * travel, ..settled };
    assert!((0.0..1.0).contains(&truth.position), "the cycle leaves the stroke: {truth:?}");
    for (name, found) in [
        ("fixed", cycling::<PerUnit>(named, HOUR, &cycle)),
        ("f64", cycling::<f64>(named, HOUR, &cycle)),
        ("f32", cycling::<Single>(named, HOUR, &cycle)),
    ] {
        let pressures = (found.pressure_a - truth.pressure_a).abs().max((found.pressure_b - truth.pressure_b).abs());
        let found = Distance { position: (found.position - truth.position).abs(), pressure: pressures };
        println!(
            "{:<8} {name:<5} after one hour: position {:.5} %, pressure {:.5} % ({:.4} strokes in the oracle)",
            named.name,
            100.0 * found.position,
            100.0 * found.pressure,
            truth.position - 0.5
        );
        assert!(of(Case::Hour).holds(found), "{} {name}: {found:?}", named.name);
    }
}

#[test]
fn an_hour_of_cycling_ends_where_the_oracle_does() {
    thread::scope(|scope| {
        for named in drives::named() {
            scope.spawn(move || an_hour_of_cycling(&named));
        }
    });
}

fn creep_in_an_hour<N: Scalar<Real = f64>>(named: &NamedDrive, number: &str) {
    let machine = named.machine.with(&[(LoadForce, 8e3)]);
    let drive = drive::<N>(&machine, TICK);
    // Half a supply pressure away from equilibrium, so that it has to settle first.
    let mut initial = InitialState::at_rest(&machine, 0.15);
    initial.pressure_a_pa += 3.5e6;
    let mut state = at_rest(&drive, 0.0, &initial);
    let mut run = |ticks: usize| {
        for _ in 0..ticks {
            drive.step(&mut state, DriveInput::Command(N::ZERO), Load::NONE);
        }
        row(&state)
    };
    let settled = run(10_000);
    let after = run(HOUR);
    let creep_percent = 100.0 * (after.position - settled.position);
    println!("{:<8} {number:<5} creeps by {creep_percent:.6} % of stroke in one hour", named.name);
    assert!(creep_percent.abs() <= CREEP_PERCENT, "{} {number}: {creep_percent} %", named.name);
    let moved = (after.pressure_a - settled.pressure_a).abs().max((after.pressure_b - settled.pressure_b).abs());
    assert!(moved < 1e-7, "{} {number}: pressures creep by {moved:e}", named.name);
}

#[test]
fn a_closed_valve_holds_a_load_for_an_hour() {
    thread::scope(|scope| {
        for named in drives::named() {
            scope.spawn(move || {
                creep_in_an_hour::<PerUnit>(&named, "fixed");
                creep_in_an_hour::<Single>(&named, "f32");
            });
        }
    });
}

fn an_hour_of_leakage<N: Scalar<Real = f64>>(machine: &Machine<f64>) -> Row {
    let drive = drive::<N>(machine, TICK);
    let mut state = at_rest(&drive, 0.0, &InitialState::at_rest(machine, 0.15));
    for _ in 0..HOUR {
        drive.step(&mut state, DriveInput::Command(N::ZERO), Load::NONE);
    }
    row(&state)
}

fn leaking_for_an_hour(named: &NamedDrive) {
    for (leakage, load_n) in [(2e-12, 0.0), (2e-12, 8e3), (1e-13, 0.0)] {
        let machine = named.machine.with(&[(InternalLeakage, leakage), (LoadForce, load_n)]);
        let real = an_hour_of_leakage::<f64>(&machine);
        for (number, found) in
            [("fixed", an_hour_of_leakage::<PerUnit>(&machine)), ("f32", an_hour_of_leakage::<Single>(&machine))]
        {
            let percent = 100.0 * (found.position - real.position);
            println!(
                "{:<8} {number:<5} leaks {leakage:e} under {load_n} N: {percent:.6} % from f64 in an hour",
                named.name
            );
            assert!(percent.abs() <= LEAKING_PERCENT, "{} {number} {leakage:e} {load_n}: {percent} %", named.name);
        }
    }
}

#[test]
fn a_closed_valve_with_leakage_past_the_piston_ends_where_f64_does() {
    thread::scope(|scope| {
        for named in drives::named() {
            scope.spawn(move || leaking_for_an_hour(&named));
        }
    });
}

/// Travel in the second half of a run with the spool held `opening` beyond its dead zone.
fn crept(rows: &[Row]) -> f64 {
    rows[rows.len() - 1].position - rows[rows.len() / 2].position
}

#[test]
fn a_small_opening_is_not_swallowed() {
    for named in drives::named() {
        let machine = &named.machine;
        let held = |opening: f64, side: f64, ticks: usize| {
            let spool = side * (machine.get(DeadZone) + opening);
            vec![(spool - machine.get(ValveOffset)) / machine.get(ValveGain); ticks]
        };
        for (opening, ticks) in [(1e-2, 4_000), (1e-4, 20_000), (1e-5, 20_000), (1e-6, 20_000), (1e-7, 60_000)] {
            for side in [1.0, -1.0] {
                // The pressures settle with a wide opening to the values that a small opening would reach, which would take very long.
                let start = InitialState::at_rest(machine, 0.15);
                let settled = oracle(machine, TICK, &held(1e-2, side, 3000), &start)[2999];
                let supply_pa = machine.get(SupplyPressure);
                let pressure_a_pa = settled.pressure_a * supply_pa;
                let initial = InitialState { pressure_a_pa, pressure_b_pa: settled.pressure_b * supply_pa, ..start };
                let volts = held(opening, side, ticks);
                let truth = crept(&oracle(machine, TICK, &volts, &initial));
                let real = crept(&core::<f64>(machine, TICK, &volts, &initial)) / truth - 1.0;
                let fixed = crept(&core::<PerUnit>(machine, TICK, &volts, &initial)) / truth - 1.0;
                let single = crept(&core::<Single>(machine, TICK, &volts, &initial)) / truth - 1.0;
                let text = format!(
                    "{:<8} opening {:+.0e}: f64 {real:+.1e}, fixed {fixed:+.1e}, f32 {single:+.1e}",
                    named.name,
                    side * opening
                );
                println!("{text}");
                assert!(real.abs() < 1e-5, "{text}");
                assert!(fixed.abs() < 5e-6 + OPENING_STEPS / opening, "{text}");
                assert!(single.abs() < 5e-6 + OPENING_STEPS / opening, "{text}");
            }
        }
    }
}
