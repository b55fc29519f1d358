//! The rows in Parquet: a folder of parts, each written whole or not at all.
//!
//! `DuckDB`, pandas and databases read the folder as one table (`TABLE/*.parquet`). The rows of a night stand in one part, so a night is there whole or not at
//! all, whenever a run is killed.

use std::collections::BTreeSet;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytes::Bytes;
use model_core::machine::Parameter;
use parquet::basic::{Compression, ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{ChunkReader, FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::record::{Field, Row as Record};
use parquet::schema::types::Type;
use recording::files::atomic;
use watch::Link;

use crate::columns::{column_of, deviation_of};
use crate::row::{Judgement, MISFITS, Row, Strength};

/// The file that a run holds while it writes. It stays: to be there means nothing.
const LOCK: &str = ".lock";
const ENDING: &str = "parquet";

/// Why a table cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The folder or a part of it cannot be read or written.
    #[error("{}: {cause}", path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        cause: io::Error,
    },
    /// Another run writes to it.
    #[error("{}: another run is writing to this table; expected that one to end first, or another table", path.display())]
    Locked {
        /// The table.
        path: PathBuf,
    },
    /// A part that is no part of such a table.
    #[error("{}: {what}; expected a part of a table that `host-sim fleet` wrote", path.display())]
    NoPart {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}

/// A table that rows are appended to.
#[derive(Debug)]
pub struct Table {
    folder: PathBuf,
    /// Held until the table is dropped, or the process ends.
    _lock: File,
    /// The drives and nights whose rows are there.
    known: BTreeSet<(String, String)>,
    next: usize,
}

impl Table {
    /// The table in a folder; made where it is not there.
    ///
    /// # Errors
    /// Another run writes to it, it cannot be written, or one of its parts is of another table.
    pub fn open(folder: &Path) -> Result<Self, TableError> {
        let failed = |cause| TableError::Io { path: folder.to_owned(), cause };
        fs::create_dir_all(folder).map_err(failed)?;
        let lock = File::create(folder.join(LOCK)).map_err(failed)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(TableError::Locked { path: folder.to_owned() }),
            Err(TryLockError::Error(cause)) => return Err(failed(cause)),
        }
        let mut known = BTreeSet::new();
        let mut next = 0;
        for part in parts(folder)? {
            known.extend(keys_of(&part)?);
            let number = part.file_stem().and_then(|stem| stem.to_str()?.rsplit('-').next()?.parse::<usize>().ok());
            next = next.max(number.map_or(0, |number| number + 1));
        }
        Ok(Self { folder: folder.to_owned(), _lock: lock, known, next })
    }

    /// Whether a night's rows are there.
    #[must_use]
    pub fn has(&self, drive: &str, night: &str) -> bool {
        self.known.contains(&(drive.to_owned(), night.to_owned()))
    }

    /// Adds the rows of whole nights as a part of their own. When that fails, nothing of them is there.
    ///
    /// # Errors
    /// The part cannot be written.
    pub fn append(&mut self, rows: &[Row]) -> Result<(), TableError> {
        if rows.is_empty() {
            return Ok(());
        }
        let path = self.folder.join(format!("part-{:06}.{ENDING}", self.next));
        let bytes = to_parquet(rows).map_err(|cause| TableError::Io { path: path.clone(), cause })?;
        let written = atomic::write(&path, |out| out.write_all(&bytes));
        written.map_err(|cause| TableError::Io { path, cause })?;
        self.next += 1;
        self.known.extend(rows.iter().map(|row| (row.drive.clone(), row.night.clone())));
        Ok(())
    }
}

/// Every row of a table, in the order of drives and nights.
///
/// # Errors
/// A part cannot be read, or is of another table.
pub fn rows(folder: &Path) -> Result<Vec<Row>, TableError> {
    let mut all = Vec::new();
    for part in parts(folder)? {
        all.extend(rows_of(&part)?);
    }
    all.sort_by(|one: &Row, other: &Row| one.order().cmp(&other.order()));
    Ok(all)
}

fn parts(folder: &Path) -> Result<Vec<PathBuf>, TableError> {
    let failed = |cause| TableError::Io { path: folder.to_owned(), cause };
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if !is_hidden && path.extension().is_some_and(|ending| ending == ENDING) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// What a column has of a row, where it is a number.
type NumberOf = Box<dyn Fn(&Row) -> Option<f64>>;

/// What a column has of a row.
enum Column {
    Text(fn(&Row) -> Option<String>),
    Count(fn(&Row) -> Option<i64>),
    Number(NumberOf),
}

const DRIVE: &str = "drive";
const NIGHT: &str = "night";
const RECORDING: &str = "recording";
const VERDICT: &str = "verdict";
const LINK: &str = "link";
const WORDS: &str = "words";
const RECORDINGS: &str = "recordings";
const OF_LIMIT: &str = "of_limit";
const VERSION: &str = "version";
const SECONDS: &str = "seconds";

/// The columns in their order: what a night is, what is said of it, how much there is of every effect.
fn columns() -> Vec<(String, Column)> {
    let mut all = vec![
        (DRIVE.to_owned(), Column::Text(|row| Some(row.drive.clone()))),
        (NIGHT.to_owned(), Column::Text(|row| Some(row.night.clone()))),
        (RECORDING.to_owned(), Column::Text(|row| row.recording.clone())),
        (VERDICT.to_owned(), Column::Text(|row| Some(row.judgement.name().to_owned()))),
        (LINK.to_owned(), Column::Text(|row| row.link.map(|link| link.name().to_owned()))),
        (WORDS.to_owned(), Column::Text(|row| Some(row.words.clone()))),
        (RECORDINGS.to_owned(), Column::Count(|row| i64::try_from(row.recordings).ok())),
        (OF_LIMIT.to_owned(), Column::Number(Box::new(|row| row.of_limit))),
    ];
    for (index, signal) in MISFITS.into_iter().enumerate() {
        all.push((misfit_column(signal), Column::Number(Box::new(move |row| row.misfits[index]))));
    }
    for &parameter in Parameter::ALL {
        let of = move |row: &Row| row.strengths.iter().find(|one| one.parameter == parameter).copied();
        all.extend(
            column_of(parameter).map(|name| (name, Column::Number(Box::new(move |row| of(row).map(|one| one.value))))),
        );
        all.extend(
            deviation_of(parameter).map(|name| (name, Column::Number(Box::new(move |row| of(row).map(|one| one.std))))),
        );
    }
    all.push((VERSION.to_owned(), Column::Text(|row| Some(row.version.clone()))));
    all.push((SECONDS.to_owned(), Column::Number(Box::new(|row| Some(row.seconds)))));
    all
}

fn misfit_column(signal: recording::Signal) -> String {
    format!("misfit_{}", signal.name())
}

/// Rows as the bytes of a part.
///
/// # Errors
/// They cannot be packed.
pub fn to_parquet(rows: &[Row]) -> io::Result<Vec<u8>> {
    packed(rows).map_err(io::Error::other)
}

/// The rows of a part's bytes; `name` stands for it in messages.
///
/// # Errors
/// They are no part of such a table.
pub fn of_parquet(name: &str, bytes: Vec<u8>) -> Result<Vec<Row>, TableError> {
    read(Path::new(name), Bytes::from(bytes))
}

fn packed(rows: &[Row]) -> Result<Vec<u8>, ParquetError> {
    let columns = columns();
    let schema = schema(&columns)?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut file = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut file, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (_, column) in &columns {
        put(&mut group, column, rows)?;
    }
    group.close()?;
    writer.close()?;
    Ok(file)
}

/// The schema of some of the columns.
fn schema<'a>(columns: impl IntoIterator<Item = &'a (String, Column)>) -> Result<Type, ParquetError> {
    let field = |(name, column): &(String, Column)| {
        let physical = match column {
            Column::Text(_) => Physical::BYTE_ARRAY,
            Column::Count(_) => Physical::INT64,
            Column::Number(_) => Physical::DOUBLE,
        };
        let text = matches!(column, Column::Text(_));
        let field = Type::primitive_type_builder(name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_converted_type(if text { ConvertedType::UTF8 } else { ConvertedType::NONE })
            .with_logical_type(text.then_some(LogicalType::String));
        field.build().map(Arc::new)
    };
    let fields = columns.into_iter().map(field).collect::<Result<Vec<_>, ParquetError>>()?;
    Type::group_type_builder("fleet").with_fields(fields).build()
}

/// Writes the next column.
fn put(
    group: &mut SerializedRowGroupWriter<'_, &mut Vec<u8>>,
    column: &Column,
    rows: &[Row],
) -> Result<(), ParquetError> {
    fn present<V>(values: &[Option<V>]) -> Vec<i16> {
        values.iter().map(|value| i16::from(value.is_some())).collect()
    }
    let Some(mut out) = group.next_column()? else { return Ok(()) };
    match column {
        Column::Text(of) => {
            let values: Vec<Option<ByteArray>> =
                rows.iter().map(|row| of(row).map(|text| text.into_bytes().into())).collect();
            let there: Vec<ByteArray> = values.iter().flatten().cloned().collect();
            out.typed::<ByteArrayType>().write_batch(&there, Some(&present(&values)), None)?;
        }
        Column::Count(of) => {
            let values: Vec<Option<i64>> = rows.iter().map(of).collect();
            let there: Vec<i64> = values.iter().flatten().copied().collect();
            out.typed::<Int64Type>().write_batch(&there, Some(&present(&values)), None)?;
        }
        Column::Number(of) => {
            let values: Vec<Option<f64>> = rows.iter().map(of).collect();
            let there: Vec<f64> = values.iter().flatten().copied().collect();
            out.typed::<DoubleType>().write_batch(&there, Some(&present(&values)), None)?;
        }
    }
    out.close()
}

fn rows_of(part: &Path) -> Result<Vec<Row>, TableError> {
    read(part, File::open(part).map_err(|cause| TableError::Io { path: part.to_owned(), cause })?)
}

fn read<R: ChunkReader + 'static>(part: &Path, from: R) -> Result<Vec<Row>, TableError> {
    let no_part = |what: String| TableError::NoPart { path: part.to_owned(), what };
    let reader = SerializedFileReader::new(from).map_err(|error| no_part(error.to_string()))?;
    let records = reader.get_row_iter(None).map_err(|error| no_part(error.to_string()))?;
    records.map(|record| row_of(&record.map_err(|error| no_part(error.to_string()))?).map_err(no_part)).collect()
}

/// The nights of a part, whatever else it says of them: a table of years has many.
fn keys_of(part: &Path) -> Result<Vec<(String, String)>, TableError> {
    let no_part = |what: String| TableError::NoPart { path: part.to_owned(), what };
    let refused = |error: ParquetError| no_part(error.to_string());
    let file = File::open(part).map_err(|cause| TableError::Io { path: part.to_owned(), cause })?;
    let reader = SerializedFileReader::new(file).map_err(refused)?;
    let there = reader.metadata().file_metadata().schema_descr();
    let is_there = |name: &str| there.columns().iter().any(|column| column.name() == name);
    if let Some(name) = [WORDS, RECORDINGS, VERSION].into_iter().find(|name| !is_there(name)) {
        return Err(no_part(format!("no column `{name}`")));
    }
    let all = columns();
    let wanted = all.iter().filter(|(name, _)| [DRIVE, NIGHT, VERDICT].contains(&name.as_str()));
    let records = reader.get_row_iter(Some(schema(wanted).map_err(refused)?)).map_err(refused)?;
    let key = |record: Result<Record, ParquetError>| {
        let record = record.map_err(refused)?;
        judgement_of(&record).map_err(no_part)?;
        let text = |name| needed(&record, name).map_err(no_part);
        Ok((text(DRIVE)?, text(NIGHT)?))
    };
    records.map(key).collect()
}

/// A column of a record; `None` where there is none of this name.
fn field<'a>(record: &'a Record, name: &str) -> Option<&'a Field> {
    record.get_column_iter().find(|(known, _)| *known == name).map(|(_, field)| field)
}

fn text(record: &Record, name: &str) -> Result<Option<String>, String> {
    match field(record, name) {
        Some(Field::Str(text)) => Ok(Some(text.clone())),
        Some(Field::Null) => Ok(None),
        _ => Err(format!("no column `{name}` of text")),
    }
}

fn needed(record: &Record, name: &str) -> Result<String, String> {
    text(record, name)?.ok_or_else(|| format!("an empty cell in column `{name}`"))
}

fn judgement_of(record: &Record) -> Result<Judgement, String> {
    let named = needed(record, VERDICT)?;
    Judgement::parse(&named).ok_or_else(|| format!("`{named}` in column `{VERDICT}`"))
}

/// A record as a row, or which column is not as it should be.
fn row_of(record: &Record) -> Result<Row, String> {
    // A table of an earlier version may lack an effect, and then has none of it.
    let number = |name: &str| match field(record, name) {
        Some(Field::Double(value)) => Some(*value),
        _ => None,
    };
    let link = text(record, LINK)?.and_then(|name| Link::ALL.into_iter().find(|link| link.name() == name));
    let strength = |&parameter: &Parameter| {
        let value = number(&column_of(parameter)?)?;
        Some(Strength { parameter, value, std: number(&deviation_of(parameter)?).unwrap_or(f64::NAN) })
    };
    Ok(Row {
        drive: needed(record, DRIVE)?,
        night: needed(record, NIGHT)?,
        recording: text(record, RECORDING)?,
        judgement: judgement_of(record)?,
        link,
        words: needed(record, WORDS)?,
        recordings: match field(record, RECORDINGS) {
            Some(Field::Long(count)) => usize::try_from(*count).unwrap_or(0),
            _ => return Err(format!("no column `{RECORDINGS}` of whole numbers")),
        },
        of_limit: number(OF_LIMIT),
        misfits: MISFITS.map(|signal| number(&misfit_column(signal))),
        strengths: Parameter::ALL.iter().filter_map(strength).collect(),
        version: needed(record, VERSION)?,
        seconds: number(SECONDS).unwrap_or(0.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(drive: &str, night: &str, recording: Option<&str>) -> Row {
        Row {
            drive: drive.into(),
            night: night.into(),
            recording: recording.map(str::to_owned),
            judgement: if recording.is_some() { Judgement::Unusable } else { Judgement::Changed },
            link: (recording.is_none()).then_some(Link::FlowAndChambers),
            words: "öl läuft vorbei".into(),
            recordings: 2,
            of_limit: Some(1.5),
            misfits: [None, Some(1.25), None, Some(1.0)],
            strengths: vec![Strength { parameter: Parameter::InternalLeakage, value: 2e-12, std: 1e-14 }],
            version: "0.1.0".into(),
            seconds: 0.25,
        }
    }

    #[test]
    fn rows_come_back_as_they_were_appended_in_the_order_of_drives_and_nights() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table");
        let (late, early, bad) = (row("b", "2", None), row("a", "1", None), row("b", "2", Some("x.csv")));
        let mut table = Table::open(&path).unwrap();
        table.append(&[late.clone(), bad.clone()]).unwrap();
        table.append(std::slice::from_ref(&early)).unwrap();
        assert!(table.has("b", "2") && !table.has("b", "1"));
        drop(table);
        assert_eq!(rows(&path).unwrap(), [early, late, bad]);
        let mut again = Table::open(&path).unwrap();
        assert!(again.has("a", "1") && again.has("b", "2"));
        again.append(&[row("c", "1", None)]).unwrap();
        assert_eq!(rows(&path).unwrap().len(), 4);
    }

    #[test]
    fn a_table_that_is_written_to_or_is_another_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let held = Table::open(folder.path()).unwrap();
        assert!(matches!(Table::open(folder.path()), Err(TableError::Locked { .. })));
        drop(held);
        fs::write(folder.path().join("mine.parquet"), "no parquet").unwrap();
        let refused = Table::open(folder.path()).unwrap_err();
        assert!(refused.to_string().contains("mine.parquet"), "{refused}");
    }
}
