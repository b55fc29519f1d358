//! A result does not depend on the time at which it happens.

use proptest::prelude::*;

use model_core::drive::{Drive, DriveInput, Interfaces, Load};
use model_core::machine::{Machine, Parameter as P, Tick};
use model_core::number::{PerUnit, Scalar};
use recording::excitation::signals::Excitation;
use system_tests::any_effects::{LOAD, STOPS, any_effects, overlapped, without};
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::simulate::{DELAY, State, at_rest, command, drive};
use virtual_plant::InitialState;

use super::cases;

/// The machine without effects that move it while its valve is closed, or that depend on the time since its start: the neutral's drift, the oil
/// that warms up.
fn at_peace(machine: &Machine<f64>) -> Machine<f64> {
    let none = [
        P::ValveOffset,
        P::ValveLeakageOpening,
        P::EdgeRounding,
        P::TankPressure,
        P::InternalLeakage,
        P::LoadForce,
        P::NullDriftTravel,
        P::ViscosityLoss,
    ];
    overlapped(&without(machine, &[&none[..], &LOAD, &STOPS].concat()))
}

/// A run that begins so many ticks later; without dry friction it holds the rounding of its pressures by a little more.
fn later<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, volts: &[f64], wait: usize) -> Vec<Interfaces<N>> {
    let drive = drive::<N>(machine, tick);
    let mut state: State<N> = at_rest(&drive, 0.0, &InitialState::at_rest(machine, 0.1));
    // First, forces that are left by rounding are removed.
    state.chambers.a = N::ZERO;
    state.chambers.b = N::ZERO;
    let start = state;
    for _ in 0..wait {
        drive.step(&mut state, DriveInput::Command(N::ZERO), Load::NONE);
        assert_eq!((state.chambers, state.motion), (start.chambers, start.motion), "nothing moves it");
    }
    volts.iter().map(|&volts| drive.step(&mut state, DriveInput::Command(command(volts)), Load::NONE)).collect()
}

proptest! {
    #![proptest_config(cases(1000))]

    /// Only the position in the ring of the delay line differs.
    #[test]
    fn the_same_later_is_the_same(
        machine in any_machine(),
        tick in any_tick(),
        effects in any_effects(),
        seed in any::<u64>(),
        wait in 1_usize..200,
    ) {
        let machine = at_peace(&effects.on(&machine));
        prop_assume!(Drive::<PerUnit>::new::<DELAY>(&machine, tick).is_ok());
        let volts = &Excitation::random_steps(seed).sample(1e-3)[..1000];
        prop_assert_eq!(later::<PerUnit>(&machine, tick, volts, wait), later::<PerUnit>(&machine, tick, volts, 0));
        prop_assert_eq!(later::<f64>(&machine, tick, volts, wait), later::<f64>(&machine, tick, volts, 0));
    }
}
