//! Loads by position, end stops, and warming oil.

use proptest::prelude::*;

use model_core::machine::Parameter as P;
use model_core::number::{PerUnit, Scalar, Single};

use super::bench::{STROKE_M, at_rest, cases, drive, oil_at, position_m, press, pushed, velocity_m_per_s, with};

#[test]
fn a_spring_bears_its_force_where_its_formula_says() {
    fn check<N: Scalar<Real = f64>>() {
        let load = [(P::LoadSpring, 2e4), (P::LoadSpringForce, 300.0), (P::LoadSpringBow, 5e4)];
        let drive = drive::<N>(&with(&press(), &load));
        let mut state = at_rest(&drive, [0.4, 0.4], 0.5);
        // 300 + 2e4·0.05 + 5e4·0.05² = 1425 N at 50 mm out of the middle.
        for _ in 0..8000 {
            pushed(&drive, &mut state, 1425.0);
        }
        let found = position_m(&drive, &state) - 0.5 * STROKE_M;
        assert!((found - 0.05).abs() < 1e-6, "{found}");
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

/// A light, undamped mass on a spring of 1e6 N/m: its amplitude and its period stay constant.
#[test]
fn a_stiff_spring_swings_with_its_own_period_and_no_more_than_it_was_given() {
    let machine = with(&press(), &[(P::LoadSpring, 1e6), (P::MovingMass, 100.0), (P::ViscousFriction, 0.0)]);
    let drive = drive::<f64>(&machine);
    let mut state = at_rest(&drive, [0.4, 0.4], 0.5 + 0.01 / STROKE_M);
    let (mut crossings, mut largest, mut before) = (0, 0.0_f64, 1.0);
    for tick in 0..1000 {
        pushed(&drive, &mut state, 0.0);
        let out = position_m(&drive, &state) - 0.5 * STROKE_M;
        crossings += usize::from(out * before < 0.0);
        before = out;
        largest = largest.max(out.abs());
        if tick < 100 {
            largest = 0.0;
        }
    }
    // ω = 100 1/s: 31.8 half turns a second.
    assert!((31..=32).contains(&crossings), "{crossings}");
    assert!(largest <= 0.010_000_1, "{largest}");
    assert!(largest > 0.009, "{largest}");
}

#[test]
fn a_stop_bears_a_force_at_its_depth_and_lets_go_of_the_rod() {
    fn check<N: Scalar<Real = f64>>() {
        for (at, force_n) in [(P::StopExtended, 5e3_f64), (P::StopRetracted, -5e3)] {
            let away = if at == P::StopExtended { P::StopRetracted } else { P::StopExtended };
            let stop = [(at, 0.15), (away, force_n.signum() * -100.0), (P::StopStiffness, 1e8), (P::StopDamping, 1e4)];
            let drive = drive::<N>(&with(&press(), &stop));
            let mut state = at_rest(&drive, [0.4, 0.4], 0.5 - 0.02 * force_n.signum() / STROKE_M);
            for _ in 0..500 {
                pushed(&drive, &mut state, force_n);
            }
            let depth_m = (position_m(&drive, &state) - 0.15) * force_n.signum();
            assert!((depth_m - 5e-5).abs() < 2e-7, "5 kN on 1e8 N/m: {depth_m}");
            let velocity = velocity_m_per_s(&drive, &state);
            // A step of the position is 6e-6 of the full force on this stop: fixed point rests within that.
            assert!(velocity.abs() < 1e-5, "{velocity}");
            for _ in 0..400 {
                pushed(&drive, &mut state, -0.2 * force_n);
            }
            // As without a stop: 1 kN against 1e4 N s/m.
            let velocity = velocity_m_per_s(&drive, &state) * force_n.signum();
            assert!((velocity + 0.1).abs() < 1e-4, "{velocity}");
        }
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

proptest! {
    #![proptest_config(cases(500))]

    /// Kinetic energy plus that of the stop's spring, without any force: never more than the rod had at first.
    #[test]
    fn a_stop_gives_back_no_more_than_it_took(
        exponent in 6.0..9.0_f64, damping in prop::sample::select(vec![0.0, 1e3, 1e4, 1e5]),
        mass in 10.0..200.0_f64, velocity in 0.001..1.0_f64, from in 0.0..1.0_f64, both in any::<bool>(),
    ) {
        let stiffness = 10_f64.powf(exponent);
        let stop = [(P::StopExtended, 0.15), (P::StopRetracted, if both { 0.149 } else { -100.0 }), (P::StopStiffness, stiffness), (P::StopDamping, damping)];
        let machine = with(&with(&press(), &[(P::MovingMass, mass), (P::ViscousFriction, 0.0)]), &stop);
        let drive = drive::<f64>(&machine);
        let mut state = at_rest(&drive, [0.4, 0.4], (0.1495 - 1e-3 * velocity * from) / STROKE_M);
        state.motion.velocity = velocity / drive.bases().velocity_m_per_s;
        let energy = |state: &super::bench::State<f64>| {
            let at = position_m(&drive, state);
            let depth = (at - 0.15).max(if both { 0.149 - at } else { 0.0 }).max(0.0);
            0.5 * mass * velocity_m_per_s(&drive, state).powi(2) + 0.5 * stiffness * depth * depth
        };
        let mut before = energy(&state);
        for _ in 0..300 {
            pushed(&drive, &mut state, 0.0);
            let after = energy(&state);
            prop_assert!(after <= before * (1.0 + 1e-9), "{after} J of {before} J");
            before = after;
        }
    }
}

#[test]
fn friction_falls_and_leakage_rises_as_the_oil_warms() {
    fn check<N: Scalar<Real = f64>>() {
        for loss in [0.6, -1.0] {
            let warming = [(P::ViscosityLoss, loss), (P::WarmingTime, 0.5), (P::Stroke, 3.0)];
            let drive = drive::<N>(&with(&press(), &warming));
            let mut state = at_rest(&drive, [0.4, 0.4], 0.1);
            for tick in 1..=2000 {
                pushed(&drive, &mut state, 1000.0);
                let factor = 1.0 - loss * (1.0 - (-f64::from(tick) * 1e-3 / 0.5).exp());
                // The velocity follows by m/D, 5 ms and some.
                let expected = 1000.0 / (1e4 * factor);
                if tick > 100 {
                    let found = velocity_m_per_s(&drive, &state);
                    assert!((found / expected - 1.0).abs() < 0.03, "{tick}: {found} {expected}");
                }
            }
            let done = N::strokes(state.warmth);
            assert!((done - (1.0 - (-4.0_f64).exp())).abs() < 1e-6, "{done}");
        }
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

#[test]
fn friction_follows_a_measured_temperature_from_tick_to_tick() {
    fn check<N: Scalar<Real = f64>>() {
        let thinning = [(P::ViscosityLossPerKelvin, 0.04), (P::ReferenceTemperature, 45.0), (P::Stroke, 3.0)];
        let drive = drive::<N>(&with(&press(), &thinning));
        let mut state = at_rest(&drive, [0.4, 0.4], 0.1);
        // Not measured at first; at the end the temperature is beyond three halvings of the viscosity.
        for temperature_c in [None, Some(45.0), Some(65.0), Some(28.0), Some(110.0)] {
            if let Some(temperature_c) = temperature_c {
                oil_at(&drive, &mut state, temperature_c);
            }
            for _ in 0..600 {
                pushed(&drive, &mut state, 1000.0);
            }
            let factor = (-0.04 * (temperature_c.unwrap_or(45.0) - 45.0)).exp().max(0.125);
            let (found, expected) = (velocity_m_per_s(&drive, &state), 1000.0 / (1e4 * factor));
            // The weight of the viscosity has 16 fractional digits.
            assert!((found / expected - 1.0).abs() < 1e-4, "{temperature_c:?}: {found} {expected}");
        }
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

#[test]
fn viscous_friction_changes_along_the_stroke_as_its_formula_says() {
    fn check<N: Scalar<Real = f64>>() {
        // The oil of the second thins meanwhile; the third starts where a twentieth of the friction is left.
        for (slope, bow, loss) in [(0.8, -0.4, 0.0), (-1.5, 2.0, 0.6), (3.0, 1.0, 0.0)] {
            let placed = [(P::PositionDragSlope, slope), (P::PositionDragBow, bow)];
            let warming = [(P::ViscosityLoss, loss), (P::WarmingTime, 0.5), (P::Stroke, STROKE_M)];
            let drive = drive::<N>(&with(&with(&press(), &placed), &warming));
            let mut state = at_rest(&drive, [0.4, 0.4], 0.1);
            let mut before = (velocity_m_per_s(&drive, &state), position_m(&drive, &state));
            for tick in 1..=800 {
                pushed(&drive, &mut state, 300.0);
                let after = (velocity_m_per_s(&drive, &state), position_m(&drive, &state));
                // At the position where the tick starts.
                let place = 2.0 * before.1 / STROKE_M - 1.0;
                let oil = 1.0 - loss * (1.0 - (-f64::from(tick) * 1e-3 / 0.5).exp());
                let factor = oil * f64::max(0.05, 1.0 + slope * place + bow * place * place);
                // The part of the force that does not accelerate the mass.
                let friction = 300.0 - 50.0 * (after.0 - before.0) / 1e-3;
                let expected = 1e4 * factor * (after.1 - before.1) / 1e-3;
                assert!((friction - expected).abs() < 3.0, "{tick}, {place}: {friction} {expected}");
                before = after;
            }
        }
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

#[test]
fn oil_that_warms_within_a_day_does_not_stall() {
    let warming = [(P::ViscosityLoss, 0.5), (P::WarmingTime, 1e5)];
    let drive = drive::<PerUnit>(&with(&press(), &warming));
    let mut state = at_rest(&drive, [0.4, 0.4], 0.5);
    for _ in 0..100_000 {
        pushed(&drive, &mut state, 0.0);
    }
    let done = PerUnit::strokes(state.warmth);
    assert!((done / 9.995e-4 - 1.0).abs() < 5e-4, "100 s of 1e5 s: {done}");
}
