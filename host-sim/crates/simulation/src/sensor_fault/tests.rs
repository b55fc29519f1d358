use recording::seeded_noise::Noise;

use super::*;

/// A rod that rests, moves at up to 0.2 m/s, and rests again, 1 kHz, read in steps of 20 µm.
fn rod() -> (Vec<f64>, Vec<f64>) {
    let time_s: Vec<f64> = (0..4000).map(|row| f64::from(row) * 1e-3).collect();
    let position = |time: f64| 0.15 + 0.1 * (2.0 * (time.clamp(0.5, 3.5) - 0.5)).sin();
    let values = time_s.iter().map(|time| (position(*time) / 2e-5).round() * 2e-5).collect();
    (time_s, values)
}

/// A signal with noise of six steps of its converter.
fn noisy() -> (Vec<f64>, Vec<f64>) {
    let mut seed = 5_u32;
    let mut uniform = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
    };
    let time_s: Vec<f64> = (0..4000).map(|row| f64::from(row) * 1e-3).collect();
    let values = time_s
        .iter()
        .map(|time| 3e6 + 1e6 * (4.0 * time).sin() + 12e3 * (uniform() + uniform() + uniform()))
        .map(|value| (value / 1e3).round() * 1e3)
        .collect();
    (time_s, values)
}

fn found(signal: Signal, (time_s, values): &(Vec<f64>, Vec<f64>)) -> Vec<(FailureKind, usize, usize)> {
    Failures::of(signal, time_s, values).stretches.iter().map(|s| (s.kind, s.from, s.to)).collect()
}

#[test]
fn a_rod_that_rests_and_a_spool_that_sticks_have_not_failed() {
    assert_eq!(found(Signal::Position, &rod()), []);
    // Breaks away from rest by a tenth of its travel, again and again, with readings free of noise.
    let (time_s, _) = rod();
    let spool = time_s
        .iter()
        .map(|time| ((time * 8.0).sin() * 5.0).round() / 5.0 + 1e-3 * (time * 30.0).sin().round())
        .collect();
    assert_eq!(found(Signal::Spool, &(time_s, spool)), []);
}

#[test]
fn a_position_that_hangs_and_jumps_is_found_with_its_rows() {
    let mut rod = rod();
    let held = rod.1[1000];
    rod.1[1000..1500].fill(held);
    let first = (rod.1[..1000].iter().rposition(|value| value.to_bits() != held.to_bits())).unwrap() + 1;
    assert_eq!(found(Signal::Position, &rod), [(FailureKind::Stuck, first, 1500)]);
}

#[test]
fn readings_of_nothing_are_drop_outs_in_whatever_signal() {
    let mut rod = rod();
    rod.1[700..706].fill(0.0);
    rod.1[1800..1900].fill(0.3);
    let expected = [(FailureKind::Dropout, 700, 706), (FailureKind::Dropout, 1800, 1900)];
    assert_eq!(found(Signal::Position, &rod), expected);
    let mut pressure = noisy();
    pressure.1[700..750].fill(0.0);
    assert_eq!(found(Signal::PressureA, &pressure), [(FailureKind::Dropout, 700, 750)]);
}

#[test]
fn the_rests_before_and_after_a_failure_are_none() {
    // The reading is stuck while the rod moves, and jumps to where the rod is at rest by then.
    let mut late = rod();
    let held = late.1[3300];
    late.1[3300..3600].fill(held);
    assert_eq!(found(Signal::Position, &late).last(), Some(&(FailureKind::Stuck, 3300, 3600)));
    assert_eq!(found(Signal::Position, &late).len(), 1);
    let mut resting = rod();
    resting.1[100..150].fill(0.0);
    resting.1[200..250].fill(0.0);
    let expected = [(FailureKind::Dropout, 100, 150), (FailureKind::Dropout, 200, 250)];
    assert_eq!(found(Signal::Position, &resting), expected);
    // A failure from which the sensor does not come back.
    let mut moving = rod();
    moving.1[2000..].fill(0.0);
    assert_eq!(found(Signal::Position, &moving), [(FailureKind::Stuck, 2000, 4000)]);
}

#[test]
fn a_silent_pressure_has_to_jump_and_a_jumping_one_to_be_silent() {
    let mut silent = noisy();
    let held = silent.1[393];
    // Over a whole period, the signal comes back to where it left.
    silent.1[393..393 + 1571].fill(held);
    assert_eq!(found(Signal::PressureA, &silent), []);
    let mut stuck = noisy();
    let held = stuck.1[1000];
    stuck.1[1000..1500].fill(held);
    assert_eq!(found(Signal::PressureA, &stuck), [(FailureKind::Stuck, 1000, 1500)]);
    // A rod without noise may drop to another pressure within a row.
    let (time_s, mut jumping) = rod();
    jumping[3600..].iter_mut().for_each(|value| *value += 0.05);
    assert_eq!(found(Signal::PressureA, &(time_s, jumping)), []);
}

#[test]
fn a_jump_over_a_gap_in_time_is_none() {
    let (mut time_s, mut values) = rod();
    time_s[3700..].iter_mut().for_each(|time| *time += 2.0);
    values[3700..].iter_mut().for_each(|value| *value -= 0.05);
    assert_eq!(found(Signal::Position, &(time_s, values)), []);
}

/// A spool that strokes up and down with sharp corners, jumps and rings, 200 Hz, with noise of half a thousandth.
fn stroking_spool() -> Vec<f64> {
    let shape = |row: usize| match row % 100 {
        phase @ 0..30 => 0.03 * phase as f64 - 0.45,
        30..60 => 0.45,
        phase @ 60..80 => 0.45 - 0.09 * (phase - 60) as f64 / 2.0,
        // A jump, and what rings after it.
        phase => -0.6 + 0.15 * (0.8 * (phase - 80) as f64).cos() * (-0.2 * (phase - 80) as f64).exp(),
    };
    let mut noise = Noise::new(9, 0);
    (0..1000).map(|row| shape(row) + noise.gaussian(5e-4)).collect()
}

#[test]
fn spikes_stand_out_of_a_signal_that_moves_and_its_corners_jumps_and_ringing_do_not() {
    let spikes = |values: &[f64]| -> Vec<usize> {
        let found = super::spikes(values, crate::signal::noise::noise(values, 0.0));
        (0..values.len()).filter(|row| found[*row]).collect()
    };
    let clean = stroking_spool();
    assert!(spikes(&clean).is_empty(), "{:?}", spikes(&clean));
    let mut values = clean;
    // In both directions, on the way up and down; the median of seven rows that move like this is as far from them as these failures are.
    for (row, off) in [(110, 0.17), (215, -0.17), (470, 0.2), (575, -0.3)] {
        values[row] += off;
    }
    assert_eq!(spikes(&values), [110, 215, 470, 575]);
}

#[test]
fn spikes_are_no_stretches_and_failed_rows_are_bridged() {
    let (time_s, mut values) = rod();
    values[1200] += 0.05;
    values[1700..1703].fill(0.0);
    let failures = Failures::of(Signal::Position, &time_s, &values);
    assert!(failures.stretches.is_empty());
    let failed: Vec<usize> = (0..values.len()).filter(|row| failures.rows()[*row]).collect();
    assert_eq!(failed, [1200, 1700, 1701, 1702]);
    let bridged = bridged(&values, &failures.rows());
    assert!(bridged.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 3e-4));
    assert_eq!(super::bridged(&[5.0, 1.0, 5.0], &[true, false, true]), [1.0, 1.0, 1.0]);
}

fn ends(signal: Signal, values: &[f64]) -> Vec<(f64, usize)> {
    let time_s: Vec<f64> = (0..values.len()).map(|row| row as f64 * 1e-3).collect();
    Failures::of(signal, &time_s, values).ends.iter().map(|end| (end.reading, end.count())).collect()
}

fn cut(values: &[f64], low: f64, high: f64) -> Vec<f64> {
    values.iter().map(|value| value.clamp(low, high)).collect()
}

#[test]
fn readings_at_an_end_of_a_range_lack_their_noise() {
    let (_, pressure) = noisy();
    assert_eq!(ends(Signal::PressureA, &pressure), []);
    let high = ends(Signal::PressureA, &cut(&pressure, 0.0, 3.5e6));
    let beyond = pressure.iter().filter(|value| **value >= 3.5e6).count();
    assert!(
        matches!(high.as_slice(), [(reading, count)] if (*reading - 3.5e6).abs() < 1e-3 && count.abs_diff(beyond) < 200),
        "{high:?}"
    );
    // Most of it, and both ends.
    assert_eq!(ends(Signal::PressureA, &cut(&pressure, 2.6e6, 2.9e6)).len(), 2);
    let spool: Vec<f64> = pressure.iter().map(|value| (value - 3e6) / 1e6).collect();
    assert_eq!(ends(Signal::Spool, &cut(&spool, -0.7, 0.8)).len(), 2);
}

/// A valve that overshoots at full command passes the end of its sensor for a row or two; in another quantity, or short of full travel, such a peak is none.
#[test]
fn a_spool_is_cut_at_full_travel_however_short_it_is_beyond() {
    let quantised = |full: f64| -> Vec<f64> {
        let at = |row: i32| {
            let since = f64::from(row % 400);
            let overshoot = 1.0 + 0.2 * (-since / 4.0).exp() * (since / 2.0).cos();
            let sign = if row / 400 % 2 == 0 { 0.98 } else { -0.98 };
            ((sign * overshoot * full * 4096.0).round() / 4096.0).clamp(-1.0, 4095.0 / 4096.0)
        };
        (0..1600).map(at).collect()
    };
    let spool = quantised(1.0);
    let mut found = ends(Signal::Spool, &spool);
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let beyond = |end: f64| spool.iter().filter(|value| value.to_bits() == end.to_bits()).count();
    assert_eq!(found, [(-1.0, beyond(-1.0)), (4095.0 / 4096.0, beyond(4095.0 / 4096.0))]);
    assert!(found.iter().all(|(_, rows)| (1..8).contains(rows)), "{found:?}");
    assert_eq!(ends(Signal::Spool, &quantised(0.8)), []);
    assert_eq!(ends(Signal::Position, &spool), []);
}

#[test]
fn an_end_that_another_recording_shows_holds_for_the_same_sensor() {
    let (time_s, pressure) = noisy();
    let shown = Failures::of(Signal::PressureA, &time_s, &cut(&pressure, 0.0, 3.5e6)).ends;
    let [end] = shown.as_slice() else { panic!("{shown:?}") };
    let mut short: Vec<f64> = pressure.iter().map(|pa| pa.min(3.3e6)).collect();
    short[700..703].fill(end.reading);
    assert_eq!(end.in_other(&short).map(|end| end.count()), Some(3));
    // It does not come so far, or goes beyond.
    assert_eq!(end.in_other(&cut(&pressure, 0.0, 3.3e6)), None);
    assert_eq!(end.in_other(&pressure), None);
}

#[test]
fn both_pressure_sensors_have_one_range() {
    let (time_s, pressure) = noisy();
    let a = cut(&pressure, 0.0, 3.5e6);
    // B reaches the end for a moment only.
    let mut b: Vec<f64> = pressure.iter().map(|pa| pa.min(3.3e6)).collect();
    b[700..710].fill(3.5e6);
    let column = |signal, values: &[f64]| recording::Column::si(signal, values.to_vec());
    let columns = vec![
        column(Signal::Time, &time_s),
        column(Signal::Command, &vec![0.0; time_s.len()]),
        column(Signal::PressureA, &a),
        column(Signal::PressureB, &b),
    ];
    assert_eq!(ends(Signal::PressureB, &b), []);
    let recording = Recording::new("a run", columns).unwrap();
    for signal in [Signal::PressureA, Signal::PressureB] {
        assert_eq!(sensor_range(&recording, signal), (f64::NEG_INFINITY, 3.5e6), "{signal}");
    }
    for signal in [Signal::Command, Signal::Position] {
        assert_eq!(sensor_range(&recording, signal), (f64::NEG_INFINITY, f64::INFINITY), "{signal}");
    }
}

/// A sensor that ends before its noise is added: where it is just inside, that lifts a row beyond the end.
#[test]
fn a_row_beyond_the_end_of_a_range_does_not_hide_it() {
    let (time_s, pressure) = noisy();
    let end = 3.5e6;
    let mut read = cut(&pressure, 0.0, end);
    let left = (1..read.len()).find(|&row| read[row - 1] >= end && read[row] < end).unwrap();
    read[left] = end + 2e4;
    let found = ends(Signal::PressureA, &read);
    assert!(matches!(found.as_slice(), [(reading, _)] if (*reading - end).abs() < 1.0), "{found:?}");
    let columns = vec![
        recording::Column::si(Signal::Time, time_s.clone()),
        recording::Column::si(Signal::Command, vec![0.0; time_s.len()]),
        recording::Column::si(Signal::PressureA, read),
    ];
    let recording = Recording::new("a run", columns).unwrap();
    assert_eq!(sensor_range(&recording, Signal::PressureA), (f64::NEG_INFINITY, end));
    // A tenth of the rows beyond is no end.
    let beyond: Vec<f64> = cut(&pressure, 0.0, end);
    let lifted = beyond.iter().enumerate().map(|(row, pa)| if row % 10 == 0 { pressure[row].max(*pa) } else { *pa });
    assert_eq!(ends(Signal::PressureA, &lifted.collect::<Vec<_>>()), []);
}

#[test]
fn the_noise_of_a_sensor_is_that_of_the_rows_within_its_range() {
    let (time_s, pressure) = noisy();
    let clipped = cut(&pressure, 0.0, 2.7e6);
    let found = Failures::of(Signal::PressureA, &time_s, &clipped).noise(&clipped);
    let whole = Failures::of(Signal::PressureA, &time_s, &pressure).noise(&pressure);
    assert!((found / whole - 1.0).abs() < 0.15, "{found} {whole}");
}

#[test]
fn a_sensor_without_visible_noise_shows_an_end_of_its_range_by_corners() {
    let wave: Vec<f64> =
        (0..6000).map(|row| ((3e6 + 2e6 * (0.06 * f64::from(row)).sin()) / 1e4).round() * 1e4).collect();
    assert_eq!(ends(Signal::PressureB, &wave), []);
    assert!(ends(Signal::PressureB, &cut(&wave, 0.0, 4e6)).len() == 1);
    // A rod may well come to its stop at full speed, and a floor near the tank's pressure is oil's own.
    assert_eq!(ends(Signal::Position, &cut(&wave, 0.0, 4e6)), []);
    let floor: Vec<f64> = wave.iter().map(|pa| pa - 2e6).collect();
    assert_eq!(ends(Signal::PressureB, &cut(&floor, 0.0, 9e6)), []);
}

/// Short ringing pulses out of a rest of a quiet sensor.
#[test]
fn a_rest_that_pulses_leave_to_both_sides_is_at_no_end_of_a_range() {
    let pulse = |row: u32| {
        let since = f64::from(row % 1000) - 500.0;
        if (0.0..40.0).contains(&since) { 8e5 * (-0.1 * since).exp() * (0.8 * since).cos() } else { 0.0 }
    };
    let values: Vec<f64> = (0..3000).map(|row| ((6e6 + pulse(row)) / 1e4).round() * 1e4).collect();
    assert_eq!(ends(Signal::PressureA, &values), []);
}

#[test]
fn what_rests_at_its_highest_or_lowest_value_is_at_no_end_of_a_range() {
    // A rod that rests in both directions against its stops.
    let (_, rod) = rod();
    assert_eq!(ends(Signal::Position, &cut(&rod, 0.1, 0.2)), []);
    // A pressure that rises to the supply's, in coarse steps.
    let rising = |row: u32| ((1.0 - (-0.02 * f64::from(row % 1000)).exp()) * 200.0).round() * 5e4;
    assert_eq!(ends(Signal::PressureA, &(0..4000).map(rising).collect::<Vec<_>>()), []);
    // A spool with noise that rests at full travel, and one without.
    let mut noise = Noise::new(5, 0);
    let travel = |row: u32| (2.0 * (0.005 * f64::from(row)).sin()).clamp(-1.0, 1.0);
    let noisy: Vec<f64> = (0..4000).map(|row| travel(row) + noise.gaussian(5e-4)).collect();
    assert_eq!(ends(Signal::Spool, &noisy), []);
    assert_eq!(ends(Signal::Spool, &(0..4000).map(travel).collect::<Vec<_>>()), []);
}
