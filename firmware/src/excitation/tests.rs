//! Does an excitation do what it says, and never more than its bounds permit?

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::vec::Vec;

use super::*;
use crate::set_point::{Envelope, Followed};

const STROKE_M: f64 = 0.3;
const TICK_S: f64 = 1e-3;

fn bases() -> Bases {
    Bases {
        pressure_pa: 7e6,
        velocity_m_per_s: 0.2,
        flow_m3_per_s: 6e-4,
        force_n: 2.2e4,
        stroke_m: STROKE_M,
        command_v: 10.0,
        pump_speed_rev_per_s: 50.0,
        temperature_c: 25.0,
        tick_s: TICK_S,
    }
}

const BOUNDS: Bounds = Bounds { from_m: 0.01, to_m: 0.29, velocity_m_per_s: 0.036, acceleration_m_per_s2: 0.5 };
const MIDDLE: PerUnit = PerUnit::from_bits(1 << 27);

/// Distances from the place at the start, m, tick by tick; every set point is one that the envelope of the bounds takes.
fn played(excitation: &Excitation, bounds: &Bounds) -> Vec<f64> {
    let envelope = Envelope::new(bounds, &bases(), 0.0).unwrap();
    let wave = excitation.about(MIDDLE, &bases(), bounds).unwrap_or_else(|error| panic!("{excitation:?}: {error}"));
    let rest = SetPoint { position: MIDDLE, velocity: PerUnit::ZERO };
    let mut followed = envelope.next(&Followed::resting(MIDDLE), rest, PerUnit::ZERO).unwrap();
    let mut state = WaveState::default();
    let mut offsets_m = Vec::new();
    while !wave.is_done(&state) {
        let wanted = wave.step(&mut state);
        followed = envelope
            .next(&followed, wanted, PerUnit::ZERO)
            .unwrap_or_else(|refusal| panic!("{excitation:?}, tick {}: {refusal:?}", offsets_m.len()));
        offsets_m.push((wanted.position.to_f64() - 0.5) * STROKE_M);
    }
    assert_eq!(offsets_m.len(), wave.ticks() as usize);
    // It ends where it began.
    envelope.next(&followed, wave.step(&mut state), PerUnit::ZERO).unwrap();
    assert_eq!(wave.step(&mut state), rest);
    offsets_m
}

#[test]
fn the_sine_is_within_two_thousandths_of_that_in_f64() {
    let off = |turns: u32| f64::from(sine(turns)) - libm::sin(f64::from(turns) / 4_294_967_296.0 * TURN);
    let worst = (0..=100_000_u32).map(|part| off(part.wrapping_mul(42_949)).abs()).fold(0.0, f64::max);
    std::println!("{worst:.5}");
    assert!(worst < 0.002, "{worst}");
    assert!(worst > 1e-4, "it is the short one: {worst}");
}

#[test]
fn a_sine_has_its_amplitude_and_its_frequency() {
    let offsets_m = played(&Excitation::Sine { amplitude_m: 3e-3, frequency_hz: 1.0, duration_s: 5.0 }, &BOUNDS);
    for (tick, offset_m) in (1..).zip(&offsets_m).skip(1000).take(2999) {
        let exact_m = 3e-3 * libm::sin(TURN * f64::from(tick) * TICK_S);
        assert!((offset_m - exact_m).abs() < 0.003 * 3e-3, "{tick}: {offset_m} {exact_m}");
    }
}

/// Instants at which the rod passes its place on the way out, s.
fn crossings_s(offsets_m: &[f64]) -> Vec<f64> {
    let mut found = Vec::new();
    for (tick, pair) in (1_u32..).zip(offsets_m.windows(2)) {
        if pair[0] <= 0.0 && pair[1] > 0.0 {
            found.push(TICK_S * (f64::from(tick) - pair[1] / (pair[1] - pair[0]) + 1.0));
        }
    }
    found
}

#[test]
fn a_sweep_grows_from_its_first_to_its_last_frequency_by_the_same_factor_in_the_same_time() {
    for (from_hz, to_hz, duration_s) in [(0.5, 10.0, 4.0), (0.2, 40.0, 20.0), (1.0, 2.0, 120.0)] {
        let offsets_m = played(&Excitation::Sweep { amplitude_m: 0.02, from_hz, to_hz, duration_s }, &BOUNDS);
        // Turns until t: f₀·T/ln(f₁/f₀)·((f₁/f₀)^(t/T) − 1).
        let rate = libm::log(to_hz / from_hz);
        let turns = |t_s: f64| from_hz * duration_s / rate * libm::expm1(rate * t_s / duration_s);
        // In the first ticks the window rounds to nothing.
        let crossings_s: Vec<f64> = crossings_s(&offsets_m).into_iter().filter(|at_s| *at_s > 0.5 / from_hz).collect();
        // The last falls into the end of the window, where rounding decides.
        let expected = turns(duration_s);
        assert!((crossings_s.len() as f64 - expected).abs() <= 1.0 + 0.01 * expected, "{}", crossings_s.len());
        for (turn, crossing_s) in (1_u32..).zip(&crossings_s[..crossings_s.len() - 1]) {
            let off = turns(*crossing_s) - f64::from(turn);
            assert!(off.abs() < 0.01 + 0.005 * f64::from(turn), "{crossing_s} s: {off} turns off the {turn}th");
        }
    }
}

#[test]
fn the_amplitude_of_a_sweep_follows_its_law() {
    let offsets_m =
        played(&Excitation::Sweep { amplitude_m: 5e-3, from_hz: 0.5, to_hz: 20.0, duration_s: 30.0 }, &BOUNDS);
    for (start_s, end_s) in [(5.0, 8.0), (14.0, 16.0), (25.0, 25.5)] {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "ticks of this test")]
        let rows = (start_s * 1e3) as usize..(end_s * 1e3) as usize;
        let found_m = offsets_m[rows].iter().fold(0.0, |most: f64, offset_m| most.max(offset_m.abs()));
        // The largest is near the start, where the frequency is lowest.
        let at = |t_s: f64| {
            let omega = TURN * 0.5 * libm::pow(40.0, t_s / 30.0);
            let (by_velocity, by_acceleration) = (omega / (0.8 * 0.036), omega * omega / (0.8 * 0.5));
            1.0 / libm::sqrt(200.0 * 200.0 + by_velocity * by_velocity + by_acceleration * by_acceleration)
        };
        assert!(found_m < 1.003 * at(start_s) && found_m > 0.997 * at(end_s), "{start_s} s: {found_m}");
    }
}

#[test]
fn long_strokes_go_there_and_back_at_four_speeds() {
    for amplitude_m in [0.02, -0.05] {
        let offsets_m = played(&Excitation::Strokes { amplitude_m, rest_s: 0.1 }, &BOUNDS);
        let paces: Vec<f64> = offsets_m.windows(2).map(|pair| (pair[1] - pair[0]) / TICK_S).collect();
        // The largest speed of each way: between rests.
        let mut largest = Vec::new();
        let mut now = 0.0_f64;
        for pace in &paces {
            if pace.abs() > 1e-5 {
                now = if pace.abs() > now.abs() { *pace } else { now };
            } else if now.abs() > 1e-3 {
                largest.push(now);
                now = 0.0;
            }
        }
        largest.extend((now.abs() > 1e-3).then_some(now));
        assert_eq!(largest.len(), 8, "{largest:?}");
        for (way, (found, share)) in largest.iter().zip([0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1.0, 1.0]).enumerate() {
            let outwards = (way % 2 == 0) == (amplitude_m > 0.0);
            let expected = if outwards { share } else { -share } * 0.8 * 0.036;
            assert!((found / expected - 1.0).abs() < 0.03, "{way}: {found}, expected {expected}");
        }
        let farthest = offsets_m.iter().copied().fold(0.0_f64, |a, b| if b.abs() > a.abs() { b } else { a });
        assert!((farthest / amplitude_m - 1.0).abs() < 1e-4, "{farthest}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, rng_seed: RngSeed::Fixed(4_906), ..ProptestConfig::default() })]
    #[test]
    fn no_excitation_that_is_taken_leaves_its_bounds_in_any_tick(
        kind in 0..3, amplitude_m in 1e-4..0.14_f64, octaves in 1.0..7.0_f64, from_hz in 0.05..10.0_f64, seconds in 0.1..20.0_f64,
        velocity_m_per_s in 0.01..0.2_f64, acceleration_m_per_s2 in 0.1..5.0_f64,
    ) {
        let bounds = Bounds { velocity_m_per_s, acceleration_m_per_s2, ..BOUNDS };
        let excitation = match kind {
            0 => {
                // As large as it may be.
                let omega = TURN * from_hz;
                let most_m = (0.8 * velocity_m_per_s / omega).min(0.8 * acceleration_m_per_s2 / (omega * omega));
                let amplitude_m = amplitude_m.min(0.999 * most_m);
                Excitation::Sine { amplitude_m, frequency_hz: from_hz, duration_s: seconds + 2.0 / from_hz }
            }
            1 => {
                let to_hz = (from_hz * libm::exp2(octaves)).min(100.0);
                Excitation::Sweep { amplitude_m, from_hz, to_hz, duration_s: seconds + 2.0 / from_hz }
            }
            _ => Excitation::Strokes { amplitude_m, rest_s: 0.05 * seconds },
        };
        // A long way at a quarter of a small velocity takes longer than is permitted.
        prop_assume!(excitation.about(MIDDLE, &bases(), &bounds).is_ok() || kind == 2);
        if excitation.about(MIDDLE, &bases(), &bounds).is_ok() {
            played(&excitation, &bounds);
        }
    }
}

#[test]
fn what_does_not_fit_is_refused_with_its_value() {
    let about = |excitation: Excitation, share| excitation.about(PerUnit::saturated(share), &bases(), &BOUNDS);
    let sine =
        |amplitude_m, frequency_hz, duration_s| about(Excitation::Sine { amplitude_m, frequency_hz, duration_s }, 0.1);
    // 30 mm from the end, of which 10 are out of bounds.
    assert!(
        matches!(sine(0.021, 0.1, 20.0), Err(ExcitationError::Amplitude { most_m, .. }) if (most_m - 0.02).abs() < 1e-6)
    );
    assert!(matches!(sine(f64::NAN, 0.1, 20.0), Err(ExcitationError::Amplitude { .. })));
    assert!(matches!(sine(-1e-3, 0.1, 20.0), Err(ExcitationError::Amplitude { .. })));
    assert!(matches!(sine(1e-3, 101.0, 1.0), Err(ExcitationError::Frequency { .. })));
    assert!(matches!(sine(1e-3, f64::NAN, 1.0), Err(ExcitationError::Frequency { .. })));
    assert!(matches!(sine(0.01, 1.0, 4.0), Err(ExcitationError::Velocity { .. })));
    assert!(matches!(sine(1e-3, 4.0, 4.0), Err(ExcitationError::Acceleration { .. })));
    assert!(matches!(sine(1e-3, 1.0, 1.9), Err(ExcitationError::Duration { .. })));
    assert!(matches!(sine(1e-3, 1.0, f64::INFINITY), Err(ExcitationError::Duration { .. })));
    let sweep = |from_hz, to_hz| about(Excitation::Sweep { amplitude_m: 1e-3, from_hz, to_hz, duration_s: 10.0 }, 0.5);
    assert!(sweep(1.0, 2.0).is_ok());
    assert!(matches!(sweep(1.0, 1.9), Err(ExcitationError::Frequency { .. })), "less than an octave");
    assert!(matches!(sweep(0.0, 1.9), Err(ExcitationError::Frequency { .. })));
    let strokes = |amplitude_m, rest_s| about(Excitation::Strokes { amplitude_m, rest_s }, 0.1);
    assert!(strokes(0.05, 0.1).is_ok());
    assert!(matches!(strokes(-0.05, 0.1), Err(ExcitationError::Amplitude { .. })), "there is no room inwards");
    assert!(matches!(strokes(0.05, 0.0), Err(ExcitationError::Duration { .. })));
    assert!(matches!(strokes(0.25, 10.0), Err(ExcitationError::Duration { .. })), "more than two minutes");
}
