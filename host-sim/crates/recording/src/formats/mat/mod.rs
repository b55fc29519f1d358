//! MATLAB's MAT-files, versions 5 and 7.
//!
//! Series are
//!
//! - variables that are vectors: those of the same length belong to one base (`time_s`, `position_mm`);
//! - fields of a structure that are vectors: `run.position_mm`, or `position_mm` alone;
//! - a structure with a vector `Time` and a vector `Data` (or `Values`), in upper or lower case: the form of a timeseries whose
//!   two parts are saved. The series has the structure's name, and `Time` is its clock in s;
//! - a structure `time` and `signals`, as Simulink writes "Structure With Time": each signal has its `values` and its `label`.
//!
//! Objects are not read, and so no timeseries objects either: MATLAB's classes are not part of the documented format.
//!
//! The elements are read here, with `flate2`: the libraries that were found read no structures, or are written in C and need HDF5.

mod elements;
mod numbers;
pub(crate) mod write;

use elements::{Content, Variable};
use numbers::Numbers;

use super::columns::{self, Contents, Offered};
use crate::channel_map::ChannelMap;
use crate::error::RecordingError;
use crate::formats::text::lines::MAX_COLUMNS;
use crate::recording::Recording;

pub(crate) use write::write;

/// Reads a file.
pub(crate) fn read(name: &str, bytes: &[u8], map: &ChannelMap) -> Result<Recording, RecordingError> {
    let variables = elements::variables(name, bytes)?;
    let mut file = MatFile::default();
    file.take("", &variables);
    columns::recording(name, &file, map)
}

/// The base of everything that holds no numbers.
const NOWHERE: usize = usize::MAX;

/// The vectors of a file.
#[derive(Default)]
struct MatFile<'a> {
    offered: Vec<Offered>,
    /// The numbers of the series, or what it holds instead.
    vectors: Vec<Result<&'a Numbers, &'static str>>,
    /// Structure and length of the vectors of each base.
    bases: Vec<(String, usize)>,
}

impl Contents for MatFile<'_> {
    const KIND: &'static str = "variable";

    fn offered(&self) -> &[Offered] {
        &self.offered
    }

    fn rows(&self, base: usize) -> usize {
        self.bases.get(base).map_or(0, |(_, rows)| *rows)
    }

    fn instead(&self, index: usize) -> Option<&'static str> {
        self.vectors[index].err()
    }

    fn values(&self, index: usize) -> Result<Vec<f64>, RecordingError> {
        Ok(self.vectors[index].map_or_else(|_| Vec::new(), Numbers::values))
    }
}

impl<'a> MatFile<'a> {
    /// Adds the series among these variables, which are fields of a structure with this name.
    fn take(&mut self, within: &str, variables: &'a [Variable]) {
        for Variable { name, content } in variables {
            if self.offered.len() > MAX_COLUMNS {
                return;
            }
            let path = if within.is_empty() { name.to_string() } else { format!("{within}.{name}") };
            match content {
                Content::Vector(numbers) if numbers.len() > 1 => {
                    let base = self.base(within, numbers.len());
                    self.offer(&path, name, base, false, Ok(numbers));
                }
                Content::Structures(all) => match all.as_slice() {
                    [fields] if self.take_timed(&path, name, fields) => {}
                    [fields] => self.take(&path, fields),
                    _ => {}
                },
                // Inside structures this is not reported: parameters there may have the same name as a signal.
                Content::Other(what) if within.is_empty() => self.offer(&path, name, NOWHERE, false, Err(what)),
                _ => {}
            }
        }
    }

    /// Adds a structure that has its own clock; `false` where the structure is not of this kind.
    fn take_timed(&mut self, path: &str, name: &str, fields: &'a [Variable]) -> bool {
        let Some(time) = vector(fields, &["time"]) else { return false };
        let base = self.bases.len();
        if let Some(data) = vector(fields, &["data", "values"]).filter(|data| data.len() == time.len()) {
            self.bases.push((path.to_owned(), time.len()));
            self.offer(&format!("{path}.Time"), "", base, true, Ok(time));
            self.offer(path, name, base, false, Ok(data));
            return true;
        }
        let signals = fields.iter().find(|field| *field.name == *"signals");
        let Some(Variable { content: Content::Structures(signals), .. }) = signals else { return false };
        self.bases.push((path.to_owned(), time.len()));
        self.offer(&format!("{path}.time"), "", base, true, Ok(time));
        for (number, signal) in signals.iter().enumerate() {
            if let Some(values) = vector(signal, &["values"]).filter(|values| values.len() == time.len()) {
                let label = signal.iter().find_map(|field| match &field.content {
                    Content::Text(text) if *field.name == *"label" => Some(text.trim()),
                    _ => None,
                });
                let own = format!("{path}.signals({})", number + 1);
                self.offer(label.filter(|label| !label.is_empty()).unwrap_or(&own), &own, base, false, Ok(values));
            }
        }
        true
    }

    fn base(&mut self, within: &str, length: usize) -> usize {
        let known = self.bases.iter().position(|(own, rows)| own == within && *rows == length);
        known.unwrap_or_else(|| {
            self.bases.push((within.to_owned(), length));
            self.bases.len() - 1
        })
    }

    fn offer(&mut self, name: &str, also: &str, base: usize, clock: bool, numbers: Result<&'a Numbers, &'static str>) {
        let also = Some(also).filter(|also| !also.is_empty() && *also != name).map(str::to_owned);
        let offered = Offered { name: name.to_owned(), also: also.into_iter().collect(), unit: None, base, clock };
        self.offered.push(offered);
        self.vectors.push(numbers);
    }
}

/// The field with one of these names, in upper or lower case, if it is a vector.
fn vector<'a>(fields: &'a [Variable], names: &[&str]) -> Option<&'a Numbers> {
    fields.iter().find_map(|field| match &field.content {
        Content::Vector(numbers) if names.iter().any(|name| field.name.eq_ignore_ascii_case(name)) => Some(numbers),
        _ => None,
    })
}
