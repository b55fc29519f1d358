//! MAT-files of version 4, as Scilab, older programs and `save('run.mat', '-v4', …)` write them.
//!
//! After "MAT-File Format" (The `MathWorks`): matrices one after the other. Each has five words (type, rows, columns, whether it is complex, length of the name),
//! its name with a zero, and its numbers column by column. The digits of the type are the order of the bytes, a zero, the type of the numbers,
//! and the kind of the matrix.

use super::elements::{Content, Fault, LONGEST_NAME, Variable};
use super::numbers::{Class, Numbers, Stored};
use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::formats::format::VERSION_4_HEAD;

/// What the five words of a matrix say.
struct Head {
    high_byte_first: bool,
    stored: Stored,
    kind: u32,
    rows: usize,
    columns: usize,
    is_complex: bool,
    name: usize,
}

/// The variables of a file.
pub(crate) fn variables(name: &str, bytes: &[u8]) -> Result<Vec<Variable>, RecordingError> {
    let mut variables: Vec<Variable> = Vec::new();
    let mut rest = bytes;
    while !rest.is_empty() {
        let (variable, after) = matrix(rest).map_err(|fault| {
            let after = |last: &Variable| Place::part(name, &format!("after variable `{}`", last.name));
            fault.at(variables.last().map_or_else(|| Place::file(name), after))
        })?;
        variables.push(variable);
        rest = after;
    }
    Ok(variables)
}

/// The first matrix, and what follows it.
fn matrix(bytes: &[u8]) -> Result<(Variable, &[u8]), Fault> {
    const CUT: Fault = Fault::Damaged("a matrix that is longer than the file");
    let head = head(bytes)?;
    let (name, rest) = bytes[VERSION_4_HEAD..].split_at_checked(head.name).ok_or(CUT)?;
    let name = name.split(|byte| *byte == 0).next().unwrap_or_default();
    let count = head.rows.checked_mul(head.columns).ok_or(CUT)?;
    let length = count.checked_mul(head.stored.bytes()).ok_or(CUT)?;
    let (numbers, rest) = rest.split_at_checked(length).ok_or(CUT)?;
    let rest = if head.is_complex { rest.get(length..).ok_or(CUT)? } else { rest };
    let content = match head.kind {
        0 if head.is_complex => Content::Other("complex numbers"),
        0 if head.rows != 1 && head.columns != 1 => Content::Other("a matrix"),
        0 => {
            let mut bytes = numbers.to_vec();
            if head.high_byte_first {
                bytes.chunks_exact_mut(head.stored.bytes()).for_each(<[u8]>::reverse);
            }
            Content::Vector(Numbers { class: Class::of(6), stored: head.stored, bytes })
        }
        1 => Content::Other("text"),
        2 => Content::Other("a sparse matrix"),
        _ => return Err(Fault::Damaged("a matrix of an unknown kind")),
    };
    Ok((Variable { name: String::from_utf8_lossy(name).into(), content }, rest))
}

fn head(bytes: &[u8]) -> Result<Head, Fault> {
    let words =
        bytes.get(..VERSION_4_HEAD).ok_or(Fault::Damaged("a matrix whose head is not whole"))?.as_chunks::<4>().0;
    // The type is a small number, in whichever order it is small.
    let high_byte_first = u32::from_le_bytes(words[0]) > u32::from_be_bytes(words[0]);
    let word = |index: usize| {
        let read = if high_byte_first { u32::from_be_bytes } else { u32::from_le_bytes };
        read(words[index])
    };
    let (order, stored, kind) = (word(0) / 1000, word(0) / 10 % 10, word(0) % 10);
    if order != u32::from(high_byte_first) {
        return Err(Fault::Damaged("a matrix in the number format of a VAX or Cray"));
    }
    let stored = match stored {
        0 => Stored::F64,
        1 => Stored::F32,
        2 => Stored::I32,
        3 => Stored::I16,
        4 => Stored::U16,
        5 => Stored::U8,
        _ => return Err(Fault::Damaged("numbers of an unknown type")),
    };
    let name = word(4) as usize;
    if name > LONGEST_NAME {
        return Err(Fault::Damaged("a name of more than 4096 bytes"));
    }
    let (rows, columns) = (word(1) as usize, word(2) as usize);
    Ok(Head { high_byte_first, stored, kind, rows, columns, is_complex: word(3) != 0, name })
}

#[cfg(test)]
mod tests {
    use crate::{ChannelMap, Recording, RecordingError, Signal, read_from};

    /// A matrix of one column.
    fn column(high: bool, kind: u32, name: &str, numbers: &[Vec<u8>]) -> Vec<u8> {
        let word = |word: u32| if high { word.to_be_bytes() } else { word.to_le_bytes() };
        let count = u32::try_from(numbers.len()).unwrap();
        let name_length = u32::try_from(name.len() + 1).unwrap();
        let head = [kind + if high { 1000 } else { 0 }, count, 1, 0, name_length].map(word).concat();
        [head, name.as_bytes().to_vec(), vec![0], numbers.concat()].concat()
    }

    fn read(bytes: &[u8]) -> Result<Recording, RecordingError> {
        read_from("run.mat", bytes, &ChannelMap::default())
    }

    #[test]
    fn numbers_of_every_type_and_order_are_read() {
        for high in [false, true] {
            let times: Vec<Vec<u8>> = [0.0_f64, 0.5, 1.0]
                .iter()
                .map(|time| if high { time.to_be_bytes() } else { time.to_le_bytes() }.to_vec())
                .collect();
            let mm: Vec<Vec<u8>> = [-3_i16, 4, 500]
                .iter()
                .map(|mm| if high { mm.to_be_bytes() } else { mm.to_le_bytes() }.to_vec())
                .collect();
            let text: Vec<Vec<u8>> = b"a text".iter().map(|letter| vec![*letter]).collect();
            let bytes = [
                column(high, 0, "time_s", &times),
                column(high, 51, "remark", &text),
                column(high, 30, "position_mm", &mm),
            ]
            .concat();
            let recording = read(&bytes).unwrap();
            assert_eq!(recording.time_s(), [0.0, 0.5, 1.0]);
            assert_eq!(recording.signal(Signal::Position).unwrap(), [-0.003, 0.004, 0.5]);
            assert_eq!(recording.ignored(), ["remark"]);
            for length in 1..bytes.len() {
                assert!(read(&bytes[..length]).is_err(), "{length}");
            }
        }
    }
}
