//! The records of a channel group: joined from several blocks, unpacked, and separated from the records of other groups.

use std::collections::HashMap;
use std::io::Read;

use super::Fault;
use super::blocks::{Block, File, Group};
use crate::formats::format::MAX_UNPACKED_BYTES;
use crate::formats::unsupported::Unsupported;

/// The records of a group, one after the other and without group numbers: as many as the group states.
pub(crate) fn of(file: &File<'_>, group: &Group) -> Result<Vec<u8>, Fault> {
    let fewer = || Fault::Damaged("fewer records than a channel group says");
    let cycles = usize::try_from(group.cycles).map_err(|_| fewer())?;
    let wanted = cycles.checked_mul(group.record_bytes()).ok_or_else(fewer)?;
    let mut bytes = Vec::new();
    collect(file, group.data, &mut bytes)?;
    let mut records = if group.id_bytes == 0 {
        bytes
    } else {
        let groups = file.groups()?;
        let groups: Vec<&Group> = groups.iter().filter(|other| other.data == group.data).collect();
        sorted(&groups, group, &bytes)?
    };
    if records.len() < wanted {
        return Err(fewer());
    }
    records.truncate(wanted);
    Ok(records)
}

/// Joins the data that a link points to.
fn collect(file: &File<'_>, at: u64, bytes: &mut Vec<u8>) -> Result<(), Fault> {
    if at == 0 {
        return Ok(());
    }
    let mut block = file.block(at)?;
    if block.id == *b"HL" {
        block = file.block(block.link(0))?;
    }
    // A list visits each block once, so there are no more blocks than fit into the file.
    let mut most = file.len() / 24;
    while block.id == *b"DL" {
        for link in block.links_from(1).filter(|link| *link != 0) {
            most = most.checked_sub(1).ok_or(Fault::Damaged("a list of data without end"))?;
            append(file.block(link)?, bytes)?;
        }
        most = most.checked_sub(1).ok_or(Fault::Damaged("a list of data without end"))?;
        match block.link(0) {
            0 => return Ok(()),
            next => block = file.block_of(next, *b"DL")?,
        }
    }
    append(block, bytes)
}

/// Appends the data of a data block.
fn append(block: Block<'_>, bytes: &mut Vec<u8>) -> Result<(), Fault> {
    let left = MAX_UNPACKED_BYTES.saturating_sub(bytes.len() as u64);
    let room = |length: u64| if length > left { Err(Fault::TooLarge(MAX_UNPACKED_BYTES)) } else { Ok(()) };
    match &block.id {
        b"DT" => {
            room(block.data.len() as u64)?;
            bytes.extend_from_slice(block.data);
        }
        b"DZ" => {
            let (kind, columns) = (block.u8(2)?, block.u32(4)? as usize);
            let length = block.u64(8)?;
            room(length)?;
            if kind > 1 {
                return Err(Fault::Unsupported(Unsupported::Packing(format!("method {kind}"))));
            }
            let start = bytes.len();
            let packed = block.data.get(24..).unwrap_or_default();
            let broken = |_| Fault::Damaged("packed data that cannot be unpacked");
            flate2::read::ZlibDecoder::new(packed).take(length).read_to_end(bytes).map_err(broken)?;
            if (bytes.len() - start) as u64 != length {
                return Err(Fault::Damaged("packed data of another length than it says"));
            }
            if kind == 1 && columns > 1 {
                let plain = untransposed(&bytes[start..], columns);
                bytes.truncate(start);
                bytes.extend_from_slice(&plain);
            }
        }
        b"DV" | b"LD" => return Err(Fault::Unsupported(Unsupported::ColumnOriented)),
        _ => return Err(Fault::Damaged("data in a block of another kind")),
    }
    Ok(())
}

/// Restores records that were stored transposed: all first bytes, then all second bytes, and so on. An incomplete last record follows unchanged.
fn untransposed(bytes: &[u8], columns: usize) -> Vec<u8> {
    let rows = bytes.len() / columns;
    let mut plain = Vec::with_capacity(bytes.len());
    for row in 0..rows {
        plain.extend((0..columns).map(|column| bytes[column * rows + row]));
    }
    plain.extend_from_slice(&bytes[rows * columns..]);
    plain
}

/// The records of one group out of data that several groups share; each record comes after the number of its group.
fn sorted(groups: &[&Group], group: &Group, bytes: &[u8]) -> Result<Vec<u8>, Fault> {
    let mut records = Vec::new();
    // Where groups have the same number, the first one counts. A map, because records may be as short as a byte, and groups may be thousands.
    let by_number: HashMap<u64, &Group> = groups.iter().rev().map(|group| (group.id, *group)).collect();
    let mut rest = bytes;
    let cut = || Fault::Damaged("a record that is not whole");
    while !rest.is_empty() {
        let (number, after) = rest.split_at_checked(group.id_bytes).ok_or_else(cut)?;
        let number = number.iter().rev().try_fold(0_u64, |number, byte| {
            number.checked_mul(256).and_then(|number| number.checked_add(u64::from(*byte)))
        });
        let of = number.and_then(|number| by_number.get(&number));
        let of = of.ok_or(Fault::Damaged("a record of no channel group"))?;
        let (length, after) = if of.variable {
            let (length, after) = after.split_first_chunk::<4>().ok_or_else(cut)?;
            (u32::from_le_bytes(*length) as usize, after)
        } else {
            (of.record_bytes(), after)
        };
        let (record, after) = after.split_at_checked(length).ok_or_else(cut)?;
        if of.id == group.id {
            records.extend_from_slice(record);
        }
        rest = after;
    }
    Ok(records)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_of_several_groups_are_told_apart() {
        let group = |id, value_bytes, variable| Group { id, id_bytes: 1, value_bytes, variable, ..Group::default() };
        let all = [group(1, 2, false), group(2, 1, false), group(3, 0, true)];
        let groups: Vec<&Group> = all.iter().collect();
        let bytes = [1, 10, 11, 3, 3, 0, 0, 0, 7, 7, 7, 2, 20, 1, 12, 13, 2, 21];
        assert_eq!(sorted(&groups, groups[0], &bytes).unwrap(), [10, 11, 12, 13]);
        assert_eq!(sorted(&groups, groups[1], &bytes).unwrap(), [20, 21]);
        assert!(matches!(sorted(&groups, groups[0], &bytes[..8]), Err(Fault::Damaged(_))));
        assert!(matches!(sorted(&groups[..1], groups[0], &bytes), Err(Fault::Damaged(_))));
    }

    #[test]
    fn transposed_data_come_back_record_by_record() {
        // Three records of three bytes, and one byte of a fourth record.
        assert_eq!(untransposed(&[1, 4, 7, 2, 5, 8, 3, 6, 9, 10], 3), [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
    }
}
