//! Apache Parquet, uncompressed, with snappy as pandas and pyarrow write it, or with gzip, zstd or lz4 as Spark, `Polars` and `DuckDB` do.
//!
//! Every flat column of numbers is a series; its name contains its unit (`position [mm]`, `position_mm`). Timestamps are
//! converted to s since the first timestamp of their column, durations to s, whatever unit their name has. Nulls count as missing values. Columns of lists are not
//! read. Of the metadata that pandas or Arrow add to the file only the durations are needed.

mod arrow_schema;
mod kind;
mod pages;
pub(crate) mod write;

use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use bytes::Bytes;
use kind::Kind;
use pages::Pages;
use parquet::basic::Compression;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData, ParquetMetaDataReader};
use parquet::schema::types::ColumnDescPtr;

use super::catch_panic::contained;
use super::columns::{self, Contents, Offered};
use super::format::{Format, MAX_UNPACKED_BYTES};
use super::surveyed::{Surveyed, of_contents};
use super::unsupported::Unsupported;
use crate::channel_map::ChannelMap;
use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::formats::text::lines::MAX_ROWS;
use crate::recording::Recording;

pub(crate) use write::write;

/// Reads a file.
pub(crate) fn read(name: &str, bytes: Vec<u8>, map: &ChannelMap) -> Result<Recording, RecordingError> {
    columns::recording(name, &opened(name, bytes)?, map)
}

/// All columns of a file.
pub(crate) fn survey(name: &str, bytes: Vec<u8>) -> Result<Vec<Surveyed>, RecordingError> {
    Ok(of_contents(&opened(name, bytes)?))
}

fn opened(name: &str, bytes: Vec<u8>) -> Result<FileColumns<'_>, RecordingError> {
    // The library guards against damaged files, but it does not promise that it never panics.
    let bytes = Bytes::from(bytes);
    let opened = contained(|| ParquetMetaDataReader::new().parse_and_finish(&bytes));
    let Some(Ok(metadata)) = opened else {
        return Err(damaged(Place::file(name), "an index of its columns that cannot be read"));
    };
    let rows = metadata.row_groups().iter().try_fold(0_usize, |rows, group| {
        usize::try_from(group.num_rows()).ok().and_then(|more| rows.checked_add(more)).filter(|rows| *rows <= MAX_ROWS)
    });
    let rows = rows.ok_or_else(|| RecordingError::TooManyRows { place: Place::file(name), most: MAX_ROWS })?;
    let columns = metadata.file_metadata().schema_descr().columns().to_vec();
    let durations = arrow_schema::durations(&metadata);
    let kinds = columns.iter().map(|column| Kind::of(column, durations.get(column.name()).copied()));
    let kinds: Vec<Result<Kind, &'static str>> = kinds.collect();
    let offered = columns.iter().zip(&kinds).map(|(column, kind)| {
        let is_in_seconds = kind.is_ok_and(Kind::is_in_seconds);
        let (name, unit) = (column.path().parts().join("."), is_in_seconds.then(|| "s".to_owned()));
        Offered { name, also: Vec::new(), unit, is_typed: is_in_seconds, base: 0, clock: false }
    });
    Ok(FileColumns { name, offered: offered.collect(), bytes: Arc::new(bytes), metadata, columns, kinds, rows })
}

fn damaged(place: Place, what: &'static str) -> RecordingError {
    RecordingError::Damaged { place, format: Format::Parquet, what }
}

/// The columns of a file.
struct FileColumns<'a> {
    name: &'a str,
    offered: Vec<Offered>,
    bytes: Arc<Bytes>,
    metadata: ParquetMetaData,
    columns: Vec<ColumnDescPtr>,
    /// What the columns hold, or what instead of numbers.
    kinds: Vec<Result<Kind, &'static str>>,
    rows: usize,
}

impl Contents for FileColumns<'_> {
    const KIND: &'static str = "column";

    fn offered(&self) -> &[Offered] {
        &self.offered
    }

    fn rows(&self, _: usize) -> usize {
        self.rows
    }

    fn instead(&self, index: usize) -> Option<&'static str> {
        self.kinds[index].err()
    }

    fn values(&self, index: usize) -> Result<Vec<f64>, RecordingError> {
        let header = &self.offered[index].name;
        let place = || Place::part(self.name, &format!("{} `{header}`", Self::KIND));
        let kind = self.kinds[index].map_err(|found| RecordingError::NotNumbers {
            place: place(),
            header: header.clone(),
            found: found.to_owned(),
        })?;
        let mut unpacked = 0_u64;
        for group in self.metadata.row_groups() {
            let chunk = group.columns().get(index);
            // The file is a summary of several files. None of them is opened: a recording must not determine which other files are read.
            if let Some(path) = chunk.and_then(ColumnChunkMetaData::file_path).filter(|path| !path.is_empty()) {
                let what = Unsupported::Elsewhere(path.to_owned());
                return Err(RecordingError::Unsupported { place: place(), what });
            }
            match chunk.map(ColumnChunkMetaData::compression) {
                Some(
                    Compression::UNCOMPRESSED
                    | Compression::SNAPPY
                    | Compression::GZIP(_)
                    | Compression::ZSTD(_)
                    | Compression::LZ4_RAW,
                ) => {}
                Some(other) => {
                    let packing = format!("{other:?}").split('(').next().unwrap_or_default().to_lowercase();
                    return Err(RecordingError::Unsupported { place: place(), what: Unsupported::Packing(packing) });
                }
                None => return Err(damaged(place(), "a group of rows without this column")),
            }
            let claimed = chunk.and_then(|chunk| u64::try_from(chunk.uncompressed_size()).ok());
            unpacked = unpacked.saturating_add(claimed.unwrap_or(0));
            if unpacked > MAX_UNPACKED_BYTES {
                return Err(RecordingError::TooLarge { place: place(), most_bytes: MAX_UNPACKED_BYTES });
            }
        }
        // The library may panic here too.
        match contained(|| self.column(index, kind)) {
            Some(Ok(values)) => Ok(values),
            Some(Err(error)) if pages::become_too_much(&error) => {
                Err(RecordingError::TooLarge { place: place(), most_bytes: MAX_UNPACKED_BYTES })
            }
            Some(Err(_)) | None => Err(damaged(place(), "values that cannot be read")),
        }
    }
}

impl FileColumns<'_> {
    /// The values of a column, group of rows by group of rows; NaN for nulls.
    fn column(&self, index: usize, kind: Kind) -> Result<Vec<f64>, ParquetError> {
        let described = &self.columns[index];
        let full = described.max_def_level();
        let mut values = Vec::new();
        let mut first = None;
        // Without this limit, any number of row groups could refer to the same pages.
        let left = Arc::new(AtomicUsize::new(usize::try_from(MAX_UNPACKED_BYTES)?));
        for group in self.metadata.row_groups() {
            let rows = usize::try_from(group.num_rows())?;
            let pages = Pages::new(&self.bytes, group.column(index), rows, &left)?;
            let more = match get_column_reader(described.clone(), Box::new(pages)) {
                ColumnReader::BoolColumnReader(reader) => {
                    numbers(reader, rows, full, |value| f64::from(u8::from(*value)))?
                }
                ColumnReader::Int32ColumnReader(reader) => numbers(reader, rows, full, |value| match kind {
                    Kind::Unsigned => f64::from(value.cast_unsigned()),
                    _ => kind.of_whole((*value).into(), &mut first),
                })?,
                ColumnReader::Int64ColumnReader(reader) => {
                    numbers(reader, rows, full, |value| kind.of_whole(*value, &mut first))?
                }
                ColumnReader::Int96ColumnReader(reader) => {
                    numbers(reader, rows, full, |value| kind.of_whole(value.to_nanos(), &mut first))?
                }
                ColumnReader::FixedLenByteArrayColumnReader(reader) => {
                    numbers(reader, rows, full, |value| kind.of_bytes(value.data()))?
                }
                ColumnReader::FloatColumnReader(reader) => numbers(reader, rows, full, |value| f64::from(*value))?,
                ColumnReader::DoubleColumnReader(reader) => numbers(reader, rows, full, |value| *value)?,
                ColumnReader::ByteArrayColumnReader(_) => {
                    return Err(ParquetError::General("no column of numbers".to_owned()));
                }
            };
            values.extend(more);
        }
        Ok(values)
    }
}

/// The values of a column in one group of rows; NaN for nulls.
fn numbers<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    rows: usize,
    full: i16,
    mut number: impl FnMut(&T::T) -> f64,
) -> Result<Vec<f64>, ParquetError> {
    let (mut levels, mut found) = (Vec::new(), Vec::new());
    let (read, ..) = reader.read_records(rows, Some(&mut levels), None, &mut found)?;
    if full == 0 {
        return Ok(found.iter().map(number).collect());
    }
    let mut found = found.iter();
    let value = |level: &i16| if *level == full { found.next().map_or(f64::NAN, &mut number) } else { f64::NAN };
    Ok(levels.iter().take(read).map(value).collect())
}

#[cfg(test)]
mod tests {
    use parquet::file::metadata::{ColumnChunkMetaDataBuilder, ParquetMetaDataWriter, RowGroupMetaData};

    use super::*;
    use crate::recording::Column;
    use crate::signal::Signal;

    /// Three rows of position.
    fn written() -> Vec<u8> {
        let columns =
            vec![Column::si(Signal::Time, vec![0.0, 1.0, 2.0]), Column::si(Signal::Position, vec![0.1, 0.2, 0.3])];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.parquet");
        Recording::new("run", columns).unwrap().write(&path, &[], &[]).unwrap();
        std::fs::read(path).unwrap()
    }

    /// The same file, with changed column metadata in its index.
    fn said(change: impl Fn(ColumnChunkMetaDataBuilder) -> ColumnChunkMetaDataBuilder) -> Vec<u8> {
        let mut bytes = written();
        let metadata = ParquetMetaDataReader::new().parse_and_finish(&Bytes::from(bytes.clone())).unwrap();
        let mut metadata = metadata.into_builder();
        let changed = |group: RowGroupMetaData| {
            let column = |chunk: &ColumnChunkMetaData| change(chunk.clone().into_builder()).build().unwrap();
            let columns = group.columns().iter().map(column).collect();
            group.into_builder().set_column_metadata(columns).build().unwrap()
        };
        let groups = metadata.take_row_groups().into_iter().map(changed).collect();
        let metadata = metadata.set_row_groups(groups).build();
        // The length of the index stands before the magic number at the end.
        let end = bytes.len() - 8;
        let index = u32::from_le_bytes(bytes[end..end + 4].try_into().unwrap());
        bytes.truncate(end - usize::try_from(index).unwrap());
        ParquetMetaDataWriter::new(&mut bytes, &metadata).finish().unwrap();
        bytes
    }

    fn said_to_be_in(path: &str) -> Vec<u8> {
        said(|column| column.set_file_path(path.to_owned()))
    }

    #[test]
    fn what_says_that_it_becomes_too_much_is_refused_before_it_is_unpacked() {
        let becomes = |size: u64| {
            let bytes = said(|column| column.set_total_uncompressed_size(size.cast_signed()));
            read("run.parquet", bytes, &ChannelMap::default())
        };
        assert_eq!(becomes(MAX_UNPACKED_BYTES).unwrap().time_s(), [0.0, 1.0, 2.0]);
        let refused = becomes(MAX_UNPACKED_BYTES + 1).unwrap_err();
        assert!(matches!(refused, RecordingError::TooLarge { .. }), "{refused}");
    }

    #[test]
    fn what_becomes_too_much_without_saying_so_is_refused_as_well() {
        let mut bytes = written();
        // The times are stored as a dictionary. Snappy states the unpacked length first; it is changed here to 2 GiB.
        let times: Vec<u8> = [0.0_f64, 1.0, 2.0].iter().flat_map(|time| time.to_le_bytes()).collect();
        let packed = snap::raw::Encoder::new().compress_vec(&times).unwrap();
        let at = bytes.windows(packed.len()).position(|window| window == packed).unwrap();
        bytes[at..at + 5].copy_from_slice(&[0x80, 0x80, 0x80, 0x80, 0x08]);
        let refused = read("run.parquet", bytes, &ChannelMap::default()).unwrap_err();
        assert!(matches!(refused, RecordingError::TooLarge { .. }), "{refused}");
    }

    #[test]
    fn values_that_stand_in_another_file_are_not_looked_for_there() {
        let folder = tempfile::tempdir().unwrap();
        let other = folder.path().join("other.parquet");
        std::fs::write(&other, written()).unwrap();
        for path in [other.to_str().unwrap(), "../../etc/passwd", "part-0.parquet"] {
            let refused = read("summary.parquet", said_to_be_in(path), &ChannelMap::default()).unwrap_err();
            assert!(
                matches!(&refused, RecordingError::Unsupported { what: Unsupported::Elsewhere(name), .. } if name == path),
                "{refused}"
            );
        }
        assert_eq!(read("run.parquet", said_to_be_in(""), &ChannelMap::default()).unwrap().time_s(), [0.0, 1.0, 2.0]);
    }
}
