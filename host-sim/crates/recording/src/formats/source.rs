//! Where a recording comes from: a file, or the bytes of any other source.

use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::Path;

use encoding_rs::{Encoding, UTF_16BE, UTF_16LE};
use encoding_rs_io::DecodeReaderBytesBuilder;

#[cfg(any(feature = "mat", feature = "mdf4", feature = "parquet", feature = "xlsx"))]
use super::format::MAX_BINARY_BYTES;
use super::format::{Format, HEAD};
use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::formats::text::lines::Input;

/// Opens a file; also gives its name for messages.
pub(crate) fn open(path: &Path) -> Result<(String, File), RecordingError> {
    let name = path.display().to_string();
    match File::open(path) {
        Ok(file) => Ok((name, file)),
        Err(source) => Err(unreadable(&name, source)),
    }
}

pub(crate) fn unreadable(name: &str, source: io::Error) -> RecordingError {
    RecordingError::Io { place: Place::file(name), source }
}

/// The format that the first bytes of a file show, and all of the file; a text in UTF-16 is one in UTF-8 from here on.
pub(crate) fn recognised<'a>(name: &str, mut file: impl Read + 'a) -> Result<(Format, Input<'a>), RecordingError> {
    let mut head = Vec::new();
    (&mut file).take(HEAD as u64).read_to_end(&mut head).map_err(|source| unreadable(name, source))?;
    let format =
        Format::of_content(&head).map_err(|what| RecordingError::Unsupported { place: Place::file(name), what })?;
    let encoding = utf_16(&head);
    let all = Cursor::new(head).chain(file);
    let Some(encoding) = encoding else { return Ok((format, Box::new(all))) };
    let mut decoder = DecodeReaderBytesBuilder::new();
    Ok((format, Box::new(decoder.encoding(Some(encoding)).bom_override(true).build(all))))
}

/// The order of bytes of a text in UTF-16: by the mark with which it begins, or else because every second byte is zero and the others are printable characters.
fn utf_16(head: &[u8]) -> Option<&'static Encoding> {
    if let Some((encoding, _)) = Encoding::for_bom(head) {
        return [UTF_16LE, UTF_16BE].into_iter().find(|known| *known == encoding);
    }
    let pairs = head.as_chunks::<2>().0;
    let is_text =
        |high: usize| pairs.len() > 3 && pairs.iter().all(|pair| pair[high] == 0 && is_printable(pair[1 - high]));
    if is_text(1) { Some(UTF_16LE) } else { is_text(0).then_some(UTF_16BE) }
}

fn is_printable(byte: u8) -> bool {
    matches!(byte, b' '..=b'~' | b'\t' | b'\r' | b'\n')
}

/// All bytes of a file that is not text.
#[cfg(any(feature = "mat", feature = "mdf4", feature = "parquet", feature = "xlsx"))]
pub(crate) fn held(name: &str, packed: impl Read) -> Result<Vec<u8>, RecordingError> {
    let mut bytes = Vec::new();
    packed.take(MAX_BINARY_BYTES + 1).read_to_end(&mut bytes).map_err(|source| unreadable(name, source))?;
    if bytes.len() as u64 > MAX_BINARY_BYTES {
        return Err(RecordingError::TooLarge { place: Place::file(name), most_bytes: MAX_BINARY_BYTES });
    }
    Ok(bytes)
}
