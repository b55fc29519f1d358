//! A drive that is alike on both sides does not know left from right.

use host_sim::testbed::{Excitation, InitialState};
use model_core::fixed_point::PerUnit;
use model_core::machine::{Machine, Tick};
use model_core::number::Number;
use model_core::parameter::Parameter as P;
use proptest::prelude::*;
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::simulate::{Distance, Row, core, distance};

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

fn unlikeness<N: Number<Real = f64>>(machine: &Machine<f64>, tick: Tick, seed: u64) -> Distance {
    let volts = Excitation::random_steps(seed).sample(tick.seconds());
    let mirrored: Vec<f64> = volts.iter().map(|volts| -volts).collect();
    let initial = InitialState::at_rest(machine, 0.0);
    let there = core::<N>(machine, tick, &volts, &initial);
    let back: Vec<Row> = core::<N>(machine, tick, &mirrored, &initial)
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
}
