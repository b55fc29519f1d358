//! Durations among the columns of a Parquet file: Parquet has no such type, and stores them as whole numbers. That they are durations stands only in Arrow's
//! schema, which pandas, pyarrow and Polars put beside, as the message of its columnar format in base64.
//!
//! After "Arrow Columnar Format" (Apache) and the binary format of `FlatBuffers`. Only names and types of the columns are looked at; what cannot be read has no
//! durations. No length or place in the bytes is trusted.

use std::collections::HashMap;

use parquet::file::metadata::ParquetMetaData;

/// The key of the file's metadata under which the schema stands.
const KEY: &str = "ARROW:schema";
/// Most columns that are looked at.
const MOST_FIELDS: usize = 4096;
/// The number of a duration among Arrow's types.
const DURATION: u8 = 18;
/// The number of a schema among Arrow's messages.
const SCHEMA: u8 = 1;

/// The length of the unit of each column of durations, s.
pub(super) fn durations(metadata: &ParquetMetaData) -> HashMap<String, f64> {
    let texts = metadata.file_metadata().key_value_metadata().into_iter().flatten();
    let text = texts.filter(|pair| pair.key == KEY).find_map(|pair| pair.value.as_deref());
    text.and_then(decoded).and_then(|bytes| of_message(&bytes)).unwrap_or_default()
}

/// The bytes of a text in base64.
fn decoded(text: &str) -> Option<Vec<u8>> {
    let sextet = |byte: u8| match byte {
        b'A'..=b'Z' => Some(byte - b'A'),
        b'a'..=b'z' => Some(byte - b'a' + 26),
        b'0'..=b'9' => Some(byte - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let (mut bytes, mut bits, mut held) = (Vec::with_capacity(text.len() / 4 * 3), 0_u32, 0);
    for byte in text.trim_end_matches('=').bytes() {
        bits = bits << 6 | u32::from(sextet(byte)?);
        held += 6;
        if held >= 8 {
            held -= 8;
            bytes.push(u8::try_from(bits >> held & 0xff).ok()?);
        }
    }
    Some(bytes)
}

fn of_message(bytes: &[u8]) -> Option<HashMap<String, f64>> {
    // Since version 0.15 of Arrow, four bytes of ones stand before the length.
    let start = if bytes.starts_with(&[0xff; 4]) { 8 } else { 4 };
    let buffer = Buffer(bytes.get(start..)?);
    let message = buffer.table(0)?;
    if message.byte(1)? != SCHEMA {
        return None;
    }
    let mut durations = HashMap::new();
    for field in message.table(2)?.tables(1)? {
        if field.byte(2) != Some(DURATION) {
            continue;
        }
        // A unit that is not stated is ms.
        let unit_s = match field.table(3)?.short(0).unwrap_or(1) {
            0 => 1.0,
            1 => 1e-3,
            2 => 1e-6,
            3 => 1e-9,
            _ => return None,
        };
        durations.insert(field.text(0)?, unit_s);
    }
    Some(durations)
}

/// The bytes of a buffer, in which tables and texts refer to each other.
#[derive(Clone, Copy)]
struct Buffer<'a>(&'a [u8]);

/// A table in a buffer: its place.
#[derive(Clone, Copy)]
struct Table<'a>(Buffer<'a>, usize);

impl<'a> Buffer<'a> {
    fn bytes<const N: usize>(self, at: usize) -> Option<[u8; N]> {
        self.0.get(at..)?.first_chunk::<N>().copied()
    }

    /// The place that is referred to from a place.
    fn referred(self, at: usize) -> Option<usize> {
        at.checked_add(usize::try_from(u32::from_le_bytes(self.bytes(at)?)).ok()?)
    }

    fn table(self, at: usize) -> Option<Table<'a>> {
        Some(Table(self, self.referred(at)?))
    }
}

impl<'a> Table<'a> {
    /// The place of a field, if the table has it.
    fn place(self, field: usize) -> Option<usize> {
        let Table(buffer, at) = self;
        let back = i64::from(i32::from_le_bytes(buffer.bytes(at)?));
        let list = usize::try_from(i64::try_from(at).ok()?.checked_sub(back)?).ok()?;
        let length = usize::from(u16::from_le_bytes(buffer.bytes(list)?));
        let entry = 4 + 2 * field;
        if entry + 2 > length {
            return None;
        }
        let offset = usize::from(u16::from_le_bytes(buffer.bytes(list.checked_add(entry)?)?));
        (offset > 0).then_some(at.checked_add(offset)?)
    }

    fn byte(self, field: usize) -> Option<u8> {
        self.0.bytes::<1>(self.place(field)?).map(|[byte]| byte)
    }

    fn short(self, field: usize) -> Option<i16> {
        self.0.bytes(self.place(field)?).map(i16::from_le_bytes)
    }

    fn table(self, field: usize) -> Option<Table<'a>> {
        self.0.table(self.place(field)?)
    }

    /// Where a list begins, and how many entries it has.
    fn list(self, field: usize) -> Option<(usize, usize)> {
        let at = self.0.referred(self.place(field)?)?;
        Some((at.checked_add(4)?, usize::try_from(u32::from_le_bytes(self.0.bytes(at)?)).ok()?))
    }

    fn tables(self, field: usize) -> Option<impl Iterator<Item = Table<'a>>> {
        let (at, count) = self.list(field)?;
        Some((0..count.min(MOST_FIELDS)).map_while(move |index| self.0.table(at.checked_add(4 * index)?)))
    }

    fn text(self, field: usize) -> Option<String> {
        let (at, length) = self.list(field)?;
        let bytes = self.0.0.get(at..at.checked_add(length)?)?;
        str::from_utf8(bytes).ok().map(str::to_owned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_decoded() {
        assert_eq!(decoded("aGVsbG8=").unwrap(), b"hello");
        assert_eq!(decoded("/+8A").unwrap(), [0xff, 0xef, 0]);
        assert_eq!(decoded("a*b"), None);
    }

    #[test]
    fn bytes_that_are_no_schema_have_no_durations() {
        let mut state = 1_u64;
        for length in 0..2000 {
            let bytes: Vec<u8> = (0..length % 300)
                .map(|_| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    // Small numbers, which refer to somewhere within.
                    state.to_be_bytes()[0] & if length % 2 == 0 { 0x0f } else { 0xff }
                })
                .collect();
            of_message(&bytes);
        }
    }
}
