//! Whether the sensors of a drawn drive show a difference.

use recording::Signal;

use super::drive::Hall;
use crate::rig::recorded::SyntheticRecording;
use crate::sensor::sensors::PositionSensor;

/// How much two recordings with the same noise differ, over that noise: the signal in which they differ most.
pub fn shows(hall: &Hall, with: &SyntheticRecording, without: &SyntheticRecording) -> f64 {
    let (mut with, mut without) = (with.clone(), without.clone());
    let over_noise = |&signal: &Signal| {
        let (with, without) = (channel(&mut with, signal), channel(&mut without, signal));
        let apart: Vec<f64> = with.iter().zip(without.iter()).map(|(with, without)| with - without).collect();
        rest(&apart) / noise(hall, signal)
    };
    hall.signals.iter().map(over_noise).fold(0.0, f64::max)
}

/// Standard deviation, rounding included.
fn noise(hall: &Hall, signal: Signal) -> f64 {
    let sensors = &hall.sensors;
    let with_step = |noise: f64, step: f64| noise.hypot(step / 12.0_f64.sqrt());
    match signal {
        Signal::Spool => with_step(sensors.spool.noise_std, 1.0 / sensors.spool.counts_per_unit),
        Signal::Position => {
            let PositionSensor::Linear { resolution_m } = sensors.position else {
                return sensors.position_noise_m;
            };
            with_step(sensors.position_noise_m, resolution_m)
        }
        _ => {
            let pressure = sensors.pressure;
            with_step(pressure.noise_std_pa, pressure.range_pa * 2.0_f64.powi(1 - i32::from(pressure.bits)))
        }
    }
}

/// Root mean square of what no offset and no ramp explains.
fn rest(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let along = |row: usize| row as f64 - 0.5 * (count - 1.0);
    let mean = values.iter().sum::<f64>() / count;
    let square: f64 = (0..values.len()).map(|row| along(row).powi(2)).sum();
    let slope = values.iter().enumerate().map(|(row, value)| along(row) * value).sum::<f64>() / square;
    let left = values.iter().enumerate().map(|(row, value)| (value - mean - slope * along(row)).powi(2));
    (left.sum::<f64>() / count).sqrt()
}

/// The values of a signal.
pub fn channel(kept: &mut SyntheticRecording, signal: Signal) -> &mut Vec<f64> {
    match signal {
        Signal::Spool => &mut kept.spool,
        Signal::PressureA => &mut kept.pressure_a_pa,
        Signal::PressureB => &mut kept.pressure_b_pa,
        _ => &mut kept.position_m,
    }
}
