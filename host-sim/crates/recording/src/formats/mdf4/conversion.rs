//! From the raw values of a channel to physical ones.

use super::Fault;
use super::blocks::{Block, File};
use crate::formats::text::lines::MAX_ROWS;
use crate::formats::unsupported::Unsupported;

/// Most numbers of a conversion and of those that it refers to, all together.
const MOST_NUMBERS: usize = 1_000_000;
/// Where the numbers of a conversion begin in its block.
const NUMBERS_AT: usize = 24;
/// Its first link to a text, or to a conversion of some of the values.
const FIRST_OF_VALUES: usize = 4;

/// How raw values become physical values.
#[derive(Clone, Debug)]
pub(crate) enum Conversion {
    None,
    Linear {
        add: f64,
        factor: f64,
    },
    /// (a·x² + b·x + c)/(d·x² + e·x + f).
    Rational([f64; 6]),
    /// Raw values and their physical values; linear `between` them, or the nearest.
    Table {
        pairs: Vec<(f64, f64)>,
        between: bool,
    },
    /// Ranges of raw values, each with a conversion of its own, and the conversion of all others.
    Ranges {
        ranges: Vec<(f64, f64, Conversion)>,
        others: Box<Conversion>,
    },
    /// The same value for all.
    Constant(f64),
    /// A text: no number.
    State,
    /// A conversion that is not computed.
    Unsupported(Unsupported),
}

impl Conversion {
    /// The conversion at a position; 0 where there is none. Raw values of a channel may be whole numbers or not.
    pub(crate) fn at(file: &File<'_>, at: u64, are_whole: bool) -> Result<Self, Fault> {
        let mut left = MOST_NUMBERS;
        if at == 0 { Ok(Conversion::None) } else { of(file, file.block_of(at, *b"CC")?, are_whole, &mut left, true) }
    }

    /// Why it gives no numbers, if so.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        match self {
            Conversion::Unsupported(what) => Err(Fault::Unsupported(what.clone())),
            Conversion::State => Err(Fault::NotNumbers("texts")),
            Conversion::Ranges { ranges, others } => {
                let mut found = Conversion::State.check();
                for own in ranges.iter().map(|(.., own)| own).chain([others.as_ref()]) {
                    match own.check() {
                        Err(Fault::NotNumbers(_)) => {}
                        Ok(()) => found = Ok(()),
                        refused => return refused,
                    }
                }
                found
            }
            _ => Ok(()),
        }
    }

    /// The physical value of a raw value; NaN for a text.
    pub(crate) fn of(&self, raw: f64) -> f64 {
        match self {
            Conversion::None => raw,
            Conversion::Linear { add, factor } => add + factor * raw,
            Conversion::Rational([a, b, c, d, e, f]) => ((a * raw + b) * raw + c) / ((d * raw + e) * raw + f),
            Conversion::Table { pairs, between } => {
                let after = pairs.partition_point(|(own, _)| *own < raw);
                match (after.checked_sub(1).and_then(|before| pairs.get(before)), pairs.get(after)) {
                    (Some(&(x0, y0)), Some(&(x1, y1))) => {
                        let share = (raw - x0) / (x1 - x0);
                        if *between {
                            y0 + share * (y1 - y0)
                        } else if share > 0.5 {
                            y1
                        } else {
                            y0
                        }
                    }
                    (Some(&(_, value)), None) | (None, Some(&(_, value))) => value,
                    (None, None) => f64::NAN,
                }
            }
            Conversion::Ranges { ranges, others } => {
                let own = ranges.iter().find(|(from, to, _)| (*from..=*to).contains(&raw));
                own.map_or(others.as_ref(), |(.., own)| own).of(raw)
            }
            Conversion::Constant(value) => *value,
            Conversion::State | Conversion::Unsupported(_) => f64::NAN,
        }
    }
}

/// The conversion that a block describes; `left` is the number of numbers that may be read. Only one that is not part of another may refer to others.
fn of(
    file: &File<'_>,
    block: Block<'_>,
    are_whole: bool,
    left: &mut usize,
    is_outer: bool,
) -> Result<Conversion, Fault> {
    let kind = block.u8(0)?;
    let count = usize::from(block.u16(6)?).min(MAX_ROWS);
    *left = left.checked_sub(count).ok_or(Fault::Damaged("conversions with too many numbers"))?;
    let value = |index: usize| block.bytes(NUMBERS_AT + 8 * index).map(f64::from_le_bytes);
    let values = (0..count).map(value).collect::<Result<Vec<f64>, Fault>>()?;
    let short = || Fault::Damaged("a conversion with too few numbers");
    // The upper end of a range of whole numbers belongs to it.
    let range = |from: f64, to: f64| (from, if are_whole || to <= from { to } else { to.next_down() });
    let mut referred = |index: usize| match block.link(FIRST_OF_VALUES + index) {
        0 => Ok(Conversion::State),
        at => match file.block(at)? {
            inner if inner.id == *b"CC" && is_outer => of(file, inner, are_whole, left, false),
            inner if inner.id == *b"CC" => {
                Ok(Conversion::Unsupported(Unsupported::Conversion("of another in another")))
            }
            _ => Ok(Conversion::State),
        },
    };
    let unsupported = |what| Ok(Conversion::Unsupported(Unsupported::Conversion(what)));
    match (kind, values.as_slice()) {
        (0, _) => Ok(Conversion::None),
        (1, &[add, factor, ..]) => Ok(Conversion::Linear { add, factor }),
        (2, &[a, b, c, d, e, f, ..]) => Ok(Conversion::Rational([a, b, c, d, e, f])),
        (3, _) => {
            let formula = file.text(block.link(FIRST_OF_VALUES))?.unwrap_or_default();
            Ok(Conversion::Unsupported(Unsupported::Formula(formula)))
        }
        (4 | 5, [_, _, ..]) => {
            let pairs = values.as_chunks::<2>().0.iter().map(|[raw, value]| (*raw, *value)).collect();
            Ok(Conversion::Table { pairs, between: kind == 4 })
        }
        (6, [ranges @ .., others]) => {
            let ranges = ranges.as_chunks::<3>().0.iter().map(|[from, to, value]| {
                let (from, to) = range(*from, *to);
                (from, to, Conversion::Constant(*value))
            });
            Ok(Conversion::Ranges { ranges: ranges.collect(), others: Box::new(Conversion::Constant(*others)) })
        }
        (7, keys) => {
            let mut ranges = Vec::new();
            for (index, key) in keys.iter().enumerate() {
                ranges.push((*key, *key, referred(index)?));
            }
            Ok(Conversion::Ranges { ranges, others: Box::new(referred(keys.len())?) })
        }
        (8, ends) => {
            let ends = ends.as_chunks::<2>().0;
            let mut ranges = Vec::new();
            for (index, [from, to]) in ends.iter().enumerate() {
                let (from, to) = range(*from, *to);
                ranges.push((from, to, referred(index)?));
            }
            Ok(Conversion::Ranges { ranges, others: Box::new(referred(ends.len())?) })
        }
        (1 | 2 | 4..=6, _) => Err(short()),
        (9 | 10, _) => unsupported("of texts"),
        (11, _) => unsupported("of single bits into texts"),
        _ => unsupported("of an unknown type"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::float_cmp, reason = "sums of powers of two are exact")]
    fn raw_values_are_converted() {
        assert_eq!([4.0].map(|raw| Conversion::Linear { add: 1.0, factor: 0.5 }.of(raw)), [3.0]);
        assert_eq!([3.0].map(|raw| Conversion::Rational([0.0, 2.0, 1.0, 0.0, 0.0, 4.0]).of(raw)), [1.75]);
        let pairs = vec![(0.0, 0.0), (10.0, 1.0)];
        let table = |between| Conversion::Table { pairs: pairs.clone(), between };
        assert_eq!([-1.0, 2.5, 99.0].map(|raw| table(true).of(raw)), [0.0, 0.25, 1.0]);
        assert_eq!([-1.0, 2.5, 99.0].map(|raw| table(false).of(raw)), [0.0, 0.0, 1.0]);
    }

    /// A block of a conversion with these links behind the first four, and numbers.
    fn block(kind: u8, links: &[u64], values: &[f64]) -> Vec<u8> {
        let counts = [links.len(), values.len()].map(|count| u16::try_from(count).unwrap().to_le_bytes()).concat();
        let data =
            [vec![kind, 0, 0, 0], counts, vec![0; 16], values.iter().flat_map(|value| value.to_le_bytes()).collect()]
                .concat();
        let links: Vec<u8> = [0; 4].iter().chain(links).flat_map(|link: &u64| link.to_le_bytes()).collect();
        let length = (24 + links.len() + data.len()) as u64;
        [b"##CC\0\0\0\0".as_slice(), &length.to_le_bytes(), &(links.len() as u64 / 8).to_le_bytes(), &links, &data]
            .concat()
    }

    /// The conversion that stands at 200 in a file, with a linear one at 64 and a text at 160.
    fn read(kind: u8, links: &[u64], values: &[f64], are_whole: bool) -> Result<Conversion, Fault> {
        let mut bytes = b"MDF     4.10    ".to_vec();
        bytes.resize(64, 0);
        bytes.extend(block(1, &[], &[10.0, 0.5]));
        bytes.resize(160, 0);
        bytes.extend(b"##TX\0\0\0\0\x1e\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0X*0.5\0");
        bytes.resize(200, 0);
        bytes.extend(block(kind, links, values));
        Conversion::at(&File::open(&bytes)?, 200, are_whole)
    }

    #[test]
    fn texts_for_some_values_leave_the_numbers_of_the_others() {
        let states = read(7, &[160, 64], &[7.0], true).unwrap();
        states.check().unwrap();
        assert!(states.of(7.0).is_nan() && (states.of(8.0) - 14.0).abs() < 1e-12);
        let ranges = read(8, &[160, 64], &[100.0, 200.0], true).unwrap();
        ranges.check().unwrap();
        assert!([100.0, 150.0, 200.0].iter().all(|raw| ranges.of(*raw).is_nan()));
        assert!((ranges.of(99.0) - 59.5).abs() < 1e-12 && (ranges.of(201.0) - 110.5).abs() < 1e-12);
        // Numbers for a range, and texts for all others.
        let within = read(8, &[64, 0], &[0.0, 10.0], false).unwrap();
        within.check().unwrap();
        assert!((within.of(9.9) - 14.95).abs() < 1e-12 && within.of(10.0).is_nan());
        assert!(matches!(read(7, &[160, 160], &[7.0], true).unwrap().check(), Err(Fault::NotNumbers("texts"))));
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "the numbers of the table as they are")]
    fn ranges_with_numbers_are_a_table() {
        let table = |are_whole| read(6, &[], &[0.0, 10.0, 1.5, 10.0, 20.0, 2.5, -1.0], are_whole).unwrap();
        assert_eq!([0.0, 10.0, 15.0, 20.0, 21.0].map(|raw| table(true).of(raw)), [1.5, 1.5, 2.5, 2.5, -1.0]);
        assert_eq!([0.0, 10.0, 15.0, 20.0, 21.0].map(|raw| table(false).of(raw)), [1.5, 2.5, 2.5, -1.0, -1.0]);
    }

    #[test]
    fn what_is_not_computed_is_named() {
        let refused = |kind, links: &[u64]| match read(kind, links, &[], true).unwrap().check() {
            Err(Fault::Unsupported(what)) => what,
            other => panic!("{other:?}"),
        };
        assert_eq!(refused(3, &[160]), Unsupported::Formula("X*0.5".to_owned()));
        assert_eq!(refused(9, &[]), Unsupported::Conversion("of texts"));
        // A conversion that refers to itself.
        assert!(matches!(
            read(7, &[200], &[], true).unwrap().check(),
            Err(Fault::Unsupported(_) | Fault::NotNumbers(_))
        ));
    }
}
