//! A drive that is alike on both sides does not know left from right; one that is not is its mirror image's mirror image.

use host_sim::testbed::{Excitation, InitialState};
use model_core::drive::Drive;
use model_core::fixed_point::PerUnit;
use model_core::machine::{Machine, Tick};
use model_core::number::Scalar;
use model_core::parameter::Parameter as P;
use proptest::prelude::*;
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::simulate::{DELAY, Distance, Row, core, distance};

use super::cases;

fn alike_on_both_sides(mut machine: Machine<f64>) -> Machine<f64> {
    machine.set(P::AreaA, machine.get(P::AreaB));
    // The larger oil column: it is the one that surely fits.
    machine.set(P::VolumeA, machine.get(P::VolumeA).max(machine.get(P::VolumeB)));
    machine.set(P::VolumeB, machine.get(P::VolumeA));
    for zero in [P::ValveOffset, P::LoadForce] {
        machine.set(zero, 0.0);
    }
    machine
}

/// The same drive with its chambers exchanged, so that it extends where the other retracts.
fn mirror_image(machine: &Machine<f64>) -> Machine<f64> {
    machine.with(&[
        (P::AreaA, machine.get(P::AreaB)),
        (P::AreaB, machine.get(P::AreaA)),
        (P::VolumeA, machine.get(P::VolumeB)),
        (P::VolumeB, machine.get(P::VolumeA)),
        (P::ValveOffset, -machine.get(P::ValveOffset)),
        (P::LoadForce, -machine.get(P::LoadForce)),
    ])
}

fn unlikeness<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, seed: u64) -> Distance {
    let volts = Excitation::random_steps(seed).sample(tick.seconds());
    let mirrored: Vec<f64> = volts.iter().map(|volts| -volts).collect();
    let initial = InitialState::at_rest(machine, 0.0);
    let image = mirror_image(machine);
    let beside = InitialState { pressure_a_pa: initial.pressure_b_pa, pressure_b_pa: initial.pressure_a_pa, ..initial };
    let there = core::<N>(machine, tick, &volts, &initial);
    let back: Vec<Row> = core::<N>(&image, tick, &mirrored, &beside)
        .into_iter()
        .map(|row| Row { pressure_a: row.pressure_b, pressure_b: row.pressure_a, position: -row.position })
        .collect();
    distance(&there, &back)
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn a_mirrored_command_mirrors_the_motion(
        machine in any_machine().prop_map(alike_on_both_sides),
        tick in any_tick(),
        seed in any::<u64>(),
    ) {
        let real = unlikeness::<f64>(&machine, tick, seed);
        prop_assert!(real.position < 1e-9 && real.pressure < 1e-9, "{real:?}");
        let fixed = unlikeness::<PerUnit>(&machine, tick, seed);
        prop_assert!(fixed.position < 1e-5 && fixed.pressure < 1e-5, "{fixed:?}");
    }
    /// In f64: the scales of the fixed-point format go by side A.
    #[test]
    fn the_mirror_image_of_any_drive_moves_as_its_mirror_image(
        machine in any_machine(),
        tick in any_tick(),
        seed in any::<u64>(),
    ) {
        // Other scales round otherwise, and dry friction lets the last bit decide.
        let machine = machine.with(&[(P::CoulombFriction, 0.0)]);
        prop_assume!(Drive::<f64>::new::<DELAY>(&mirror_image(&machine), tick).is_ok());
        let real = unlikeness::<f64>(&machine, tick, seed);
        prop_assert!(real.position < 1e-9 && real.pressure < 1e-9, "{real:?}");
    }
}
