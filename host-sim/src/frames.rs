//! Recordings that the firmware has streamed out, as recordings of the tool.
//!
//! The frames are read by the code that wrote them (`firmware::recorder::frame`, `firmware::recorder::message`). What the line lost or
//! damaged is left out and reported; nothing that is damaged becomes a value.
//!
//! A recording is open from its header to its end, or to a gap in the numbers of the frames: behind a gap, rows may be those of another recording
//! whose header was lost, with other ticks and other channels. Such rows are counted and belong to none.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

use firmware::recorder::frame::{FrameReader, Losses};
use firmware::recorder::message::{Message, NONE};
use recording::formats::sheet::quoted;

/// One recording as it was streamed out.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// Name of the machine.
    pub machine: String,
    /// Length of a tick, s.
    pub tick_s: f64,
    /// Rows that were streamed out.
    pub rows_sent: u32,
    /// Row at which the recording was triggered.
    pub trigger: u32,
    /// How many channels a row has.
    width: usize,
    /// Header of each channel by its number, `name [unit]`, and the SI value of one step; no entry where the channel's frame was lost.
    channels: BTreeMap<usize, (String, f64)>,
    /// Tick of the first row.
    first: u32,
    /// Words of each row that arrived, by the row's place.
    rows: BTreeMap<u32, Vec<i16>>,
}

/// Everything that a stream held.
#[derive(Clone, Debug, PartialEq)]
pub struct Stream {
    /// Its recordings, in their order.
    pub recordings: Vec<Imported>,
    /// What was wrong on the line.
    pub losses: Losses,
    /// Rows of no recording: behind a gap, behind an end, without a header, or of a place that had its row.
    pub rows_of_none: usize,
}

/// Why a recording cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImportError {
    /// There is no header in the stream.
    #[error(
        "no recording in {bytes} bytes ({refused} damaged or foreign frames); expected what the firmware's recorder streams out"
    )]
    Nothing {
        /// Length of the stream.
        bytes: usize,
        /// Frames that were not valid.
        refused: u32,
    },
    /// Several recordings, or fewer than asked for.
    #[error("{found} recordings in the stream; expected --which 1 to {found}")]
    Several {
        /// How many.
        found: usize,
    },
    /// The frame that says what a channel is was lost.
    #[error(
        "the frame of channel {channel} was lost: what its words mean is not known; expected the stream to be read once more"
    )]
    Channel {
        /// Its number.
        channel: usize,
    },
    /// The words of a channel have no valid SI value.
    #[error("a step of channel {channel} is {step}; expected the SI value of one step")]
    Step {
        /// Its number.
        channel: usize,
        /// The step in its frame.
        step: f64,
    },
    /// There is more than any recorder can have streamed out.
    #[error("more than {MAX_CAPTURE_BYTES} bytes; expected a capture of what the firmware's recorder streams out")]
    TooLarge,
}

/// Largest capture, in bytes: an hour and a half on a line of 115200 baud. Its rows may take fifty times as much memory.
pub const MAX_CAPTURE_BYTES: u64 = 1 << 26;

/// The recordings of a stream.
pub fn stream(bytes: &[u8]) -> Result<Stream, ImportError> {
    let mut reader = FrameReader::new();
    let mut recordings: Vec<Imported> = Vec::new();
    let (mut is_open, mut next, mut rows_of_none) = (false, None, 0);
    // A reader that starts late begins within a frame, which then ends here.
    for &byte in bytes.iter().chain(&[0]) {
        let Some(frame) = reader.take(byte) else { continue };
        // The numbers go on from one recording to the next, and begin again when the board does.
        is_open &= next.replace(frame.number.wrapping_add(1)) == Some(frame.number);
        match Message::of(&frame) {
            Ok(Message::Header(header)) => {
                is_open = true;
                recordings.push(Imported {
                    machine: header.machine.to_owned(),
                    tick_s: f64::from(header.tick_ns) * 1e-9,
                    rows_sent: header.rows,
                    trigger: header.trigger.wrapping_sub(header.first),
                    width: usize::from(header.channels),
                    channels: BTreeMap::new(),
                    first: header.first,
                    rows: BTreeMap::new(),
                });
            }
            Ok(Message::Channel(channel)) => {
                let number = usize::from(channel.number);
                if let Some(last) = recordings.last_mut().filter(|last| is_open && number < last.width) {
                    last.channels
                        .entry(number)
                        .or_insert((format!("{} [{}]", channel.name, channel.unit), channel.step));
                }
            }
            Ok(Message::Rows(rows)) => {
                let words: Vec<i16> = rows.words().collect();
                let Some(last) = recordings.last_mut() else {
                    rows_of_none += 1;
                    continue;
                };
                let sent = words.len() / last.width.max(1);
                let taken = if is_open { last.take(rows.first, &words) } else { 0 };
                is_open &= taken == sent;
                rows_of_none += sent - taken;
            }
            // The header says how many rows there are.
            Ok(Message::End { .. }) => is_open = false,
            Err(_) => {}
        }
    }
    let losses = reader.losses();
    if recordings.is_empty() {
        return Err(ImportError::Nothing { bytes: bytes.len(), refused: losses.refused });
    }
    Ok(Stream { recordings, losses, rows_of_none })
}

impl Stream {
    /// The only recording, or the one with the number that is given, counted from 1.
    pub fn chosen(self, which: Option<usize>) -> Result<Imported, ImportError> {
        let found = self.recordings.len();
        let index = match which {
            Some(number) => number.wrapping_sub(1),
            None if found == 1 => 0,
            None => usize::MAX,
        };
        self.recordings.into_iter().nth(index).ok_or(ImportError::Several { found })
    }
}

impl Imported {
    /// Takes rows that follow those it has; the number of those taken.
    fn take(&mut self, first: u32, words: &[i16]) -> usize {
        let (place, before) = (first.wrapping_sub(self.first), self.rows.len());
        if place as usize == before {
            let rows = words.chunks_exact(self.width.max(1)).map(<[i16]>::to_vec);
            self.rows.extend((place..self.rows_sent).zip(rows));
        }
        self.rows.len() - before
    }

    /// Rows that were lost on the line.
    #[must_use]
    pub fn rows_lost(&self) -> usize {
        (self.rows_sent as usize).saturating_sub(self.rows.len())
    }

    /// As a recording file: CSV in SI units, an empty cell where there was no value.
    pub fn csv(&self) -> Result<String, ImportError> {
        let mut known = Vec::new();
        for channel in 0..self.width {
            let of = self.channels.get(&channel).ok_or(ImportError::Channel { channel })?;
            if !(of.1 * f64::from(i16::MAX)).is_finite() {
                return Err(ImportError::Step { channel, step: of.1 });
            }
            known.push(of);
        }
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write_csv(&known, &mut text);
        Ok(text)
    }

    fn write_csv(&self, channels: &[&(String, f64)], out: &mut String) -> fmt::Result {
        write!(out, "time [s]")?;
        for (header, _) in channels {
            write!(out, ",{}", quoted(header))?;
        }
        writeln!(out)?;
        for (place, row) in &self.rows {
            // To the nanosecond: 0.003 and not 0.0030000000000000001.
            write!(out, "{}", (f64::from(*place) * self.tick_s * 1e9).round() / 1e9)?;
            for (word, (_, step)) in row.iter().zip(channels) {
                match *word {
                    NONE => write!(out, ",")?,
                    word => write!(out, ",{}", f64::from(word) * step)?,
                }
            }
            writeln!(out)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use firmware::recorder::frame::FrameWriter;
    use firmware::recorder::message::{ChannelHeader, Header, RowsWriter, end_written};
    use firmware::recorder::{Channel, Progress, Range, Recorder, Stream as Out};
    use model_core::number::{Number, PerUnit};

    use super::*;

    /// Forty ticks of two channels, of which the second has no value at the tenth row.
    fn streamed(frames: &mut FrameWriter) -> Vec<u8> {
        let channel = |name, unit, base| Channel { name, unit, base, range: Range::One };
        let mut recorder: Recorder<2, 40> =
            Recorder::new([channel("command", "V", 10.0), channel("position", "m", 0.3)], 10).unwrap();
        for tick in 0..60 {
            if tick == 20 {
                recorder.trigger();
            }
            let ramp = PerUnit::saturated(f64::from(tick) / 100.0);
            recorder.record(&[Some(ramp), (tick != 19).then_some(ramp.halved())]);
        }
        let (mut bytes, mut out) = (Vec::new(), Out::new());
        while out.write(&recorder, "press", 1_000_000, frames, &mut bytes).unwrap() == Progress::More {}
        bytes
    }

    #[test]
    fn what_the_recorder_streams_out_becomes_a_recording() {
        let stream = stream(&streamed(&mut FrameWriter::default())).unwrap();
        assert_eq!(stream.losses, Losses::default());
        let recording = stream.chosen(None).unwrap();
        assert_eq!((recording.machine.as_str(), recording.trigger, recording.rows_lost()), ("press", 10, 0));
        let csv = recording.csv().unwrap();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!((lines[0], lines.len()), ("time [s],command [V],position [m]", 41));
        let cells: Vec<f64> = lines[4].split(',').map(|cell| cell.parse().unwrap()).collect();
        // The first row is that of tick 10.
        assert!((cells[0] - 0.003).abs() < 1e-12 && (cells[1] - 1.3).abs() < 2e-4 && (cells[2] - 0.0195).abs() < 6e-6);
        assert!(lines[10].starts_with("0.009,") && lines[10].ends_with(','), "{}", lines[10]);
    }

    #[test]
    fn what_is_damaged_is_left_out_and_said() {
        let mut bytes = streamed(&mut FrameWriter::default());
        let whole = stream(&bytes).unwrap().chosen(None).unwrap();
        // Within the frame of the rows, which is the last but one and the longest.
        let middle = bytes.len() - 60;
        bytes[middle] ^= 0x10;
        let damaged = stream(&bytes).unwrap();
        assert_eq!((damaged.losses.refused, damaged.losses.missing), (1, 1));
        let damaged = damaged.chosen(None).unwrap();
        assert!(damaged.rows_lost() > 0 && damaged.rows.iter().all(|(place, row)| whole.rows[place] == *row));
        let late = stream(&bytes[9..]).unwrap_err();
        assert!(matches!(late, ImportError::Nothing { .. }), "without its header there is no recording: {late:?}");
    }

    /// The frames of a stream, each with its zeros.
    fn frames(bytes: &[u8]) -> Vec<Vec<u8>> {
        let stuffed = bytes.split(|byte| *byte == 0).filter(|frame| !frame.is_empty());
        stuffed.map(|frame| [&[0], frame, &[0]].concat()).collect()
    }

    /// Another forty ticks, under other names, of a board that has started anew or goes on.
    fn of_another(frames: &mut FrameWriter, first: u32) -> Vec<u8> {
        let mut line = Vec::new();
        let header = Header { channels: 2, tick_ns: 1_000_000, first, rows: 40, trigger: first, machine: "other" };
        let channel = |number| ChannelHeader { number, step: -1.0, name: "force", unit: "N" };
        let mut rows = RowsWriter::new(first);
        for row in 0..40 {
            assert!(rows.push(&[row, row]));
        }
        for (kind, payload) in
            [header.written(), channel(0).written(), channel(1).written(), rows.written(), end_written(40)]
        {
            frames.write(&mut line, kind, &payload).unwrap();
        }
        line
    }

    #[test]
    fn rows_behind_a_lost_header_are_not_those_of_the_recording_before() {
        for restarts in [true, false] {
            for first in [10, 50, 1000] {
                let mut writer = FrameWriter::default();
                let own = streamed(&mut writer);
                let alone = stream(&own).unwrap().chosen(None).unwrap();
                if restarts {
                    writer = FrameWriter::default();
                }
                let other = frames(&of_another(&mut writer, first));
                // The header is lost, or it and what follows it; the end of the recording before too.
                for lost in 1..=3 {
                    for own in [own.clone(), frames(&own)[..frames(&own).len() - 1].concat()] {
                        let both = stream(&[own, other[lost..].concat()].concat()).unwrap();
                        assert_eq!(both.rows_of_none, 40, "{restarts} {first} {lost}");
                        assert_eq!(both.chosen(None).unwrap(), alone);
                    }
                }
            }
        }
    }

    #[test]
    fn a_row_is_written_once_and_as_it_came_first() {
        let bytes = streamed(&mut FrameWriter::default());
        let whole = stream(&bytes).unwrap().chosen(None).unwrap();
        let all = frames(&bytes);
        let mut again = all.clone();
        again.insert(all.len() - 1, all[all.len() - 2].clone());
        let repeated = stream(&again.concat()).unwrap();
        assert!(repeated.rows_of_none > 0);
        assert_eq!(repeated.chosen(None).unwrap(), whole);
    }

    #[test]
    fn of_several_recordings_one_is_chosen() {
        let mut frames = FrameWriter::default();
        let bytes = [streamed(&mut frames), vec![0x55; 20], streamed(&mut frames)].concat();
        let both = stream(&bytes).unwrap();
        assert_eq!(both.clone().chosen(None).unwrap_err(), ImportError::Several { found: 2 });
        assert_eq!(both.clone().chosen(Some(3)).unwrap_err(), ImportError::Several { found: 2 });
        assert_eq!(both.chosen(Some(2)).unwrap().rows.len(), 40);
    }

    #[test]
    fn a_name_of_any_characters_stays_one_column_and_a_step_is_a_number() {
        let streamed = |step: f64| {
            let (mut line, mut frames) = (Vec::new(), FrameWriter::default());
            let header = Header { channels: 1, tick_ns: 1_000_000, first: 0, rows: 2, trigger: 0, machine: "m" };
            let channel = ChannelHeader { number: 0, step, name: "a,\"\n", unit: "1" };
            let mut rows = RowsWriter::new(0);
            assert!(rows.push(&[1]) && rows.push(&[2]));
            for (kind, payload) in [header.written(), channel.written(), rows.written()] {
                frames.write(&mut line, kind, &payload).unwrap();
            }
            stream(&line).unwrap().chosen(None).unwrap().csv()
        };
        assert_eq!(streamed(0.5).unwrap(), "time [s],\"a,\"\"  [1]\"\n0,0.5\n0.001,1\n");
        assert!(matches!(streamed(f64::MAX), Err(ImportError::Step { channel: 0, .. })));
        assert!(matches!(streamed(f64::NAN), Err(ImportError::Step { .. })));
    }

    #[test]
    fn a_channel_whose_meaning_was_lost_is_not_guessed() {
        let bytes = streamed(&mut FrameWriter::default());
        // Frames end with a zero each, and the stream begins with one: header, two channels.
        let zeros: Vec<usize> = bytes.iter().enumerate().filter(|(_, byte)| **byte == 0).map(|(at, _)| at).collect();
        let without = [&bytes[..zeros[2]], &bytes[zeros[3]..]].concat();
        let recording = stream(&without).unwrap().chosen(None).unwrap();
        assert_eq!(recording.csv().unwrap_err(), ImportError::Channel { channel: 0 });
    }
}
