//! Drives without a recorded command: the spool, a flow meter or a force sensor alone is enough to diagnose the links below it.

use rayon::prelude::*;

use diagnosis::Verdict;
use model_core::machine::Parameter as P;
use recording::{Column, Recording, Signal};
use virtual_plant::{PlantEffect, PlantState, SyntheticRecording};

use super::bed::{Case, Dice, accepted, press, valve_case_as};

/// The signal that drives the model, and the judged signals.
#[derive(Clone, Copy, Debug)]
struct Recorded {
    by: Signal,
    judged: &'static [Signal],
}

const SPOOL: Recorded =
    Recorded { by: Signal::Spool, judged: &[Signal::PressureA, Signal::PressureB, Signal::Position] };
const FLOW: Recorded = Recorded { by: Signal::Flow, judged: &[Signal::PressureA, Signal::PressureB, Signal::Position] };
const FLOW_ALONE: Recorded = Recorded { by: Signal::Flow, judged: &[Signal::Position] };
const FORCE: Recorded = Recorded { by: Signal::Force, judged: &[Signal::Position] };
/// Nothing drives the model but the force of both pressures.
const PRESSURES: Recorded = Recorded { by: Signal::PressureA, judged: &[Signal::PressureB, Signal::Position] };

/// A drive's readings: the spool sensor, a meter for the flow into A, or a sensor for the oil's force with usual noise; and the other sensors.
fn read(made: &SyntheticRecording, name: &str, recorded: Recorded) -> Recording {
    let machine = press().machine;
    let noise = experiment::sensor::Sensor::usual(recorded.by, &machine).noise;
    let (area_a, area_b) = (machine.get(P::AreaA), machine.get(P::AreaB));
    let mut dice = Dice::new(name.bytes().map(u64::from).sum::<u64>() + made.len() as u64);
    // The sum of twelve uniform numbers has a standard deviation of 1.
    let mut error = || noise * ((0..12).map(|_| dice.between(0.0, 1.0)).sum::<f64>() - 6.0);
    let force = |state: &PlantState| area_a * state.pressure_a_pa - area_b * state.pressure_b_pa;
    let driving: Vec<f64> = match recorded.by {
        Signal::Spool => made.spool.clone(),
        Signal::PressureA => made.pressure_a_pa.clone(),
        Signal::Flow => made.truth.iter().map(|state| state.flow_a_m3_per_s + error()).collect(),
        _ => made.truth.iter().map(|state| force(state) + error()).collect(),
    };
    let column = |signal: &Signal| {
        let values = match signal {
            Signal::PressureA => &made.pressure_a_pa,
            Signal::PressureB => &made.pressure_b_pa,
            _ => &made.position_m,
        };
        Column::si(*signal, values.clone())
    };
    let first = [Column::si(Signal::Time, made.time_s.clone()), Column::si(recorded.by, driving)];
    Recording::new(name, first.into_iter().chain(recorded.judged.iter().map(column)).collect()).unwrap()
}

fn case(seed: u64, effect: Option<PlantEffect>, recorded: Recorded) -> Case {
    valve_case_as(1e-3, seed, effect, None, |made, name| read(&made.rounded(), name, recorded))
}

/// Checks that drives with this effect, by seed, are diagnosed with this effect and nothing else; a drive without one follows its recordings.
fn are_told(recorded: Recorded, draws: &[(&'static str, f64, u64)]) {
    let said = |&(name, strength, seed): &(&'static str, f64, u64)| {
        let diagnosis = case(seed, PlantEffect::named(name, strength), recorded).diagnose();
        (name, format!("{recorded:?}, {name} {strength}, seed {seed}"), accepted(&diagnosis), diagnosis.verdict)
    };
    let all: Vec<_> = draws.par_iter().map(said).collect();
    for (name, told, accepted, verdict) in all {
        println!("{told}: {accepted}, {verdict:?}");
        assert_eq!(accepted, name, "{told}");
        assert_eq!(verdict == Verdict::NothingMissing, name == "none", "{told}: {verdict:?}");
    }
}

#[test]
fn with_the_spool_alone_the_links_below_are_told_and_nothing_where_nothing_is_missing() {
    let draws = [
        ("none", 0.0, 1),
        ("none", 0.0, 2),
        ("internal-leakage", 3e-12, 3),
        ("coulomb-friction", 600.0, 4),
        ("linkage-backlash", 5e-4, 5),
    ];
    are_told(SPOOL, &draws);
}

#[test]
fn with_a_flow_meter_and_pressures_the_links_below_are_told_and_nothing_where_nothing_is_missing() {
    let draws = [("none", 0.0, 1), ("none", 0.0, 2), ("internal-leakage", 3e-12, 3), ("linkage-backlash", 5e-4, 4)];
    are_told(FLOW, &draws);
}

#[test]
fn a_flow_meter_and_the_position_alone_tell_of_leakage_and_of_nothing_where_nothing_is_missing() {
    are_told(FLOW_ALONE, &[("none", 0.0, 1), ("none", 0.0, 2), ("internal-leakage", 3e-12, 3)]);
}

#[test]
fn a_force_sensor_and_the_position_alone_tell_of_the_mechanics_and_of_nothing_where_nothing_is_missing() {
    let draws = [("none", 0.0, 1), ("none", 0.0, 2), ("coulomb-friction", 600.0, 3), ("linkage-backlash", 1.5e-3, 4)];
    are_told(FORCE, &draws);
}

#[test]
fn both_pressures_and_the_position_alone_tell_of_the_mechanics_and_of_nothing_where_nothing_is_missing() {
    are_told(PRESSURES, &[("none", 0.0, 1), ("none", 0.0, 2), ("coulomb-friction", 600.0, 3)]);
}
