//! MATLAB's MAT-files, versions 4, 5 and 7.
//!
//! Series are
//!
//! - variables that are vectors: those of the same length belong to one base (`time_s`, `position_mm`);
//! - fields of a structure that are vectors: `run.position_mm`, or `position_mm` alone;
//! - a structure with a vector `Time` and a vector `Data` (or `Values`), in upper or lower case: the form of a timeseries whose
//!   two parts are saved. The series has the structure's name, and `Time` is its clock in s;
//! - a structure `time` and `signals`, as Simulink writes "Structure With Time": each signal has its `values` and its `label`;
//! - a structure `X` and `Y`, as dSPACE's `ControlDesk` writes it: each of `Y` has `Name`, `Data` and `Unit`, at the times of the `X` that its `XIndex` says.
//!
//! Objects are not read, and so no timeseries objects either: MATLAB's classes are not part of the documented format.
//!
//! The elements are read here, with `flate2`: the libraries that were found read no structures, or are written in C and need HDF5.

mod elements;
mod numbers;
mod version4;
pub(crate) mod write;

use elements::{Content, Variable};
use numbers::Numbers;

use super::columns::{self, Contents, Offered};
use super::format::is_version_4;
use super::surveyed::{Surveyed, of_contents};
use crate::channel_map::ChannelMap;
use crate::error::RecordingError;
use crate::formats::text::lines::MAX_COLUMNS;
use crate::recording::Recording;

pub(crate) use write::write;

/// Reads a file.
pub(crate) fn read(name: &str, bytes: &[u8], map: &ChannelMap) -> Result<Recording, RecordingError> {
    with(name, bytes, |file| columns::recording(name, file, map))?
}

/// All series of a file.
pub(crate) fn survey(name: &str, bytes: &[u8]) -> Result<Vec<Surveyed>, RecordingError> {
    with(name, bytes, |file| of_contents(file))
}

fn with<T>(name: &str, bytes: &[u8], then: impl FnOnce(&MatFile<'_>) -> T) -> Result<T, RecordingError> {
    let variables =
        if is_version_4(bytes) { version4::variables(name, bytes)? } else { elements::variables(name, bytes)? };
    let mut file = MatFile::default();
    file.take("", &variables);
    Ok(then(&file))
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
                    [fields] if self.take_timed(&path, name, fields) || self.take_axes(&path, fields) => {}
                    [fields] => self.take(&path, fields),
                    _ if within.is_empty() => self.offer(&path, name, NOWHERE, false, Err("an array of structures")),
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
                let own = format!("{path}.signals({})", number + 1);
                self.offer(text(signal, "label").unwrap_or(&own), &own, base, false, Ok(values));
            }
        }
        true
    }

    /// Adds the series `Y` of a structure, at the times `X`; `false` where the structure is not of this kind.
    fn take_axes(&mut self, path: &str, fields: &'a [Variable]) -> bool {
        let all = |name: &str| match fields.iter().find(|field| *field.name == *name).map(|field| &field.content) {
            Some(Content::Structures(all)) => all.as_slice(),
            _ => &[],
        };
        let (axes, series) = (all("X"), all("Y"));
        let Some(times) = axes.iter().map(|axis| vector(axis, &["data"])).collect::<Option<Vec<_>>>() else {
            return false;
        };
        if times.is_empty() || series.is_empty() {
            return false;
        }
        let first = self.bases.len();
        for (index, (axis, times)) in axes.iter().zip(&times).enumerate() {
            let own = format!("{path}.X({})", index + 1);
            self.bases.push((own.clone(), times.len()));
            self.offer(&own, "", first + index, true, Ok(times));
            self.with_unit(text(axis, "unit"));
        }
        for (index, one) in series.iter().enumerate() {
            let own = format!("{path}.Y({})", index + 1);
            let axis = vector(one, &["xindex"]).and_then(|axis| axis.values().first().copied()).unwrap_or(1.0);
            let axis = (0..times.len()).find(|at| (*at as f64 + 1.0 - axis).abs() < 0.5);
            let data = vector(one, &["data"]).ok_or("something else than a vector of real numbers");
            let fits = |data: &&Numbers| axis.is_some_and(|axis| data.len() == times[axis].len());
            let data =
                data.and_then(|data| Some(data).filter(fits).ok_or("other than one value for each of its times"));
            let base = axis.map_or(NOWHERE, |axis| first + axis);
            self.offer(text(one, "name").unwrap_or(&own), &own, base, false, data);
            self.with_unit(text(one, "unit"));
        }
        true
    }

    /// Gives the series that was added last a unit.
    fn with_unit(&mut self, unit: Option<&str>) {
        if let Some(last) = self.offered.last_mut() {
            last.unit = unit.map(str::to_owned);
        }
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
        let offered = Offered {
            name: name.to_owned(),
            also: also.into_iter().collect(),
            unit: None,
            is_typed: false,
            base,
            clock,
        };
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

/// The field of this name, in upper or lower case, if it is a text that is not empty.
fn text<'a>(fields: &'a [Variable], name: &str) -> Option<&'a str> {
    fields.iter().find_map(|field| match &field.content {
        Content::Text(text) if field.name.eq_ignore_ascii_case(name) => {
            Some(text.trim()).filter(|text| !text.is_empty())
        }
        _ => None,
    })
}
