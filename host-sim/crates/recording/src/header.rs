//! From header texts to the signals they hold.

use crate::channel_map::{ChannelMap, Mapping, PressureZero, Scale};
use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::formats::text_fault::{TextFault, UnitClash};
use crate::recording::{Column, Note};
use crate::signal::{Signal, split_header};
use crate::unit::Unit;
use crate::unit_in_name::split_suffix;

/// A header of a file, and the names by which it can be known.
#[derive(Clone, Debug)]
pub(crate) struct Offer {
    /// The header as it is written back; messages use it too.
    pub(crate) header: String,
    /// Names with their units; the first one that fits counts.
    pub(crate) names: Vec<(String, Option<String>)>,
    /// Where its name and a row of units say different units.
    pub(crate) clash: Option<Box<UnitClash>>,
}

/// A column that a mapping refers to.
#[derive(Debug)]
struct Meant {
    /// Its unit, from the mapping, or else from the file.
    unit: Option<String>,
}

impl Offer {
    /// The column of any format that has this header.
    pub(crate) fn by_header(header: &str) -> Self {
        let mut offer = Self::beside(header, None);
        offer.names.extend(split_suffix(header).map(|(name, unit)| (name.to_owned(), Some(unit.symbol().to_owned()))));
        offer
    }

    /// The header of a plain recording, and its unit where a row of its own has it.
    pub(crate) fn beside(header: &str, beside: Option<&str>) -> Self {
        let (name, unit) = split_header(header);
        let owned = |unit: Option<&str>| unit.map(str::to_owned);
        let mut names = vec![(name.to_owned(), owned(unit.or(beside)))];
        names.extend((name != header).then(|| (header.to_owned(), owned(beside))));
        // Written back, the unit stands with the name.
        let written = match (unit, beside) {
            (None, Some(beside)) => format!("{header} [{beside}]"),
            _ => header.to_owned(),
        };
        Self { header: written, names, clash: beside.and_then(|beside| clash(header, beside)) }
    }

    /// The unit that a mapping gives this column, if the mapping refers to this column.
    fn meant_by(&self, mapping: &Mapping) -> Option<Meant> {
        let given = mapping.header.trim();
        let whole = |(own_name, own_unit): &(String, Option<String>)| {
            (own_name == given).then(|| Meant { unit: own_unit.clone().or_else(|| self.unit_in_a_name()) })
        };
        let (name, unit) = split_header(given);
        let parted = |(own_name, own_unit): &(String, Option<String>)| match (unit, own_unit) {
            // A column without a name, such as the index that pandas writes, is nobody's.
            _ if own_name != name || name.is_empty() => None,
            (Some(unit), Some(own)) if !is_same_unit(unit, own) => None,
            (unit, own) => {
                let unit = unit.map(str::to_owned).or_else(|| own.clone());
                Some(Meant { unit: unit.or_else(|| self.unit_in_a_name()) })
            }
        };
        if unit.is_none() { self.names.iter().find_map(whole) } else { self.names.iter().find_map(parted) }
    }

    /// Whether a mapping refers to this column.
    pub(crate) fn is_meant_by(&self, mapping: &Mapping) -> bool {
        self.meant_by(mapping).is_some()
    }

    /// Its values are times in s, whatever its header says.
    pub(crate) fn is_in_seconds(&mut self) {
        for (_, unit) in &mut self.names {
            *unit = Some("s".to_owned());
        }
        self.clash = None;
        let name = split_header(&self.header).0;
        self.header = format!("{name} [s]");
    }

    /// Whether one of its names is that of the signal.
    pub(crate) fn is_named(&self, signal: Signal) -> bool {
        self.names.iter().any(|(name, _)| Signal::parse(name) == Some(signal))
    }

    /// The unit that one of its names ends with, as in `Kolbenweg_mm`.
    fn unit_in_a_name(&self) -> Option<String> {
        self.names.iter().find_map(|(_, unit)| unit.clone())
    }
}

/// The unit in a header and the one beside it, where they differ. Behind an underscore any letter may stand, so there only a unit of the same quantity, or an
/// unknown one, contradicts it.
pub(crate) fn clash(header: &str, beside: &str) -> Option<Box<UnitClash>> {
    let in_name = if let Some(in_name) = split_header(header).1 {
        in_name
    } else {
        let suffix = split_suffix(header)?.1;
        let is_other = Unit::parse(beside).is_some_and(|unit| unit.dimension() != suffix.dimension());
        if is_other {
            return None;
        }
        suffix.symbol()
    };
    let differ = !is_same_unit(in_name, beside);
    differ.then(|| Box::new(UnitClash { in_name: in_name.to_owned(), beside: beside.to_owned(), beside_at: None }))
}

/// Takes from the columns that are left unused the names by which they would be known.
pub(crate) fn leave_unused(offers: &mut [Offer], map: &ChannelMap) {
    let unused: Vec<Mapping> = map.unused().iter().map(|header| Mapping::column(header.as_str(), false)).collect();
    let is_unused = |offer: &Offer| unused.iter().any(|unused| offer.is_meant_by(unused));
    let is_mapped = |offer: &Offer| map.iter().any(|(_, mapping)| offer.is_meant_by(mapping));
    for offer in offers.iter_mut().filter(|offer| is_unused(offer) && !is_mapped(offer)) {
        offer.names.clear();
    }
}

/// Whether two texts spell the same unit.
pub(crate) fn is_same_unit(one: &str, other: &str) -> bool {
    one == other || Unit::parse(one).is_some_and(|unit| Unit::parse(other) == Some(unit))
}

/// The known columns among those offered, with their index, and the headers of the others.
#[derive(Debug, Default)]
pub(crate) struct Assignment {
    pub(crate) known: Vec<(usize, Column)>,
    pub(crate) ignored: Vec<String>,
    pub(crate) notes: Vec<Note>,
}

/// Finds the signals among the columns; `place` gives the place of an offer's header.
pub(crate) fn assign(
    offers: &[Offer],
    map: &ChannelMap,
    file: &Place,
    place: impl Fn(usize) -> Place,
) -> Result<Assignment, RecordingError> {
    let mut assignment = Assignment::default();
    let mut mapped = Vec::new();
    let mut without_unit: Option<(Place, Vec<(Signal, String)>)> = None;
    for (signal, mapping) in map.iter() {
        let found = offers.iter().position(|offer| offer.is_meant_by(mapping));
        // What a machine file says of one logger's columns does not stand in the way of another's that are known by their names.
        let is_unusable = |index: usize| {
            let meant = offers[index].meant_by(mapping).and_then(|meant| meant.unit);
            let fits = unit_of(signal, mapping.scale, &mapping.header, meant.as_deref(), || file.clone()).is_ok();
            !fits && (0..offers.len()).any(|other| other != index && offers[other].is_named(signal))
        };
        match found.filter(|index| mapping.required || !is_unusable(*index)) {
            Some(index) => {
                let is_alike = |other: &usize| {
                    offers[*other].header == offers[index].header && offers[*other].is_meant_by(mapping)
                };
                if let Some(second) = (index + 1..offers.len()).find(is_alike) {
                    return Err(twice(signal, offers, [index, second], place(second)));
                }
                mapped.push((index, signal, mapping));
            }
            None if mapping.required => {
                let present = offers.iter().map(|offer| offer.header.clone()).collect();
                let header = mapping.header.clone();
                return Err(RecordingError::MappedColumnAbsent { place: file.clone(), signal, header, present });
            }
            None => assignment.notes.push(Note::MappedColumnAbsent { signal, header: mapping.header.clone() }),
        }
    }
    for (index, offer) in offers.iter().enumerate() {
        let by_map = mapped.iter().find(|(at, ..)| *at == index);
        let found = match by_map {
            Some(&(_, signal, mapping)) => offer.meant_by(mapping).map(|meant| (signal, meant.unit, mapping.scale)),
            None => offer
                .names
                .iter()
                .find_map(|(name, unit)| Signal::parse(name).map(|signal| (signal, unit.clone(), None)))
                .filter(|(signal, ..)| mapped.iter().all(|(_, other, _)| other != signal)),
        };
        let Some((signal, unit, scale)) = found else {
            // The index that pandas writes has no name.
            assignment.ignored.extend(Some(offer.header.clone()).filter(|header| !header.is_empty()));
            continue;
        };
        if let Some(units) = &offer.clash {
            let fault = TextFault::UnitsDiffer { header: offer.header.clone(), units: units.clone() };
            return Err(RecordingError::Text { place: place(index), fault });
        }
        let unit = match unit_of(signal, scale, &offer.header, unit.as_deref(), || place(index)) {
            // All columns without a unit are collected, so that the user learns of all of them at once.
            Err(RecordingError::MissingUnit { place, columns }) => {
                without_unit.get_or_insert_with(|| (place, Vec::new())).1.extend(columns);
                continue;
            }
            other => other?,
        };
        let is_absolute = signal.is_pressure() && map.pressure == PressureZero::Absolute;
        let unit = if is_absolute { unit.absolute() } else { unit };
        if let Some((first, _)) = assignment.known.iter().find(|(_, column)| column.signal == signal) {
            return Err(twice(signal, offers, [*first, index], place(index)));
        }
        let header = offer.header.clone();
        assignment.known.push((index, Column::of_file(header, signal, unit)));
    }
    if let Some((place, columns)) = without_unit {
        return Err(RecordingError::MissingUnit { place, columns });
    }
    through_linkage(&mut assignment, map);
    Ok(assignment)
}

/// The error of two columns for one signal.
fn twice(signal: Signal, offers: &[Offer], [first, second]: [usize; 2], place: Place) -> RecordingError {
    let [one, other] = [first, second].map(|index| offers[index].header.clone());
    if one == other {
        return RecordingError::AlikeColumns { place, header: one, numbers: [first + 1, second + 1] };
    }
    RecordingError::DuplicateColumn { place, signal, first: one, second: other }
}

/// Takes the position from the angle of the joint where only that was recorded.
fn through_linkage(assignment: &mut Assignment, map: &ChannelMap) {
    let of = |signal| assignment.known.iter().find(|(_, column)| column.signal == signal);
    let Some((index, angle)) = of(Signal::Angle) else { return };
    let note = match &map.linkage {
        _ if of(Signal::Position).is_some() => Note::AngleBesidePosition,
        None => Note::AngleWithoutLinkage,
        Some(linkage) => {
            let position = (*index, Column::position_from(angle, linkage));
            assignment.known.push(position);
            Note::PositionFromAngle
        }
    };
    assignment.notes.push(note);
}

/// The column of a signal, if the offered header stands for it: by the signal's mapping, or else by its name.
pub(crate) fn one(
    offer: &Offer,
    signal: Signal,
    mapping: Option<&Mapping>,
    place: impl Fn() -> Place,
) -> Result<Option<Column>, RecordingError> {
    let found = if let Some(mapping) = mapping {
        offer.meant_by(mapping).map(|meant| (meant.unit, mapping.scale))
    } else {
        let named = offer.names.iter().find(|(name, _)| Signal::parse(name) == Some(signal));
        named.map(|(_, unit)| (unit.clone(), None))
    };
    let Some((unit, scale)) = found else { return Ok(None) };
    let unit = unit_of(signal, scale, &offer.header, unit.as_deref(), place)?;
    Ok(Some(Column::of_file(offer.header.clone(), signal, unit)))
}

/// The unit of a known signal from the scale of its mapping, or else from the text in its header's brackets.
fn unit_of(
    signal: Signal,
    scale: Option<Scale>,
    header: &str,
    unit: Option<&str>,
    place: impl Fn() -> Place,
) -> Result<Unit, RecordingError> {
    if let Some(Scale { zero, full }) = scale {
        let readings_in = unit.and_then(Unit::parse);
        return Ok(Unit::of_sensor(readings_in, signal.si_unit().dimension(), zero, full));
    }
    let header = || header.to_owned();
    let Some(text) = unit else {
        if signal.is_dimensionless() {
            return Ok(signal.si_unit());
        }
        return Err(RecordingError::MissingUnit { place: place(), columns: vec![(signal, header())] });
    };
    match Unit::parse(text) {
        None => Err(RecordingError::UnknownUnit { place: place(), signal, header: header(), unit: text.to_owned() }),
        Some(unit) if signal.dimensions().contains(&unit.dimension()) => Ok(unit),
        Some(_) => {
            Err(RecordingError::WrongDimension { place: place(), signal, header: header(), unit: text.to_owned() })
        }
    }
}
