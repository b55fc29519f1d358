//! Files packed by gzip: what they hold is read in its own format, as it is unpacked.

use std::io::{self, Read};

use flate2::read::MultiGzDecoder;

use super::format::MAX_UNPACKED_BYTES;
use super::source::unreadable;
use super::text::lines::Input;
use super::unsupported::Unsupported;
use crate::error::RecordingError;
use crate::files::source_error::Place;

/// What is packed; one packed file in another is refused.
pub(crate) fn unpacked<'a>(name: &str, packed: impl Read + 'a) -> Result<Input<'a>, RecordingError> {
    let mut decoder = MultiGzDecoder::new(packed);
    let mut head = [0; 2];
    let length = read_some(&mut decoder, &mut head).map_err(|source| unreadable(name, of_packing(source)))?;
    if head == [0x1f, 0x8b] {
        let what = Unsupported::Foreign("a file that is packed twice", "a file that is packed once");
        return Err(RecordingError::Unsupported { place: Place::file(name), what });
    }
    let rest = Limited { inner: decoder, left: MAX_UNPACKED_BYTES };
    Ok(Box::new(io::Cursor::new(head).take(length as u64).chain(rest)))
}

/// An error of what is packed, and not of the disk, says so.
fn of_packing(error: io::Error) -> io::Error {
    use io::ErrorKind as Kind;
    match error.kind() {
        Kind::UnexpectedEof | Kind::InvalidInput | Kind::InvalidData => {
            io::Error::new(Kind::InvalidData, format!("what gzip packed is cut off or damaged ({error})"))
        }
        _ => error,
    }
}

fn read_some(from: &mut impl Read, head: &mut [u8; 2]) -> io::Result<usize> {
    let mut length = 0;
    while length < head.len() {
        match from.read(&mut head[length..])? {
            0 => break,
            more => length += more,
        }
    }
    Ok(length)
}

/// A reader that fails where more comes than may be unpacked.
struct Limited<R> {
    inner: R,
    left: u64,
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(buffer).map_err(of_packing)?;
        self.left = self.left.checked_sub(read as u64).ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::FileTooLarge,
                format!("more than {} MiB once unpacked", MAX_UNPACKED_BYTES >> 20),
            )
        })?;
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::GzEncoder;

    use crate::{ChannelMap, RecordingError, Signal, read_from};

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn a_packed_text_is_read_as_it_is_unpacked() {
        let text = b"time [s];position [mm]\n0;1,5\n1;2,5\n";
        let bytes = packed(text);
        let read = |bytes: &[u8]| read_from("run.csv.gz", bytes, &ChannelMap::default());
        assert_eq!(read(&bytes).unwrap().signal(Signal::Position).unwrap(), [0.0015, 0.0025]);
        // A logger that packs each part by itself.
        let parts = [packed(&text[..30]), packed(&text[30..])].concat();
        assert_eq!(read(&parts).unwrap().rows(), 2);
        for end in [12, bytes.len() - 9, bytes.len() - 4] {
            let cut = read(&bytes[..end]).unwrap_err();
            assert!(matches!(cut, RecordingError::Io { .. }));
            let told = cut.to_string();
            let is_told =
                told.contains("cut off or damaged") && told.ends_with("expected a whole file: save or copy it again");
            assert!(is_told, "{told}");
        }
        let twice = read(&packed(&bytes)).unwrap_err().to_string();
        assert!(twice.contains("packed twice"), "{twice}");
        assert!(matches!(read(&packed(b"")).unwrap_err(), RecordingError::Empty { .. }));
    }
}
