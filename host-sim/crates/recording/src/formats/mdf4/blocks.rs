//! The blocks of an MDF file: a name, a length, links to other blocks, then data; and the groups and channels they describe.

use super::Fault;
use super::channel::Channel;
use super::composition;
use super::conversion::Conversion;
use crate::formats::text::lines::MAX_COLUMNS;
use crate::formats::unsupported::Unsupported;

/// Most channel groups that are read.
const MAX_GROUPS: usize = 4096;
/// Position of the header block.
const HEADER: u8 = 64;
/// Longest name or unit.
const LONGEST_TEXT: usize = 4096;

/// A block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block<'a> {
    pub(crate) id: [u8; 2],
    links: &'a [[u8; 8]],
    pub(crate) data: &'a [u8],
}

impl<'a> Block<'a> {
    /// The position that a link points to; 0 where there is no link.
    pub(crate) fn link(&self, index: usize) -> u64 {
        self.links.get(index).map_or(0, |bytes| u64::from_le_bytes(*bytes))
    }

    /// All links from this one on.
    pub(crate) fn links_from(&self, index: usize) -> impl Iterator<Item = u64> + 'a {
        self.links.iter().skip(index).map(|bytes| u64::from_le_bytes(*bytes))
    }

    /// Bytes of the data at a place.
    pub(crate) fn bytes<const N: usize>(&self, at: usize) -> Result<[u8; N], Fault> {
        let bytes = self.data.get(at..).and_then(|rest| rest.first_chunk::<N>()).copied();
        bytes.ok_or(Fault::Damaged("a block that is too short"))
    }

    pub(crate) fn u64(&self, at: usize) -> Result<u64, Fault> {
        self.bytes(at).map(u64::from_le_bytes)
    }

    pub(crate) fn u32(&self, at: usize) -> Result<u32, Fault> {
        self.bytes(at).map(u32::from_le_bytes)
    }

    pub(crate) fn u16(&self, at: usize) -> Result<u16, Fault> {
        self.bytes(at).map(u16::from_le_bytes)
    }

    pub(crate) fn u8(&self, at: usize) -> Result<u8, Fault> {
        self.bytes::<1>(at).map(|[byte]| byte)
    }
}

/// A channel group: records of one kind.
#[derive(Clone, Debug, Default)]
pub(crate) struct Group {
    pub(crate) name: Option<String>,
    /// Position of the data of its data group.
    pub(crate) data: u64,
    /// Bytes of the number that distinguishes the records of several groups; 0 where there is one group.
    pub(crate) id_bytes: usize,
    pub(crate) id: u64,
    pub(crate) cycles: u64,
    /// Bytes of a record's values, and of the bits that mark invalid values.
    pub(crate) value_bytes: usize,
    pub(crate) mark_bytes: usize,
    /// Whether its records have variable lengths, each record with its own length.
    pub(crate) variable: bool,
    pub(crate) first_channel: u64,
}

impl Group {
    /// Bytes of a record, without its group number.
    pub(crate) fn record_bytes(&self) -> usize {
        self.value_bytes + self.mark_bytes
    }
}

/// A file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct File<'a>(&'a [u8]);

impl<'a> File<'a> {
    /// Opens a file, if its version is one that is read.
    pub(crate) fn open(bytes: &'a [u8]) -> Result<Self, Fault> {
        let head = bytes.get(..usize::from(HEADER)).ok_or(Fault::Damaged("a head that is not whole"))?;
        let version = String::from_utf8_lossy(&head[8..16]).trim_end_matches([' ', '\0']).to_owned();
        if !version.starts_with("4.") {
            return Err(Fault::Unsupported(Unsupported::MdfVersion(version)));
        }
        Ok(Self(bytes))
    }

    /// Bytes of the file.
    pub(crate) fn len(&self) -> u64 {
        self.0.len() as u64
    }

    /// The block that stands at a place.
    pub(crate) fn block(&self, at: u64) -> Result<Block<'a>, Fault> {
        let damaged = Fault::Damaged("a link to where no block is");
        let start = usize::try_from(at).ok().and_then(|at| self.0.get(at..));
        let Some((&[b'#', b'#', a, b, _, _, _, _], rest)) = start.and_then(|start| start.split_first_chunk::<8>())
        else {
            return Err(damaged);
        };
        let Some((length, rest)) = rest.split_first_chunk::<8>() else { return Err(damaged) };
        let Some((links, rest)) = rest.split_first_chunk::<8>() else { return Err(damaged) };
        let cut = || Fault::Damaged("a block that is longer than the file");
        let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| cut())?;
        let links = usize::try_from(u64::from_le_bytes(*links)).map_err(|_| cut())?;
        let content = length.checked_sub(24).and_then(|length| rest.get(..length)).ok_or_else(cut)?;
        let links = links.checked_mul(8).and_then(|bytes| content.split_at_checked(bytes)).ok_or_else(cut)?;
        Ok(Block { id: [a, b], links: links.0.as_chunks::<8>().0, data: links.1 })
    }

    /// The block of this kind at a place.
    pub(crate) fn block_of(&self, at: u64, id: [u8; 2]) -> Result<Block<'a>, Fault> {
        let block = self.block(at)?;
        if block.id == id { Ok(block) } else { Err(Fault::Damaged("a link to a block of another kind")) }
    }

    /// The blocks of a linked list, in which the first link of each block points to the next; at most so many.
    pub(super) fn list(&self, mut at: u64, id: [u8; 2], most: usize) -> Result<Vec<Block<'a>>, Fault> {
        let mut blocks = Vec::new();
        while at != 0 {
            if blocks.len() == most {
                return Err(Fault::Damaged("a list of blocks that is too long, or has no end"));
            }
            let block = self.block_of(at, id)?;
            at = block.link(0);
            blocks.push(block);
        }
        Ok(blocks)
    }

    /// A name or a unit: as plain text, or in the `TX` element of a comment.
    pub(super) fn text(&self, at: u64) -> Result<Option<String>, Fault> {
        if at == 0 {
            return Ok(None);
        }
        let block = self.block(at)?;
        let short = &block.data[..block.data.len().min(LONGEST_TEXT)];
        let text = String::from_utf8_lossy(short.split(|byte| *byte == 0).next().unwrap_or_default());
        let text = match &block.id {
            b"TX" => text.as_ref(),
            b"MD" => {
                text.split_once("<TX>").and_then(|(_, rest)| rest.split_once("</TX>")).map_or("", |(inner, _)| inner)
            }
            _ => return Err(Fault::Damaged("a name that is not text")),
        };
        Ok(Some(text.trim()).filter(|text| !text.is_empty()).map(str::to_owned))
    }

    /// All channel groups.
    pub(crate) fn groups(&self) -> Result<Vec<Group>, Fault> {
        let header = self.block_of(HEADER.into(), *b"HD")?;
        let mut groups = Vec::new();
        for data_group in self.list(header.link(0), *b"DG", MAX_GROUPS)? {
            for block in self.list(data_group.link(1), *b"CG", MAX_GROUPS)? {
                if groups.len() == MAX_GROUPS {
                    return Err(Fault::Damaged("more than 4096 channel groups"));
                }
                let flags = block.u16(16)?;
                groups.push(Group {
                    name: self.text(block.link(2))?,
                    data: data_group.link(2),
                    id_bytes: usize::from(data_group.u8(0)?),
                    id: block.u64(0)?,
                    cycles: block.u64(8)?,
                    value_bytes: block.u32(24)? as usize,
                    mark_bytes: block.u32(28)? as usize,
                    variable: flags & 1 != 0,
                    first_channel: block.link(1),
                });
            }
        }
        Ok(groups)
    }

    /// The channels of a group.
    pub(crate) fn channels(&self, group: &Group) -> Result<Vec<Channel>, Fault> {
        if group.variable {
            return Ok(Vec::new());
        }
        let mut channels = Vec::new();
        for block in self.list(group.first_channel, *b"CN", MAX_COLUMNS)? {
            composition::add(self, block, None, 0, &mut channels)?;
        }
        Ok(channels)
    }

    /// The channel that a block describes, without what it consists of.
    pub(super) fn channel(&self, block: Block<'_>) -> Result<Channel, Fault> {
        let conversion = match block.link(4) {
            0 => None,
            at => Some(self.block_of(at, *b"CC")?),
        };
        let of_conversion = conversion.map_or(0, |conversion| conversion.link(1));
        let unit = self.text(block.link(6))?;
        Ok(Channel {
            name: self.text(block.link(2))?.unwrap_or_default(),
            member: None,
            unit: if unit.is_some() { unit } else { self.text(of_conversion)? },
            kind: block.u8(0)?,
            sync: block.u8(1)?,
            data_type: block.u8(2)?,
            bit_offset: u32::from(block.u8(3)?),
            byte_offset: block.u32(4)? as usize,
            bits: block.u32(8)?,
            flags: block.u32(12)?,
            mark: block.u32(16)? as usize,
            instead: None,
            moved: (0, 0),
            conversion: Conversion::None,
            conversion_at: block.link(4),
        })
    }
}
