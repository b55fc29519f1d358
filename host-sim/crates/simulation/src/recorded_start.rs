//! The initial state of a recording.

use model_core::machine::{Machine, Parameter};
use recording::Signal;

use crate::input_point::InputPoint;
use crate::sensor_fault::Mended;
use crate::start_in_motion::{Motion, SpoolAtStart};
use crate::straight_line::{Line, noise_of};
use crate::taken_up::TakenUp;

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
    /// What a run takes from the recording at the end of that time, where this begins in motion.
    pub taken_up: Option<TakenUp>,
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
            taken_up: None,
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
/// A recording that does not begin at rest starts with the spool and the velocity that it shows, its other values come from its first rows, and it is
/// taken up where the valve has settled.
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
    let began = |signal| {
        recording.signal(signal).map(|values: &[f64]| at_start(&time_s[..rest], &values[..rest], noise_of(values)))
    };
    let known = |signal| began(signal).filter(|_| !mended.is_at_end(signal, 0..rest));
    let pressures_pa = known(Signal::PressureA).zip(known(Signal::PressureB));
    let position_m = began(Signal::Position).unwrap_or(0.5 * machine.get(Parameter::Stroke));
    let is_moved = motion.unknown_for_s > 0.0 || motion.velocity_m_per_s != 0.0;
    let taken_up = if is_moved { TakenUp::of(mended, motion.unknown_for_s) } else { None };
    Start {
        velocity_m_per_s: motion.velocity_m_per_s,
        spool: motion.spool,
        settled: began(Signal::Spool).filter(|_| motion.spool.is_none() && input_point == InputPoint::Command),
        unknown_for_s: taken_up.map_or(motion.unknown_for_s, |taken_up| taken_up.after_s),
        taken_up,
        ..Start::at_rest(command.map_or(0.0, |command| command[0]), pressures_pa, position_m)
    }
}

/// Fewest rows that a line is laid through.
const LEAST_ROWS: usize = 2;
/// What the first rows tell, with fewer and with more of them, is that many standard deviations apart less often than once in sixteen thousand recordings.
const BEYOND_NOISE: f64 = 4.0;

/// The value of a signal at its first row, from the rows around it: their mean, or where they clearly rise or fall, the
/// start of the line through them. A row from which on something moves the signal does not belong to them: it shows by a value that
/// does not agree within the noise with that of fewer rows.
fn at_start(time_s: &[f64], values: &[f64], noise: f64) -> f64 {
    let (mut start, mut low, mut high) = (values[0], f64::NEG_INFINITY, f64::INFINITY);
    for rows in LEAST_ROWS..=values.len() {
        let line = Line::through(&time_s[..rows], &values[..rows], noise);
        let (value, std) = if line.clear_slope() == 0.0 {
            (line.mean, line.mean_std)
        } else {
            (line.at_start, line.std_at(time_s[0]))
        };
        (low, high) = (low.max(value - BEYOND_NOISE * std), high.min(value + BEYOND_NOISE * std));
        if low > high {
            break;
        }
        start = value;
    }
    start
}

#[cfg(test)]
mod tests {
    use recording::seeded_noise::Noise;

    use super::*;

    /// Six rows at 4 ms of a pressure that a step moves from the third on: 20 ms would have mixed what was before with what came after.
    #[test]
    fn a_step_in_the_third_row_does_not_change_the_value_before_it() {
        for seed in 0..200 {
            let mut noise = Noise::new(seed, 1);
            let time_s: Vec<f64> = (0..6).map(|row| 4e-3 * f64::from(row)).collect();
            let mut pressure = |row: usize| 35e5 - 1.5e5 * row.saturating_sub(2) as f64 + noise.gaussian(5e3);
            let values: Vec<f64> = (0..6).map(&mut pressure).collect();
            let start = at_start(&time_s, &values, 5e3);
            assert!((start - 35e5).abs() < 4e4, "{seed}: {start}");
        }
    }

    #[test]
    fn of_a_rest_all_rows_are_used() {
        let of = |seed| {
            let mut noise = Noise::new(seed, 1);
            let time_s: Vec<f64> = (0..100).map(|row| 1e-3 * f64::from(row)).collect();
            let values: Vec<f64> = time_s.iter().map(|_| noise.gaussian(1.0)).collect();
            at_start(&time_s, &values, 1.0)
        };
        let mean_square = (0..500).map(|seed| of(seed).powi(2)).sum::<f64>() / 500.0;
        assert!((0.008..0.013).contains(&mean_square), "{mean_square}");
    }
}
