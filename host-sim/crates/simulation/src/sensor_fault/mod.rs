//! Readings that a working sensor never gives: spikes, dropouts, and a reading that is stuck.
//!
//! A rod at rest gives a constant reading, and so does a spool that sticks, so a constant alone is no failure. A failure as found
//! here starts or ends with a jump that is several times larger than every other change of the recording. A position cannot jump,
//! as its velocity is bounded by what the recording shows. A signal that may jump (a spool that breaks away, a pressure between two
//! slow samples) must also repeat one reading for longer than its own noise allows. A sensor without noise that is stuck to the end
//! of the recording, or comes back to where it left, cannot be distinguished from a drive at rest and is not found; of two
//! constants with one jump between, the first counts as the failure. Readings at an end of the sensor's range are found in another way, see [`RangeEnd`].

mod dropouts;
mod range_ends;
mod spikes;

use std::borrow::Cow;
use std::ops::Range;

use dropouts::stretches;
use range_ends::range_ends;
use spikes::spikes;

use recording::{Recording, Signal};

use crate::signal::noise::{noise, resolution};

pub use range_ends::{RangeEnd, Side};

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
    /// The ends of the sensor's range that it reached.
    pub ends: Vec<RangeEnd>,
}

impl Failures {
    /// Looks for failures in what a sensor recorded.
    #[must_use]
    pub fn of(signal: Signal, time_s: &[f64], values: &[f64]) -> Self {
        let step = resolution(values);
        let mut ends = range_ends(signal, values, step);
        let noise = noise_within(values, &ends);
        let mut spikes = spikes(values, noise);
        let mut stretches = stretches(signal, time_s, values, &spikes, noise.max(step));
        // A reading that it jumps to is no end of its range that it reaches.
        let jumped = |end: &RangeEnd| {
            stretches
                .iter()
                .map(|stretch| end.rows[stretch.from..stretch.to].iter().filter(|at_end| **at_end).count())
                .sum::<usize>()
        };
        ends.retain(|end| 2 * jumped(end) < end.count());
        for end in &ends {
            stretches.retain(|stretch| !end.rows[stretch.from..stretch.to].contains(&true));
            spikes.iter_mut().zip(&end.rows).for_each(|(spike, at_end)| *spike &= !at_end);
        }
        Self { spikes, stretches, ends }
    }

    /// Whether the sensor failed at all.
    #[must_use]
    pub fn are_any(&self) -> bool {
        self.spikes.contains(&true) || !self.stretches.is_empty() || !self.ends.is_empty()
    }

    /// Rows in which the sensor failed.
    #[must_use]
    pub fn rows(&self) -> Vec<bool> {
        let mut failed = self.spikes.clone();
        for stretch in &self.stretches {
            failed[stretch.from..stretch.to].fill(true);
        }
        for end in &self.ends {
            failed.iter_mut().zip(&end.rows).for_each(|(failed, at_end)| *failed |= at_end);
        }
        failed
    }

    /// Standard deviation of the sensor's noise, where it is not at an end of its range.
    #[must_use]
    pub fn noise(&self, values: &[f64]) -> f64 {
        noise_within(values, &self.ends)
    }
}

fn noise_within(values: &[f64], ends: &[RangeEnd]) -> f64 {
    if ends.is_empty() {
        return noise(values, resolution(values));
    }
    let is_within = |row: &usize| !ends.iter().any(|end| end.rows[*row]);
    let within: Vec<f64> = (0..values.len()).filter(is_within).map(|row| values[row]).collect();
    noise(&within, resolution(&within))
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

/// Between which readings a sensor works, as far as the recording shows: infinite where it shows no end.
///
/// The pressure sensors of both chambers are alike: where one is seen to end, the other that never reads beyond ends as well.
#[must_use]
pub fn sensor_range(recording: &Recording, signal: Signal) -> (f64, f64) {
    let unlimited = (f64::NEG_INFINITY, f64::INFINITY);
    let Some(read) = recording.signal(signal).filter(|_| MEASURED.contains(&signal)) else { return unlimited };
    let alike: &[Signal] = match signal {
        Signal::PressureA | Signal::PressureB => &[Signal::PressureA, Signal::PressureB],
        _ => &[signal],
    };
    let values = alike.iter().filter_map(|&signal| Some((signal, recording.signal(signal)?)));
    let ends: Vec<RangeEnd> =
        values.flat_map(|(signal, values)| Failures::of(signal, recording.time_s(), values).ends).collect();
    let seen = |side: Side| {
        let reached = ends.iter().find(|end| end.side == side && side.is_end(end.reading, read));
        reached.map(|end| end.reading)
    };
    (seen(Side::Low).unwrap_or(unlimited.0), seen(Side::High).unwrap_or(unlimited.1))
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

    /// Whether a sensor is at an end of its range in most of these rows.
    pub(crate) fn is_at_end(&self, signal: Signal, rows: Range<usize>) -> bool {
        let found = self.failures.iter().filter(|(of, _)| *of == signal).flat_map(|(_, failures)| &failures.ends);
        found.into_iter().any(|end| 2 * end.rows[rows.clone()].iter().filter(|row| **row).count() > rows.len())
    }
}

#[cfg(test)]
mod tests;
