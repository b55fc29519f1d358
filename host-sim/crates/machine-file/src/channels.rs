//! `[channels]`: which columns of a recording hold which signals, and how a sensor's readings become values.

use std::ops::Range;

use toml_edit::{Item, TableLike};

use recording::channel_map::nearest_signal;
use recording::{Mapping, PressureZero, Scale, Signal};

use crate::error::MachineFileError;
use crate::reader::Reader;

/// The key of the zero of all pressure sensors.
pub(crate) const PRESSURE: &str = "pressure";
/// The key of the columns that are left unused.
pub(crate) const UNUSED: &str = "unused";
/// The last is one of other consumers alone.
const KEYS: [&str; 4] = ["column", "zero", "full", FULL_FLOW];
/// What another consumer of the supply that is known by its command takes at the full reading.
pub(crate) const FULL_FLOW: &str = "full_flow_m3_per_s";

impl Reader<'_> {
    /// Reads the table: a header in quotation marks, or a table of `column`, `zero` and `full`, for each signal.
    pub(crate) fn channels(&mut self, table: &dyn TableLike) -> Result<(), MachineFileError> {
        // First: what is mapped as well is mapped, wherever it stands.
        if let Some(item) = table.get(UNUSED) {
            self.unused(item)?;
        }
        for (key, item) in table.iter().filter(|(key, _)| *key != UNUSED) {
            if key == PRESSURE {
                self.result.channels.pressure = self.pressure(item)?;
                continue;
            }
            let Some(signal) = Signal::parse(key) else {
                let (place, found) = (self.key_place(table, key), key.to_owned());
                return Err(MachineFileError::UnknownSignal { place, found, nearest: nearest_signal(key) });
            };
            let name = format!("channels.{key}");
            let mapping = match item.as_table_like() {
                Some(sensor) => self.sensor(signal, &name, sensor, self.key_place(table, key))?,
                None if item.as_str().is_none() => {
                    return Err(self.wrong_type(item, &name, "a header in quotation marks, or { column, zero, full }"));
                }
                None => Mapping::column(self.header(signal, &name, item)?, false),
            };
            self.result.channels.insert(signal, mapping);
        }
        Ok(())
    }

    /// The headers of columns that are not known by their names.
    fn unused(&mut self, item: &Item) -> Result<(), MachineFileError> {
        let (key, expected) = (format!("channels.{UNUSED}"), "an array of headers in quotation marks");
        let headers = item.as_array().ok_or_else(|| self.wrong_type(item, &key, expected))?;
        for header in headers {
            let text = header.as_str().ok_or_else(|| self.wrong_type(item, &key, expected))?.trim();
            if text.is_empty() {
                return Err(MachineFileError::EmptyHeader { place: self.place(header.span()), signal: UNUSED });
            }
            self.result.channels.leave_unused(text);
        }
        Ok(())
    }

    /// Where the pressure sensors read zero.
    fn pressure(&self, item: &Item) -> Result<PressureZero, MachineFileError> {
        let key = format!("channels.{PRESSURE}");
        let found = self.string(item, &key)?;
        PressureZero::parse(found).ok_or_else(|| MachineFileError::UnknownChoice {
            place: self.place(item.span()),
            key,
            found: found.to_owned(),
            choices: "\"gauge\", \"absolute\" or \"unknown\"",
        })
    }

    fn header(&self, signal: Signal, key: &str, item: &Item) -> Result<String, MachineFileError> {
        let header = self.string(item, key)?.trim();
        if header.is_empty() {
            return Err(MachineFileError::EmptyHeader { place: self.place(item.span()), signal: signal.name() });
        }
        Ok(header.to_owned())
    }

    /// `{ column = "spool_sensor [V]", zero = 5.0, full = 5.0 }`; of another consumer `{ column = "stick [V]", full = 10.0, full_flow_m3_per_s = 3e-4 }`.
    fn sensor(
        &self,
        signal: Signal,
        name: &str,
        sensor: &dyn TableLike,
        place: recording::files::source_error::Place,
    ) -> Result<Mapping, MachineFileError> {
        let known = if Signal::OTHER_FLOWS.contains(&signal) { &KEYS[..] } else { &KEYS[..3] };
        self.only(sensor, name, known)?;
        let Some(column) = sensor.get("column") else {
            let meaning = "the header of the column, such as \"spool_sensor [V]\"";
            return Err(MachineFileError::MissingKey { place, key: "column", unit: "1", meaning });
        };
        let header = self.header(signal, &format!("{name}.column"), column)?;
        let zero = self.reading(sensor, name, "zero", 0.0)?;
        let spans = |key: &str| {
            let span = self.reading(sensor, name, key, 1.0)?;
            if span == 0.0 {
                let place = self.place(sensor.get(key).and_then(Item::span));
                return Err(MachineFileError::NoSpan { place, key: format!("{name}.{key}") });
            }
            Ok(span)
        };
        if Signal::OTHER_FLOWS.contains(&signal) && sensor.get("full").is_some() && sensor.get(FULL_FLOW).is_none() {
            let meaning = "the flow that the other consumer takes at its full command";
            return Err(MachineFileError::MissingKey { place, key: FULL_FLOW, unit: "m3/s", meaning });
        }
        let full = spans("full")? / spans(FULL_FLOW)?;
        Ok(Mapping { header, required: false, scale: Some(Scale { zero, full }) })
    }

    fn reading(&self, sensor: &dyn TableLike, name: &str, key: &str, default: f64) -> Result<f64, MachineFileError> {
        let Some(item) = sensor.get(key) else { return Ok(default) };
        let name = format!("{name}.{key}");
        let span: Option<Range<usize>> = item.span();
        let value = self.number(item, &name)?;
        if value.is_finite() {
            return Ok(value);
        }
        let (min, max, unit) = (f64::MIN, f64::MAX, "1");
        Err(MachineFileError::OutOfRange { place: self.place(span), key: name, value, min, max, unit })
    }
}
