//! What the preprocessing found in each recording: noise, steps of the sensors, rows that failed, dither, the clock, the initial
//! state.

use std::fmt;

use diagnosis::Shown;
use identification::clock::{Shift, Stamps};
use identification::experiment::Prepared;
use identification::visible::shows_lag;
use recording::display_unit::{significant, unit_for_people};
use recording::{Note, Recording, Signal};
use simulation::sensor_fault::{FailureKind, Failures, RangeEnd, Stretch};
use simulation::signal::noise::{extent, resolution};
use simulation::signal::spectrum::{SpectralLine, strongest_line};

use crate::wording::{range_end, unsettled};

/// Slowest dither, Hz: below it a command is motion.
const SLOWEST_DITHER_HZ: f64 = 30.0;
/// Factor by which a line exceeds the spectrum around it at least; below this it is the edge of a step and no dither.
const ABOVE: f64 = 1e3;
/// Smallest dither as a share of the command's span: a smaller one moves no spool, and comes from how the numbers were written.
const LEAST_SHARE: f64 = 1e-3;

/// What was found in one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct PreparedChannel {
    /// The signal.
    pub signal: Signal,
    /// Standard deviation of its noise, SI.
    pub noise: f64,
    /// Step of its sensor, SI, where one is visible.
    pub step: Option<f64>,
    /// Rows where it failed for a moment; they are not judged.
    pub spikes: usize,
    /// Where it failed for longer; these rows are not judged either.
    pub failures: Vec<FailedRows>,
    /// Where it is at an end of its range; nor are these.
    pub ends: Vec<AtEnd>,
    /// Its value at the start, SI, from the neighbouring rows.
    pub start: f64,
    /// Fit that a perfect model would reach, %.
    pub ceiling_percent: f64,
}

/// A sensor that repeated one value that is not a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FailedRows {
    /// The signal.
    pub signal: Signal,
    /// How it failed.
    pub kind: FailureKind,
    /// Time of its first row, s.
    pub from_s: f64,
    /// Time of its last row, s.
    pub to_s: f64,
    /// What it read, SI.
    pub reading: f64,
}

impl FailedRows {
    fn of(signal: Signal, time_s: &[f64], stretch: &Stretch) -> Self {
        let Stretch { kind, from, to, reading } = *stretch;
        Self { signal, kind, from_s: time_s[from], to_s: time_s[to - 1], reading }
    }
}

/// In words, without how its rows are treated.
impl fmt::Display for FailedRows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = unit_for_people(self.signal);
        let (reading, kind) = (significant(unit.from_si(self.reading), 4), self.kind.name());
        write!(f, "{} {kind} at {reading} {unit} from {:.3} to {:.3} s", self.signal, self.from_s, self.to_s)
    }
}

/// A sensor at an end of its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtEnd {
    /// The signal.
    pub signal: Signal,
    /// What it reads there, SI.
    pub reading: f64,
    /// Rows there.
    pub rows: usize,
    /// These rows as a share of all.
    pub share: f64,
}

impl AtEnd {
    fn of(signal: Signal, end: &RangeEnd) -> Self {
        let rows = end.count();
        Self { signal, reading: end.reading, rows, share: rows as f64 / end.rows.len() as f64 }
    }
}

/// In words, without how its rows are treated.
impl fmt::Display for AtEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&range_end(self.signal, self.reading, self.share))
    }
}

/// A measured signal that is not judged and failed in some rows: there a straight line replaces it, as a drive input or as the initial state.
#[derive(Clone, Debug, PartialEq)]
pub struct Bridged {
    /// The signal.
    pub signal: Signal,
    /// Rows where it failed for a moment.
    pub spikes: usize,
    /// Where it failed for longer.
    pub failures: Vec<FailedRows>,
    /// Where it is at an end of its range.
    pub ends: Vec<AtEnd>,
}

/// What was found in one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Preprocessing {
    /// The recording.
    pub recording: String,
    /// Rows.
    pub rows: usize,
    /// Length, s.
    pub duration_s: f64,
    /// Time at its beginning that is not judged, s, as it does not begin at rest and not all of its state is measured.
    pub unsettled_s: f64,
    /// The judged channels.
    pub channels: Vec<PreparedChannel>,
    /// Measured signals that drive or start the model and failed.
    pub bridged: Vec<Bridged>,
    /// Dither in the command.
    pub dither: Option<SpectralLine>,
    /// What its time stamps show.
    pub stamps: Stamps,
    /// Channels that are late against the model after the diagnosis.
    pub shifts: Vec<Shift>,
    /// Whether its pressures were taken as read by absolute sensors.
    pub taken_as_absolute: bool,
    /// What had to be corrected when it was read.
    pub notes: Vec<String>,
}

impl Preprocessing {
    /// Every failure of more than a moment, each with how its rows are treated.
    pub fn failures(&self) -> impl Iterator<Item = (String, &'static str)> {
        fn said<'a>(failures: &'a [FailedRows], ends: &'a [AtEnd]) -> impl Iterator<Item = String> + 'a {
            ends.iter().map(ToString::to_string).chain(failures.iter().map(ToString::to_string))
        }
        let judged = self.channels.iter().flat_map(|channel| said(&channel.failures, &channel.ends));
        let driving = self.bridged.iter().flat_map(|bridged| said(&bridged.failures, &bridged.ends));
        judged.map(|said| (said, "not judged")).chain(driving.map(|said| (said, "bridged by a straight line")))
    }

    /// What is worth reporting about the start and the clock, in sentences.
    #[must_use]
    pub fn of_start_and_clock(&self) -> Vec<String> {
        let mut said = Vec::new();
        if self.unsettled_s > 0.0 {
            said.push(unsettled(self.unsettled_s));
        }
        if self.stamps.lost > 0 || self.stamps.uneven > 0 {
            let interval = significant(1e3 * self.stamps.interval_s, 4);
            let (lost, uneven) = (self.stamps.lost, self.stamps.uneven);
            said.push(format!("{lost} rows are missing at intervals of {interval} ms, {uneven} intervals are uneven"));
        }
        for shift in &self.shifts {
            let (late, std) = (significant(1e3 * shift.late_s.abs(), 3), significant(1e3 * shift.std_s, 2));
            let which = if shift.late_s > 0.0 { "late" } else { "early" };
            said.push(format!("{} is {late} ± {std} ms {which} against the model", shift.signal));
        }
        said
    }
}

/// Sums up the preprocessing of a recording.
#[must_use]
pub(crate) fn preprocessing(recording: &Recording, shown: &Shown) -> Preprocessing {
    let (prepared, time_s) = (&shown.prepared, recording.time_s());
    let (start, settled) = (&prepared.stimulus.start, prepared.unsettled);
    let channels = prepared.channels.iter().map(|channel| {
        let step = resolution(&channel.recorded);
        let failures: Vec<_> =
            channel.stretches.iter().map(|stretch| FailedRows::of(channel.signal, time_s, stretch)).collect();
        let longer: usize =
            channel.stretches.iter().map(|stretch| stretch.to.saturating_sub(stretch.from.max(settled))).sum();
        let at_end: usize = channel.ends.iter().flat_map(|end| &end.rows[settled..]).filter(|at_end| **at_end).count();
        PreparedChannel {
            signal: channel.signal,
            noise: channel.noise,
            step: (step > 0.0).then_some(step),
            spikes: channel.failed[settled..].iter().filter(|failed| **failed).count().saturating_sub(longer + at_end),
            failures,
            ends: channel.ends.iter().map(|end| AtEnd::of(channel.signal, end)).collect(),
            start: match (channel.signal, start.pressures_pa) {
                (Signal::Position, _) => start.position_m,
                (Signal::PressureA, Some((a, _))) => a,
                (Signal::PressureB, Some((_, b))) => b,
                _ => channel.recorded.first().copied().unwrap_or(0.0),
            },
            ceiling_percent: channel.noise_floor_percent(),
        }
    });
    Preprocessing {
        recording: prepared.name.clone(),
        rows: prepared.time_s.len(),
        duration_s: prepared.duration_s(),
        unsettled_s: time_s[settled] - time_s[0],
        channels: channels.collect(),
        bridged: bridged(prepared),
        dither: recording.signal(Signal::Command).and_then(|command| dither(command, recording.sample_interval_s())),
        stamps: Stamps::of(time_s),
        shifts: shifts(shown),
        taken_as_absolute: recording.notes().contains(&Note::TakenAsAbsolute),
        notes: recording.notes().iter().map(ToString::to_string).collect(),
    }
}

/// Measured signals that are not judged, where they failed.
fn bridged(prepared: &Prepared) -> Vec<Bridged> {
    let judged = |signal| prepared.channels.iter().any(|channel| channel.signal == signal);
    prepared
        .failures
        .iter()
        .filter(|(signal, _)| !judged(*signal))
        .map(|&(signal, Failures { ref spikes, ref stretches, ref ends })| Bridged {
            signal,
            spikes: spikes.iter().filter(|spike| **spike).count(),
            failures: stretches.iter().map(|stretch| FailedRows::of(signal, &prepared.time_s, stretch)).collect(),
            ends: ends.iter().map(|end| AtEnd::of(signal, end)).collect(),
        })
        .collect()
}

/// Channels that are late against the model after the diagnosis.
fn shifts(shown: &Shown) -> Vec<Shift> {
    let prepared = &shown.prepared;
    prepared
        .channels
        .iter()
        .filter_map(|channel| {
            let simulated = shown.after.signal(channel.signal)?;
            let rows = channel.recorded.iter().zip(simulated);
            let missed: Vec<f64> = rows.map(|(recorded, simulated)| recorded - simulated).collect();
            let shift = Shift::of(channel.signal, &prepared.time_s, &missed, simulated, &channel.failed)?;
            // A shift of less than a row may well show; one of a large part of the recording is none.
            shows_lag(shift.late_s, 0.0, prepared.duration_s()).then_some(shift)
        })
        .collect()
}

/// A line in the spectrum of the command's differences: they have no level, and the edge of a step makes no line.
fn dither(command: &[f64], interval_s: f64) -> Option<SpectralLine> {
    let changes: Vec<f64> = command.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let line = strongest_line(&changes, interval_s, SLOWEST_DITHER_HZ).filter(|line| line.above > ABOVE)?;
    let amplitude = line.amplitude / (2.0 * libm::sin(std::f64::consts::PI * line.hz * interval_s));
    let (low, high) = extent(command);
    (amplitude > LEAST_SHARE * (high - low) && amplitude > resolution(command))
        .then_some(SpectralLine { amplitude, ..line })
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
        // A slow sweep written with four decimals: the rounding has spectral lines of its own.
        let rounded: Vec<f64> = (0..4000)
            .map(|row| (4.0 * (f64::from(row) * 2e-3).sin() * 1e4).round() / 1e4 + 1e-4 * f64::from(row % 2))
            .collect();
        assert_eq!(dither(&rounded, 1e-3), None);
    }
}
