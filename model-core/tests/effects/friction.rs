//! Every law of dry friction holds exactly, brakes only, and is as large as its formula.

use proptest::prelude::*;

use model_core::drive::{Drive, DriveInput, Load};
use model_core::machine::Parameter as P;
use model_core::number::{PerUnit, Scalar, Single};
use model_core::ports::{Forces, MotionState, Surroundings};

use super::bench::{STROKE_M, at_rest, cases, drive, position_m, press, pushed, velocity_m_per_s, with};

/// Its name, its parameters, and the force that holds the rod against extending and against retracting, N.
type Law = (&'static str, Vec<(P, f64)>, [f64; 2]);

/// Each law, and what holds the rod at 0.75 of the stroke under 3 MPa and 1 MPa: against extending and against retracting, N.
fn laws() -> Vec<Law> {
    vec![
        ("stribeck", vec![(P::StribeckForce, 300.0), (P::StribeckExcess, 200.0)], [500.0, 500.0]),
        ("asymmetric", vec![(P::AsymmetricExtending, 600.0), (P::AsymmetricRetracting, 250.0)], [600.0, 250.0]),
        (
            "by position",
            vec![(P::PositionFriction, 400.0), (P::PositionFrictionSlope, 200.0), (P::PositionFrictionBow, 100.0)],
            [525.0, 525.0],
        ),
        ("by pressure", vec![(P::PressureFriction, 1e-4)], [400.0, 400.0]),
        (
            "all together",
            vec![
                (P::CoulombFriction, 100.0),
                (P::StribeckExcess, 100.0),
                (P::AsymmetricRetracting, 50.0),
                (P::PressureFriction, 1e-4),
            ],
            [600.0, 650.0],
        ),
    ]
}

const PRESSURES: [f64; 2] = [3.0 / 7.0, 1.0 / 7.0];

#[test]
fn what_sticks_stays_exactly_and_what_is_pushed_harder_goes() {
    fn check<N: Scalar<Real = f64>>() {
        for (name, law, [extending_n, retracting_n]) in laws() {
            let drive = drive::<N>(&with(&press(), &law));
            let start = at_rest(&drive, PRESSURES, 0.75);
            for force_n in [0.999 * extending_n, -0.999 * retracting_n, 0.0] {
                let mut state = start;
                for _ in 0..50 {
                    assert_eq!(pushed(&drive, &mut state, force_n).velocity, N::ZERO, "{name}, {force_n} N");
                    assert_eq!(state.motion, start.motion, "{name}, {force_n} N");
                }
            }
            for force_n in [1.001 * extending_n, -1.001 * retracting_n] {
                let mut state = start;
                pushed(&drive, &mut state, force_n);
                assert!(velocity_m_per_s(&drive, &state) * force_n > 0.0, "{name}, {force_n} N");
            }
        }
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

/// At steady speed D·v + F(v) is the force.
fn steady_m_per_s<N: Scalar<Real = f64>>(law: &[(P, f64)], force_n: f64) -> f64 {
    let drive = drive::<N>(&with(&with(&press(), &[(P::Stroke, 3.0)]), law));
    let mut state = at_rest(&drive, PRESSURES, 0.5);
    for _ in 0..400 {
        pushed(&drive, &mut state, force_n);
    }
    velocity_m_per_s(&drive, &state)
}

#[test]
fn at_steady_speed_the_friction_is_its_formula() {
    fn check<N: Scalar<Real = f64>>() {
        let near =
            |found: f64, expected: f64| assert!((found - expected).abs() < 2e-4 * expected.abs(), "{found} {expected}");
        let asymmetric = [(P::AsymmetricExtending, 600.0), (P::AsymmetricRetracting, 250.0)];
        near(steady_m_per_s::<N>(&asymmetric, 2000.0), (2000.0 - 600.0) / 1e4);
        near(steady_m_per_s::<N>(&asymmetric, -2000.0), -(2000.0 - 250.0) / 1e4);
        let seals = [(P::PressureFriction, 1e-4)];
        near(steady_m_per_s::<N>(&seals, 2000.0), (2000.0 - 400.0) / 1e4);
        let presliding = [(P::PreslidingForce, 500.0), (P::PreslidingStiffness, 1e8)];
        near(steady_m_per_s::<N>(&presliding, 2000.0), (2000.0 - 500.0) / 1e4);
        // 1e4·0.15 + 300 + 200/(1 + (2^⅛ − 1)·(0.15/0.1)²)⁸
        let stribeck = [(P::StribeckForce, 300.0), (P::StribeckExcess, 200.0), (P::StribeckVelocity, 0.1)];
        near(
            steady_m_per_s::<N>(&stribeck, 1500.0 + 300.0 + 200.0 / (1.0 + (2.0_f64.powf(0.125) - 1.0) * 2.25).powi(8)),
            0.15,
        );
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

#[test]
fn bristles_give_elastically_before_they_slide() {
    fn check<N: Scalar<Real = f64>>() {
        let drive = drive::<N>(&with(&press(), &[(P::PreslidingForce, 500.0), (P::PreslidingStiffness, 1e7)]));
        let mut state = at_rest(&drive, PRESSURES, 0.5);
        let mut before_n = 0.0;
        let mut settle = |force_n: f64| {
            for tick in 0..2000 {
                let share = f64::from(tick.min(1000)) / 1000.0;
                pushed(&drive, &mut state, before_n + share * (force_n - before_n));
            }
            before_n = force_n;
            (position_m(&drive, &state) - 0.5 * STROKE_M, velocity_m_per_s(&drive, &state))
        };
        // dF/dz = stiffness·(1 − F/force) on the way: z/Z = 1 − e^(−travel/Z), Z = 50 µm, so ln 2 of Z at half the force.
        let (travel_m, velocity) = settle(250.0);
        assert!(velocity.abs() < 1e-7, "it rests: {velocity}");
        assert!((travel_m / 5e-5 - 2_f64.ln()).abs() < 0.1, "{travel_m}");
        let (back_m, _) = settle(0.0);
        assert!(back_m < travel_m - 2e-5 && back_m > -5e-6, "it springs back, not all the way: {back_m}");
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

fn any_law() -> impl Strategy<Value = Vec<(P, f64)>> {
    let mut laws: Vec<Vec<(P, f64)>> = laws().into_iter().map(|(_, law, _)| law).collect();
    laws.push(vec![(P::PreslidingForce, 500.0)]);
    prop::sample::select(laws)
}

fn braked<N: Scalar<Real = f64>>(drive: &Drive<N>, velocity: N, from: f64) {
    let mut state = MotionState { velocity, ..MotionState::at_rest(N::travel(from)) };
    let around = Surroundings { pressed: N::saturated(0.6), ..Surroundings::NONE };
    let free = Forces { start: N::ZERO, first: N::ZERO, second: N::ZERO, around };
    for _ in 0..60 {
        let before = state.velocity;
        drive.mechanics().step(&mut state, free);
        assert!(state.velocity.magnitude() <= before.magnitude(), "{before:?} {state:?}");
    }
}

proptest! {
    #![proptest_config(cases(500))]

    /// Bristles may push the rod back as far as they were bent, so they are left out.
    #[test]
    fn dry_friction_never_accelerates(law in any_law(), bits in -(1 << 28)..=1 << 28, small in 0_u32..28, from in 0.0..1.0_f64) {
        let machine = with(&press(), &law);
        let velocity = PerUnit::from_bits(bits >> small);
        braked(&drive::<PerUnit>(&machine), velocity, from);
        braked(&drive::<f64>(&machine), velocity.to_f64(), from);
    }

    /// Work done on the rod over a run from rest is never negative: friction only takes energy.
    #[test]
    fn friction_takes_energy(
        law in any_law(),
        stiffness in prop::sample::select(vec![0.0, 3e6, 3e7, 1e8, 1e9, 1e11]),
        forces in prop::collection::vec(-3000.0..3000.0_f64, 5..40),
    ) {
        let machine = with(&with(&press(), &law), &[(P::PreslidingStiffness, stiffness)]);
        let drive = drive::<f64>(&machine);
        let mut state = at_rest(&drive, PRESSURES, 0.5);
        let (mut given, mut passed) = (0.0, 1.0_f64);
        for force_n in forces {
            for _ in 0..20 {
                let before = position_m(&drive, &state);
                let force = force_n / drive.bases().force_n;
                drive.step(&mut state, DriveInput::Force { from: force, to: force }, Load::NONE);
                let work = force_n * (position_m(&drive, &state) - before);
                given += work;
                passed += work.abs();
            }
            let kinetic = 0.5 * 50.0 * velocity_m_per_s(&drive, &state).powi(2);
            prop_assert!(kinetic <= given + 0.02 * passed, "{kinetic} J of {given} J, {passed} J");
        }
    }
}
