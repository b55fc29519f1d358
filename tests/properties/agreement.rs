//! Fixed point and f64 compute one model.

use std::cell::RefCell;

use proptest::prelude::*;

use model_core::machine::Parameter as P;
use model_core::number::{PerUnit, Scalar};
use recording::excitation::signals::Excitation;
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::simulate::{Row, core, distance};
use virtual_plant::InitialState;

use super::runner;

/// What rounding may make of a run of 4 s.
pub(crate) struct Budget {
    /// Of the position, strokes.
    pub(crate) position: f64,
    /// Of the pressures, in supply pressures, or as a multiple of the largest sum of both pressures where this is more.
    pub(crate) pressure: f64,
    /// Share of the travel by which the position may be off besides.
    pub(crate) travel_share: f64,
}

/// That of fixed point.
const BUDGET: Budget = Budget {
    // A tenth of the position's tolerance.
    position: 1e-5,
    pressure: 1e-4,
    // The gain from velocity to strokes per tick, 5e-6 in a slow, long drive, is rounded by 2e-9.
    travel_share: 4e-4,
};

/// Near the end of the format, ±8 supply pressures, or the force of these on A: there fixed point limits the force on the rod, and f64 does not.
pub(crate) const HELD: f64 = 7.5;

/// Largest sum of the absolute values of both pressures in a run, supply pressures.
pub(crate) fn largest_pressures(run: &[Row]) -> f64 {
    run.iter().fold(0.0, |largest, row| largest.max(row.pressure_a.abs() + row.pressure_b.abs()))
}

#[test]
fn fixed_point_and_f64_agree_for_every_drive() {
    assert_agrees::<PerUnit>(&BUDGET, file!());
}

/// That a number type computes of every drive what f64 computes; `file` is that of the test.
pub(crate) fn assert_agrees<N: Scalar<Real = f64>>(budget: &Budget, file: &'static str) {
    let at_the_limit = RefCell::new(Vec::new());
    runner(1000, file)
        .run(&(any_machine(), any_tick(), any::<u64>()), |(machine, tick, seed)| {
            let volts = Excitation::random_steps(seed).sample(tick.seconds());
            let initial = InitialState::at_rest(&machine, 0.0);
            let real = core::<f64>(&machine, tick, &volts, &initial);
            let highest = largest_pressures(&real);
            prop_assume!(highest < HELD);
            let apart = distance(&real, &core::<N>(&machine, tick, &volts, &initial));
            let travel = real.iter().fold(0.0_f64, |travel, row| travel.max(row.position.abs()));
            // Dry friction decides: the last bit may release or stop the rod a tick earlier, and its pressures change with it.
            let sticks = machine.get(P::CoulombFriction) > 0.0;
            let ways = real.windows(2).map(|pair| (pair[1].position - pair[0].position).abs());
            let per_tick = ways.fold(0.0, f64::max);
            let decided = if sticks { 2.0 * per_tick } else { 0.0 };
            let most = budget.position + budget.travel_share * travel + decided;
            prop_assert!(apart.position <= most, "{apart:?} of {travel}, {per_tick} a tick");
            let off = apart.pressure / (budget.pressure * highest.max(1.0));
            let limited = machine.get(P::FlowLimit).is_finite();
            if limited && !sticks {
                at_the_limit.borrow_mut().push(off);
            }
            prop_assert!(sticks || limited || off <= 1.0, "{apart:?}");
            Ok(())
        })
        .unwrap();
    // A drive with a limited flow may oscillate at its limit (`settling`), and rounding errors with it.
    let at_the_limit = at_the_limit.into_inner();
    let far = at_the_limit.iter().filter(|off| **off > 1.0 || off.is_nan()).count();
    println!("{far} of {} with a limited flow are further off", at_the_limit.len());
    assert!(at_the_limit.len() > 100 && 20 * far < at_the_limit.len(), "{far} of {}", at_the_limit.len());
}
