//! The last seconds of all channels, frozen by a trigger, and streamed out in frames.
//!
//! Each tick gives one row, with one 16-bit word per channel: a signal's upper bits, at the resolution of its [`Channel`]'s range. The
//! ring keeps a stated number of rows from before the trigger and fills up with those after it; then it stops until it is armed again.
//!
//! ```text
//! Waiting ── trigger ──► Triggered ── ring full of what follows ──► Frozen ── arm ──► Waiting
//! ```

pub mod frame;
pub mod message;
mod outbox;

use embedded_io::Write;
use heapless::Deque;
use model_core::number::PerUnit;
use thiserror::Error;

use frame::{FrameError, FrameWriter};
use message::{ChannelHeader, Header, NONE, RowsWriter, end_written};

pub use outbox::Outbox;

/// Largest magnitude that a channel holds, per unit; a smaller range has a finer step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// ±1, in steps of 3.1e-5.
    One,
    /// ±2, in steps of 6.1e-5.
    Two,
    /// ±4, in steps of 1.2e-4.
    Four,
    /// ±8, in steps of 2.4e-4: the whole range of a signal.
    Eight,
}

/// One channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// As in a recording's CSV header.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// SI value that 1 stands for.
    pub base: f64,
    /// The range that it holds.
    pub range: Range,
}

impl Range {
    const fn shift(self) -> u32 {
        match self {
            Range::One => 13,
            Range::Two => 14,
            Range::Four => 15,
            Range::Eight => 16,
        }
    }
}

impl Channel {
    /// A signal's word: rounded to nearest, held at the ends of the range.
    #[must_use]
    pub fn word(&self, signal: PerUnit) -> i16 {
        let shift = self.range.shift();
        let rounded = (i64::from(signal.to_bits()) + (1 << (shift - 1))) >> shift;
        i16::try_from(rounded.clamp(i64::from(-i16::MAX), i64::from(i16::MAX))).unwrap_or(NONE)
    }

    /// SI value of one step of a word.
    #[must_use]
    pub fn step(&self) -> f64 {
        self.base * PerUnit::from_bits(1 << self.range.shift()).to_f64()
    }
}

/// Why such a recorder is not possible.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RecorderError {
    /// The row of the trigger itself must fit in addition to those before it.
    #[error("{before} rows before the trigger, expected fewer than the {room} there are")]
    Before {
        /// How many were requested.
        before: usize,
        /// How many rows there are.
        room: usize,
    },
    /// A row must fit a frame, and a channel's number a byte.
    #[error("{found} channels, expected 1 to 64")]
    Channels {
        /// How many there are.
        found: usize,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Waiting,
    Triggered { at: u32, left: usize },
    Frozen { trigger: u32 },
}

/// What the recorder is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Recording {
    /// It records and waits for a trigger.
    Waiting,
    /// It records what follows the trigger.
    Triggered,
    /// It has stopped and can be streamed out.
    Frozen,
}

/// A ring of `ROWS` rows of `CHANNELS` words.
#[derive(Clone, Debug)]
pub struct Recorder<const CHANNELS: usize, const ROWS: usize> {
    channels: [Channel; CHANNELS],
    rows: Deque<[i16; CHANNELS], ROWS>,
    /// Rows that are kept from before the trigger.
    before: usize,
    /// Tick of the next row.
    tick: u32,
    phase: Phase,
}

impl<const CHANNELS: usize, const ROWS: usize> Recorder<CHANNELS, ROWS> {
    /// An armed, empty recorder; in a full ring `before` rows lie before the trigger.
    ///
    /// # Errors
    /// No row is left for the trigger, or a row does not fit a frame.
    pub const fn new(channels: [Channel; CHANNELS], before: usize) -> Result<Self, RecorderError> {
        if before >= ROWS {
            return Err(RecorderError::Before { before, room: ROWS });
        }
        if CHANNELS == 0 || CHANNELS > 64 {
            return Err(RecorderError::Channels { found: CHANNELS });
        }
        Ok(Self { channels, rows: Deque::new(), before, tick: 0, phase: Phase::Waiting })
    }

    /// Takes the row of this tick, unless the recorder is frozen; `None` means no value.
    pub fn record(&mut self, signals: &[Option<PerUnit>; CHANNELS]) {
        let tick = self.tick;
        self.tick = tick.wrapping_add(1);
        let left = match self.phase {
            Phase::Frozen { .. } => return,
            Phase::Waiting => None,
            Phase::Triggered { left, .. } => Some(left),
        };
        let mut row = [NONE; CHANNELS];
        for ((word, channel), signal) in row.iter_mut().zip(&self.channels).zip(signals) {
            *word = signal.map_or(NONE, |signal| channel.word(signal));
        }
        if self.rows.is_full() {
            self.rows.pop_front();
        }
        // There is room now.
        let _ = self.rows.push_back(row);
        if let (Some(left), Phase::Triggered { at, .. }) = (left, self.phase) {
            self.phase = match left.checked_sub(1) {
                Some(0) | None => Phase::Frozen { trigger: at },
                Some(left) => Phase::Triggered { at, left },
            };
        }
    }

    /// Triggers: the next row is that of the trigger. Only the first trigger counts.
    pub fn trigger(&mut self) {
        if self.phase == Phase::Waiting {
            self.phase = Phase::Triggered { at: self.tick, left: ROWS - self.before };
        }
    }

    /// Deletes all rows and waits for the next trigger. The count of ticks continues.
    pub fn arm(&mut self) {
        self.rows.clear();
        self.phase = Phase::Waiting;
    }

    /// What the recorder is doing.
    #[must_use]
    pub fn recording(&self) -> Recording {
        match self.phase {
            Phase::Waiting => Recording::Waiting,
            Phase::Triggered { .. } => Recording::Triggered,
            Phase::Frozen { .. } => Recording::Frozen,
        }
    }
}

/// How much of a frozen recording has been streamed out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Next {
    Header,
    Channel(u8),
    Rows(usize),
    Done,
}

/// Streams a frozen recording out, one frame per call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Stream {
    next: Next,
}

/// Whether there is more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Progress {
    /// Nothing was frozen, or everything has been written.
    Done,
    /// A frame was written, and more will follow.
    More,
}

impl Default for Stream {
    fn default() -> Self {
        Self::new()
    }
}

impl Stream {
    /// From the start.
    #[must_use]
    pub const fn new() -> Self {
        Self { next: Next::Header }
    }

    /// Writes the next frame to `line`. A frame that the line refuses is written again by the next call.
    ///
    /// # Errors
    /// The line fails.
    pub fn write<W: Write, const CHANNELS: usize, const ROWS: usize>(
        &mut self,
        recorder: &Recorder<CHANNELS, ROWS>,
        machine: &str,
        tick_ns: u32,
        frames: &mut FrameWriter,
        line: &mut W,
    ) -> Result<Progress, FrameError<W::Error>> {
        let Phase::Frozen { trigger } = recorder.phase else { return Ok(Progress::Done) };
        // The rows end before the tick at which `record` found them complete.
        let rows = recorder.rows.len();
        let first = recorder.first_tick(trigger);
        #[expect(clippy::cast_possible_truncation, reason = "rows are in memory, channels at most 64")]
        let (count, channels) = (rows as u32, CHANNELS as u8);
        let ((kind, payload), next) = match self.next {
            Next::Done => return Ok(Progress::Done),
            Next::Header => {
                let header = Header { channels, tick_ns, first, rows: count, trigger, machine };
                (header.written(), Next::Channel(0))
            }
            Next::Channel(number) => match recorder.channels.get(usize::from(number)) {
                Some(channel) => (channel.header(number).written(), Next::Channel(number + 1)),
                None => recorder.some_rows(0, first),
            },
            Next::Rows(from) if from < rows => recorder.some_rows(from, first),
            Next::Rows(_) => (end_written(count), Next::Done),
        };
        frames.write(line, kind, &payload)?;
        self.next = next;
        Ok(if next == Next::Done { Progress::Done } else { Progress::More })
    }
}

impl Channel {
    fn header(&self, number: u8) -> ChannelHeader<'_> {
        ChannelHeader { number, step: self.step(), name: self.name, unit: self.unit }
    }
}

impl<const CHANNELS: usize, const ROWS: usize> Recorder<CHANNELS, ROWS> {
    /// Tick of the oldest row: the trigger's tick, less the rows that were kept from before it.
    fn first_tick(&self, trigger: u32) -> u32 {
        let after = ROWS - self.before;
        #[expect(clippy::cast_possible_truncation, reason = "rows are in memory")]
        let before = self.rows.len().saturating_sub(after) as u32;
        trigger.wrapping_sub(before)
    }

    /// A frame of rows that begins with a given one, and what comes next.
    fn some_rows(&self, from: usize, first: u32) -> ((u8, crate::recorder::message::Payload), Next) {
        #[expect(clippy::cast_possible_truncation, reason = "rows are in memory")]
        let mut writer = RowsWriter::new(first.wrapping_add(from as u32));
        let fitting = self.rows.iter().skip(from).take_while(|row| writer.push(row.as_slice())).count();
        (writer.written(), Next::Rows(from + fitting))
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use model_core::number::Number;

    use super::*;
    use crate::recorder::frame::FrameReader;
    use crate::recorder::message::Message;

    const CHANNELS: [Channel; 2] = [
        Channel { name: "position", unit: "m", base: 0.3, range: Range::One },
        Channel { name: "pressure_a", unit: "Pa", base: 7e6, range: Range::Eight },
    ];

    fn signals(tick: u32) -> [Option<PerUnit>; 2] {
        let position = PerUnit::saturated(1e-4 * f64::from(tick));
        [Some(position), (!tick.is_multiple_of(10)).then_some(PerUnit::saturated(-3.0))]
    }

    /// A thousand ticks, the trigger at 600: 300 rows of which 200 lie before it.
    fn frozen() -> Recorder<2, 300> {
        let mut recorder = Recorder::new(CHANNELS, 200).unwrap();
        for tick in 0..1000 {
            if tick == 600 || tick == 650 {
                recorder.trigger();
            }
            recorder.record(&signals(tick));
        }
        recorder
    }

    fn streamed(recorder: &Recorder<2, 300>) -> Vec<u8> {
        let (mut line, mut frames, mut stream) = (Vec::new(), FrameWriter::default(), Stream::new());
        while stream.write(recorder, "press", 1_000_000, &mut frames, &mut line).unwrap() == Progress::More {}
        line
    }

    #[test]
    fn the_ring_holds_what_was_asked_for_before_and_after_the_trigger_and_stands_still() {
        let recorder = frozen();
        assert_eq!(recorder.recording(), Recording::Frozen);
        let oldest = recorder.rows.front().unwrap();
        assert_eq!(oldest[0], CHANNELS[0].word(signals(400)[0].unwrap()));
        assert_eq!(recorder.rows.back().unwrap()[0], CHANNELS[0].word(signals(699)[0].unwrap()));
    }

    #[test]
    fn an_early_trigger_has_fewer_rows_before_it() {
        let mut recorder: Recorder<2, 300> = Recorder::new(CHANNELS, 200).unwrap();
        recorder.record(&signals(0));
        recorder.trigger();
        assert_eq!(recorder.recording(), Recording::Triggered);
        (1..101).for_each(|tick| recorder.record(&signals(tick)));
        assert_eq!((recorder.recording(), recorder.rows.len()), (Recording::Frozen, 101));
        assert_eq!(recorder.first_tick(1), 0);
        recorder.arm();
        assert_eq!((recorder.recording(), recorder.rows.len()), (Recording::Waiting, 0));
    }

    #[test]
    fn the_stream_carries_every_word_its_tick_and_its_scale() {
        let (mut reader, mut rows, mut steps) = (FrameReader::new(), Vec::new(), Vec::new());
        for byte in streamed(&frozen()) {
            let Some(frame) = reader.take(byte) else { continue };
            match Message::of(&frame).unwrap() {
                Message::Header(header) => {
                    assert_eq!((header.machine, header.tick_ns, header.rows), ("press", 1_000_000, 300));
                    assert_eq!((header.first, header.trigger, header.channels), (400, 600, 2));
                }
                Message::Channel(channel) => {
                    assert_eq!(channel.name, CHANNELS[usize::from(channel.number)].name);
                    steps.push(channel.step);
                }
                Message::Rows(found) => {
                    assert_eq!(found.first as usize, 400 + rows.len());
                    let words: Vec<i16> = found.words().collect();
                    rows.extend(words.chunks(2).map(|row| [row[0], row[1]]));
                }
                Message::End { rows } => assert_eq!(rows, 300),
            }
        }
        assert_eq!(rows.len(), 300);
        for (tick, [position, pressure]) in (400_u32..).zip(rows) {
            let position_m = f64::from(position) * steps[0];
            assert!((position_m - 0.3e-4 * f64::from(tick)).abs() <= 0.51 * steps[0], "{tick}: {position_m}");
            if tick.is_multiple_of(10) {
                assert_eq!(pressure, NONE);
            } else {
                assert!((f64::from(pressure) * steps[1] + 2.1e7).abs() <= 0.51 * steps[1]);
            }
        }
    }

    #[test]
    fn a_word_is_held_at_the_ends_of_its_range() {
        assert_eq!(CHANNELS[0].word(PerUnit::saturated(3.0)), i16::MAX);
        assert_eq!(CHANNELS[0].word(PerUnit::saturated(-3.0)), -i16::MAX);
        assert_eq!(CHANNELS[1].word(PerUnit::saturated(-8.0)), -i16::MAX);
    }

    #[test]
    fn no_recorder_without_room_for_its_trigger_or_without_channels() {
        let refused = Recorder::<2, 300>::new(CHANNELS, 300).err();
        assert_eq!(refused, Some(RecorderError::Before { before: 300, room: 300 }));
        assert_eq!(Recorder::<0, 300>::new([], 0).err(), Some(RecorderError::Channels { found: 0 }));
    }
}
