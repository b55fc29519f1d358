//! What stands in a file, whether or not its columns are known.

use std::io::{Cursor, Read};
use std::path::Path;

use super::columns::{Contents, Offered};
use super::format::{Format, HEAD};
use super::read::{open, unreadable};
use super::text::clock::is_stamp;
use super::text::decimal_mark::DecimalMark;
use super::text::heading::Heading;
use super::text::lines::{Input, Lines};
use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::signal::{Signal, split_header};
use crate::unit::{Dimension, Unit};
use crate::unit_in_name::split_suffix;

/// Most rows and columns that are looked at.
const MOST_ROWS: usize = 20_000;
const MOST_COLUMNS: usize = 256;

/// A column of a file.
#[derive(Clone, Debug)]
pub struct Surveyed {
    /// Its name as it stands in the file.
    pub name: String,
    /// Its unit, where it has a known one.
    pub unit: Option<Unit>,
    /// Whether its cells are dates or times of day.
    pub is_stamped: bool,
    /// Its numbers, in its unit, as far as they are numbers.
    pub values: Vec<f64>,
}

impl Surveyed {
    /// The name with the unit, as a map has it.
    #[must_use]
    pub fn header(&self) -> String {
        let told = split_header(&self.name).1.is_some() || split_suffix(&self.name).is_some();
        match self.unit {
            Some(unit) if !told => format!("{} [{unit}]", self.name),
            _ => self.name.clone(),
        }
    }

    pub(crate) fn dimension(&self) -> Option<Dimension> {
        self.unit.map(Unit::dimension)
    }

    /// Whether its unit is one of this signal.
    pub(crate) fn suits(&self, signal: Signal) -> bool {
        self.dimension().is_some_and(|own| signal.dimensions().contains(&own))
    }

    /// Whether it rises from row to row; several rows may share a value.
    pub(crate) fn rises(&self) -> bool {
        let first_and_last = self.values.first().zip(self.values.last());
        self.is_stamped
            || (self.values.windows(2).all(|pair| pair[0] <= pair[1])
                && first_and_last.is_some_and(|(first, last)| first < last))
    }

    /// The largest less the smallest of its values.
    pub(crate) fn spread(&self) -> f64 {
        let ends = self
            .values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)));
        ends.1 - ends.0
    }

    /// Whether its name without the unit has this word: as a part, or as a whole where it is short.
    pub(crate) fn is_called(&self, word: &str) -> bool {
        let (name, _) = split_header(&self.name);
        let name = split_suffix(name).map_or(name, |(short, _)| short).to_lowercase();
        if word.chars().count() > 3 {
            return name.contains(word);
        }
        let is_edge = |character: Option<char>| character.is_none_or(|character| !character.is_alphanumeric());
        name.match_indices(word)
            .any(|(at, _)| is_edge(name[..at].chars().next_back()) && is_edge(name[at + word.len()..].chars().next()))
    }
}

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

fn of(name: &str, mut input: Input<'_>) -> Result<Vec<Surveyed>, RecordingError> {
    let mut head = Vec::new();
    (&mut input).take(HEAD as u64).read_to_end(&mut head).map_err(|source| unreadable(name, source))?;
    let format =
        Format::of_content(&head).map_err(|what| RecordingError::Unsupported { place: Place::file(name), what })?;
    let all = Cursor::new(head).chain(input);
    match format {
        Format::Text => of_text(name, Box::new(all)),
        #[cfg(feature = "gzip")]
        Format::Gzip => of(name, super::gzip::unpacked(name, all)?),
        #[cfg(feature = "xlsx")]
        Format::Xlsx => {
            let text = super::xlsx::text(name, super::read::held(name, all)?, &crate::ChannelMap::default())?;
            of_text(name, Box::new(Cursor::new(text)))
        }
        #[cfg(feature = "mat")]
        Format::Mat => super::mat::survey(name, &super::read::held(name, all)?),
        #[cfg(feature = "mdf4")]
        Format::Mdf4 => super::mdf4::survey(name, &super::read::held(name, all)?),
        #[cfg(feature = "parquet")]
        Format::Parquet => super::parquet::survey(name, super::read::held(name, all)?),
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

/// The series that a file without lines offers.
#[cfg_attr(
    not(any(feature = "mat", feature = "mdf4", feature = "parquet")),
    expect(dead_code, reason = "no format has series")
)]
pub(crate) fn of_contents<C: Contents>(contents: &C) -> Vec<Surveyed> {
    let surveyed = |(index, offered): (usize, &Offered)| {
        let name = &offered.name;
        let (_, in_name) = split_header(name);
        let unit = in_name.and_then(Unit::parse).or_else(|| split_suffix(name).map(|(_, unit)| unit));
        let unit = offered.unit.as_deref().and_then(Unit::parse).or(unit);
        let unit = unit.or_else(|| offered.clock.then(|| Unit::si(Dimension::Time)));
        let mut values =
            if contents.instead(index).is_some() { Vec::new() } else { contents.values(index).unwrap_or_default() };
        values.truncate(MOST_ROWS);
        values.retain(|value| value.is_finite());
        Surveyed { name: name.clone(), unit, is_stamped: false, values }
    };
    // A clock that the file itself tells needs no line of a map.
    let all = contents.offered().iter().enumerate().filter(|(_, offered)| !offered.clock);
    all.take(MOST_COLUMNS).map(surveyed).filter(|column| !column.values.is_empty()).collect()
}
