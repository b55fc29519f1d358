//! Frames on a line: COBS between zeros, with a length-independent CRC and a running number.
//!
//! ```text
//! 00  COBS( kind u8 | number u16 | payload … | CRC-32 )  00          all words little-endian
//! ```
//!
//! A zero occurs only between frames, so a reader finds the next frame whatever it lost before (S. Cheshire, M. Baker:
//! *Consistent Overhead Byte Stuffing*, IEEE/ACM Transactions on Networking 7, 1999). CRC-32 (ISO-HDLC) finds any two wrong bits and any
//! burst of 32 in a frame of this size, and misses one damaged frame in 4·10⁹. The number shows how many frames are missing.
//!
//! The host reads frames with this same source file.

use crc::{CRC_32_ISO_HDLC, Crc, Table};
use embedded_io::Write;
use heapless::Vec;
use thiserror::Error;

/// Largest payload, bytes.
pub const PAYLOAD: usize = 192;
const HEAD: usize = 3;
const CHECK: usize = 4;
/// Largest frame before it is stuffed.
const PLAIN: usize = HEAD + PAYLOAD + CHECK;
/// Largest frame after stuffing: one byte more in each 254.
const STUFFED: usize = PLAIN + PLAIN.div_ceil(254) + 1;

/// Largest frame on a line, bytes.
pub const LARGEST: usize = STUFFED + 2;

/// A small table: 64 bytes of flash instead of 1024, but four steps per byte instead of one.
const CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// A frame as it was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// What it holds; the user of this module defines the kinds.
    pub kind: u8,
    /// Its number, one more than that of the frame before.
    pub number: u16,
    /// What it carries.
    pub payload: Vec<u8, PAYLOAD>,
}

/// Why a frame was not written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FrameError<E> {
    /// The payload is too long.
    #[error("a payload of {found} bytes, at most {PAYLOAD} fit")]
    TooLong {
        /// Its length.
        found: usize,
    },
    /// The line did not accept it.
    #[error("the line failed")]
    Line(E),
}

/// Writes frames and numbers them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameWriter {
    number: u16,
}

impl FrameWriter {
    /// Writes one frame to `line`.
    ///
    /// # Errors
    /// The payload is longer than [`PAYLOAD`], or the line fails; the number is used up in the latter case only.
    pub fn write<W: Write>(&mut self, line: &mut W, kind: u8, payload: &[u8]) -> Result<(), FrameError<W::Error>> {
        let too_long = FrameError::TooLong { found: payload.len() };
        let plain = assembled(kind, self.number, payload).ok_or(too_long)?;
        let mut stuffed = [0; LARGEST];
        // Zero before and after: the first one ends whatever a newly opened line shows before the frame.
        let length = cobs::try_encode(&plain, stuffed.get_mut(1..=STUFFED).unwrap_or_default())
            .map_err(|_| FrameError::TooLong { found: payload.len() })?;
        self.number = self.number.wrapping_add(1);
        line.write_all(stuffed.get(..length + 2).unwrap_or_default()).map_err(FrameError::Line)
    }
}

fn assembled(kind: u8, number: u16, payload: &[u8]) -> Option<Vec<u8, PLAIN>> {
    if payload.len() > PAYLOAD {
        return None;
    }
    let mut plain: Vec<u8, PLAIN> = Vec::new();
    plain.push(kind).ok()?;
    plain.extend_from_slice(&number.to_le_bytes()).ok()?;
    plain.extend_from_slice(payload).ok()?;
    plain.extend_from_slice(&CRC.checksum(&plain).to_le_bytes()).ok()?;
    Some(plain)
}

/// Errors on the line so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Frames that are missing according to their numbers. A gap of more than half of all numbers is taken for a restart of the writer.
    pub missing: u32,
    /// Pieces between zeros that are no valid frame: damaged, foreign, or too long.
    pub refused: u32,
}

/// Reads frames from bytes that may be lost, damaged or foreign.
#[derive(Clone, Debug)]
pub struct FrameReader {
    stuffed: Vec<u8, STUFFED>,
    too_long: bool,
    next: Option<u16>,
    losses: Losses,
}

impl Default for FrameReader {
    fn default() -> Self {
        Self::new()
    }
}

impl FrameReader {
    /// A reader that has seen nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { stuffed: Vec::new(), too_long: false, next: None, losses: Losses { missing: 0, refused: 0 } }
    }

    /// Errors so far.
    #[must_use]
    pub fn losses(&self) -> Losses {
        self.losses
    }

    /// Takes one byte; returns the frame that ends with it, if one does.
    pub fn take(&mut self, byte: u8) -> Option<Frame> {
        if byte != 0 {
            self.too_long |= self.stuffed.push(byte).is_err();
            return None;
        }
        let found = if self.too_long { None } else { self.unstuffed() };
        if found.is_none() && !self.stuffed.is_empty() {
            self.losses.refused = self.losses.refused.saturating_add(1);
        }
        self.stuffed.clear();
        self.too_long = false;
        let frame = found?;
        let gap = self.next.map_or(0, |next| frame.number.wrapping_sub(next));
        if gap <= u16::MAX / 2 {
            self.losses.missing = self.losses.missing.saturating_add(u32::from(gap));
        }
        self.next = Some(frame.number.wrapping_add(1));
        Some(frame)
    }

    fn unstuffed(&self) -> Option<Frame> {
        let mut plain = [0; STUFFED];
        let length = cobs::decode(&self.stuffed, &mut plain).ok()?.frame_size();
        let (body, check) = plain.get(..length)?.split_last_chunk::<CHECK>()?;
        if CRC.checksum(body) != u32::from_le_bytes(*check) {
            return None;
        }
        let ([kind, low, high], payload) = body.split_first_chunk::<HEAD>()?;
        let payload = Vec::from_slice(payload).ok()?;
        Some(Frame { kind: *kind, number: u16::from_le_bytes([*low, *high]), payload })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use std::vec::Vec as Bytes;

    use super::*;

    fn line(payloads: &[Bytes<u8>]) -> Bytes<u8> {
        let mut line = Bytes::new();
        let mut writer = FrameWriter::default();
        for payload in payloads {
            writer.write(&mut line, 7, payload).unwrap();
        }
        line
    }

    fn read(bytes: &[u8]) -> (Bytes<Frame>, Losses) {
        let mut reader = FrameReader::new();
        let frames = bytes.iter().filter_map(|&byte| reader.take(byte)).collect();
        (frames, reader.losses())
    }

    fn payloads() -> impl Strategy<Value = Bytes<Bytes<u8>>> {
        // Many zeros: these are the bytes that are stuffed.
        let byte = prop_oneof![1 => Just(0_u8), 1 => any::<u8>()];
        prop::collection::vec(prop::collection::vec(byte, 0..=PAYLOAD), 1..6)
    }

    #[test]
    fn a_frame_is_what_its_layout_says() {
        let frame = line(&[Bytes::from([0_u8, 5])]);
        assert_eq!(frame.first(), Some(&0));
        assert_eq!(frame.last(), Some(&0));
        // 7, then 00 00 (number) 00 (payload): each zero starts a new COBS block.
        assert_eq!(frame[1..6], [2, 7, 1, 1, 6]);
        assert_eq!(frame[6], 5);
        assert_eq!(frame.len(), 1 + 1 + 3 + 2 + 4 + 1);
    }

    #[test]
    fn the_checksum_is_the_one_its_name_promises() {
        assert_eq!(CRC.checksum(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn too_long_a_payload_is_refused_and_its_number_is_not_used_up() {
        let mut bytes = Bytes::new();
        let mut writer = FrameWriter::default();
        let refused = writer.write(&mut bytes, 1, &[0; PAYLOAD + 1]);
        assert_eq!(refused, Err(FrameError::TooLong { found: PAYLOAD + 1 }));
        assert_eq!((bytes.len(), writer), (0, FrameWriter::default()));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(payloads in payloads()) {
            let (frames, losses) = read(&line(&payloads));
            prop_assert_eq!(losses, Losses::default());
            prop_assert_eq!(frames.len(), payloads.len());
            for (index, (frame, payload)) in frames.iter().zip(&payloads).enumerate() {
                prop_assert_eq!((frame.kind, usize::from(frame.number)), (7, index));
                prop_assert_eq!(&frame.payload[..], &payload[..]);
            }
        }

        #[test]
        fn whatever_arrives_nothing_panics_and_nothing_is_read_of_noise(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
            let (frames, _) = read(&bytes);
            // One in 4·10⁹ may pass.
            prop_assert!(frames.is_empty());
        }

        #[test]
        fn damage_costs_frames_and_never_changes_one(
            payloads in payloads(),
            damage in prop::collection::vec((any::<prop::sample::Index>(), 1_u8..=255, 0_u8..3), 0..4),
        ) {
            let mut bytes = line(&payloads);
            for (at, other, kind) in damage {
                let at = at.index(bytes.len());
                match kind {
                    0 => bytes[at] ^= other,
                    1 => bytes.insert(at, other),
                    _ => { bytes.remove(at); }
                }
            }
            let (frames, losses) = read(&bytes);
            for frame in &frames {
                prop_assert_eq!(&frame.payload[..], &payloads[usize::from(frame.number)][..]);
            }
            if let (Some(first), Some(last)) = (frames.first(), frames.last()) {
                let between = usize::from(last.number - first.number) + 1;
                prop_assert_eq!(between - frames.len(), losses.missing as usize);
            }
        }
    }
}
