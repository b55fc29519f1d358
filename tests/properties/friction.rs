//! Dry friction holds the rod exactly, and can only brake it.

use proptest::prelude::*;

use model_core::drive::{Drive, DriveInput, Load};
use model_core::machine::{Machine, Parameter as P, Tick};
use model_core::number::{PerUnit, Scalar};
use model_core::ports::{Forces, MotionState, Surroundings};
use system_tests::any_effects::{LOAD, LUGRE, STOPS, any_effects, overlapped, without};
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::simulate::{DELAY, at_rest, drive};
use virtual_plant::InitialState;

use super::cases;

/// A machine with dry friction of up to a tenth of the drive's force and any other effects, except those that push the rod or feed a chamber.
/// Its valve is closed.
fn with_friction() -> impl Strategy<Value = Machine<f64>> {
    (any_machine(), any_effects(), 0.001..0.1).prop_map(|(machine, effects, share)| {
        let machine = effects.on(&machine);
        let none = [
            P::ValveOffset,
            P::ValveLeakageOpening,
            P::EdgeRounding,
            P::NullDriftTravel,
            P::InternalLeakage,
            P::ExternalLeakageA,
            P::ExternalLeakageB,
        ];
        let none = [&none[..], &LOAD, &STOPS, &LUGRE].concat();
        overlapped(&without(&machine, &none))
            .with(&[(P::CoulombFriction, share * machine.get(P::AreaA) * machine.get(P::SupplyPressure))])
    })
}

/// The machine with a dry friction that is nowhere less than Coulomb's.
fn everywhere_alike(machine: &Machine<f64>) -> Machine<f64> {
    without(machine, &[P::PositionFrictionSlope, P::PositionFrictionBow])
}

fn held<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, share: f64, shaking: &[f64]) {
    let drive = drive::<N>(machine, tick);
    let friction_n = machine.get(P::CoulombFriction);
    let mut initial = InitialState::at_rest(machine, 0.1);
    // Up to half the friction balances the pressures, up to another half the load.
    initial.pressure_a_pa += 0.49 * share * friction_n / machine.get(P::AreaA);
    let start = at_rest(&drive, 0.0, &initial);
    let mut state = start;
    let force = |share: &f64| N::saturated(0.49 * share * friction_n / drive.bases().force_n);
    for pair in shaking.windows(2) {
        let seen =
            drive.step(&mut state, DriveInput::Command(N::ZERO), Load { from: force(&pair[0]), to: force(&pair[1]) });
        assert_eq!(seen.velocity, N::ZERO);
        assert_eq!(state.motion, start.motion, "it sticks");
        assert_eq!(state.chambers, start.chambers, "and no oil is pressed");
    }
}

/// Whether a rod without other forces, at a velocity and a position, never gets faster: with these shares for the pressure on its seals and
/// the temperature of the oil.
fn only_brakes<N: Scalar<Real = f64>>(
    machine: &Machine<f64>,
    tick: Tick,
    (velocity, place): (f64, f64),
    [pressed, warm]: [f64; 2],
) -> bool {
    let drive = drive::<N>(machine, tick);
    let mut state = MotionState { velocity: N::saturated(velocity), ..MotionState::at_rest(N::travel(place)) };
    let around = Surroundings { pressed: N::saturated(pressed), viscosity: N::saturated(warm), ..Surroundings::NONE };
    let free = Forces { start: N::ZERO, first: N::ZERO, second: N::ZERO, around };
    (0..50).all(|_| {
        let before = state.velocity;
        drive.mechanics().step(&mut state, free);
        state.velocity.to_f64().abs() <= before.to_f64().abs()
    })
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn what_sticks_stays_exactly_where_it_is(
        machine in with_friction(),
        tick in any_tick(),
        share in -1.0..1.0,
        shaking in prop::collection::vec(-1.0..1.0, 2..100),
    ) {
        let machine = everywhere_alike(&machine);
        prop_assume!(Drive::<PerUnit>::new::<DELAY>(&machine, tick).is_ok());
        held::<PerUnit>(&machine, tick, share, &shaking);
        held::<f64>(&machine, tick, share, &shaking);
    }

    #[test]
    fn dry_friction_never_accelerates(
        machine in with_friction(),
        tick in any_tick(),
        share in -1.0..1.0_f64,
        small in 0_i32..28,
        place in 0.0..1.0_f64,
        around in prop::array::uniform2(0.0..1.0_f64),
    ) {
        prop_assume!(Drive::<PerUnit>::new::<DELAY>(&machine, tick).is_ok());
        let velocity = share * f64::exp2(-f64::from(small));
        prop_assert!(only_brakes::<PerUnit>(&machine, tick, (velocity, place), around), "fixed point");
        prop_assert!(only_brakes::<f64>(&machine, tick, (velocity, place), around), "f64");
    }
}
