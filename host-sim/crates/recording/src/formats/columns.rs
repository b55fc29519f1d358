//! From the number series and times of a file without lines to a recording.
//!
//! All such formats are converted here, by the same rules:
//!
//! - A series is known by its name with its unit in brackets (`position [mm]`), by a name and a unit that the format stores
//!   separately, or by a unit after an underscore (`position_mm`); or it is mapped. Series that are not known are never decoded.
//! - Series belong to *bases*, each with its own times: the base's clock, or else the series of the base that is known as time.
//! - All known series of one base form a table: a row with a missing number (NaN, null) or with the time of the row before is
//!   left out and counted, like a row with an empty cell in a text. Series of several bases are interpolated like the channels of
//!   an export.

use super::resample::{self, Sampled};
use crate::channel_map::ChannelMap;
use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::formats::coarse_stamps::CoarseStamps;
use crate::formats::text::lines::{MAX_COLUMNS, most_rows};
use crate::header::{Assignment, Offer, assign, is_same_unit, leave_unused, one};
use crate::recording::{At, Column, LeftOut, Note, Recording};
use crate::signal::{Signal, split_header};
use crate::unit::{Dimension, Unit};
use crate::unit_in_name::split_suffix;

/// A series of numbers that a file offers.
#[derive(Clone, Debug)]
pub(crate) struct Offered {
    /// Its name as it stands in the file.
    pub(crate) name: String,
    /// Shorter names for it.
    pub(crate) also: Vec<String>,
    /// Its unit, where the file stores one beside the name.
    pub(crate) unit: Option<String>,
    /// Whether this unit follows from the type of the numbers, and so is the right one whatever the name says.
    pub(crate) is_typed: bool,
    /// Index of the file's base that it belongs to.
    pub(crate) base: usize,
    /// Whether the file itself, not the name, marks it as its base's clock; its unit is then s, where the file gives none.
    pub(crate) clock: bool,
}

/// A file that offers series.
pub(crate) trait Contents {
    /// The word for a series in messages.
    const KIND: &'static str;
    /// The series in the order of the file.
    fn offered(&self) -> &[Offered];
    /// The number of values on a base.
    fn rows(&self, base: usize) -> usize;
    /// What a series holds, where it does not hold numbers.
    fn instead(&self, _: usize) -> Option<&'static str> {
        None
    }
    /// The values of a series in the unit of the file; NaN where it has none.
    fn values(&self, index: usize) -> Result<Vec<f64>, RecordingError>;
}

/// The recording that a file holds.
pub(crate) fn recording<C: Contents>(name: &str, contents: &C, map: &ChannelMap) -> Result<Recording, RecordingError> {
    let offered = contents.offered();
    if offered.len() > MAX_COLUMNS {
        return Err(RecordingError::TooManyColumns { place: Place::file(name), most: MAX_COLUMNS });
    }
    let mut offers: Vec<Offer> = offered.iter().map(offer).collect();
    leave_unused(&mut offers, map);
    let file = File { name, contents, offers };
    let clocks = file.clocks(map)?;
    let is_time = |index: &usize| clocks.iter().any(|(at, _)| at == index);
    let others: Vec<usize> = (0..offered.len()).filter(|index| !is_time(index) && !offered[*index].clock).collect();
    let offers: Vec<Offer> = others.iter().map(|&index| file.offers[index].clone()).collect();
    let place = |index: usize| file.place(others[index]);
    let Assignment { known, ignored, notes } = assign(&offers, &map.without(Signal::Time), &Place::file(name), place)?;
    let known: Vec<(usize, Column)> = known
        .into_iter()
        .filter(|(_, column)| column.signal != Signal::Time)
        .map(|(index, column)| (others[index], titled(column, &offered[others[index]], map)))
        .collect();
    let present = || offered.iter().map(|offered| offered.name.clone()).collect::<Vec<_>>();
    // Each series may have its own times.
    let most = most_rows(2 * known.len());
    let mut pairs = Vec::new();
    for (index, column) in known {
        if let Some(found) = contents.instead(index) {
            let (place, header) = (file.place(index), offered[index].name.clone());
            return Err(RecordingError::NotNumbers { place, header, found: found.to_owned() });
        }
        let Some(clock) = clocks.iter().find(|(at, _)| offered[*at].base == offered[index].base) else {
            let header = offered[index].name.clone();
            return Err(RecordingError::NoTimes { place: file.place(index), header, present: present() });
        };
        let rows = contents.rows(offered[index].base);
        if rows > most {
            return Err(RecordingError::TooManyRows { place: file.place(index), most });
        }
        pairs.push((clock, index, column));
    }
    let Some(((first, _), ..)) = pairs.first() else {
        return Err(RecordingError::NothingKnown { place: Place::file(name), present: present() });
    };
    if pairs.iter().all(|((clock, _), ..)| *clock == *first) {
        file.table(pairs, ignored, notes)
    } else {
        file.together(pairs, ignored, notes)
    }
}

/// The ways to name a series.
fn offer(offered: &Offered) -> Offer {
    let own_unit = || offered.unit.as_deref().map(str::trim).filter(|unit| !unit.is_empty()).map(str::to_owned);
    let mut names = Vec::new();
    for name in std::iter::once(&offered.name).chain(&offered.also) {
        let (short, in_name) = split_header(name);
        let unit = match (in_name, own_unit()) {
            (Some(in_name), Some(own)) if !offered.is_typed && !is_same_unit(in_name, &own) => {
                // Neither of the two can be believed.
                Some(format!("{in_name} in its name, {own} beside it"))
            }
            (Some(in_name), None) => Some(in_name.to_owned()),
            (_, own) => own,
        };
        names.push((name.clone(), own_unit()));
        names.push((short.to_owned(), unit));
        let suffix = split_suffix(name).filter(|_| in_name.is_none() && offered.unit.is_none());
        names.extend(suffix.map(|(short, unit)| (short.to_owned(), Some(unit.symbol().to_owned()))));
    }
    Offer { header: offered.name.clone(), names, clash: None }
}

/// A column under the name by which it is known, with its unit, so that a text written from it can be read again.
fn titled(mut column: Column, offered: &Offered, map: &ChannelMap) -> Column {
    if column.from_angle.is_some() {
        return column;
    }
    let mapped = map.get(column.signal).map(|mapping| split_header(&mapping.header).0);
    let name = mapped.unwrap_or(column.signal.name());
    let unit = column.unit.symbol();
    let bare =
        Unit::parse(unit).is_none_or(|unit| unit.dimension() == Dimension::Ratio && unit == column.signal.si_unit());
    let told = offered.unit.is_some() || split_header(&offered.name).1.is_some();
    column.header = if bare && !told { name.to_owned() } else { format!("{name} [{unit}]") };
    column
}

/// A file that is being read.
struct File<'a, C> {
    name: &'a str,
    contents: &'a C,
    offers: Vec<Offer>,
}

/// A known series, with the clock of its base.
type Known<'a> = (&'a (usize, Column), usize, Column);

impl<C: Contents> File<'_, C> {
    fn place(&self, index: usize) -> Place {
        Place::part(self.name, &format!("{} `{}`", C::KIND, self.contents.offered()[index].name))
    }

    /// The time series of each base: the series that is mapped to time or known as time, or else the base's clock.
    fn clocks(&self, map: &ChannelMap) -> Result<Vec<(usize, Column)>, RecordingError> {
        let mut clocks: Vec<(usize, Column)> = Vec::new();
        // A machine file may map the time of another logger's files.
        let mapping = map.get(Signal::Time);
        let is_here = mapping.is_some_and(|mapping| self.offers.iter().any(|offer| offer.is_meant_by(mapping)));
        let mapping = mapping.filter(|mapping| mapping.required || is_here);
        let mut mapped = false;
        for (index, offered) in self.contents.offered().iter().enumerate() {
            let named = one(&self.offers[index], Signal::Time, mapping, || self.place(index));
            mapped |= matches!(named, Ok(Some(_)));
            let found = if offered.clock {
                let text = offered.unit.as_deref().map(str::trim).filter(|text| !text.is_empty()).unwrap_or("s");
                let unit = Unit::parse(text).filter(|unit| unit.dimension() == Dimension::Time);
                let (signal, header, place) = (Signal::Time, offered.name.clone(), self.place(index));
                let unit =
                    unit.ok_or_else(|| RecordingError::UnknownUnit { place, signal, header, unit: text.to_owned() })?;
                Some(Column::of_file(String::new(), signal, unit))
            } else {
                named?
            };
            let Some(mut column) = found else { continue };
            if let Some(found) = self.contents.instead(index) {
                let (place, header) = (self.place(index), offered.name.clone());
                return Err(RecordingError::NotNumbers { place, header, found: found.to_owned() });
            }
            column.header = format!("time [{}]", column.unit);
            let before = clocks.iter().position(|(at, _)| self.contents.offered()[*at].base == offered.base);
            match before {
                None => clocks.push((index, column)),
                // The user's mapping takes precedence over the clock that the file names.
                Some(at) if self.contents.offered()[clocks[at].0].clock && mapping.is_some() => {
                    clocks[at] = (index, column);
                }
                Some(_) if offered.clock => {}
                Some(at) => {
                    let first = self.contents.offered()[clocks[at].0].name.clone();
                    let (place, signal, second) = (self.place(index), Signal::Time, offered.name.clone());
                    return Err(RecordingError::DuplicateColumn { place, signal, first, second });
                }
            }
        }
        match mapping.filter(|mapping| mapping.required && !mapped) {
            Some(mapping) => {
                let present = self.offers.iter().map(|offer| offer.header.clone()).collect();
                let (place, header) = (Place::file(self.name), mapping.header.clone());
                Err(RecordingError::MappedColumnAbsent { place, signal: Signal::Time, header, present })
            }
            None => Ok(clocks),
        }
    }

    /// The values of a series in SI units; NaN where it has none.
    fn si(&self, index: usize, column: &Column) -> Result<Vec<f64>, RecordingError> {
        let offered = &self.contents.offered()[index];
        let mut values = self.contents.values(index)?;
        let expected = self.contents.rows(offered.base);
        if values.len() != expected {
            let (place, header, found) = (self.place(index), offered.name.clone(), values.len());
            return Err(RecordingError::LengthMismatch { place, header, found, expected });
        }
        for (row, value) in values.iter_mut().enumerate() {
            if value.is_nan() {
                continue;
            }
            let Some(si) = column.read(*value) else { return Err(column.out_of_reach(self.row(index, row), *value)) };
            if si.is_infinite() {
                let place = self.row(index, row);
                return Err(RecordingError::NotFinite {
                    place,
                    header: offered.name.clone(),
                    found: value.to_string(),
                });
            }
            *value = si;
        }
        Ok(values)
    }

    fn row(&self, index: usize, row: usize) -> Place {
        Place::row_of(self.name, &format!("{} `{}`", C::KIND, self.contents.offered()[index].name), row + 1)
    }

    /// Series of one base, row by row.
    fn table(
        &self,
        known: Vec<Known<'_>>,
        ignored: Vec<String>,
        mut notes: Vec<Note>,
    ) -> Result<Recording, RecordingError> {
        let mut columns = Vec::new();
        let mut clock = 0;
        if let Some(((index, time), ..)) = known.first() {
            clock = *index;
            columns.push(Column { values: self.si(*index, time)?, ..time.clone() });
        }
        for (_, index, column) in known {
            columns.push(Column { values: self.si(index, &column)?, ..column });
        }
        let rows = columns[0].values.len();
        let (mut kept, mut previous_s) = (0, f64::NEG_INFINITY);
        let (mut repeated, mut incomplete) = (None, None);
        let mut left_out = LeftOut::default();
        for row in 0..rows {
            let time_s = columns[0].values[row];
            let lacks = columns.iter().any(|column| column.values[row].is_nan());
            if !lacks && time_s < previous_s {
                let place = self.row(clock, row);
                return Err(RecordingError::TimeBackwards { place, previous_s, found_s: time_s });
            }
            if lacks || time_s <= previous_s {
                let why = if lacks { &mut incomplete } else { &mut repeated };
                why.get_or_insert((0, At::Row(row + 1))).0 += 1;
                left_out.after.push(kept);
                left_out
                    .cells
                    .extend(columns.iter().map(|column| Some(column.values[row]).filter(|value| !value.is_nan())));
                continue;
            }
            previous_s = time_s;
            for column in &mut columns {
                column.values[kept] = column.values[row];
            }
            kept += 1;
        }
        for column in &mut columns {
            column.values.truncate(kept);
        }
        if repeated.is_some() && kept > 1 {
            let mut series: Vec<&mut Vec<f64>> = columns.iter_mut().map(|column| &mut column.values).collect();
            if let Some(mut coarse) = CoarseStamps::found(&mut series, &mut left_out) {
                notes.extend(coarse.spread(series[0], true));
                repeated = None;
                kept = columns[0].values.len();
            }
        }
        if kept < 2 {
            return Err(RecordingError::TooFewRows { place: Place::file(self.name), rows: kept, skipped: rows - kept });
        }
        let name = &self.contents.offered()[clock].name;
        if columns[0].is_index(name) {
            return Err(RecordingError::Index { place: self.place(clock), header: name.clone() });
        }
        notes.extend(repeated.map(|(rows, first)| Note::DuplicateTimes { rows, first }));
        notes.extend(incomplete.map(|(rows, first)| Note::IncompleteRows { rows, first }));
        let mut recording = Recording::assemble(self.name, columns, ignored, notes);
        recording.left_out = left_out;
        Ok(recording)
    }

    /// Joins series of several bases, at the times of the first base.
    fn together(
        &self,
        known: Vec<Known<'_>>,
        ignored: Vec<String>,
        notes: Vec<Note>,
    ) -> Result<Recording, RecordingError> {
        let mut repeated = None;
        let mut channels = Vec::new();
        for ((clock, time), index, column) in known {
            let times = self.si(*clock, time)?;
            let values = self.si(index, &column)?;
            let mut channel = Sampled::new(column);
            for (row, (&time_s, &value)) in times.iter().zip(&values).enumerate() {
                if time_s.is_nan() || value.is_nan() {
                    continue;
                }
                let pushed = channel.push(time_s, value).map_err(|previous_s| {
                    let place = self.row(*clock, row);
                    RecordingError::TimeBackwards { place, previous_s, found_s: time_s }
                })?;
                if !pushed {
                    repeated.get_or_insert((0, At::Row(row + 1))).0 += 1;
                }
            }
            channels.push(channel);
        }
        resample::together(self.name, channels, ignored, notes, repeated)
    }
}
