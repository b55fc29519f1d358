//! From header texts to the signals they hold.

use crate::channel_map::{ChannelMap, Mapping, PressureZero, Scale};
use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::recording::{Column, Note};
use crate::signal::{Signal, split_header};
use crate::unit::Unit;

/// A header of a file, and the names by which it can be known.
#[derive(Debug)]
pub(crate) struct Offer {
    /// The header as it is written back; messages use it too.
    pub(crate) header: String,
    /// Names with their units; the first one that fits counts.
    pub(crate) names: Vec<(String, Option<String>)>,
}

/// A column that a mapping refers to.
#[derive(Debug)]
struct Meant {
    /// Its unit, from the mapping, or else from the file.
    unit: Option<String>,
}

impl Offer {
    /// The header of a plain recording.
    pub(crate) fn plain(header: &str) -> Self {
        let (name, unit) = split_header(header);
        Self { header: header.to_owned(), names: vec![(name.to_owned(), unit.map(str::to_owned))] }
    }

    /// The unit that a mapping gives this column, if the mapping refers to this column.
    fn meant_by(&self, mapping: &Mapping) -> Option<Meant> {
        let (name, unit) = split_header(&mapping.header);
        self.names.iter().find_map(|(own_name, own_unit)| match (unit, own_unit) {
            _ if own_name != name => None,
            (Some(unit), Some(own)) if unit != own => None,
            (unit, own) => Some(Meant { unit: unit.map(str::to_owned).or_else(|| own.clone()) }),
        })
    }
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
        let found = offers.iter().position(|offer| offer.meant_by(mapping).is_some());
        match found {
            Some(index) => mapped.push((index, signal, mapping)),
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
            assignment.ignored.push(offer.header.clone());
            continue;
        };
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
        if let Some((_, first)) = assignment.known.iter().find(|(_, column)| column.signal == signal) {
            let (first, second) = (first.header.clone(), offer.header.clone());
            return Err(RecordingError::DuplicateColumn { place: place(index), signal, first, second });
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
