//! What stands in a file, whether or not its columns are known.

use std::io::Read;
use std::path::Path;

use super::format::Format;
use super::source::{open, recognised};
use super::surveyed::{MOST_COLUMNS, MOST_ROWS, Surveyed};
use super::text::clock::is_stamp;
use super::text::decimal_mark::DecimalMark;
use super::text::heading::Heading;
use super::text::lines::{Input, Lines};
use crate::error::RecordingError;
use crate::files::source_error::Place;

/// The columns of a file.
///
/// # Errors
/// The file cannot be read, or has no columns.
pub fn survey(path: &Path) -> Result<Vec<Surveyed>, RecordingError> {
    let (name, file) = open(path)?;
    survey_from(&name, file)
}

/// The same from any source; `name` stands for the file in messages.
pub fn survey_from(name: &str, input: impl Read) -> Result<Vec<Surveyed>, RecordingError> {
    of(name, Box::new(input))
}

fn of(name: &str, input: Input<'_>) -> Result<Vec<Surveyed>, RecordingError> {
    let (format, all) = recognised(name, input)?;
    match format {
        Format::Text => of_text(name, all),
        #[cfg(feature = "gzip")]
        Format::Gzip => of(name, super::gzip::unpacked(name, all)?),
        #[cfg(feature = "xlsx")]
        Format::Xlsx => {
            let text = super::xlsx::text(name, super::source::held(name, all)?, &crate::ChannelMap::default())?;
            of_text(name, Box::new(std::io::Cursor::new(text)))
        }
        #[cfg(feature = "mat")]
        Format::Mat => super::mat::survey(name, &super::source::held(name, all)?),
        #[cfg(feature = "mdf4")]
        Format::Mdf4 => super::mdf4::survey(name, &super::source::held(name, all)?),
        #[cfg(feature = "parquet")]
        Format::Parquet => super::parquet::survey(name, super::source::held(name, all)?),
        #[allow(unreachable_patterns, reason = "reached where the program was built without a feature")]
        format => Err(RecordingError::FeatureAbsent { place: Place::file(name), format }),
    }
}

fn of_text(name: &str, input: Input<'_>) -> Result<Vec<Surveyed>, RecordingError> {
    let mut lines = Lines::new(name, input);
    let (mut heading, mut splitter) = Heading::read(&mut lines)?;
    heading.look_below(&mut lines, &mut splitter)?;
    let mark = DecimalMark::new(heading.separator);
    let mut columns: Vec<Surveyed> = (0..heading.names.len().min(MOST_COLUMNS))
        .map(|index| Surveyed {
            name: heading.names[index].clone(),
            unit: heading.unit(index),
            is_stamped: heading.is_stamped(index),
            values: Vec::new(),
        })
        .collect();
    for _ in 0..MOST_ROWS {
        // What is wrong with a row is said when the file is read.
        let Ok(Some(line)) = lines.next() else { break };
        let Ok(cells) = splitter.split(line) else { break };
        for (index, column) in columns.iter_mut().enumerate() {
            let text = cells.get(index);
            column.is_stamped &= is_stamp(text);
            column.values.extend(mark.lenient(text).filter(|value| value.is_finite()));
        }
    }
    Ok(columns)
}
