//! Separation of effects on known drives.

use test_press::with_papers_valve as press;

use super::*;

fn with(parameter: Parameter, value: f64) -> Machine<f64> {
    let mut machine = press();
    machine.set(parameter, value);
    machine
}

fn sensors(present: &[Signal]) -> Vec<Sensor> {
    let all = [(Signal::Spool, 1e-3), (Signal::PressureA, 2e4), (Signal::PressureB, 2e4), (Signal::Position, 5e-5)];
    all.map(|(signal, noise)| Sensor { signal, noise, present: present.contains(&signal) }).to_vec()
}

fn separated(
    chosen: &Machine<f64>,
    rival: &Machine<f64>,
    moves: &[(Parameter, f64)],
    present: &[Signal],
) -> Separation {
    let pairs = [Pair { effect: "chosen", rival: "rival", confidence: 0.2, machine: *rival }];
    let (tests, sensors) = (standard_tests(chosen, 10.0), sensors(present));
    let told = separated_in(&tests, chosen, moves, &pairs, &sensors, Tick::OneMillisecond).unwrap();
    let of_pair: Vec<_> = tests.iter().zip(&told).map(|(test, told)| (test, &told[0].1)).collect();
    separation(&pairs[0], &of_pair, &sensors, &DMatrix::identity(moves.len(), moves.len()))
}

#[test]
fn every_standard_test_runs_and_is_short() {
    let tests = standard_tests(&press(), 10.0);
    assert!(tests.len() >= 8);
    for test in &tests {
        assert!(test.duration_s() > 1.0 && test.duration_s() < 21.0, "{}: {}", test.name, test.duration_s());
        assert!(test.command_v.iter().all(|volts| volts.abs() <= 10.0), "{}", test.name);
        assert!(test.stimulus(&press(), Tick::OneMillisecond).is_some(), "{}", test.name);
    }
}

#[test]
fn holding_a_load_tells_leakage_from_external_leakage_and_the_best_test_comes_first() {
    let chosen = with(Parameter::InternalLeakage, 2e-12);
    let rival = with(Parameter::ExternalLeakageA, 2e-12);
    let found = separated(&chosen, &rival, &[], &[Signal::PressureA, Signal::PressureB, Signal::Position]);
    let hold = found.tests.iter().find(|distance| distance.test == "closed-valve hold under load").unwrap();
    assert!(hold.over_noise > TELLS, "{hold:?}");
    assert!(
        found
            .tests
            .windows(2)
            .all(|pair| (pair[0].tells() && !pair[1].tells()) || pair[0].per_20_s >= pair[1].per_20_s)
    );
    assert!(found.is_separated(), "{found:?}");
}

#[test]
fn a_sensor_that_is_not_there_is_named_where_it_doubles_the_distance() {
    let chosen = with(Parameter::HysteresisWidth, 0.02);
    let rival = with(Parameter::BacklashPlay, 3e-4);
    let found = separated(&chosen, &rival, &[], &[Signal::Spool, Signal::Position]);
    assert!(found.is_separated());
    let blind = separated(&chosen, &rival, &[], &[Signal::PressureA]);
    let (sensor, better) = blind.sensor.as_ref().unwrap();
    assert!(matches!(sensor, Signal::Spool | Signal::Position), "{sensor}");
    assert!(better.per_20_s > 2.0 * blind.tests[0].per_20_s);
}

#[test]
fn what_a_refit_would_take_away_separates_nothing() {
    let chosen = press();
    let rival = with(Parameter::ViscousFriction, 1.01e5);
    let channels = [Signal::PressureA, Signal::PressureB, Signal::Position];
    let far = separated(&chosen, &rival, &[], &channels);
    let near = separated(&chosen, &rival, &[(Parameter::ViscousFriction, 1e4)], &channels);
    assert!(near.tests[0].per_20_s < 0.1 * far.tests[0].per_20_s, "{near:?} {far:?}");
}
