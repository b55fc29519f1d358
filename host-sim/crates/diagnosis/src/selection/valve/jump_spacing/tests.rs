use machine_file::LoadSource;
use model_core::machine::Parameter;
use recording::Signal;
use test_press::{press, recorded_for};

use super::*;

const BAND: f64 = 0.02;
const KEPT: f64 = 0.2;

/// The press without stiction, and with the play that follows its sticking spool on average.
fn play() -> (Machine<f64>, Machine<f64>) {
    let machine = press(&[(Parameter::ViscousFriction, 2e4), (Parameter::DeadZone, 0.03)]);
    (machine, machine.with(&[(Parameter::HysteresisWidth, BAND * (1.0 + KEPT))]))
}

fn sticking() -> Machine<f64> {
    play().0.with(&[(Parameter::StictionBand, BAND), (Parameter::StictionKept, KEPT)])
}

fn prepared(truth: &Machine<f64>, sensors: &[(Signal, f64)], rows: u32) -> Prepared {
    Prepared::new(&recorded_for(truth, sensors, rows), &play().0, LoadSource::Constant, None).unwrap()
}

const POSITION: (Signal, f64) = (Signal::Position, 1e-5);

#[test]
fn jumps_that_no_sensor_sees_are_heard_in_the_position_with_their_length() {
    let case = prepared(&sticking(), &[POSITION], 4000);
    let jump_spacing = JumpSpacing::of(&play().1, &[&case]).unwrap().expect("it sticks");
    let length = BAND * (1.0 - KEPT);
    assert!((jump_spacing.length / length - 1.0).abs() < 0.2, "{jump_spacing:?} of {length}");
    assert!(jump_spacing.evidence > 2.0 * SPACING_TOLD, "{jump_spacing:?}");
    let held_out = prepared(&sticking(), &[POSITION], 3000);
    assert!(jump_spacing.is_in(&play().1, &[&held_out]).unwrap());
    // Jumps of another length are not these.
    let other = JumpSpacing { length: 0.4 * length, ..jump_spacing };
    assert!(!other.is_in(&play().1, &[&held_out]).unwrap());
    let smooth = prepared(&play().1, &[POSITION], 3000);
    assert!(!jump_spacing.is_in(&play().1, &[&smooth]).unwrap());
}

#[test]
fn no_jump_is_found_where_none_is_not_even_by_a_model_that_is_off() {
    let (plain, play) = play();
    let case = prepared(&play, &[POSITION], 4000);
    for model in [play, plain, play.with(&[(Parameter::ValveGain, 0.057)])] {
        assert_eq!(JumpSpacing::of(&model, &[&case]).unwrap(), None);
    }
}

#[test]
fn a_recorded_spool_is_not_listened_for() {
    let case = prepared(&sticking(), &[(Signal::Spool, 1e-3), POSITION], 4000);
    assert_eq!(JumpSpacing::of(&play().1, &[&case]).unwrap(), None);
    assert_eq!(JumpSpacing::of(&play().1, &[]).unwrap(), None);
}

#[test]
fn a_phase_strays_around_the_circle_and_stays_a_distribution() {
    let mut phases = [0.0; PHASES];
    phases[0] = 1.0;
    let near = strayed(&phases, 0.002);
    assert!((near.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    assert!((near[1] - near[PHASES - 1]).abs() < 1e-12 && near[1] < near[0] && near[2] < near[1]);
    // A standard deviation of 0.045 turns is 1.07 phases: the neighbour has exp(−½/1.07²).
    assert!((near[1] / near[0] - (-0.5_f64 / (24.0_f64.powi(2) * 0.002)).exp()).abs() < 1e-9);
    let far = strayed(&phases, 0.3);
    assert!(far.iter().all(|share| (share * PHASES as f64 - 1.0).abs() < 1e-2));
    let rests = strayed(&phases, 0.0);
    assert!((rests[0] - 1.0).abs() < 1e-9);
}

#[test]
fn what_follows_from_the_rows_before_is_made_white() {
    let mut noise = recording::seeded_noise::Noise::new(5, 0);
    let mut last = 0.0;
    let missed_m: Vec<f64> = (0..4000)
        .map(|_| {
            last = 0.9 * last + noise.gaussian(1e-5);
            last
        })
        .collect();
    let time_s: Vec<f64> = (0..4000).map(|row| f64::from(row) * 1e-3).collect();
    let none = || vec![0.0; 4000];
    let mut tracks = vec![Track { time_s, missed_m, noise_m: 1e-6, x: none(), gain: none(), blocks: Vec::new() }];
    let memory = whitened(&mut tracks).unwrap();
    assert!((memory[0] - 1.0).abs() < 1e-12 && (memory[1] + 0.9).abs() < 0.05, "{memory:?}");
    let white = &tracks[0].missed_m[100..];
    let lagged: f64 = white.windows(2).map(|pair| pair[0] * pair[1]).sum();
    assert!((lagged / white.iter().map(|value| value * value).sum::<f64>()).abs() < 0.05);
}
