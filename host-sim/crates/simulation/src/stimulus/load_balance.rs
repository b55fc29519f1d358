//! The load that balances the recorded pressures.

use model_core::machine::{Machine, Parameter, Tick};
use recording::{Recording, Signal};

use super::is_carried;
use crate::error::SimulateError;
use crate::sensor_bias::{PRESSURE_A, PRESSURE_B, behind};
use crate::signal::noise::{extent, noise, resolution};
use crate::signal::slope::slopes;

/// Aa·pa − Ab·pb from the true pressures behind the recorded readings, N.
pub(crate) fn pressure_force(recording: &Recording, machine: &Machine<f64>) -> Result<Vec<f64>, SimulateError> {
    let need = |signal| {
        recording.signal(signal).ok_or_else(|| SimulateError::Missing {
            recording: recording.name().to_owned(),
            signal,
            reason: "the force on the rod is taken from both chamber pressures",
        })
    };
    let (area_a, area_b) = (machine.get(Parameter::AreaA), machine.get(Parameter::AreaB));
    let (a, b) = (need(Signal::PressureA)?, need(Signal::PressureB)?);
    if area_a.max(area_b) <= 0.0 {
        return Err(SimulateError::NoAreas { recording: recording.name().to_owned() });
    }
    let force =
        |(a, b): (&f64, &f64)| area_a * behind(machine, PRESSURE_A, *a) - area_b * behind(machine, PRESSURE_B, *b);
    Ok(a.iter().zip(b).map(force).collect())
}

/// Viscous friction that keeps the rod from ringing on the oil spring and hardly brakes it otherwise, N s/m: a twentieth
/// of critical damping, or the machine's where that is less. More, up to the machine's, where the step does not compute the same machine with so little.
pub(crate) fn light_damping(machine: &Machine<f64>, tick: Tick) -> f64 {
    /// From one trial to the next.
    const MORE: f64 = 2.0;
    let (lightest, own) = (lightest_damping(machine), machine.get(Parameter::ViscousFriction));
    let is_computed = |damping: f64| is_carried(&machine.with(&[(Parameter::ViscousFriction, damping)]), tick);
    if lightest <= 0.0 || is_computed(lightest) || !is_carried(machine, tick) {
        return lightest;
    }
    let mut more = std::iter::successors(Some(lightest), |damping| Some(MORE * damping));
    more.find(|damping| *damping >= own || is_computed(*damping)).map_or(own, |damping| damping.min(own))
}

fn lightest_damping(machine: &Machine<f64>) -> f64 {
    let side = |area: Parameter, volume: Parameter| {
        machine.get(area).powi(2) * machine.get(Parameter::BulkModulus) / machine.get(volume)
    };
    let spring = side(Parameter::AreaA, Parameter::VolumeA) + side(Parameter::AreaB, Parameter::VolumeB);
    let critical = 2.0 * (spring * machine.get(Parameter::MovingMass)).sqrt();
    (0.05 * critical).min(machine.get(Parameter::ViscousFriction))
}

/// The force, N, in addition to the machine's constant load, that balances the recorded pressures, and the damping at the
/// recorded velocity where the position is recorded.
pub(crate) fn balance(recording: &Recording, machine: &Machine<f64>, damping: f64) -> Result<Vec<f64>, SimulateError> {
    let pressures = pressure_force(recording, machine)?;
    let rows_in = |time_s: f64| time_s / recording.sample_interval_s();
    let width_s = SMOOTHED_S * (share_of_noise(&pressures) / SMOOTHED_AT).min(1.0);
    let force = smoothed(&pressures, rows_in(width_s));
    let constant = machine.get(Parameter::LoadForce);
    let braked: Vec<f64> = match recording.signal(Signal::Position) {
        Some(position) => {
            let velocity = slopes(recording.time_s(), &smoothed(position, rows_in(width_s)), 1);
            velocity.iter().map(|velocity| damping * velocity).collect()
        }
        None => vec![0.0; force.len()],
    };
    Ok(force.iter().zip(braked).map(|(force, braked)| braked - force - constant).collect())
}

/// A force from noisy pressures is smoothed over this time, s: short enough not to blur the start and end of a stroke.
const SMOOTHED_S: f64 = 0.05;
/// Share of noise from which the full time is used; with less noise, the time is shorter in proportion.
const SMOOTHED_AT: f64 = 0.01;

/// Noise of a series over its span.
fn share_of_noise(values: &[f64]) -> f64 {
    let (low, high) = extent(values);
    if high > low { noise(values, resolution(values)) / (high - low) } else { 0.0 }
}

/// Centred moving average over `width` samples (at least one); shorter at both ends.
fn smoothed(values: &[f64], width: f64) -> Vec<f64> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive count")]
    let half = (0.5 * width).clamp(0.0, 1e6) as usize;
    let mut sums = Vec::with_capacity(values.len() + 1);
    sums.push(0.0);
    for value in values {
        sums.push(sums[sums.len() - 1] + value);
    }
    (0..values.len())
        .map(|index| {
            let reach = half.min(index).min(values.len() - 1 - index);
            (sums[index + reach + 1] - sums[index - reach]) / (2 * reach + 1) as f64
        })
        .collect()
}
