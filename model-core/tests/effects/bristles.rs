//! Every law of dry friction acts through bristles like `LuGre` integrated independently of the core.

use proptest::prelude::*;

use model_core::machine::Parameter as P;
use model_core::number::{PerUnit, Scalar};

use super::bench::{STROKE_M, at_rest, cases, commanded, drive, position_m, press, pushed, velocity_m_per_s, with};

const MASS_KG: f64 = 50.0;
const DAMPING_N_S_PER_M: f64 = 1e4;
const TICK_S: f64 = 1e-3;
/// Steps of the integration in a tick.
const STEPS: usize = 1000;
/// Sum of both pressures on the seals, Pa.
const PRESSED_PA: f64 = 4e6;

/// Largest distance to the integration over 0.9 s and 6 cm of travel, m. Between rigid friction and bristles of 1e9 N/m it is 1.3e-5.
const POSITION_M: f64 = 4e-5;
/// Root mean square distance of the velocity, m/s.
const VELOCITY_M_PER_S: f64 = 5e-4;
/// Largest distance of fixed point to f64, m.
const ROUNDING_M: f64 = 5e-8;

/// The friction at a velocity and a position, in strokes from mid-stroke times two, N.
type Level = fn(f64, f64) -> f64;
/// Its name, its parameters and its formula.
type Law = (&'static str, Vec<(P, f64)>, Level);

/// Share of Stribeck's excess that is left at a multiple of his velocity.
fn falling(t: f64) -> f64 {
    (1.0 + (2.0_f64.powf(0.125) - 1.0) * t * t).powi(-8)
}

/// Each law alone, and some together.
fn laws() -> Vec<Law> {
    vec![
        ("coulomb", vec![(P::CoulombFriction, 500.0)], |_, _| 500.0),
        ("presliding", vec![(P::PreslidingForce, 500.0)], |_, _| 500.0),
        (
            "stribeck",
            vec![(P::StribeckForce, 300.0), (P::StribeckExcess, 200.0), (P::StribeckVelocity, 0.02)],
            |v, _| 300.0 + 200.0 * falling(v / 0.02),
        ),
        ("asymmetric", vec![(P::AsymmetricExtending, 600.0), (P::AsymmetricRetracting, 250.0)], |v, _| {
            if v > 0.0 { 600.0 } else { 250.0 }
        }),
        (
            "by position",
            vec![(P::PositionFriction, 400.0), (P::PositionFrictionSlope, 200.0), (P::PositionFrictionBow, 100.0)],
            |_, s| 400.0 + 200.0 * s + 100.0 * s * s,
        ),
        ("by pressure", vec![(P::PressureFriction, 1e-4)], |_, _| 1e-4 * PRESSED_PA),
        (
            "all together",
            vec![
                (P::CoulombFriction, 100.0),
                (P::StribeckExcess, 100.0),
                (P::AsymmetricRetracting, 50.0),
                (P::PressureFriction, 1e-4),
                (P::StribeckVelocity, 0.02),
            ],
            |v, _| 500.0 + 100.0 * falling(v / 0.02) + if v < 0.0 { 50.0 } else { 0.0 },
        ),
    ]
}

/// Slow and fast, to and fro, with a rest under half the friction.
fn force_n(time_s: f64) -> f64 {
    if time_s < 0.5 {
        1500.0 * (12.0 * time_s).sin()
    } else if time_s < 0.7 {
        200.0
    } else {
        -1000.0 * (40.0 * time_s).sin() - 400.0
    }
}

/// Position and velocity after each tick, m and m/s: the bristles' damping is `damping` N s/m.
fn lugre(level: Level, stiffness: f64, damping: f64) -> Vec<[f64; 2]> {
    let slope = |[y, v, z]: [f64; 3], force: f64| {
        let g = level(v, 2.0 * (y / STROKE_M) - 1.0);
        let bending = v - stiffness * v.abs() * z / g;
        [v, (force - stiffness * z - damping * bending - DAMPING_N_S_PER_M * v) / MASS_KG, bending]
    };
    let along = |at: [f64; 3], slope: [f64; 3], step: f64| std::array::from_fn(|index| at[index] + step * slope[index]);
    let mut at = [0.5 * STROKE_M, 0.0, 0.0];
    (0..900)
        .map(|tick| {
            let force = force_n(f64::from(tick) * TICK_S);
            let step = TICK_S / STEPS as f64;
            for _ in 0..STEPS {
                let k1 = slope(at, force);
                let k2 = slope(along(at, k1, 0.5 * step), force);
                let k3 = slope(along(at, k2, 0.5 * step), force);
                let k4 = slope(along(at, k3, step), force);
                at = std::array::from_fn(|index| {
                    at[index] + step / 6.0 * (k1[index] + 2.0 * (k2[index] + k3[index]) + k4[index])
                });
            }
            [at[0], at[1]]
        })
        .collect()
}

/// The core's damping: critical, or that of its step.
fn damping(stiffness: f64) -> f64 {
    f64::min(2.0 * (stiffness * MASS_KG).sqrt(), (1.0 - 0.5_f64.sqrt()) * TICK_S * stiffness)
}

fn core<N: Scalar<Real = f64>>(law: &[(P, f64)], stiffness: f64) -> Vec<[f64; 2]> {
    let machine = with(&with(&press(), law), &[(P::PreslidingStiffness, stiffness)]);
    let drive = drive::<N>(&machine);
    let mut state = at_rest(&drive, [3.0 / 7.0, 1.0 / 7.0], 0.5);
    (0..900)
        .map(|tick| {
            pushed(&drive, &mut state, force_n(f64::from(tick) * TICK_S));
            [position_m(&drive, &state), velocity_m_per_s(&drive, &state)]
        })
        .collect()
}

/// Largest distance of the positions, m, and root mean square distance of the velocities, m/s.
fn apart(found: &[[f64; 2]], truth: &[[f64; 2]]) -> [f64; 2] {
    let position = found.iter().zip(truth).map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f64::max);
    let square: f64 = found.iter().zip(truth).map(|(a, b)| (a[1] - b[1]).powi(2)).sum();
    [position, (square / truth.len() as f64).sqrt()]
}

#[test]
fn every_law_acts_through_bristles_as_lugre_does() {
    let mut failed = false;
    for (name, law, level) in laws() {
        for stiffness in [3e6, 3e7, 3e8] {
            let truth = lugre(level, stiffness, damping(stiffness));
            let (real, fixed) = (core::<f64>(&law, stiffness), core::<PerUnit>(&law, stiffness));
            let [position, velocity] = apart(&real, &truth);
            let [rounding, _] = apart(&fixed, &real);
            println!(
                "{name:<14} {stiffness:.0e} N/m: {position:.1e} m, {velocity:.1e} m/s, fixed point {rounding:.1e} m"
            );
            failed |= !(position < POSITION_M && velocity < VELOCITY_M_PER_S && rounding < ROUNDING_M);
        }
    }
    assert!(!failed);
}

#[test]
fn no_stiffness_is_no_bristles() {
    let coulomb = [(P::CoulombFriction, 500.0)];
    let presliding = [(P::PreslidingForce, 500.0)];
    assert_eq!(core::<PerUnit>(&coulomb, 0.0), core::<PerUnit>(&presliding, 0.0));
    assert_eq!(core::<PerUnit>(&coulomb, 3e7), core::<PerUnit>(&presliding, 3e7));
}

#[test]
fn bristles_without_friction_are_nothing() {
    assert_eq!(core::<PerUnit>(&[], 1e8), core::<PerUnit>(&[], 0.0));
}

/// Pressed against its bristles the rod neither oscillates nor creeps, except for the last bit of fixed point: 3 nm a second.
#[test]
fn a_rod_that_hangs_on_its_bristles_stays() {
    fn check<N: Scalar<Real = f64>>(ticks: u32, creep_m: f64) {
        for (name, law, _) in laws() {
            for stiffness in [3e6, 3e8, 3e10] {
                let drive = drive::<N>(&with(&with(&press(), &law), &[(P::PreslidingStiffness, stiffness)]));
                let mut state = at_rest(&drive, [3.0 / 7.0, 1.0 / 7.0], 0.5);
                for _ in 0..1000 {
                    pushed(&drive, &mut state, 150.0);
                }
                let before = position_m(&drive, &state);
                for _ in 0..ticks {
                    pushed(&drive, &mut state, 150.0);
                }
                let crept = position_m(&drive, &state) - before;
                assert!(crept.abs() < creep_m, "{name}, {stiffness:e} N/m: {crept:e} m");
            }
        }
    }
    check::<PerUnit>(100_000, 3e-7);
    check::<f64>(10_000, 1e-12);
}

proptest! {
    #![proptest_config(cases(100))]

    /// However stiff the bristles are, a drive that is commanded comes to rest.
    #[test]
    fn bristles_do_not_chatter(which in 0..7_usize, decade in 3.0..12.0_f64, command in -1.0..1.0_f64) {
        let law = laws().swap_remove(which).1;
        let machine = with(&with(&press(), &law), &[(P::PreslidingStiffness, 10_f64.powf(decade))]);
        let drive = drive::<PerUnit>(&machine);
        let mut state = at_rest(&drive, [0.3, 0.5], 0.5);
        for tick in 0..2000 {
            commanded(&drive, &mut state, if tick < 200 { command } else { 0.0 });
        }
        let velocity = velocity_m_per_s(&drive, &state);
        prop_assert!(velocity.abs() < 1e-6, "{velocity:e} m/s");
    }
}
