//! A channel's values: the bits of its records, and what they mean.

use super::Fault;
use super::blocks::Group;
use super::conversion::Conversion;
use crate::formats::unsupported::Unsupported;

/// A channel as its block describes it.
#[derive(Clone, Debug)]
pub(crate) struct Channel {
    pub(crate) name: String,
    /// Its own name, where it is a member of a structure and `name` has that of the structure too.
    pub(crate) member: Option<String>,
    pub(crate) unit: Option<String>,
    pub(crate) kind: u8,
    pub(crate) sync: u8,
    pub(crate) data_type: u8,
    pub(crate) bit_offset: u32,
    pub(crate) byte_offset: usize,
    pub(crate) bits: u32,
    pub(crate) flags: u32,
    /// Number of the bit that marks its value as invalid.
    pub(crate) mark: usize,
    /// What it is, where it is not a series of numbers but consists of other channels.
    pub(crate) instead: Option<&'static str>,
    /// Bytes and marking bits by which it stands behind its place, as an element of an array.
    pub(crate) moved: (i64, i64),
    pub(crate) conversion: Conversion,
    /// Position of its conversion, as long as that is not read; 0 where it has none.
    pub(crate) conversion_at: u64,
}

const VARIABLE: u8 = 1;
const MASTER: u8 = 2;
const VIRTUAL_MASTER: u8 = 3;
const SYNCHRONISATION: u8 = 4;
const VIRTUAL_DATA: u8 = 6;
const SYNC_TIME: u8 = 1;
const ALL_INVALID: u32 = 1;
const MARKED: u32 = 2;

impl Channel {
    /// Whether it holds the times of its group.
    pub(crate) fn is_clock(&self) -> bool {
        matches!(self.kind, MASTER | VIRTUAL_MASTER) && self.sync == SYNC_TIME
    }

    /// Whether its raw values are whole numbers.
    pub(crate) fn is_whole(&self) -> bool {
        self.is_virtual() || matches!(self.data_type, 0..=3)
    }

    /// Moves it by so many bytes, and by so many bits that mark values.
    pub(crate) fn move_by(&mut self, bytes: i64, marks: i64) {
        let by = |place: usize, by: i64| {
            usize::try_from(by).map_or_else(
                |_| place.saturating_sub(usize::try_from(by.unsigned_abs()).unwrap_or(usize::MAX)),
                |by| place.saturating_add(by),
            )
        };
        (self.byte_offset, self.mark) = (by(self.byte_offset, bytes), by(self.mark, marks));
        self.moved = (self.moved.0.saturating_add(bytes), self.moved.1.saturating_add(marks));
    }

    /// Whether its raw value is the number of the record.
    pub(crate) fn is_virtual(&self) -> bool {
        matches!(self.kind, VIRTUAL_MASTER | VIRTUAL_DATA)
    }

    /// Checks that it holds numbers of a supported layout.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        self.conversion.check()?;
        if self.is_virtual() {
            return Ok(());
        }
        if matches!(self.data_type, 6..=9) {
            return Err(Fault::NotNumbers("text"));
        }
        if matches!(self.kind, VARIABLE | SYNCHRONISATION) {
            return Err(Fault::NotNumbers("data of any length"));
        }
        let bits = self.bits;
        match self.data_type {
            0..=3 if bits > 0 && bits <= 64_u32.saturating_sub(self.bit_offset) => Ok(()),
            0..=3 => Err(Fault::Unsupported(Unsupported::Layout(format!("{bits} bits at bit {}", self.bit_offset)))),
            4 | 5 if matches!(bits, 16 | 32 | 64) && self.bit_offset == 0 => Ok(()),
            4 | 5 => Err(Fault::Unsupported(Unsupported::Layout(format!("a floating number of {bits} bits")))),
            _ => Err(Fault::NotNumbers("something else than numbers")),
        }
    }

    /// The values of all records, after [`Self::check`] has accepted the channel; NaN for values that are marked invalid.
    pub(crate) fn values(&self, group: &Group, records: &[u8]) -> Result<Vec<f64>, Fault> {
        if self.flags & ALL_INVALID != 0 {
            return Ok(vec![f64::NAN; usize::try_from(group.cycles).unwrap_or(0)]);
        }
        if self.is_virtual() {
            return Ok((0..group.cycles).map(|record| self.conversion.of(record as f64)).collect());
        }
        let bytes = (self.bits + self.bit_offset).div_ceil(8) as usize;
        let outside = || Fault::Damaged("a channel outside its record");
        let end = self.byte_offset.checked_add(bytes).filter(|end| *end <= group.value_bytes).ok_or_else(outside)?;
        let marked = self.flags & MARKED != 0;
        if marked && self.mark / 8 >= group.mark_bytes {
            return Err(outside());
        }
        let value = |record: &[u8]| {
            if marked && record[group.value_bytes + self.mark / 8] >> (self.mark % 8) & 1 == 1 {
                return f64::NAN;
            }
            self.conversion.of(self.raw(&record[self.byte_offset..end]))
        };
        // The record length is not zero, because the channel lies in the record.
        Ok(records.chunks_exact(group.record_bytes()).map(value).collect())
    }

    /// The raw value, from at most eight bytes.
    #[expect(clippy::cast_possible_truncation, reason = "the bits are those of a shorter number")]
    fn raw(&self, bytes: &[u8]) -> f64 {
        let mut wide = [0; 8];
        let high_byte_first = self.data_type % 2 == 1;
        for (at, byte) in bytes.iter().enumerate() {
            wide[if high_byte_first { bytes.len() - 1 - at } else { at }] = *byte;
        }
        let word = u64::from_le_bytes(wide);
        let unused = 64 - self.bits;
        let high = (word >> self.bit_offset) << unused;
        match (self.data_type, self.bits) {
            (0 | 1, _) => (high >> unused) as f64,
            (2 | 3, _) => (high.cast_signed() >> unused) as f64,
            (_, 16) => half::f16::from_bits(word as u16).to_f64(),
            (_, 32) => f64::from(f32::from_bits(word as u32)),
            _ => f64::from_bits(word),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(data_type: u8, bit_offset: u32, bits: u32, conversion: Conversion) -> Channel {
        let (name, unit, kind, sync, flags) = ("x".to_owned(), None, 0, 0, MARKED);
        let (byte_offset, mark, conversion_at, moved) = (1, 3, 0, (0, 0));
        let (member, instead) = (None, None);
        Channel {
            name,
            member,
            unit,
            kind,
            sync,
            data_type,
            bit_offset,
            byte_offset,
            bits,
            flags,
            mark,
            instead,
            moved,
            conversion,
            conversion_at,
        }
    }

    fn group(value_bytes: usize) -> Group {
        Group { cycles: 2, value_bytes, mark_bytes: 1, ..Group::default() }
    }

    fn values(channel: &Channel, value_bytes: usize, records: &[u8]) -> Vec<f64> {
        channel.check().unwrap();
        channel.values(&group(value_bytes), records).unwrap()
    }

    #[test]
    fn numbers_of_any_width_and_order_are_read() {
        let of = |data_type, bit_offset, bits| channel(data_type, bit_offset, bits, Conversion::None);
        assert_eq!(values(&of(0, 0, 8), 2, &[9, 200, 0, 9, 7, 0]), [200.0, 7.0]);
        assert_eq!(values(&of(2, 0, 8), 2, &[9, 200, 0, 9, 7, 0]), [-56.0, 7.0]);
        assert_eq!(values(&of(2, 4, 12), 3, &[9, 0xf0, 0xff, 0, 9, 0x10, 0x00, 0]), [-1.0, 1.0]);
        assert_eq!(values(&of(1, 0, 16), 3, &[9, 1, 2, 0, 9, 2, 1, 0]), [258.0, 513.0]);
        let single = [[9].as_slice(), &1.5_f32.to_be_bytes(), &[0], &[9], &(-2.0_f32).to_be_bytes(), &[0]].concat();
        assert_eq!(values(&of(5, 0, 32), 5, &single), [1.5, -2.0]);
        // 1.5 and -2 as half numbers.
        assert_eq!(values(&of(4, 0, 16), 3, &[9, 0x00, 0x3e, 0, 9, 0x00, 0xc0, 0]), [1.5, -2.0]);
    }

    #[test]
    fn what_is_marked_invalid_is_no_value() {
        let read = values(&channel(0, 0, 8, Conversion::None), 2, &[9, 1, 0b1000, 9, 2, 0b0111]);
        assert!(read[0].is_nan() && read[1..] == [2.0]);
    }

    #[test]
    fn a_channel_outside_its_record_is_refused() {
        let wide = channel(0, 0, 64, Conversion::None);
        assert!(matches!(wide.values(&group(2), &[0; 6]), Err(Fault::Damaged(_))));
        assert!(matches!(channel(0, 60, 8, Conversion::None).check(), Err(Fault::Unsupported(_))));
        // In 32 bits their sum overflows to 4.
        assert!(matches!(channel(0, 5, u32::MAX, Conversion::None).check(), Err(Fault::Unsupported(_))));
        assert!(matches!(channel(6, 0, 8, Conversion::None).check(), Err(Fault::NotNumbers(_))));
    }
}
