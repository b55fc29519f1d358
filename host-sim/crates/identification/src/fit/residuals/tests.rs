//! Rows in which a sensor failed have no weight.

use machine_file::LoadSource;
use recording::Recording;
use test_press::{extending, press};

use super::*;
use crate::fit::initial_state::settle;

/// The recording with its position read too far out by two standard deviations of its noise, in all rows or in every fourth.
fn read_too_far(recording: &Recording, machine: &Machine<f64>, every_fourth: bool) -> Prepared {
    let mut prepared = Prepared::new(recording, machine, LoadSource::Constant, None).unwrap();
    let channel = &mut prepared.channels[0];
    assert!(channel.failed.iter().all(|failed| !failed));
    for (row, value) in channel.recorded.iter_mut().enumerate() {
        *value += 2.0 * channel.noise;
        channel.failed[row] = every_fourth && row % 4 != 0;
    }
    prepared
}

#[test]
fn rows_in_which_a_sensor_failed_make_no_mean_smaller() {
    let machine = press(&[(model_core::machine::Parameter::ViscousFriction, 4e4)]);
    let recording = extending(&machine);
    let start = StartState::default();
    let [all, some] = [false, true].map(|every_fourth| read_too_far(&recording, &machine, every_fourth));
    let missed = |prepared: &Prepared| misfits(&machine, [(prepared, start)]).unwrap()[0].mean_square().sqrt();
    // Two standard deviations and the noise itself.
    assert!((missed(&all) - 5.0_f64.sqrt()).abs() < 0.1, "{}", missed(&all));
    assert!((missed(&some) / missed(&all) - 1.0).abs() < 0.05, "{} of {}", missed(&some), missed(&all));

    let mut cases = [some];
    set_tolerances(&machine, &mut cases, &[start]).unwrap();
    assert!((cases[0].channels[0].tolerance - missed(&cases[0])).abs() < 1e-12);
}

#[test]
fn rows_in_which_the_position_failed_hold_no_start_back() {
    let machine = press(&[(model_core::machine::Parameter::ViscousFriction, 4e4)]);
    let recording = extending(&machine);
    let [all, some] = [false, true]
        .map(|every_fourth| settle(&machine, &read_too_far(&recording, &machine, every_fourth)).unwrap().shift);
    // A quarter of the rows weighs less against the start's prior; if the others counted with residual 0, less than half would remain.
    assert!(all > 1.0 && some > 0.7 * all, "{some} of {all}");
}

#[test]
fn where_in_its_play_a_rod_starts_is_found_from_what_it_does_later() {
    use model_core::machine::Parameter::{BacklashPlay, ViscousFriction};
    let machine = press(&[(ViscousFriction, 4e4), (BacklashPlay, 1.2e-3)]);
    let mut case = Prepared::new(&extending(&machine), &machine, LoadSource::Constant, None).unwrap();
    // The rod stood at the end of its play from where it takes all of it to push the sensor.
    let from_the_end = StartState { shift: -5.5e-4 / case.start_sigma_on(&machine), ..StartState::default() };
    case.channels[0].recorded =
        simulated(&machine, &runs(&machine, [(&case, from_the_end)].into_iter()), |_| true).unwrap().remove(0);
    let found_m = settle(&machine, &case).unwrap().offset(&machine, &case).shift_m;
    assert!((found_m + 5.5e-4).abs() < 5e-5, "{found_m}");
}

#[test]
fn what_is_smooth_beneath_noise_is_worth_few_samples() {
    let mut noise = recording::seeded_noise::Noise::new(3, 0);
    let white: Vec<f64> = (0..4096).map(|_| noise.gaussian(1.0)).collect();
    // For white noise, the largest value over all block lengths is slightly too large.
    assert!(
        (0.4 * 4096.0..=effective_samples(&white)).contains(&samples_by_blocks(&white)),
        "{}",
        samples_by_blocks(&white)
    );

    let swing = |row: usize| 0.7 * (std::f64::consts::TAU * row as f64 / 1024.0).sin();
    let both: Vec<f64> = white.iter().enumerate().map(|(row, value)| value + swing(row)).collect();
    assert!(effective_samples(&both) > 2000.0, "{}", effective_samples(&both));
    // The means of sixteen blocks, each a quarter of a swing, hold 0.81 of its power: 16·1.245/(0.245·0.81) of them, 100.
    assert!((70.0..140.0).contains(&samples_by_blocks(&both)), "{}", samples_by_blocks(&both));

    let short = [1.0, -2.0, 1.5];
    assert_eq!(samples_by_blocks(&short).to_bits(), effective_samples(&short).to_bits());
    assert_eq!(samples_by_blocks(&[0.0; 100]).to_bits(), effective_samples(&[0.0; 100]).to_bits());
}
