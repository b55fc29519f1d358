//! Channels with their own times, resampled to the times of the first channel.
//!
//! All signals come out at the times of the first channel: those with other times are interpolated linearly there. Times outside
//! any channel's range and repeated times are left out; they are written back where the recording is. Time goes out as `time [s]`.

use std::ops::RangeInclusive;

use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::formats::coarse_stamps::CoarseStamps;
use crate::recording::{At, Column, LeftOut, Note, Recording};
use crate::signal::Signal;

/// One known channel with its samples.
#[derive(Debug)]
pub(crate) struct Sampled {
    pub(crate) column: Column,
    time_s: Vec<f64>,
    /// Samples that repeat the time before them: how many samples precede each of them, and its value.
    repeated: Vec<(usize, f64)>,
}

impl Sampled {
    /// A channel without samples.
    pub(crate) fn new(column: Column) -> Self {
        Self { column, time_s: Vec::new(), repeated: Vec::new() }
    }

    /// Adds a sample in SI units; `false` when it repeats the time before it and is left out. An error holds the previous time, if time goes back.
    pub(crate) fn push(&mut self, time_s: f64, value: f64) -> Result<bool, f64> {
        match self.time_s.last() {
            Some(&previous_s) if time_s < previous_s => return Err(previous_s),
            Some(&previous_s) if time_s <= previous_s => {
                self.repeated.push((self.time_s.len(), value));
                return Ok(false);
            }
            _ => {}
        }
        self.time_s.push(time_s);
        self.column.values.push(value);
        Ok(true)
    }

    /// Spreads its samples within coarse time stamps, if it has such; the note on it, and the number of samples that no longer repeat a time.
    fn spread(&mut self) -> Option<(Note, usize)> {
        let cells = |&(after, value): &(usize, f64)| [Some(self.time_s[after - 1]), Some(value)];
        let mut left_out = LeftOut {
            after: self.repeated.iter().map(|(after, _)| *after).collect(),
            cells: self.repeated.iter().flat_map(cells).collect(),
        };
        let mut series = [&mut self.time_s, &mut self.column.values];
        let mut coarse = CoarseStamps::found(&mut series, &mut left_out)?;
        let note = coarse.spread(series[0], true)?;
        Some((note, std::mem::take(&mut self.repeated).len()))
    }

    /// Its value at a time, linear between its samples; `None` where it has none.
    fn at(&self, time: f64) -> Option<f64> {
        let after = self.time_s.partition_point(|own| *own < time).max(1);
        let (times, values) = (self.time_s.get(after - 1..=after)?, self.column.values.get(after - 1..=after)?);
        (times[0]..=times[1]).contains(&time).then(|| interpolate(times, values, &[time])[0])
    }
}

/// The recording of at least one channel; `repeated` is the number of samples that repeat a time, and the place of the first of them.
pub(crate) fn together(
    name: &str,
    mut known: Vec<Sampled>,
    ignored: Vec<String>,
    mut notes: Vec<Note>,
    mut repeated: Option<(usize, At)>,
) -> Result<Recording, RecordingError> {
    for channel in &mut known {
        let Some((note, spread)) = channel.spread() else { continue };
        repeated = repeated.map(|(rows, first)| (rows - spread, first)).filter(|(rows, _)| *rows > 0);
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    if let Some(empty) = known.iter().find(|channel| channel.time_s.len() < 2) {
        let (rows, skipped) = (empty.time_s.len(), repeated.map_or(0, |(rows, _)| rows));
        return Err(RecordingError::TooFewRows { place: Place::file(name), rows, skipped });
    }
    let start = |channel: &Sampled| channel.time_s.first().copied().unwrap_or(f64::INFINITY);
    let end = |channel: &Sampled| channel.time_s.last().copied().unwrap_or(f64::NEG_INFINITY);
    let from_s = known.iter().map(start).fold(f64::NEG_INFINITY, f64::max);
    let to_s = known.iter().map(end).fold(f64::INFINITY, f64::min);
    let all_s = known.first().map_or_else(Vec::new, |first| first.time_s.clone());
    let time_s: Vec<f64> = all_s.iter().copied().filter(|time| (from_s..=to_s).contains(time)).collect();
    if time_s.len() < 2 {
        return Err(RecordingError::NoCommonTime { place: Place::file(name), from_s, to_s });
    }
    let left_out = left_out(&known, from_s..=to_s);
    let mut resampled = Vec::new();
    let mut columns = vec![Column::si(Signal::Time, time_s.clone())];
    for mut channel in known {
        if channel.time_s != time_s {
            if channel.time_s != all_s {
                resampled.push(channel.column.signal);
            }
            channel.column.values = interpolate(&channel.time_s, &channel.column.values, &time_s);
        }
        columns.push(channel.column);
    }
    let rows_left_out = all_s.len() - time_s.len();
    if !resampled.is_empty() || rows_left_out > 0 {
        notes.push(Note::Resampled { signals: resampled, rows_left_out });
    }
    notes.extend(repeated.map(|(rows, first)| Note::DuplicateTimes { rows, first }));
    let mut recording = Recording::assemble(name, columns, ignored, notes);
    recording.left_out = left_out;
    Ok(recording)
}

/// Samples of the first channel that are not among the recording's rows: outside the time that is `common` to all channels, or with a
/// repeated time. The values of the other channels at their times are included.
fn left_out(known: &[Sampled], common: RangeInclusive<f64>) -> LeftOut {
    let mut left_out = LeftOut::default();
    let Some((first, others)) = known.split_first() else { return left_out };
    let mut kept = 0;
    let mut repeated = first.repeated.iter().peekable();
    for (index, &time) in first.time_s.iter().enumerate() {
        let mut leave_out = |kept: usize, value: f64| {
            left_out.after.push(kept);
            left_out.cells.extend([Some(time), Some(value)]);
            left_out.cells.extend(others.iter().map(|channel| channel.at(time)));
        };
        if common.contains(&time) {
            kept += 1;
        } else {
            leave_out(kept, first.column.values[index]);
        }
        while let Some((_, value)) = repeated.next_if(|(after, _)| *after == index + 1) {
            leave_out(kept, *value);
        }
    }
    left_out
}

/// Values at `at_s` by linear interpolation between samples; every `at_s` lies within `time_s`, and both rise.
fn interpolate(time_s: &[f64], values: &[f64], at_s: &[f64]) -> Vec<f64> {
    let mut next = 1;
    let value_at = |&at: &f64| {
        while next + 1 < time_s.len() && time_s[next] < at {
            next += 1;
        }
        let (t0, t1) = (time_s[next - 1], time_s[next]);
        let (v0, v1) = (values[next - 1], values[next]);
        if at >= t1 { v1 } else { on_line(v0, v1, share_of(t0, t1, at)) }
    };
    at_s.iter().map(value_at).collect()
}

/// The fraction of the interval from `from` to `to` that lies before `at`.
pub(crate) fn share_of(from: f64, to: f64, at: f64) -> f64 {
    let whole = to - from;
    // Half values are used where the difference would exceed the range of a double.
    if whole.is_finite() { (at - from) / whole } else { (0.5 * at - 0.5 * from) / (0.5 * to - 0.5 * from) }
}

/// Linear interpolation between two values.
pub(crate) fn on_line(from: f64, to: f64, share: f64) -> f64 {
    let rise = to - from;
    if rise.is_finite() { from + rise * share } else { from * (1.0 - share) + to * share }
}
