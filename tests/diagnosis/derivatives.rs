//! The derivatives that every fit depends on, against differences of plain runs.

use identification::experiment::Prepared;
use model_core::machine::{Machine, Parameter as P};
use recording::Signal;
use simulation::{By, Derivatives, StartOffset, Stimulus, rows_f64};

use super::bed::{in_oil, pump_case, valve_case};

const SIGNALS: [Signal; 5] = [Signal::Spool, Signal::PressureA, Signal::PressureB, Signal::Velocity, Signal::Position];

fn plain(machine: &Machine<f64>, stimulus: &Stimulus) -> Vec<[f64; 5]> {
    let mut rows = Vec::new();
    rows_f64(machine, stimulus, StartOffset::none(), &mut |_, value| {
        rows.push(SIGNALS.map(|signal| value(signal).unwrap()));
    })
    .unwrap();
    rows
}

/// A value with its derivative.
#[derive(Clone, Copy, Default)]
struct Derived {
    value: f64,
    slope: f64,
}

fn derived(machine: &Machine<f64>, stimulus: &Stimulus, parameter: P) -> Vec<[Derived; 5]> {
    let by = [By { parameter, value: machine.get(parameter), slope: 1.0 }];
    let offset = StartOffset::none();
    let run =
        Derivatives { machine, by: &by, offset, level_slope: 0.0, shift_slope_m: 0.0, stimulus, signals: &SIGNALS };
    let mut rows: Vec<[Derived; 5]> = Vec::new();
    run.run(&mut |row, place, found| {
        rows.resize(row + 1, [Derived::default(); 5]);
        let (value, slopes) = found.unwrap();
        rows[row][place] = Derived { value, slope: f64::from(slopes[0]) };
    })
    .unwrap();
    rows
}

/// The derivative of the position by the start's shift, at the last row: all of the shift, where the sensor goes along or is pushed.
fn by_shift(machine: &Machine<f64>, stimulus: &Stimulus, shift_m: f64) -> (f64, f64) {
    let offset = StartOffset { shift_m, ..StartOffset::none() };
    let signals = [Signal::Position];
    let run =
        Derivatives { machine, by: &[], offset, level_slope: 0.0, shift_slope_m: 1.0, stimulus, signals: &signals };
    let mut slopes = Vec::new();
    run.run(&mut |_, _, found| slopes.push(f64::from(found.unwrap().1[1]))).unwrap();
    (slopes[0], slopes[slopes.len() - 1])
}

#[test]
fn the_start_within_a_play_moves_what_the_sensor_shows_once_it_is_pushed() {
    let case = valve_case(31, None, true, None);
    let mut machine = case.file.machine;
    let prepared = Prepared::new(&case.training[0], &machine, case.file.load_source, None).unwrap();
    let (first, last) = by_shift(&machine, &prepared.stimulus, 0.0);
    assert!((first - 1.0).abs() < 1e-6 && (last - 1.0).abs() < 0.2, "{first} {last}");
    machine.set(P::BacklashPlay, 1e-3);
    let (first, last) = by_shift(&machine, &prepared.stimulus, 3e-4);
    assert!(first.abs() < 1e-6 && (last - 1.0).abs() < 0.2, "{first} {last}");
}

/// Values agree to the last bit. Derivatives agree within 1e-4 of the signal's largest one, against central differences of a step so small
/// that the rod starts and stops in the same ticks.
fn check(machine: &Machine<f64>, stimulus: &Stimulus, parameter: P, scale: f64) {
    let step = 1e-6 * scale;
    let moved = |by: f64| {
        let mut moved = *machine;
        moved.set(parameter, machine.get(parameter) + by);
        plain(&moved, stimulus)
    };
    let (at, above, below) = (plain(machine, stimulus), moved(step), moved(-step));
    let exact = derived(machine, stimulus, parameter);
    let key = parameter.description().key;
    for (index, signal) in SIGNALS.iter().enumerate() {
        let largest = exact.iter().fold(0.0_f64, |largest, row| largest.max(row[index].slope.abs()));
        let mut worst = 0.0_f64;
        for (row, plain) in at.iter().enumerate() {
            assert_eq!(exact[row][index].value.to_bits(), plain[index].to_bits(), "{key}, {signal}, row {row}");
            let difference = (above[row][index] - below[row][index]) / (2.0 * step);
            worst = worst.max((exact[row][index].slope - difference).abs());
        }
        assert!(worst <= 1e-4 * largest, "{key}, {signal}: {worst:e} of {largest:e}");
    }
}

#[test]
fn derivatives_of_a_valve_drive_by_every_uncertain_value_are_its_differences() {
    let case = valve_case(31, None, true, None);
    let mut machine = case.file.machine;
    // A delay of whole ticks has different derivatives on its two sides; this one is of 7.3 ticks.
    machine.set(P::TransportDelay, 0.0073);
    for (parameter, value) in [(P::InternalLeakage, 3e-12), (P::HoseCompliance, 3e-13), (P::CoulombFriction, 500.0)] {
        machine.set(parameter, value);
    }
    let prepared = Prepared::new(&case.training[0], &machine, case.file.load_source, None).unwrap();
    for &parameter in case.file.sigma.keys() {
        check(&machine, &prepared.stimulus, parameter, machine.get(parameter));
    }
    for parameter in [P::InternalLeakage, P::HoseCompliance, P::CoulombFriction] {
        check(&machine, &prepared.stimulus, parameter, machine.get(parameter));
    }
}

/// Each effect parameter alone, at a value that does not stop the rod more often than it stops without the effect.
#[test]
fn derivatives_by_the_smooth_effects_of_chambers_mechanics_and_sensors_are_differences() {
    let case = valve_case(31, None, true, None);
    let machine = case.file.machine;
    let recording = in_oil(&case.training[0], |time_s| 30.0 + 10.0 * time_s);
    let press = |changes: &[(P, f64)], of: &[(P, f64)]| {
        let mut machine = machine;
        for &(parameter, value) in changes.iter().chain(of) {
            machine.set(parameter, value);
        }
        let prepared = Prepared::new(&recording, &machine, case.file.load_source, None).unwrap();
        for &(parameter, value) in of {
            // Some parameters move the rod by micrometres: they need a step large enough to be visible above rounding.
            check(&machine, &prepared.stimulus, parameter, 30.0 * value.abs());
        }
    };
    press(&[], &[(P::ExternalLeakageA, 2e-12), (P::ExternalLeakageB, 3e-12)]);
    press(&[], &[(P::AirShare, 0.01)]);
    press(&[], &[(P::VolumeShare, 0.5)]);
    press(&[], &[(P::PositionDragSlope, 0.5), (P::PositionDragBow, 0.8)]);
    press(&[], &[(P::LoadSpring, 1e4), (P::LoadSpringForce, 300.0), (P::LoadSpringBow, 2e5)]);
    press(&[(P::InternalLeakage, 3e-12)], &[(P::ViscosityLoss, 0.4), (P::WarmingTime, 3.0)]);
    press(
        &[(P::InternalLeakage, 3e-12)],
        &[(P::ViscosityLossPerKelvin, 0.03), (P::ReferenceTemperature, 35.0), (P::ViscosityLoss, 0.4)],
    );
    press(&[], &[(P::PositionLag, 5e-3), (P::PositionDelay, 7.3e-3)]);
    press(&[], &[(P::PressureAOffset, 1e5), (P::PressureBFactor, 0.03), (P::PositionFactor, 0.02)]);
}

/// At an effect parameter of 0 the value is that of the model without the effect, and the derivative exists.
#[test]
fn an_effect_of_nothing_has_a_derivative() {
    let case = valve_case(31, None, true, None);
    let machine = case.file.machine;
    let recording = in_oil(&case.training[0], |time_s| 50.0 + time_s);
    let prepared = Prepared::new(&recording, &machine, case.file.load_source, None).unwrap();
    let without = plain(&machine, &prepared.stimulus);
    for parameter in [
        P::ExternalLeakageA,
        P::ExternalLeakageB,
        P::AirShare,
        P::VolumeShare,
        P::CoulombFriction,
        P::StribeckForce,
        P::StribeckExcess,
        P::AsymmetricExtending,
        P::AsymmetricRetracting,
        P::PositionFriction,
        P::PositionFrictionSlope,
        P::PositionDragSlope,
        P::PositionDragBow,
        P::PressureFriction,
        P::LoadSpring,
        P::LoadSpringForce,
        P::LoadSpringBow,
        P::PreslidingForce,
        P::ViscosityLoss,
        P::ViscosityLossPerKelvin,
        P::BacklashPlay,
        P::PositionLag,
        P::PositionDelay,
        P::PressureAOffset,
        P::PressureBFactor,
        P::PositionFactor,
    ] {
        let found = derived(&machine, &prepared.stimulus, parameter);
        let key = parameter.description().key;
        let mut moved = 0.0_f64;
        for (found, without) in found.iter().zip(&without) {
            for (found, without) in found.iter().zip(without) {
                assert!(
                    (found.value - without).abs() <= 1e-9 * (1.0 + without.abs()),
                    "{key}: {} {without}",
                    found.value
                );
                assert!(found.slope.is_finite(), "{key}");
                moved = moved.max(found.slope.abs());
            }
        }
        // The position-dependent friction may be limited to zero.
        assert!(moved > 0.0 || parameter == P::PositionFrictionSlope, "{key}");
    }
}

#[test]
fn derivatives_of_a_pump_drive_by_every_uncertain_value_are_its_differences() {
    let case = pump_case(32, None);
    let mut machine = case.file.machine;
    machine.set(P::PumpSlip, 3e-13);
    let prepared = Prepared::new(&case.training[0], &machine, case.file.load_source, None).unwrap();
    for &parameter in case.file.sigma.keys().chain(&[P::PumpSlip]) {
        check(&machine, &prepared.stimulus, parameter, machine.get(parameter));
    }
}
