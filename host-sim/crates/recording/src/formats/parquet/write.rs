//! Writing Parquet with snappy: a column of doubles for each column, under its header.

use std::io;
use std::sync::Arc;

use parquet::basic::{Compression, Repetition, Type as Physical};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::formats::sheet::Sheet;

/// The bytes of a file; null stands for a missing value.
pub(crate) fn write(sheet: &Sheet<'_>) -> io::Result<Vec<u8>> {
    bytes(sheet).map_err(io::Error::other)
}

fn bytes(sheet: &Sheet<'_>) -> Result<Vec<u8>, ParquetError> {
    let field = |header: &str| {
        let field = Type::primitive_type_builder(header, Physical::DOUBLE).with_repetition(Repetition::OPTIONAL);
        field.build().map(Arc::new)
    };
    let fields = sheet.columns.iter().map(|column| field(&column.header)).collect::<Result<Vec<_>, ParquetError>>()?;
    let schema = Type::group_type_builder("schema").with_fields(fields).build()?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut file = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut file, Arc::new(schema), Arc::new(properties))?;
    let mut rows = writer.next_row_group()?;
    for column in &sheet.columns {
        let present: Vec<i16> = column.values().map(|value| i16::from(value.is_some())).collect();
        let values: Vec<f64> = column.values().flatten().collect();
        let Some(mut out) = rows.next_column()? else { break };
        out.typed::<DoubleType>().write_batch(&values, Some(&present), None)?;
        out.close()?;
    }
    rows.close()?;
    writer.close()?;
    Ok(file)
}
