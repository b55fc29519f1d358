//! Leakage to tank, air in the oil, volumes that follow the piston.

use model_core::machine::Parameter as P;
use model_core::number::{PerUnit, Scalar, Single};

use super::bench::{State, at_rest, commanded, drive, press, with};

const SUPPLY_PA: f64 = 7e6;
const ATMOSPHERE_PA: f64 = 1.013e5;

/// The press with a rod that hardly moves, so that only the chamber has an effect.
fn clamped(changes: &[(P, f64)]) -> model_core::machine::Machine<f64> {
    with(&with(&press(), &[(P::CoulombFriction, 5e4)]), changes)
}

fn after<N: Scalar<Real = f64>>(drive: &model_core::drive::Drive<N>, state: &mut State<N>, ticks: usize) -> [f64; 2] {
    for _ in 0..ticks {
        commanded(drive, state, 0.0);
    }
    [state.chambers.a.to_f64() * SUPPLY_PA, state.chambers.b.to_f64() * SUPPLY_PA]
}

/// dp/dt = −G·E0/V·(p − pt): over one time constant, to a share 1/e.
#[test]
fn a_leaking_chamber_falls_to_tank_by_its_own_time_constant() {
    fn check<N: Scalar<Real = f64>>() {
        let leakage = 2e-12;
        let tank_pa = 2e5;
        let drive = drive::<N>(&clamped(&[(P::ExternalLeakageA, leakage), (P::TankPressure, tank_pa)]));
        let time_s = 5.2e-4 / 1.2e9 / leakage;
        // 216.7 ms
        let mut state = at_rest(&drive, [0.5, 0.5], 0.5);
        let [a, b] = after(&drive, &mut state, 217);
        let expected = tank_pa + (3.5e6 - tank_pa) * (-0.217 / time_s).exp();
        assert!((a - expected).abs() < 100.0, "{a} {expected}");
        assert!((b - 3.5e6).abs() < 1e-6 * SUPPLY_PA, "nothing leaves B: {b}");
        let [a, _] = after(&drive, &mut state, 5000);
        assert!((a - tank_pa).abs() < 10.0, "{a}");
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

/// A flow of 1e-5 m³/s for a tick into A, the rod held fast: dp = h·Q/C.
fn rise_pa<N: Scalar<Real = f64>>(changes: &[(P, f64)], pressure_pa: f64, position: f64) -> f64 {
    let drive = drive::<N>(&clamped(changes));
    let flow = N::saturated(1e-5 / drive.bases().flow_m3_per_s);
    let mut state = at_rest(&drive, [pressure_pa / SUPPLY_PA, 0.0], position);
    let flows = model_core::ports::Flows { a: flow, b: N::ZERO };
    let before = state.chambers.a.to_f64();
    drive.step(
        &mut state,
        model_core::drive::DriveInput::Flow { from: flows, to: flows },
        model_core::drive::Load::NONE,
    );
    (state.chambers.a.to_f64() - before) * SUPPLY_PA
}

#[test]
fn air_makes_a_chamber_soft_at_low_pressure_and_hardly_at_high() {
    fn check<N: Scalar<Real = f64>>() {
        for (pressure_pa, share) in [(0.0, 0.01), (1e5, 0.01), (3e5, 0.03), (1e6, 0.01), (5e6, 0.05)] {
            let absolute = pressure_pa + ATMOSPHERE_PA;
            let capacity = |absolute: f64| {
                5.2e-4 / 1.2e9 * (1.0 + 1.2e9 * share * (ATMOSPHERE_PA / absolute).powf(0.75) * 0.75 / absolute)
            };
            let found = rise_pa::<N>(&[(P::AirShare, share)], pressure_pa, 0.5);
            // Of the capacity halfway.
            let expected = 1e-8 / capacity(absolute + 0.5e-8 / capacity(absolute));
            assert!((found - expected).abs() < 1e-4 * expected + 0.1, "{pressure_pa}: {found} {expected}");
        }
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

#[test]
fn a_chamber_grows_with_its_piston_and_never_vanishes() {
    fn check<N: Scalar<Real = f64>>() {
        for (share, position) in [(1.0, 0.5), (1.0, 1.0), (0.5, 0.2), (1.0, 0.25)] {
            let volume = 5.2e-4 + share * 3.117e-3 * 0.3 * (position - 0.5);
            let found = rise_pa::<N>(&[(P::VolumeShare, share)], 3e6, position);
            let expected = 1e-8 * 1.2e9 / volume;
            assert!((found - expected).abs() < 1e-4 * expected, "{position}: {found} {expected}");
        }
        let found = rise_pa::<N>(&[(P::VolumeShare, 1.5)], 3e6, -3.0);
        assert!(found > 0.0 && found.is_finite());
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

/// Oil that is pumped in and out of a closed chamber leaves its pressure as it was: the capacity of a tick is not that of its start, with which
/// each cycle would lose oil.
#[test]
fn a_chamber_with_air_keeps_its_oil_however_often_it_breathes() {
    fn check<N: Scalar<Real = f64>>() {
        let drive = drive::<N>(&clamped(&[(P::AirShare, 0.004)]));
        let mut state = at_rest(&drive, [2e6 / SUPPLY_PA, 0.0], 0.5);
        let before = state.chambers.a.to_f64();
        // 30 periods of 20 ticks; the pressure swings by about 10 bar to each side.
        let flow = |tick: u32| {
            let volume_m3_per_s = 1e-4 * (core::f64::consts::TAU * f64::from(tick) / 20.0).cos();
            let a = N::saturated(volume_m3_per_s / drive.bases().flow_m3_per_s);
            model_core::ports::Flows { a, b: N::ZERO }
        };
        let (mut lowest, mut highest) = (f64::MAX, f64::MIN);
        for tick in 0..600 {
            let input = model_core::drive::DriveInput::Flow { from: flow(tick), to: flow(tick + 1) };
            drive.step(&mut state, input, model_core::drive::Load::NONE);
            lowest = state.chambers.a.to_f64().min(lowest);
            highest = state.chambers.a.to_f64().max(highest);
        }
        let after = state.chambers.a.to_f64();
        let swing = (highest - lowest) * SUPPLY_PA;
        assert!(swing > 1e6 && (after - before).abs() * SUPPLY_PA < 0.02 * swing, "{before} {after} {swing}");
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}
