//! The derivative by each effect parameter of the smooth effects, also at nil, agrees with the difference of two runs.

use model_core::drive::{Drive, DriveInput, Load};
use model_core::machine::{Machine, Parameter as P, Tick};
use model_core::number::{Field, Scalar};
use model_core::ports::ChamberState;
use recording::excitation::signals::Excitation;
use simulation::number::dual::Dual;
use system_tests::drives;
use system_tests::simulate::{DELAY, State};

/// Spool, both pressures, the supply's and the position, per unit, at every tick.
fn signals<N: Scalar>(machine: &Machine<N::Real>) -> Vec<[N::Real; 5]> {
    let drive = Drive::<N>::new::<DELAY>(machine, Tick::OneMillisecond).unwrap();
    let pressures = ChamberState { a: N::saturated(0.4), b: N::saturated(0.67) };
    let mut state: State<N> = drive.at_rest(N::ZERO, pressures, N::travel(N::Real::constant(0.5)));
    let step = |volts: &f64| {
        drive.step(&mut state, DriveInput::Command(N::saturated(volts / 10.0)), Load::NONE);
        let of = |signal: N| signal.to_real();
        let (chambers, supply) = (state.chambers, state.supply.pressure);
        [of(state.valve.spool()), of(chambers.a), of(chambers.b), of(supply), N::strokes(state.motion.position)]
    };
    Excitation::random_steps(3).sample(1e-3)[..1500].iter().map(step).collect()
}

/// Compares the derivative with differences over `step`, within `tolerance` of the largest value of each signal.
fn check(machine: &Machine<f64>, parameter: P, step: f64, one_sided: bool, tolerance: f64) {
    let moved = |by: f64| signals::<f64>(&machine.with(&[(parameter, machine.get(parameter) + by)]));
    let above = moved(step);
    let below = if one_sided { moved(1e-3 * step) } else { moved(-step) };
    let span = if one_sided { step - 1e-3 * step } else { 2.0 * step };
    let mut lifted = machine.map(Dual::<1>::constant);
    lifted.set(parameter, Dual::variable(machine.get(parameter), 0, 1.0));
    let exact = signals::<Dual<1>>(&lifted);
    let plain = signals::<f64>(machine);
    let key = parameter.description().key;
    let mut moves = false;
    for signal in 0..5 {
        let largest =
            exact.iter().fold(0.0_f64, |largest, row| largest.max(f64::from(row[signal].partials()[0]).abs()));
        moves |= largest > 0.0;
        for (row, exact) in exact.iter().enumerate() {
            let plain = plain[row][signal];
            assert!((exact[signal].value - plain).abs() <= 1e-9, "{key}, {signal}, row {row}: the value");
            assert!(one_sided || exact[signal].value.to_bits() == plain.to_bits(), "{key}, {signal}, row {row}: bits");
            let difference = (above[row][signal] - below[row][signal]) / span;
            let miss = (f64::from(exact[signal].partials()[0]) - difference).abs();
            assert!(miss <= tolerance * largest + 1e-12, "{key}, {signal}, row {row}: {miss:e} of {largest:e}");
        }
    }
    assert!(moves, "{key} moves nothing");
}

/// Parameter, a medium value, and the size of its range.
const SMOOTH: [(P, f64); 18] = [
    (P::HysteresisWidth, 0.05),
    (P::NullDriftTravel, 0.05),
    (P::NullDriftTime, 0.5),
    (P::SolenoidCurvature, 0.7),
    (P::SolenoidLoss, 0.02),
    (P::SolenoidOnset, 0.2),
    (P::FlowForce, 2e-8),
    (P::DeadZoneDifference, 0.04),
    (P::FlowGainLinear, 0.3),
    (P::FlowGainBeyond, 0.2),
    (P::MeteringRatio, 0.2),
    (P::MeteringPorts, -0.1),
    (P::MeteringDirections, 0.1),
    (P::DroopResistance, 3e9),
    (P::ReturnResistance, 3e12),
    (P::ValveLeakageOpening, 0.01),
    (P::EdgeRounding, 0.02),
    (P::LaminarPressure, 2e4),
];

#[test]
fn derivatives_by_each_effect_are_the_differences_with_all_of_them_on() {
    let mut changes = SMOOTH.to_vec();
    changes.extend([(P::DroopTime, 0.02), (P::ValveLeakageReach, 0.1)]);
    let machine = drives::press().with(&changes);
    for &(parameter, size) in &changes {
        check(&machine, parameter, 1e-6 * size, false, 2e-4);
    }
}

#[test]
fn an_effect_at_nil_has_the_derivative_of_its_beginning() {
    let machine = drives::press().with(&[(P::DroopTime, 0.02), (P::SolenoidOnset, 0.2)]);
    for (parameter, size) in SMOOTH {
        // A rounding begins with its square.
        if !matches!(parameter, P::NullDriftTime | P::SolenoidOnset | P::EdgeRounding) {
            check(&machine, parameter, 1e-5 * size, true, 2e-3);
        }
    }
}
