//! What the preparation found in each recording: noise, steps of the sensors, rows that failed, dither, the state at the start.

use crate::noise::resolution;
use crate::prepare::Prepared;
use crate::recording::{Recording, Signal};
use crate::spectrum::{Line, strongest_line};

/// Slowest dither, Hz: below it a command is motion.
const SLOWEST_DITHER_HZ: f64 = 30.0;
/// How far a line is above the spectrum around it at least to be dither and no edge of a step.
const ABOVE: f64 = 1e3;

/// What was found in one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundChannel {
    /// The signal.
    pub signal: Signal,
    /// Standard deviation of its noise, SI.
    pub noise: f64,
    /// Step of its sensor, SI, where one shows.
    pub step: Option<f64>,
    /// Rows where it failed for a moment; they are not judged.
    pub spikes: usize,
    /// Its value at the start, SI, from the rows around.
    pub start: f64,
    /// Fit that a perfect model would reach, %.
    pub ceiling_percent: f64,
}

/// What was found in one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The recording.
    pub recording: String,
    /// Rows.
    pub rows: usize,
    /// Length, s.
    pub duration_s: f64,
    /// The judged channels.
    pub channels: Vec<FoundChannel>,
    /// Dither in the command.
    pub dither: Option<Line>,
    /// What reading it had to put right.
    pub notes: Vec<String>,
}

/// Sums up what was prepared of a recording.
#[must_use]
pub fn found(recording: &Recording, prepared: &Prepared) -> Found {
    let start = &prepared.stimulus.start;
    let channels = prepared.channels.iter().map(|channel| {
        let step = resolution(&channel.recorded);
        FoundChannel {
            signal: channel.signal,
            noise: channel.noise,
            step: (step > 0.0).then_some(step),
            spikes: channel.failed.iter().filter(|failed| **failed).count(),
            start: match (channel.signal, start.pressures_pa) {
                (Signal::Position, _) => start.position_m,
                (Signal::PressureA, Some((a, _))) => a,
                (Signal::PressureB, Some((_, b))) => b,
                _ => channel.recorded.first().copied().unwrap_or(0.0),
            },
            ceiling_percent: channel.noise_floor_percent(),
        }
    });
    Found {
        recording: prepared.name.clone(),
        rows: prepared.time_s.len(),
        duration_s: prepared.duration_s(),
        channels: channels.collect(),
        dither: recording.signal(Signal::Command).and_then(|command| dither(command, recording.sample_interval_s())),
        notes: recording.notes().iter().map(ToString::to_string).collect(),
    }
}

/// A line in the command's differences: they hold no level, and the edge of a step is no line.
fn dither(command: &[f64], interval_s: f64) -> Option<Line> {
    let changes: Vec<f64> = command.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let line = strongest_line(&changes, interval_s, SLOWEST_DITHER_HZ).filter(|line| line.above > ABOVE)?;
    let gain = 2.0 * (std::f64::consts::PI * line.hz * interval_s).sin();
    Some(Line { amplitude: line.amplitude / gain, ..line })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dither_is_found_with_its_size_and_steps_are_none() {
        let steps: Vec<f64> = (0..4000).map(|row| [0.0, 4.0, 0.0, -4.0][row / 500 % 4]).collect();
        assert_eq!(dither(&steps, 1e-3), None);
        let with: Vec<f64> = steps
            .iter()
            .enumerate()
            .map(|(row, volts)| volts + 0.3 * (std::f64::consts::TAU * 120.0 * row as f64 * 1e-3).sin())
            .collect();
        let line = dither(&with, 1e-3).unwrap();
        assert!((line.hz - 120.0).abs() < 0.5 && (line.amplitude - 0.3).abs() < 0.05, "{line:?}");
    }
}
