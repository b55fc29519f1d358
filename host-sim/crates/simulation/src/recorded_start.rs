//! The initial state of a recording.

use model_core::machine::{Machine, Parameter};
use recording::Signal;

use crate::input_point::InputPoint;
use crate::sensor_fault::Mended;
use crate::start_in_motion::{Motion, SpoolAtStart};

/// Initial state of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Command held before the start, V.
    pub command_v: f64,
    /// Chamber pressures, Pa; `None` where the recording does not have them: then the level at rest and the balance of forces give them.
    pub pressures_pa: Option<(f64, f64)>,
    /// Position, m.
    pub position_m: f64,
    /// Measured external force, N; 0 where there is none.
    pub load_n: f64,
    /// Flow that other consumers take from the same supply, m³/s; 0 where none is recorded.
    pub other_flow_m3_per_s: f64,
    /// Velocity, m/s; 0 where the recording does not show that the rod moves.
    pub velocity_m_per_s: f64,
    /// The spool, where it is measured and is not where the command would hold it after a long time.
    pub spool: Option<SpoolAtStart>,
    /// What the sensor of a spool reads that has settled at the command, 1: within the valve's hysteresis it may rest anywhere.
    pub settled: Option<f64>,
    /// Time after which a state that no sensor shows has settled, s; 0 where nothing is unknown.
    pub unknown_for_s: f64,
}

impl Start {
    /// A drive at rest, its valve settled at the command.
    #[must_use]
    pub const fn at_rest(command_v: f64, pressures_pa: Option<(f64, f64)>, position_m: f64) -> Self {
        Self {
            command_v,
            pressures_pa,
            position_m,
            load_n: 0.0,
            other_flow_m3_per_s: 0.0,
            velocity_m_per_s: 0.0,
            spool: None,
            settled: None,
            unknown_for_s: 0.0,
        }
    }
}

/// Shortest time over which the initial state is averaged, s: less than a valve needs to move a rod.
const REST_LEAST_S: f64 = 0.02;
/// Longest time, s, while the command keeps its first value.
const REST_MOST_S: f64 = 0.1;

/// The initial state of a recording: means over the rest at its start, so that the noise of one row does not shift all
/// others. Rows with a failed sensor are bridged in it. Where no position is recorded, the rod stands at mid-stroke.
///
/// A recording that does not begin at rest starts with the spool and the velocity that it shows, and its other values come from its first rows.
/// A pressure at an end of its sensor's range is not known, so that none of the two is taken.
pub(crate) fn start(mended: &Mended<'_>, machine: &Machine<f64>, input_point: InputPoint) -> Start {
    let recording = &*mended.recording;
    let time_s = recording.time_s();
    let command = recording.signal(Signal::Command);
    let held = |row: usize| command.is_some_and(|command| command[row].to_bits() == command[0].to_bits());
    let motion = Motion::of(recording, machine, input_point);
    let rest = (0..time_s.len())
        .take_while(|&row| {
            let since = time_s[row] - time_s[0];
            since < REST_LEAST_S || (since < REST_MOST_S && held(row))
        })
        .count();
    let rest = if motion.is_changing { motion.first_rows } else { rest };
    let began = |signal| recording.signal(signal).map(|values: &[f64]| at_start(&time_s[..rest], &values[..rest]));
    let known = |signal| began(signal).filter(|_| !mended.is_at_end(signal, rest));
    let pressures_pa = known(Signal::PressureA).zip(known(Signal::PressureB));
    let position_m = began(Signal::Position).unwrap_or(0.5 * machine.get(Parameter::Stroke));
    Start {
        velocity_m_per_s: motion.velocity_m_per_s,
        spool: motion.spool,
        settled: began(Signal::Spool).filter(|_| motion.spool.is_none() && input_point == InputPoint::Command),
        unknown_for_s: motion.unknown_for_s,
        ..Start::at_rest(command.map_or(0.0, |command| command[0]), pressures_pa, position_m)
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
