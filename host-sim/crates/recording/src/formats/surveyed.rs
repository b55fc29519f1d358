//! A column of a file, whether or not it is known.

#[cfg(any(feature = "mat", feature = "mdf4", feature = "parquet"))]
use super::columns::{Contents, Offered};
use crate::signal::{Signal, split_header};
use crate::unit::{Dimension, Unit};
use crate::unit_in_name::split_suffix;

/// Most rows and columns that are looked at.
pub(crate) const MOST_ROWS: usize = 20_000;
pub(crate) const MOST_COLUMNS: usize = 256;

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

/// The series that a file without lines offers.
#[cfg(any(feature = "mat", feature = "mdf4", feature = "parquet"))]
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
