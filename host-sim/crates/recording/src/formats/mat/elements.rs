//! The elements of a MAT-file, versions 5 and 7, and the variables they hold.
//!
//! After "MAT-File Format" (The `MathWorks`): a head of 128 bytes, then elements, each a type, a length and its bytes. A variable is an
//! element whose bytes are elements again: flags, dimensions, name, then numbers or fields. In version 7 each variable is packed
//! by deflate. No length is trusted that goes beyond the bytes that are present.

use std::io::Read;
use std::rc::Rc;

use super::numbers::{Class, Numbers, Stored};
use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::formats::format::{Format, MAX_UNPACKED_BYTES};
use crate::formats::unsupported::Unsupported;

/// Bytes of the head.
const HEAD: usize = 128;
/// Deepest level of nested structures that is read.
const DEEPEST: usize = 3;
/// Most fields of a structure, or most structures of an array, that are read.
const MOST_FIELDS: usize = 4096;
/// Longest name of a variable or a field, in bytes; MATLAB's own names have at most 63.
pub(super) const LONGEST_NAME: usize = 4096;

const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// The flag of complex numbers.
const COMPLEX: u32 = 1 << 11;

/// A variable, or a field of one.
#[derive(Debug)]
pub(crate) struct Variable {
    pub(crate) name: Rc<str>,
    pub(crate) content: Content,
}

/// What a variable holds.
#[derive(Debug)]
pub(crate) enum Content {
    /// Real numbers along one dimension.
    Vector(Numbers),
    /// A text of one row.
    Text(String),
    /// Structures, each with its fields.
    Structures(Vec<Vec<Variable>>),
    /// Anything else, described in words.
    Other(&'static str),
}

/// Why bytes are not a valid MAT-file.
pub(crate) enum Fault {
    Damaged(&'static str),
    TooLarge,
}

impl Fault {
    pub(super) fn at(self, place: Place) -> RecordingError {
        match self {
            Fault::Damaged(what) => RecordingError::Damaged { place, format: Format::Mat, what },
            Fault::TooLarge => RecordingError::TooLarge { place, most_bytes: MAX_UNPACKED_BYTES },
        }
    }
}

const CUT: Fault = Fault::Damaged("an element that is longer than what holds it");

/// The variables of a file.
pub(crate) fn variables(name: &str, bytes: &[u8]) -> Result<Vec<Variable>, RecordingError> {
    let file = || Place::file(name);
    match bytes.get(HEAD - 2..HEAD) {
        Some(b"IM") => {}
        Some(b"MI") => return Err(RecordingError::Unsupported { place: file(), what: Unsupported::BigEndian }),
        _ => return Err(Fault::Damaged("a head that is not whole").at(file())),
    }
    let mut rest = Elements(&bytes[HEAD..]);
    let mut unpacked = MAX_UNPACKED_BYTES;
    let mut variables: Vec<Variable> = Vec::new();
    while !rest.0.is_empty() {
        let place = || match variables.last() {
            Some(last) => Place::part(name, &format!("after variable `{}`", last.name)),
            None => file(),
        };
        let found = rest.next().and_then(|(kind, content)| match kind {
            MATRIX => variable(content, 0),
            COMPRESSED => {
                let content = inflated(content, &mut unpacked)?;
                match Elements(&content).next()? {
                    (MATRIX, content) => variable(content, 0),
                    _ => Err(Fault::Damaged("a packed element that is not a variable")),
                }
            }
            _ => Err(Fault::Damaged("an element that is not a variable")),
        });
        let variable = found.map_err(|fault| fault.at(place()))?;
        // Variables without a name are the inner parts of objects.
        if !variable.name.is_empty() {
            variables.push(variable);
        }
    }
    Ok(variables)
}

/// Unpacks bytes: as many as their first element states, and no more than `left`.
fn inflated(packed: &[u8], left: &mut u64) -> Result<Vec<u8>, Fault> {
    let broken = |_| Fault::Damaged("packed data that cannot be unpacked");
    let mut decoder = flate2::read::ZlibDecoder::new(packed);
    let mut content = vec![0; 8];
    decoder.read_exact(&mut content).map_err(broken)?;
    let length = u64::from(word(&content, 4).unwrap_or_default());
    if length > *left {
        return Err(Fault::TooLarge);
    }
    *left -= length;
    decoder.take(length).read_to_end(&mut content).map_err(broken)?;
    Ok(content)
}

/// The elements of a sequence that are not read yet.
struct Elements<'a>(&'a [u8]);

impl<'a> Elements<'a> {
    /// Type and bytes of the next element.
    fn next(&mut self) -> Result<(u32, &'a [u8]), Fault> {
        let first = word(self.0, 0).ok_or(CUT)?;
        // A short element has its length in the upper half of the type, and its bytes where the length would be.
        let (kind, start, length, padded) = match (first & 0xffff, (first >> 16) as usize) {
            (kind, 0) => {
                let length = word(self.0, 4).ok_or(CUT)? as usize;
                let padded = if kind == COMPRESSED { Some(length) } else { length.checked_next_multiple_of(8) };
                (kind, 8, length, padded)
            }
            (_, short) if short > 4 => return Err(CUT),
            (kind, short) => (kind, 4, short, Some(4)),
        };
        let content = self.0.get(start..).and_then(|rest| rest.get(..length)).ok_or(CUT)?;
        // The padding of the last element may be missing.
        let after = start.saturating_add(padded.ok_or(CUT)?).min(self.0.len());
        self.0 = &self.0[after..];
        Ok((kind, content))
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..)?.first_chunk::<4>().copied()?))
}

fn words(bytes: &[u8]) -> impl Iterator<Item = usize> + '_ {
    bytes.as_chunks::<4>().0.iter().map(|bytes| u32::from_le_bytes(*bytes) as usize)
}

/// The variable that consists of these elements, in a structure at this depth.
fn variable(bytes: &[u8], depth: usize) -> Result<Variable, Fault> {
    let mut elements = Elements(bytes);
    if bytes.is_empty() {
        return Ok(Variable { name: Rc::default(), content: Content::Other("nothing") });
    }
    let flags = word(elements.next()?.1, 0).ok_or(CUT)?;
    let other = |name: &[u8], what| Ok(Variable { name: named(name)?, content: Content::Other(what) });
    if flags & 0xff == 17 {
        // An object has its name where the dimensions would be.
        return other(elements.next()?.1, "an object");
    }
    let dimensions: Vec<usize> = words(elements.next()?.1).collect();
    let name = elements.next()?.1;
    let count = dimensions.iter().try_fold(1_usize, |count, &one| count.checked_mul(one)).ok_or(CUT)?;
    let one_row = dimensions.iter().filter(|&&one| one != 1).count() <= 1;
    let content = match flags & 0xff {
        1 => return other(name, "a cell array"),
        2 => {
            if depth == DEEPEST {
                return other(name, "a structure in structures");
            }
            Content::Structures(structures(elements, count, depth)?)
        }
        3 => return other(name, "an object"),
        4 if one_row => Content::Text(text(elements.next()?)),
        4 => return other(name, "a text of several rows"),
        5 => return other(name, "a sparse matrix"),
        class @ 6..=15 => {
            if flags & COMPLEX != 0 {
                return other(name, "complex numbers");
            }
            let (kind, content) = elements.next()?;
            let stored = Stored::of(kind).ok_or(Fault::Damaged("numbers of an unknown type"))?;
            if content.len() != count.checked_mul(stored.bytes()).ok_or(CUT)? {
                return Err(Fault::Damaged("a variable with more or fewer numbers than its size says"));
            }
            if !one_row {
                return other(name, "a matrix");
            }
            Content::Vector(Numbers { class: Class::of(class), stored, bytes: content.to_vec() })
        }
        _ => return other(name, "something unknown"),
    };
    Ok(Variable { name: named(name)?, content })
}

/// A name that is shared by all fields with this name: an array of structures stores it once for all.
fn named(bytes: &[u8]) -> Result<Rc<str>, Fault> {
    if bytes.len() > LONGEST_NAME {
        return Err(Fault::Damaged("a name of more than 4096 bytes"));
    }
    Ok(String::from_utf8_lossy(bytes).into())
}

/// The structures of an array; their field names come first.
fn structures(mut elements: Elements<'_>, count: usize, depth: usize) -> Result<Vec<Vec<Variable>>, Fault> {
    let length = word(elements.next()?.1, 0).ok_or(CUT)? as usize;
    let names = elements.next()?.1;
    if length == 0 {
        return Err(Fault::Damaged("fields without names"));
    }
    if names.len() / length > MOST_FIELDS || count > MOST_FIELDS {
        return Err(Fault::Damaged("a structure of more than 4096 fields or elements"));
    }
    let names = names.chunks_exact(length).map(|name| named(name.split(|byte| *byte == 0).next().unwrap_or_default()));
    let names = names.collect::<Result<Vec<Rc<str>>, Fault>>()?;
    let mut all = Vec::new();
    for _ in 0..count {
        let mut fields = Vec::new();
        for name in &names {
            let (kind, content) = elements.next()?;
            if kind != MATRIX {
                return Err(Fault::Damaged("a field that is not a variable"));
            }
            let content = variable(content, depth + 1)?.content;
            fields.push(Variable { name: Rc::clone(name), content });
        }
        all.push(fields);
    }
    Ok(all)
}

/// A text stored in 8 or 16 bits a character.
fn text((kind, bytes): (u32, &[u8])) -> String {
    if matches!(kind, 4 | 17) {
        let units: Vec<u16> = bytes.as_chunks::<2>().0.iter().map(|pair| u16::from_le_bytes(*pair)).collect();
        return String::from_utf16_lossy(&units);
    }
    String::from_utf8_lossy(bytes).into_owned()
}
