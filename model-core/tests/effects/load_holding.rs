//! Load-holding valves: free into the chamber, and out of it only as far as the pressures open them.

use proptest::prelude::*;

use model_core::flow::PumpDrive;
use model_core::machine::{Machine, Parameter as P};
use model_core::number::{PerUnit, Scalar};
use model_core::ports::ChamberState;

use super::bench::{at_rest, cases, commanded, drive, press, with};

const SUPPLY_PA: f64 = 7e6;
/// Of chamber A: opened by 90 bar, of which the pressure in B gives three times as much as its own.
const SET_PA: f64 = 9e6;
const RATIO: f64 = 3.0;
const SPAN_PA: f64 = 5e6;

fn holding() -> Machine<f64> {
    with(&press(), &[(P::HoldingSetA, SET_PA), (P::PilotRatio, RATIO), (P::HoldingSpan, SPAN_PA)])
}

/// Flows into A and out of B over `K_Q`·√p0, with these pressures in Pa.
fn flows<N: Scalar<Real = f64>>(machine: &Machine<f64>, spool: f64, [a, b]: [f64; 2]) -> [f64; 2] {
    let drive = drive::<N>(machine);
    let full = machine.get(P::FlowCoefficient) * SUPPLY_PA.sqrt() / drive.bases().flow_m3_per_s;
    let pressures = ChamberState { a: N::saturated(a / SUPPLY_PA), b: N::saturated(b / SUPPLY_PA) };
    let found = drive.flows(N::saturated(spool), PumpDrive { speed: N::ZERO, direction: 0 }, pressures);
    [found.a, found.b].map(|flow| flow.to_f64() / full)
}

/// What flows out of A with the spool this far towards retracting, over `K_Q`·√p0.
fn out_of_a(spool: f64, [a, b]: [f64; 2]) -> f64 {
    let edge = spool - 0.05;
    let poppet = ((a + RATIO * b - SET_PA) / SPAN_PA).clamp(0.0, 2.0);
    let opening = if poppet > 0.0 { edge * poppet / edge.hypot(poppet) } else { 0.0 };
    opening * (a / SUPPLY_PA).sqrt()
}

#[test]
fn oil_leaves_the_chamber_past_poppet_and_edge_in_series() {
    // Shut, just open, half open, as wide as it goes.
    for pressures in [[4e6, 1e6], [4e6, 1.7e6], [3e6, 3e6], [6e6, 6e6]] {
        for spool in [0.1, 0.4, 1.0] {
            let expected = out_of_a(spool, pressures);
            for found in [flows::<f64>(&holding(), -spool, pressures), flows::<PerUnit>(&holding(), -spool, pressures)]
            {
                assert!((found[0] + expected).abs() < 2e-6, "{spool} {pressures:?}: {found:?} {expected}");
            }
        }
    }
    assert!(out_of_a(0.4, [3e6, 3e6]) > 0.1 && out_of_a(0.4, [4e6, 1e6]) == 0.0);
}

#[test]
fn oil_enters_freely_and_the_other_chamber_has_no_such_valve() {
    for pressures in [[4e6, 1e6], [3e6, 3e6]] {
        let (with, without) = (flows::<f64>(&holding(), 0.6, pressures), flows::<f64>(&press(), 0.6, pressures));
        for (with, without) in with.into_iter().zip(without) {
            assert!((with - without).abs() < 1e-9, "{with} {without}");
        }
    }
    // A load that is above the supply does not push oil back through a valve that its pressure does not open.
    assert!(flows::<f64>(&holding(), 0.6, [8e6, 0.0])[0] == 0.0);
    assert!(flows::<f64>(&press(), 0.6, [8e6, 0.0])[0] < -0.1);
}

/// A pulling load of 9 kN, and a setting of 240 bar: the spool opens A to the tank, and the rod sinks only as far as the pressure in B opens the valve.
#[test]
fn a_load_is_held_until_the_other_side_is_pressed() {
    fn sunk<N: Scalar<Real = f64>>(machine: &Machine<f64>) -> [f64; 2] {
        let machine = with(machine, &[(P::LoadForce, -9e3)]);
        let drive = drive::<N>(&machine);
        let mut state = at_rest(&drive, [9e3 / 3.117e-3 / SUPPLY_PA, 0.0], 0.7);
        let mut lowest_b: f64 = 1.0;
        for tick in 0..700 {
            commanded(&drive, &mut state, -0.5);
            if tick > 400 {
                lowest_b = lowest_b.min(state.chambers.b.to_f64());
            }
        }
        [N::strokes(state.motion.position), lowest_b * SUPPLY_PA]
    }
    let holding = with(&holding(), &[(P::HoldingSetA, 2.4e7)]);
    for [held, free] in
        [[sunk::<f64>(&holding), sunk::<f64>(&press())], [sunk::<PerUnit>(&holding), sunk::<PerUnit>(&press())]]
    {
        assert!(held[0] > free[0] + 0.02, "{held:?} {free:?}");
        assert!(held[1] > free[1] + 3e5, "{held:?} {free:?}");
    }
}

#[test]
fn the_poppet_follows_with_its_time_constant() {
    let machine = with(&holding(), &[(P::HoldingTime, 0.05), (P::DeadZone, 0.5)]);
    let drive = drive::<f64>(&machine);
    let mut state = at_rest(&drive, [0.5, 0.2], 0.5);
    assert!(state.poppets.a.abs() < 1e-12);
    // Closed edges: both pressures stay where they are set.
    state.chambers = ChamberState { a: 0.5, b: 0.6 };
    let rest = at_rest(&drive, [0.5, 0.6], 0.5).poppets.a;
    for _ in 0..50 {
        state.chambers = ChamberState { a: 0.5, b: 0.6 };
        commanded(&drive, &mut state, 0.0);
    }
    let reached = state.poppets.a / rest;
    assert!((reached - (1.0 - (-1.0_f64).exp())).abs() < 1e-6, "{reached}");
}

proptest! {
    #![proptest_config(cases(40))]

    /// No poppet leaves its range, and fixed point stays with f64 for a second of any commands.
    #[test]
    fn no_setting_and_no_pilot_runs_away(
        settings in prop::array::uniform2(0.2..3.0_f64), ratio in 0.0..15.0_f64, span in -1.5..1.0_f64,
        time in -2.7..0.0_f64, commands in prop::collection::vec(-1.0..1.0_f64, 1..12),
    ) {
        let machine = with(&press(), &[
            (P::HoldingSetA, settings[0] * SUPPLY_PA), (P::HoldingSetB, settings[1] * SUPPLY_PA),
            (P::PilotRatio, ratio), (P::HoldingSpan, SUPPLY_PA * 10_f64.powf(span)), (P::HoldingTime, 10_f64.powf(time)),
        ]);
        let drive = drive::<PerUnit>(&machine);
        let widest = 2.0 * machine.get(P::FlowCoefficient) * SUPPLY_PA.sqrt() / drive.bases().flow_m3_per_s;
        let mut state = at_rest(&drive, [0.5, 0.5], 0.5);
        for command in commands {
            for _ in 0..200 {
                commanded(&drive, &mut state, command);
                for poppet in [state.poppets.a, state.poppets.b] {
                    prop_assert!((0.0..=widest + 1e-7).contains(&poppet.to_f64()), "{poppet:?}");
                }
                // A closed chamber that the other one presses rises by the ratio of the areas, and the moving mass more.
                prop_assert!(state.chambers.a.to_f64() < 6.0 && state.chambers.b.to_f64() < 6.0, "{:?}", state.chambers);
            }
        }
    }
}
