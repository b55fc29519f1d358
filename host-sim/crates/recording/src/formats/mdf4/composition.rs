//! Channels that consist of others: the members of a structure and the elements of an array, each with its own place in the record.

use super::Fault;
use super::blocks::{Block, File};
use super::channel::Channel;
use crate::formats::text::lines::MAX_COLUMNS;

/// Deepest level of structures and arrays in each other.
const DEEPEST: usize = 4;
/// Most elements of an array that are channels of their own.
const MOST_ELEMENTS: u64 = 64;
/// The flag of an array whose first index varies fastest.
const COLUMN_BY_COLUMN: u32 = 1 << 6;

/// Adds a channel with all that it consists of; `within` is the name of what it is a member of.
pub(super) fn add(
    file: &File<'_>,
    block: Block<'_>,
    within: Option<&str>,
    depth: usize,
    all: &mut Vec<Channel>,
) -> Result<(), Fault> {
    let mut channel = file.channel(block)?;
    if let Some(within) = within {
        let own = std::mem::take(&mut channel.name);
        let is_whole = own.strip_prefix(within).is_some_and(|rest| rest.starts_with(['.', '[']));
        channel.name = if is_whole { own.clone() } else { format!("{within}.{own}") };
        channel.member = Some(own);
    }
    put(file, channel, block.link(1), depth, all)
}

/// Adds a channel that consists of what stands at `composition`; 0 for a plain one.
fn put(
    file: &File<'_>,
    mut channel: Channel,
    composition: u64,
    depth: usize,
    all: &mut Vec<Channel>,
) -> Result<(), Fault> {
    if all.len() > MAX_COLUMNS || composition == 0 || depth == DEEPEST {
        channel.instead = channel.instead.or((composition != 0).then_some("structures or arrays in each other"));
        all.push(channel);
        return Ok(());
    }
    let block = file.block(composition)?;
    match &block.id {
        b"CN" => {
            let (name, moved) = (channel.name.clone(), channel.moved);
            channel.instead = Some("a structure, whose members are listed behind its name and a point");
            all.push(channel);
            let from = all.len();
            for member in file.list(composition, *b"CN", MAX_COLUMNS)? {
                if all.len() > MAX_COLUMNS {
                    return Ok(());
                }
                add(file, member, Some(&name), depth + 1, all)?;
            }
            // The blocks tell the places in the first element of an array of structures.
            for member in &mut all[from..] {
                member.move_by(moved.0, moved.1);
            }
            Ok(())
        }
        b"CA" => {
            let (sizes, steps) = layout(block)?;
            let count = sizes.iter().try_fold(1_u64, |count, size| count.checked_mul(*size));
            channel.instead = Some("an array, whose elements are listed behind its name, as `[0]`");
            let template = Channel { instead: None, ..channel.clone() };
            // Elements of the first kind stand in the same record.
            let is_listed = block.u8(1)? == 0 && count.is_some_and(|count| count <= MOST_ELEMENTS);
            if !is_listed {
                channel.instead = Some("an array that is long, or in channel groups of its own");
                all.push(channel);
                return Ok(());
            }
            all.push(channel);
            let (bytes, marks) = (i64::from(block.u32(8)?.cast_signed()), i64::from(block.u32(12)?));
            for number in 0..count.unwrap_or(0) {
                let (mut rest, mut place, mut index) = (number, 0, String::new());
                for (size, step) in sizes.iter().zip(&steps).rev() {
                    place += rest % size * step;
                    index = format!("[{}]{index}", rest % size);
                    rest /= size;
                }
                let place = i64::try_from(place).unwrap_or(i64::MAX);
                let mut element = template.clone();
                element.name = format!("{}{index}", template.name);
                element.member = template.member.as_ref().map(|member| format!("{member}{index}"));
                element.move_by(place.saturating_mul(bytes), place.saturating_mul(marks));
                put(file, element, block.link(0), depth + 1, all)?;
            }
            Ok(())
        }
        _ => Err(Fault::Damaged("a channel of what is neither a structure nor an array")),
    }
}

/// The sizes of an array, and by how many elements each index moves.
fn layout(block: Block<'_>) -> Result<(Vec<u64>, Vec<u64>), Fault> {
    let count = usize::from(block.u16(2)?);
    let sizes = (0..count.min(8)).map(|index| block.u64(16 + 8 * index)).collect::<Result<Vec<u64>, Fault>>()?;
    let mut steps = vec![1_u64; sizes.len()];
    let order: Vec<usize> = if block.u32(4)? & COLUMN_BY_COLUMN == 0 {
        (0..sizes.len()).rev().collect()
    } else {
        (0..sizes.len()).collect()
    };
    let mut step = 1_u64;
    for index in order {
        steps[index] = step;
        step = step.saturating_mul(sizes[index]);
    }
    Ok((sizes, steps))
}
