//! ASAM MDF 4, versions 4.00 to 4.11, and those parts of later versions that are the same.
//!
//! Every channel group has its samples, at the times of its master channel; where known channels have different masters, they are
//! interpolated. A channel is known by its name, its name before a backslash (`position\XCP:1`), or both behind its group's name
//! (`Bench.position`), with the unit that the file stores separately. Raw values are converted as the file specifies: linear, rational,
//! or by a table of numbers; where some values are texts, those count as missing, as does a value that the file marks as invalid. The members of a
//! structure and the elements of an array are channels of their own (`Bench.position`, `pressures[0]`).
//!
//! The blocks are read here, because no library was found that unpacks data blocks (loggers and asammdf pack them by default),
//! joins records across the ends of blocks, and does not trust the lengths that the file states.

mod blocks;
mod channel;
mod composition;
mod conversion;
mod records;

use std::cell::RefCell;
use std::rc::Rc;

use blocks::{File, Group};
use channel::Channel;
use conversion::Conversion;

use super::columns::{self, Contents, Offered};
use super::format::Format;
use super::surveyed::{Surveyed, of_contents};
use super::unsupported::Unsupported;
use crate::channel_map::ChannelMap;
use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::formats::text::lines::{MAX_COLUMNS, MAX_ROWS};
use crate::recording::Recording;
use crate::unit_in_name::split_suffix;

/// Why a file, or a part of it, cannot be read.
#[derive(Debug)]
pub(crate) enum Fault {
    Damaged(&'static str),
    Unsupported(Unsupported),
    TooLarge(u64),
    /// A channel without numbers; the text names what it holds.
    NotNumbers(&'static str),
}

impl Fault {
    fn at(self, place: Place, header: &str) -> RecordingError {
        match self {
            Fault::Damaged(what) => RecordingError::Damaged { place, format: Format::Mdf4, what },
            Fault::Unsupported(what) => RecordingError::Unsupported { place, what },
            Fault::TooLarge(most_bytes) => RecordingError::TooLarge { place, most_bytes },
            Fault::NotNumbers(found) => {
                RecordingError::NotNumbers { place, header: header.to_owned(), found: found.to_owned() }
            }
        }
    }
}

/// Reads a file.
pub(crate) fn read(name: &str, bytes: &[u8], map: &ChannelMap) -> Result<Recording, RecordingError> {
    columns::recording(name, &opened(name, bytes)?, map)
}

/// All channels of a file.
pub(crate) fn survey(name: &str, bytes: &[u8]) -> Result<Vec<Surveyed>, RecordingError> {
    Ok(of_contents(&opened(name, bytes)?))
}

fn opened<'a>(name: &'a str, bytes: &'a [u8]) -> Result<Mdf<'a>, RecordingError> {
    let file = File::open(bytes).map_err(|fault| fault.at(Place::file(name), ""))?;
    let groups = file.groups().map_err(|fault| fault.at(Place::file(name), ""))?;
    let mut contents = Mdf { name, file, groups, offered: Vec::new(), channels: Vec::new(), last: RefCell::default() };
    contents.list().map_err(|fault| fault.at(Place::file(name), ""))?;
    Ok(contents)
}

/// The channels of a file.
struct Mdf<'a> {
    name: &'a str,
    file: File<'a>,
    groups: Vec<Group>,
    offered: Vec<Offered>,
    /// Group and channel of each offered series.
    channels: Vec<(usize, Channel)>,
    /// The group that was read last, and its records: they are kept because channels of one group follow each other.
    last: RefCell<Option<(usize, Rc<Vec<u8>>)>>,
}

impl Mdf<'_> {
    fn list(&mut self) -> Result<(), Fault> {
        for (base, group) in self.groups.iter().enumerate() {
            // A group without samples holds nothing to read; loggers leave such groups behind.
            if group.cycles == 0 {
                continue;
            }
            for channel in self.file.channels(group)? {
                let name = channel.name.clone();
                let short = name.split('\\').next().unwrap_or_default().to_owned();
                let mut also: Vec<String> = Some(short.clone()).filter(|short| *short != name).into_iter().collect();
                also.extend(group.name.as_ref().map(|group| format!("{group}.{short}")));
                // A member goes by its own name alone where that or the file tells its unit; else it is there to be mapped.
                let has_unit = |own: &&String| channel.unit.is_some() || split_suffix(own).is_some();
                also.extend(channel.member.as_ref().filter(has_unit).cloned());
                let (unit, clock) = (channel.unit.clone(), channel.is_clock());
                if self.channels.len() > MAX_COLUMNS {
                    return Ok(());
                }
                self.offered.push(Offered { name, also, unit, is_typed: false, base, clock });
                self.channels.push((base, channel));
            }
        }
        Ok(())
    }
}

impl Mdf<'_> {
    fn records(&self, base: usize) -> Result<Rc<Vec<u8>>, Fault> {
        if let Some((_, records)) = self.last.borrow().as_ref().filter(|(last, _)| *last == base) {
            return Ok(Rc::clone(records));
        }
        let records = Rc::new(records::of(&self.file, &self.groups[base])?);
        self.last.replace(Some((base, Rc::clone(&records))));
        Ok(records)
    }
}

impl Contents for Mdf<'_> {
    const KIND: &'static str = "channel";

    fn offered(&self) -> &[Offered] {
        &self.offered
    }

    fn rows(&self, base: usize) -> usize {
        usize::try_from(self.groups[base].cycles).unwrap_or(usize::MAX)
    }

    fn instead(&self, index: usize) -> Option<&'static str> {
        self.channels[index].1.instead
    }

    fn values(&self, index: usize) -> Result<Vec<f64>, RecordingError> {
        let (base, channel) = &self.channels[index];
        let fault = |fault: Fault| {
            fault.at(Place::part(self.name, &format!("{} `{}`", Self::KIND, channel.name)), &channel.name)
        };
        let group = &self.groups[*base];
        if self.rows(*base) > MAX_ROWS {
            return Err(RecordingError::TooManyRows { place: Place::file(self.name), most: MAX_ROWS });
        }
        let conversion = Conversion::at(&self.file, channel.conversion_at, channel.is_whole()).map_err(fault)?;
        let channel = Channel { conversion, ..channel.clone() };
        channel.check().map_err(fault)?;
        let records = if channel.is_virtual() { Rc::default() } else { self.records(*base).map_err(fault)? };
        channel.values(group, &records).map_err(fault)
    }
}
