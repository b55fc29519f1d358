//! Fixed point and f64 are one model.

use host_sim::testbed::{Excitation, InitialState};
use model_core::fixed_point::PerUnit;
use model_core::parameter::Parameter as P;
use proptest::prelude::*;
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::simulate::{core, distance};

use super::cases;

/// Budget of the rounding over 4 s, strokes: a tenth of the position's tolerance.
const POSITION: f64 = 1e-5;
/// The same, supply pressures.
const PRESSURE: f64 = 5e-5;
/// Share of the travel: the gain from velocity to strokes per tick, 5e-6 in a slow, long drive, is rounded by 2e-9.
const TRAVEL_SHARE: f64 = 4e-4;

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn fixed_point_and_f64_agree_for_every_drive(machine in any_machine(), tick in any_tick(), seed in any::<u64>()) {
        let volts = Excitation::random_steps(seed).sample(tick.seconds());
        let initial = InitialState::at_rest(&machine, 0.0);
        let real = core::<f64>(&machine, tick, &volts, &initial);
        let fixed = core::<PerUnit>(&machine, tick, &volts, &initial);
        let apart = distance(&real, &fixed);
        let travel = real.iter().fold(0.0_f64, |travel, row| travel.max(row.position.abs()));
        // Dry friction decides: the last bit may let the rod go, or catch it, a tick earlier, and its pressures with it.
        let sticks = machine.get(P::CoulombFriction) > 0.0;
        let per_tick = real.windows(2).fold(0.0_f64, |most, pair| most.max((pair[1].position - pair[0].position).abs()));
        let decided = if sticks { 2.0 * per_tick } else { 0.0 };
        prop_assert!(apart.position <= POSITION + TRAVEL_SHARE * travel + decided, "{apart:?} of {travel}, {per_tick} a tick");
        prop_assert!(sticks || apart.pressure <= PRESSURE, "{apart:?}");
    }
}
