//! What the frames of a recording hold: the controller writes them and the host reads them.
//!
//! | kind | payload, little-endian |
//! |---|---|
//! | 1 header | version u8, channels u8, tick in ns u32, tick of the first row u32, rows u32, tick of the trigger u32, machine's name |
//! | 2 channel | its number u8, SI value of one step f64, length of its name u8, name, unit |
//! | 3 rows | tick of the first u32, then row by row one i16 a channel; [`NONE`] is no value |
//! | 4 end | rows written u32 |
//!
//! SI value = word · step, so the host needs no other file. Names and units are those of a recording's CSV header.

use heapless::Vec;
use thiserror::Error;

use super::frame::{Frame, PAYLOAD};

/// Version of this layout.
pub const VERSION: u8 = 1;
/// A word that means that there was no value.
pub const NONE: i16 = i16::MIN;
/// Longest name of a machine, bytes.
pub const MACHINE_NAME: usize = 64;
/// Longest name or unit of a channel, bytes.
pub const CHANNEL_NAME: usize = 32;

/// A payload before it is sent.
pub type Payload = Vec<u8, PAYLOAD>;

/// One message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Message<'a> {
    /// What follows.
    Header(Header<'a>),
    /// One channel of the recording.
    Channel(ChannelHeader<'a>),
    /// Some rows.
    Rows(Rows<'a>),
    /// The end.
    End {
        /// How many rows were written.
        rows: u32,
    },
}

/// What follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header<'a> {
    /// How many words a row has.
    pub channels: u8,
    /// Length of a tick, ns.
    pub tick_ns: u32,
    /// Tick of the first row.
    pub first: u32,
    /// How many rows follow.
    pub rows: u32,
    /// Tick at which the recording was triggered.
    pub trigger: u32,
    /// The machine's name.
    pub machine: &'a str,
}

/// One channel: what its words mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelHeader<'a> {
    /// Its place in a row.
    pub number: u8,
    /// SI value of one step.
    pub step: f64,
    /// Its name.
    pub name: &'a str,
    /// Its unit.
    pub unit: &'a str,
}

/// Rows of successive ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rows<'a> {
    /// Tick of the first.
    pub first: u32,
    bytes: &'a [u8],
}

impl Rows<'_> {
    /// All words, row by row.
    pub fn words(&self) -> impl Iterator<Item = i16> + '_ {
        self.bytes.as_chunks().0.iter().map(|&word| i16::from_le_bytes(word))
    }
}

/// Why a frame is not a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MessageError {
    /// A frame of another kind.
    #[error("frame of kind {found}, expected 1 to 4")]
    Kind {
        /// Its kind.
        found: u8,
    },
    /// A layout that this source does not know.
    #[error("layout {found}, expected {VERSION}")]
    Version {
        /// Its version.
        found: u8,
    },
    /// The payload ends too early, or within a word.
    #[error("a payload of {found} bytes is cut short")]
    Length {
        /// Its length.
        found: usize,
    },
    /// A name is not UTF-8.
    #[error("a name is not UTF-8")]
    Name,
}

const HEADER: u8 = 1;
const CHANNEL: u8 = 2;
const ROWS: u8 = 3;
const END: u8 = 4;

impl Header<'_> {
    /// Kind and payload; a name that is too long is cut.
    #[must_use]
    pub fn written(&self) -> (u8, Payload) {
        let words = [self.tick_ns, self.first, self.rows, self.trigger].map(u32::to_le_bytes);
        let name = cut(self.machine, MACHINE_NAME).as_bytes();
        (HEADER, payload(&[&[VERSION, self.channels], words.as_flattened(), name]))
    }
}

impl ChannelHeader<'_> {
    /// Kind and payload; a name or unit that is too long is cut.
    #[must_use]
    pub fn written(&self) -> (u8, Payload) {
        let (name, unit) = (cut(self.name, CHANNEL_NAME), cut(self.unit, CHANNEL_NAME));
        #[expect(clippy::cast_possible_truncation, reason = "at most CHANNEL_NAME")]
        let length = name.len() as u8;
        (CHANNEL, payload(&[&[self.number], &self.step.to_le_bytes(), &[length], name.as_bytes(), unit.as_bytes()]))
    }
}

/// Rows before they are sent: as many as fit in a frame.
#[derive(Clone, Debug)]
pub struct RowsWriter {
    payload: Payload,
}

impl RowsWriter {
    /// No rows yet; the first will be that of tick `first`.
    #[must_use]
    pub fn new(first: u32) -> Self {
        Self { payload: payload(&[&first.to_le_bytes()]) }
    }

    /// Adds a row if it still fits, and returns whether it did.
    pub fn push(&mut self, row: &[i16]) -> bool {
        let fits = self.payload.len() + 2 * row.len() <= PAYLOAD;
        if fits {
            for word in row {
                // Fits, as checked above.
                let _ = self.payload.extend_from_slice(&word.to_le_bytes());
            }
        }
        fits
    }

    /// Kind and payload.
    #[must_use]
    pub fn written(self) -> (u8, Payload) {
        (ROWS, self.payload)
    }
}

/// Kind and payload of the end.
#[must_use]
pub fn end_written(rows: u32) -> (u8, Payload) {
    (END, payload(&[&rows.to_le_bytes()]))
}

impl<'a> Message<'a> {
    /// The message that a frame holds.
    ///
    /// # Errors
    /// The frame is not a message of this layout.
    pub fn of(frame: &'a Frame) -> Result<Self, MessageError> {
        let mut rest = Remaining { bytes: &frame.payload, length: frame.payload.len() };
        match frame.kind {
            HEADER => Ok(Self::Header(rest.header()?)),
            CHANNEL => Ok(Self::Channel(rest.channel()?)),
            ROWS => {
                let first = rest.word()?;
                if rest.bytes.len().is_multiple_of(2) {
                    Ok(Self::Rows(Rows { first, bytes: rest.bytes }))
                } else {
                    Err(rest.short())
                }
            }
            END => Ok(Self::End { rows: rest.word()? }),
            found => Err(MessageError::Kind { found }),
        }
    }
}

/// The part of a payload that is not read yet.
struct Remaining<'a> {
    bytes: &'a [u8],
    length: usize,
}

impl<'a> Remaining<'a> {
    fn short(&self) -> MessageError {
        MessageError::Length { found: self.length }
    }

    fn next<const COUNT: usize>(&mut self) -> Result<[u8; COUNT], MessageError> {
        let (next, rest) = self.bytes.split_first_chunk().ok_or_else(|| self.short())?;
        self.bytes = rest;
        Ok(*next)
    }

    fn byte(&mut self) -> Result<u8, MessageError> {
        self.next().map(|[byte]| byte)
    }

    fn word(&mut self) -> Result<u32, MessageError> {
        self.next().map(u32::from_le_bytes)
    }

    fn text(&mut self, length: usize) -> Result<&'a str, MessageError> {
        let (text, rest) = self.bytes.split_at_checked(length).ok_or_else(|| self.short())?;
        self.bytes = rest;
        core::str::from_utf8(text).map_err(|_| MessageError::Name)
    }

    fn header(&mut self) -> Result<Header<'a>, MessageError> {
        let found = self.byte()?;
        if found != VERSION {
            return Err(MessageError::Version { found });
        }
        Ok(Header {
            channels: self.byte()?,
            tick_ns: self.word()?,
            first: self.word()?,
            rows: self.word()?,
            trigger: self.word()?,
            machine: self.text(self.bytes.len())?,
        })
    }

    fn channel(&mut self) -> Result<ChannelHeader<'a>, MessageError> {
        let number = self.byte()?;
        let step = f64::from_le_bytes(self.next()?);
        let length = self.byte()?;
        Ok(ChannelHeader { number, step, name: self.text(length.into())?, unit: self.text(self.bytes.len())? })
    }
}

/// Joins the parts; all messages are made to fit.
fn payload(parts: &[&[u8]]) -> Payload {
    let mut payload = Payload::new();
    for part in parts {
        let room = PAYLOAD - payload.len();
        let _ = payload.extend_from_slice(part.get(..room).unwrap_or(part));
    }
    payload
}

/// The longest beginning of a text that has at most so many bytes and ends after a whole character.
fn cut(text: &str, most: usize) -> &str {
    text.get(..text.floor_char_boundary(most)).unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn frame((kind, payload): (u8, Payload)) -> Frame {
        Frame { kind, number: 0, payload }
    }

    #[test]
    fn every_message_is_read_as_it_was_written() {
        let header =
            Header { channels: 9, tick_ns: 1_000_000, first: 7, rows: 2000, trigger: 1500, machine: "press-63-40" };
        assert_eq!(Message::of(&frame(header.written())), Ok(Message::Header(header)));
        let channel = ChannelHeader { number: 3, step: 213.6, name: "pressure_a", unit: "Pa" };
        assert_eq!(Message::of(&frame(channel.written())), Ok(Message::Channel(channel)));
        let mut rows = RowsWriter::new(u32::MAX);
        while rows.push(&[1, NONE, i16::MAX]) {}
        let rows = frame(rows.written());
        let Ok(Message::Rows(rows)) = Message::of(&rows) else { panic!("{rows:?}") };
        assert_eq!((rows.first, rows.words().count()), (u32::MAX, 93));
        assert!(rows.words().take(6).eq([1, NONE, i16::MAX, 1, NONE, i16::MAX]));
        assert_eq!(Message::of(&frame(end_written(2000))), Ok(Message::End { rows: 2000 }));
    }

    #[test]
    fn what_is_no_message_says_why() {
        let read = |kind, payload: &[u8]| {
            let frame = frame((kind, Payload::from_slice(payload).unwrap()));
            Message::of(&frame).map(|_| ()).unwrap_err()
        };
        assert_eq!(read(9, &[]), MessageError::Kind { found: 9 });
        assert_eq!(read(HEADER, &[2, 1]), MessageError::Version { found: 2 });
        assert_eq!(read(HEADER, &[1, 1, 0]), MessageError::Length { found: 3 });
        assert_eq!(read(ROWS, &[0; 5]), MessageError::Length { found: 5 });
        assert_eq!(read(CHANNEL, &[0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0xff]), MessageError::Name);
    }

    proptest! {
        #[test]
        fn no_payload_panics(kind in 0_u8..6, bytes in prop::collection::vec(any::<u8>(), 0..=PAYLOAD)) {
            let _ = Message::of(&frame((kind, Payload::from_slice(&bytes).unwrap())));
        }

        #[test]
        fn a_name_of_any_length_makes_a_message(machine in "\\PC{0,80}", name in "\\PC{0,40}") {
            let header = Header { channels: 1, tick_ns: 1, first: 0, rows: 0, trigger: 0, machine: &machine };
            let read = frame(header.written());
            let read = Message::of(&read);
            prop_assert!(matches!(read, Ok(Message::Header(found)) if machine.starts_with(found.machine)), "{read:?}");
            let channel = ChannelHeader { number: 0, step: 1.0, name: &name, unit: "m" };
            let read = frame(channel.written());
            let read = Message::of(&read);
            prop_assert!(matches!(read, Ok(Message::Channel(found)) if found.unit == "m"), "{read:?}");
        }
    }
}
