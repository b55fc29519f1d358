//! The pages of a column, read without those statements of the file that the library would trust and should not.
//!
//! The library allocates memory for the unpacked size that a page states, and unpacks gzip without limit. Therefore the metadata that it gets say
//! that nothing is packed: it reads only the page headers, and the data after them are unpacked here.

use std::io::Read;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use bytes::Bytes;
use flate2::read::MultiGzDecoder;
use lz4_flex::block::{DecompressError, decompress_into};
use parquet::basic::{Compression, Type};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::ParquetError;
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::serialized_reader::SerializedPageReader;
use ruzstd::decoding::StreamingDecoder;

/// The pages of a column of numbers in a group of rows, unpacked up to the limit for the whole column. A dictionary that states more values than its
/// page can hold is refused: the library allocates memory for all stated values before it reads the first; half a kilobyte may state 16 GiB.
pub(crate) struct Pages {
    packed: SerializedPageReader<Bytes>,
    packing: Compression,
    /// Bytes that the pages still to come may take when unpacked, in this and all other groups.
    left: Arc<AtomicUsize>,
    /// Bytes of a value; dictionaries of booleans do not occur.
    width: usize,
}

impl Pages {
    /// The pages of a group, of which no more may be unpacked than the `left` bytes of the column.
    pub(crate) fn new(
        file: &Arc<Bytes>,
        chunk: &ColumnChunkMetaData,
        rows: usize,
        left: &Arc<AtomicUsize>,
    ) -> Result<Self, ParquetError> {
        let as_it_is = chunk.clone().into_builder().set_compression(Compression::UNCOMPRESSED).build()?;
        let width = match chunk.column_type() {
            Type::INT32 | Type::FLOAT => 4,
            Type::INT64 | Type::DOUBLE => 8,
            _ => 1,
        };
        Ok(Self {
            packed: SerializedPageReader::new(Arc::clone(file), &as_it_is, rows, None)?,
            packing: chunk.compression(),
            left: Arc::clone(left),
            width,
        })
    }

    /// Unpacks the data after the levels of a page.
    fn unpack(&mut self, page: &mut Bytes, levels: usize) -> Result<(), ParquetError> {
        if self.packing == Compression::UNCOMPRESSED {
            return Ok(());
        }
        let Some((plain, packed)) = page.split_at_checked(levels) else {
            return Err(ParquetError::General("levels that are longer than their page".to_owned()));
        };
        let mut bytes = plain.to_vec();
        let left = self.left.load(Ordering::Relaxed);
        append(self.packing, packed, left, &mut bytes)?;
        self.left.store(left.saturating_sub(bytes.len() - levels), Ordering::Relaxed);
        *page = Bytes::from(bytes);
        Ok(())
    }
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Result<Option<Page>, ParquetError> {
        let Some(mut page) = self.packed.get_next_page()? else { return Ok(None) };
        match &mut page {
            Page::DataPage { buf, .. } => self.unpack(buf, 0)?,
            Page::DataPageV2 { is_compressed: false, .. } => {}
            Page::DataPageV2 { buf, def_levels_byte_len, rep_levels_byte_len, .. } => {
                self.unpack(buf, *def_levels_byte_len as usize + *rep_levels_byte_len as usize)?;
            }
            Page::DictionaryPage { buf, num_values, .. } => {
                self.unpack(buf, 0)?;
                if *num_values as usize > buf.len() / self.width {
                    let what = "a dictionary of more values than its page has room for";
                    return Err(ParquetError::General(what.to_owned()));
                }
            }
        }
        Ok(Some(page))
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>, ParquetError> {
        self.packed.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<(), ParquetError> {
        self.packed.skip_next_page()
    }
}

impl Iterator for Pages {
    type Item = Result<Page, ParquetError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

/// Unpacked pages exceed their limit.
#[derive(Debug, thiserror::Error)]
#[error("pages that become too much")]
struct TooMuch;

fn too_much() -> ParquetError {
    ParquetError::External(Box::new(TooMuch))
}

/// Whether this error says that unpacked pages exceed their limit.
pub(crate) fn become_too_much(error: &ParquetError) -> bool {
    matches!(error, ParquetError::External(source) if source.is::<TooMuch>())
}

/// Appends unpacked bytes, unless they are more than `most`. Memory is allocated for actual output, not for the stated size.
fn append(packing: Compression, packed: &[u8], most: usize, into: &mut Vec<u8>) -> Result<(), ParquetError> {
    match packing {
        // A page without values.
        _ if packed.is_empty() => Ok(()),
        Compression::GZIP(_) => append_all(MultiGzDecoder::new(packed), most, into),
        Compression::ZSTD(_) => append_zstd(packed, most, into),
        Compression::SNAPPY => append_snappy(packed, most, into),
        Compression::LZ4_RAW => append_lz4(packed, most, into),
        other => Err(ParquetError::NYI(other.to_string())),
    }
}

/// Unpacks frame by frame; a decoder uses up to 100 MiB in addition, and a frame that needs more is refused.
fn append_zstd(packed: &[u8], most: usize, into: &mut Vec<u8>) -> Result<(), ParquetError> {
    let (mut rest, start) = (packed, into.len());
    while !rest.is_empty() {
        let frame = StreamingDecoder::new(&mut rest).map_err(|error| ParquetError::External(Box::new(error)))?;
        append_all(frame, most - (into.len() - start), into)?;
    }
    Ok(())
}

/// Appends the whole output, piece by piece.
fn append_all(source: impl Read, most: usize, into: &mut Vec<u8>) -> Result<(), ParquetError> {
    // One byte more than allowed shows that the output is too long.
    let length = source.take(most as u64 + 1).read_to_end(into)?;
    if length > most { Err(too_much()) } else { Ok(()) }
}

/// Snappy states the unpacked size first: three packed bytes give at most 64.
fn append_snappy(packed: &[u8], most: usize, into: &mut Vec<u8>) -> Result<(), ParquetError> {
    let length = snap::raw::decompress_len(packed)?;
    if length > most {
        return Err(too_much());
    }
    if length / 22 > packed.len() {
        return Err(ParquetError::General("a page that cannot become what it says".to_owned()));
    }
    let start = into.len();
    into.resize(start + length, 0);
    snap::raw::Decoder::new().decompress(packed, &mut into[start..])?;
    Ok(())
}

/// LZ4 does not state the unpacked size: the buffer grows until it suffices.
fn append_lz4(packed: &[u8], most: usize, into: &mut Vec<u8>) -> Result<(), ParquetError> {
    let start = into.len();
    let mut room = packed.len().saturating_mul(4).min(most);
    loop {
        into.resize(start + room, 0);
        match decompress_into(packed, &mut into[start..]) {
            Ok(length) => {
                into.truncate(start + length);
                return Ok(());
            }
            Err(DecompressError::OutputTooSmall { .. }) if room < most => room = room.saturating_mul(2).min(most),
            Err(DecompressError::OutputTooSmall { .. }) => return Err(too_much()),
            Err(error) => return Err(ParquetError::External(Box::new(error))),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use parquet::basic::{Encoding, GzipLevel, ZstdLevel};
    use parquet::column::page::{CompressedPage, PageWriter};
    use parquet::file::writer::{SerializedPageWriter, TrackedWrite};
    use parquet::schema::types::{self, ColumnDescriptor, ColumnPath};

    use super::*;

    fn packings() -> [Compression; 4] {
        [
            Compression::SNAPPY,
            Compression::GZIP(GzipLevel::default()),
            Compression::ZSTD(ZstdLevel::default()),
            Compression::LZ4_RAW,
        ]
    }

    fn packed(packing: Compression, plain: &[u8]) -> Vec<u8> {
        match packing {
            Compression::SNAPPY => snap::raw::Encoder::new().compress_vec(plain).unwrap(),
            Compression::GZIP(_) => {
                let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
                encoder.write_all(plain).unwrap();
                encoder.finish().unwrap()
            }
            Compression::ZSTD(_) => {
                ruzstd::encoding::compress_to_vec(plain, ruzstd::encoding::CompressionLevel::Fastest)
            }
            Compression::LZ4_RAW => lz4_flex::block::compress(plain),
            other => panic!("{other}"),
        }
    }

    /// A column of doubles in these pages, each of which states an unpacked size of 2 GiB; `most` is what they may take.
    fn column(packing: Compression, pages: &[Page], most: usize) -> Pages {
        let mut file = TrackedWrite::new(Vec::new());
        for page in pages {
            let page = CompressedPage::new(page.clone(), 0x7fff_ffff);
            SerializedPageWriter::new(&mut file).write_page(page).unwrap();
        }
        let file = Bytes::from(file.into_inner().unwrap());
        let double = types::Type::primitive_type_builder("x", Type::DOUBLE).build().unwrap();
        let described = ColumnDescriptor::new(Arc::new(double), 0, 0, ColumnPath::from("x"));
        let chunk = ColumnChunkMetaData::builder(Arc::new(described)).set_compression(packing);
        let chunk = chunk.set_total_compressed_size(i64::try_from(file.len()).unwrap()).build().unwrap();
        Pages::new(&Arc::new(file), &chunk, 64, &Arc::new(AtomicUsize::new(most))).unwrap()
    }

    #[test]
    fn nothing_is_unpacked_to_more_than_it_may_become() {
        let plain = vec![7_u8; 1_000_000];
        for packing in packings() {
            let packed = packed(packing, &plain);
            let unpacked = |packed: &[u8], most| {
                let mut bytes = b"before".to_vec();
                append(packing, packed, most, &mut bytes).map(|()| bytes)
            };
            let whole = unpacked(&packed, plain.len()).unwrap();
            assert!(whole.strip_prefix(b"before") == Some(plain.as_slice()), "{packing}: {} bytes", whole.len());
            for most in [0, 1000, plain.len() - 1] {
                let refused = unpacked(&packed, most).unwrap_err();
                assert!(become_too_much(&refused), "{packing}: {refused}");
            }
            let cut = unpacked(&packed[..packed.len() / 2], plain.len()).unwrap_err();
            assert!(!become_too_much(&cut), "{packing}: {cut}");
            assert_eq!(unpacked(&[], 0).unwrap(), b"before");
        }
        // A stated size of 2 GiB, in seven bytes.
        let lie = append(Compression::SNAPPY, &[0x80, 0x80, 0x80, 0x80, 0x08, 0, 7], usize::MAX, &mut Vec::new());
        assert!(matches!(lie, Err(ParquetError::General(_))), "{lie:?}");
    }

    #[test]
    fn pages_of_every_kind_become_what_is_in_them_and_no_more_all_together_than_they_may() {
        let plain: Vec<u8> = (0..64).flat_map(|number| f64::from(number).to_le_bytes()).collect();
        let behind_levels = |bytes: &[u8]| [b"levels".as_slice(), bytes].concat();
        for packing in packings() {
            let packed = packed(packing, &plain);
            let buf = Bytes::from(packed.clone());
            let dictionary =
                Page::DictionaryPage { buf: buf.clone(), num_values: 64, encoding: Encoding::PLAIN, is_sorted: false };
            let first = Page::DataPage {
                buf,
                num_values: 64,
                encoding: Encoding::PLAIN,
                def_level_encoding: Encoding::RLE,
                rep_level_encoding: Encoding::RLE,
                statistics: None,
            };
            let second = |bytes: &[u8], is_compressed| Page::DataPageV2 {
                buf: Bytes::from(behind_levels(bytes)),
                num_values: 64,
                encoding: Encoding::PLAIN,
                num_nulls: 0,
                num_rows: 64,
                def_levels_byte_len: 4,
                rep_levels_byte_len: 2,
                is_compressed,
                statistics: None,
            };
            let pages = [dictionary, first, second(&packed, true), second(&plain, false)];
            let found: Vec<Vec<u8>> =
                column(packing, &pages, 1 << 20).map(|page| page.unwrap().buffer().to_vec()).collect();
            assert_eq!(found, [plain.clone(), plain.clone(), behind_levels(&plain), behind_levels(&plain)]);
            let mut few = column(packing, &pages, 3 * plain.len() - 1);
            assert!(few.next().unwrap().is_ok() && few.next().unwrap().is_ok());
            let refused = few.next().unwrap().unwrap_err();
            assert!(become_too_much(&refused), "{packing}: {refused}");
        }
    }
}
