//! Readings that a working sensor never gives: spikes, dropouts, and a reading that is stuck.
//!
//! A rod at rest gives a constant reading, and so does a spool that sticks, so a constant alone is no failure. A failure as found
//! here starts or ends with a jump that is several times larger than every other change of the recording. A position cannot jump,
//! as its velocity is bounded by what the recording shows. A signal that may jump (a spool that breaks away, a pressure between two
//! slow samples) must also repeat one reading for longer than its own noise allows. A sensor without noise that is stuck to the end
//! of the recording, or comes back to where it left, cannot be distinguished from a drive at rest and is not found; of two
//! constants with one jump between, the first counts as the failure.

mod dropouts;
mod spikes;

use std::borrow::Cow;

use dropouts::stretches;
use spikes::spikes;

use recording::{Recording, Signal};

use crate::signal::noise::{noise, resolution};

/// Kind of failure over several rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FailureKind {
    /// It jumped away, repeated one value, and jumped back.
    Dropout,
    /// It repeated one value and jumped to, or from, the signal's true value.
    Stuck,
}

impl FailureKind {
    /// Its name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            FailureKind::Dropout => "dropout",
            FailureKind::Stuck => "stuck",
        }
    }
}

/// Rows over which a failed sensor repeated one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// What it did.
    pub kind: FailureKind,
    /// First row.
    pub from: usize,
    /// The row after its last.
    pub to: usize,
    /// What it read, SI.
    pub reading: f64,
}

/// Where a sensor failed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Failures {
    /// Failed rows that stand alone, up to three together.
    pub spikes: Vec<bool>,
    /// Longer failures, in order; they do not overlap.
    pub stretches: Vec<Stretch>,
}

impl Failures {
    /// Looks for failures in what a sensor recorded.
    #[must_use]
    pub fn of(signal: Signal, time_s: &[f64], values: &[f64]) -> Self {
        let step = resolution(values);
        let noise = noise(values, step);
        let spikes = spikes(values, noise);
        let stretches = stretches(signal, time_s, values, &spikes, noise.max(step));
        Self { spikes, stretches }
    }

    /// Whether the sensor failed at all.
    #[must_use]
    pub fn are_any(&self) -> bool {
        self.spikes.contains(&true) || !self.stretches.is_empty()
    }

    /// Rows in which the sensor failed.
    #[must_use]
    pub fn rows(&self) -> Vec<bool> {
        let mut failed = self.spikes.clone();
        for stretch in &self.stretches {
            failed[stretch.from..stretch.to].fill(true);
        }
        failed
    }
}

/// Values with the failed rows bridged by a straight line; at an end, by the nearest value that did not fail.
#[must_use]
pub fn bridged(recorded: &[f64], failed: &[bool]) -> Vec<f64> {
    let mut values = recorded.to_vec();
    let mut row = 0;
    while row < values.len() {
        if !failed[row] {
            row += 1;
            continue;
        }
        let next = (row..values.len()).find(|row| !failed[*row]);
        let before = row.checked_sub(1).map(|row| values[row]);
        let (from, to) = match (before, next.map(|row| values[row])) {
            (Some(from), Some(to)) => (from, to),
            (Some(value), None) | (None, Some(value)) => (value, value),
            (None, None) => return values,
        };
        let end = next.unwrap_or(values.len());
        let count = (end - row + 1) as f64;
        for (step, value) in values[row..end].iter_mut().enumerate() {
            *value = from + (to - from) * (step + 1) as f64 / count;
        }
        row = end;
    }
    values
}

/// Measured signals that a simulation may start from or be driven by. A command is not measured: its jumps are intended.
pub const MEASURED: [Signal; 7] = [
    Signal::Spool,
    Signal::Flow,
    Signal::PressureA,
    Signal::PressureB,
    Signal::Force,
    Signal::Position,
    Signal::OilTemperature,
];

/// A recording in which the failed rows of its sensors are bridged.
#[derive(Clone, Debug)]
pub struct Mended<'a> {
    /// The recording, bridged where a sensor failed.
    pub recording: Cow<'a, Recording>,
    /// What was found in each of [`MEASURED`] that was recorded, in that order.
    pub failures: Vec<(Signal, Failures)>,
}

impl<'a> Mended<'a> {
    /// Looks for failures in every measured signal.
    #[must_use]
    pub fn of(recording: &'a Recording) -> Self {
        let mut mended = Self { recording: Cow::Borrowed(recording), failures: Vec::new() };
        for signal in MEASURED {
            let Some(values) = recording.signal(signal) else { continue };
            let failures = Failures::of(signal, recording.time_s(), values);
            if failures.are_any() {
                mended.recording.to_mut().replace(signal, &bridged(values, &failures.rows()));
            }
            mended.failures.push((signal, failures));
        }
        mended
    }
}

#[cfg(test)]
mod tests;
