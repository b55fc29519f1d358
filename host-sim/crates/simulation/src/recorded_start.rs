//! The initial state of a recording.

use model_core::machine::{Machine, Parameter};
use recording::{Recording, Signal};

/// Initial state of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Command held before the start, V.
    pub command_v: f64,
    /// Chamber pressures, Pa; `None` where the recording does not have them: then the level at rest and the balance of forces give them.
    pub pressures_pa: Option<(f64, f64)>,
    /// Position, m.
    pub position_m: f64,
}

/// Shortest time over which the initial state is averaged, s: less than a valve needs to move a rod.
const REST_LEAST_S: f64 = 0.02;
/// Longest time, s, while the command keeps its first value.
const REST_MOST_S: f64 = 0.1;

/// The initial state of a recording: means over the rest at its start, so that the noise of one row does not shift all
/// others. Rows with a failed sensor are bridged in it. Where no position is recorded, the rod stands at mid-stroke.
pub(crate) fn start(recording: &Recording, machine: &Machine<f64>) -> Start {
    let time_s = recording.time_s();
    let command = recording.signal(Signal::Command);
    let held = |row: usize| command.is_some_and(|command| command[row].to_bits() == command[0].to_bits());
    let rest = (0..time_s.len())
        .take_while(|&row| {
            let since = time_s[row] - time_s[0];
            since < REST_LEAST_S || (since < REST_MOST_S && held(row))
        })
        .count();
    let began = |signal| recording.signal(signal).map(|values: &[f64]| at_start(&time_s[..rest], &values[..rest]));
    Start {
        command_v: command.map_or(0.0, |command| command[0]),
        pressures_pa: began(Signal::PressureA).zip(began(Signal::PressureB)),
        position_m: began(Signal::Position).unwrap_or(0.5 * machine.get(Parameter::Stroke)),
    }
}

/// The value of a signal at its first row, from the rows around it: their mean, or where they clearly rise or fall, the
/// start of the line through them.
fn at_start(time_s: &[f64], values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let (middle, mean) = (time_s.iter().sum::<f64>() / count, values.iter().sum::<f64>() / count);
    let spread: f64 = time_s.iter().map(|time| (time - middle).powi(2)).sum();
    if values.len() < 4 || spread <= 0.0 {
        return values[0];
    }
    let slope = time_s.iter().zip(values).map(|(time, value)| (time - middle) * (value - mean)).sum::<f64>() / spread;
    let about: f64 =
        time_s.iter().zip(values).map(|(time, value)| (value - mean - slope * (time - middle)).powi(2)).sum();
    let slope_std = (about / (count - 2.0) / spread).sqrt();
    if slope.abs() > 4.0 * slope_std { mean + slope * (time_s[0] - middle) } else { mean }
}
