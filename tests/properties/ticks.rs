//! Ticks of 0.5, 1 and 2 ms agree to second order where nothing switches.
//!
//! A switching event takes effect at the end of a tick, up to a tick late or early, and has no order: a command that is held before a valve
//! without lags, the edge of a dead zone, a rate limit. What is decided at such a moment may last: a spool that has jumped and one that has not
//! stay where they are, and so does a rod that dry friction holds. So no error bound there holds for every machine.

use std::cell::RefCell;

use proptest::prelude::*;

use model_core::machine::{Machine, Parameter as P, Source};
use model_core::number::PerUnit;
use system_tests::simulate::{Row, core, distance};
use virtual_plant::InitialState;

use super::runner;
use super::smooth::{Smooth, TICKS, any_smooth, quantile};

/// Factor by which halving the tick divides the difference between two ticks, for position and pressures; `None` near a corner.
fn divided_by(smooth: &Smooth) -> Option<[f64; 2]> {
    let mut runs = Vec::new();
    for (tick, every) in TICKS.into_iter().zip([1, 2, 4]) {
        let run: Vec<Row> = smooth.run(tick)?.iter().map(|at| at.row).step_by(every).collect();
        runs.push(run);
    }
    let (coarse, fine) = (distance(&runs[0], &runs[1]), distance(&runs[1], &runs[2]));
    Some([coarse.position / fine.position, coarse.pressure / fine.pressure])
}

/// (1)–(14), as `chain` solves them: halving the tick divides the error of a second-order step by four, of a first-order step by two.
/// For single machines, two errors of opposite signs may make it more or less.
#[test]
fn halving_the_tick_divides_the_error_by_four_on_any_machine_where_nothing_switches() {
    let found = RefCell::new([Vec::new(), Vec::new()]);
    runner(500, file!())
        .run(&any_smooth(), |smooth| {
            let ratios = divided_by(&smooth);
            prop_assume!(ratios.is_some());
            for (found, ratio) in found.borrow_mut().iter_mut().zip(ratios.into_iter().flatten()) {
                found.push(ratio);
            }
            Ok(())
        })
        .unwrap();
    for (mut ratios, of) in found.into_inner().into_iter().zip(["position", "pressure"]) {
        let [least, low, middle] = [0.01, 0.05, 0.5].map(|share| quantile(&mut ratios, share));
        println!("{of}: one in a hundred below {least:.2}, one in twenty below {low:.2}, half below {middle:.2}");
        assert!(least > 2.0 && low > 2.7 && (3.7..4.3).contains(&middle), "{of}: {least} {low} {middle}");
    }
}

/// A valve that would pass seven times the limit, open for good, on a rod that a damper holds: a tick at the limit fills A beyond the supply.
/// The pressure in A must end at the supply pressure at any tick, with two edges and with four. Without a slope of the limited flow it ended
/// at 0.60 of it at 2 ms, where the flows of both stages cancel.
#[test]
fn a_flow_that_was_at_its_limit_ends_at_the_true_pressures() {
    let two_edges = Machine::with_defaults(Source::Valve).with(&[
        (P::SupplyPressure, 2e6),
        (P::FlowLimit, 8e-5),
        (P::FlowCoefficient, 4e-7),
        (P::AreaA, 4.9e-4),
        (P::AreaB, 4.1e-4),
        (P::Stroke, 0.2),
        (P::VolumeA, 1.4e-4),
        (P::VolumeB, 1.4e-4),
        (P::BulkModulus, 7.4e8),
        (P::MovingMass, 5.0),
        (P::ViscousFriction, 4e5),
        (P::ValveGain, 0.1),
    ]);
    let four_edges = two_edges.with(&[(P::DroopResistance, 1e3), (P::DroopTime, 1e-3)]);
    for machine in [two_edges, four_edges] {
        let initial = InitialState::at_rest(&machine, 0.0);
        for tick in TICKS {
            for found in [
                core::<f64>(&machine, tick, &[10.0; 1000], &initial)[999],
                core::<PerUnit>(&machine, tick, &[10.0; 1000], &initial)[999],
            ] {
                assert!((found.pressure_a - 1.0).abs() < 0.05, "{tick:?}: {found:?}");
            }
        }
    }
}
