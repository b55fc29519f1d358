//! Writing a machine file back: changed values in the user's own text.

use std::collections::BTreeMap;
use std::path::Path;

use toml_edit::{Array, Document, DocumentMut, InlineTable, Item, Table, TableLike, Value};

use model_core::machine::Parameter;
use recording::files::atomic;
use recording::files::source_error::Place;
use recording::linkage::Rises;
use recording::{PressureZero, Scale, Signal};

use crate::band::put_band;
use crate::channels::{FULL_FLOW, PRESSURE, UNUSED};
use crate::error::MachineFileError;
use crate::keys::{self, EFFECTS};
use crate::linkage::{ANGLES, LINKAGE, POSITIONS, RISES};
use crate::reader::read_text;
use crate::{LoadSource, MachineFile};

impl MachineFile {
    /// Writes the file: the text that was read, with its comments and order, and with the changed values in it.
    ///
    /// A value is written when the text gives it or when it is not its default. Each number is the
    /// shortest text that reads back to the same bits. Values that the drive does not use (those
    /// of a valve in a pump drive) are not written. A value that could not be read back is an error, and
    /// then nothing is written.
    pub fn save(&self, path: &Path) -> Result<(), MachineFileError> {
        let file = path.display().to_string();
        let text = self.to_text(&file)?;
        atomic::write(path, |out| out.write_all(text.as_bytes()))
            .map_err(|source| MachineFileError::Write { place: Place::file(&file), source })
    }

    /// The text that [`MachineFile::save`] writes; `file` stands for it in messages.
    pub fn to_text(&self, file: &str) -> Result<String, MachineFileError> {
        let syntax = |error: &toml_edit::TomlError| MachineFileError::Syntax {
            place: error.span().map_or_else(|| Place::file(file), |span| Place::in_text(file, &self.text, span)),
            message: error.message().replace('\n', "; "),
        };
        let before = if self.text.is_empty() { None } else { Some(read_text(file, &self.text)?) };
        // If the source of oil has changed, nothing of the old text is kept.
        let before = before.filter(|before| before.machine.source == self.machine.source);
        let mut document = match before {
            Some(_) => Document::parse(self.text.as_str()).map_err(|error| syntax(&error))?.into_mut(),
            None => DocumentMut::new(),
        };
        let name_before = before.as_ref().map(|before| before.name.as_str());
        if name_before != Some(self.name.as_str()) {
            put(document.as_table_mut(), "name", Value::from(self.name.as_str()));
        }
        self.put_parameters(&mut document, before.as_ref());
        if self.load_source != before.as_ref().map_or(LoadSource::Constant, |before| before.load_source) {
            put(table(document.as_table_mut(), "load"), "source", Value::from(self.load_source.name()));
        }
        self.put_channels(&mut document, before.as_ref());
        self.put_linkage(&mut document, before.as_ref());
        self.put_fit(&mut document, before.as_ref());
        put_band(&mut document, self.band.as_ref(), before.as_ref().and_then(|before| before.band.as_ref()));
        let text = document.to_string();
        read_text(file, &text)?;
        Ok(text)
    }

    fn put_parameters(&self, document: &mut DocumentMut, before: Option<&MachineFile>) {
        for name in keys::tables() {
            if !keys::belongs(name, self.machine.source) {
                continue;
            }
            let parent_effect = name.strip_prefix(EFFECTS);
            let listed = parent_effect.is_some_and(|effect| self.effects.contains(effect));
            if parent_effect.is_none() && before.is_none() && ["supply", "valve", "pump", "cylinder"].contains(&name) {
                table(document.as_table_mut(), name);
            }
            let mut written = false;
            for key in keys::keys(name) {
                let parameters = keys::at_key(name, key);
                let differs = |parameter| {
                    let text = before.filter(|before| before.given.contains(&parameter));
                    let stands =
                        text.map_or_else(|| keys::fallback(parameter, &self.machine), |b| b.machine.get(parameter));
                    stands.to_bits() != self.machine.get(parameter).to_bits()
                };
                let stands = before.is_some_and(|before| parameters.iter().any(|p| before.given.contains(p)));
                let is_asked = |&parameter: &Parameter| !stands && keys::is_required(parameter, self.machine.source);
                let changed = parameters.iter().any(|parameter| differs(*parameter) || is_asked(parameter));
                written |= stands || changed;
                if changed || (listed && !stands) {
                    let numbers: Vec<Value> = parameters.iter().map(|&p| number(self.machine.get(p))).collect();
                    let array = keys::address(parameters[0]).index.is_some();
                    let value = match numbers.first() {
                        Some(one) if !array => one.clone(),
                        _ => Value::Array(Array::from_iter(numbers)),
                    };
                    put(nested(document, name), key, value);
                }
            }
            if let Some(effect) = parent_effect {
                if listed && !written {
                    nested(document, name);
                } else if !listed && before.is_some_and(|before| before.effects.contains(effect)) {
                    self.remove_effect(document, name, effect);
                }
            }
        }
    }

    /// Switches an effect off by removing its table, unless one of its values differs from its default.
    fn remove_effect(&self, document: &mut DocumentMut, name: &str, effect: &str) {
        let off = keys::in_table(name).all(|(parameter, _)| {
            self.machine.get(parameter).to_bits() == keys::fallback(parameter, &self.machine).to_bits()
        });
        if off && let Some(effects) = document.get_mut("effects").and_then(Item::as_table_like_mut) {
            effects.remove(effect);
        }
    }

    fn put_channels(&self, document: &mut DocumentMut, before: Option<&MachineFile>) {
        let zero = before.map_or(PressureZero::default(), |before| before.channels.pressure);
        if zero != self.channels.pressure {
            put(table(document.as_table_mut(), "channels"), PRESSURE, self.channels.pressure.name().into());
        }
        let unused = self.channels.unused();
        if before.map_or(&[][..], |before| before.channels.unused()) != unused {
            put(table(document.as_table_mut(), "channels"), UNUSED, unused.iter().map(String::as_str).collect());
        }
        let gone = |signal: &Signal| self.channels.get(*signal).is_none();
        for (signal, _) in before.iter().flat_map(|before| before.channels.iter()).filter(|(signal, _)| gone(signal)) {
            table(document.as_table_mut(), "channels").remove(signal.name());
        }
        for (signal, mapping) in self.channels.iter() {
            let stands = before.and_then(|before| before.channels.get(signal));
            if stands.is_none_or(|stands| (&stands.header, stands.scale) != (&mapping.header, mapping.scale)) {
                let value = mapping.scale.map_or_else(
                    || Value::from(mapping.header.as_str()),
                    |Scale { zero, full }| {
                        let mut sensor = InlineTable::new();
                        sensor.insert("column", Value::from(mapping.header.as_str()));
                        sensor.insert("zero", Value::from(zero));
                        sensor.insert("full", Value::from(full));
                        if Signal::OTHER_FLOWS.contains(&signal) {
                            sensor.insert(FULL_FLOW, Value::from(1.0));
                        }
                        Value::from(sensor)
                    },
                );
                put(table(document.as_table_mut(), "channels"), signal.name(), value);
            }
        }
    }

    /// What `[linkage]` says beside its parameters, where it differs from the text's.
    fn put_linkage(&self, document: &mut DocumentMut, before: Option<&MachineFile>) {
        let linkage = self.channels.linkage.as_deref();
        let Some(linkage) = linkage.filter(|_| before.and_then(|before| before.channels.linkage.as_deref()) != linkage)
        else {
            return;
        };
        let written = table(document.as_table_mut(), LINKAGE);
        if let Some((angles_rad, positions_m)) = linkage.table() {
            for (key, values) in [(ANGLES, angles_rad), (POSITIONS, positions_m)] {
                put(written, key, Value::Array(values.into_iter().map(number).collect()));
            }
        } else if let Some(triangle) = linkage.triangle().filter(|triangle| triangle.rises != Rises::default()) {
            put(written, RISES, triangle.rises.name().into());
        }
    }

    fn put_fit(&self, document: &mut DocumentMut, before: Option<&MachineFile>) {
        let had = before.is_some_and(|before| before.has_sigma_table);
        if had || self.has_sigma_table || !self.sigma.is_empty() {
            put_by_parameter(document, "fit.sigma", &self.sigma, before.map(|before| &before.sigma));
        }
        if !self.tolerance.is_empty() || before.is_some_and(|before| !before.tolerance.is_empty()) {
            put_by_parameter(document, "fit.tolerance", &self.tolerance, before.map(|before| &before.tolerance));
        }
    }
}

/// Writes a table with a number for each of some parameters, by their full keys.
fn put_by_parameter(
    document: &mut DocumentMut,
    name: &str,
    values: &BTreeMap<Parameter, f64>,
    before: Option<&BTreeMap<Parameter, f64>>,
) {
    let written = nested(document, name);
    for (&parameter, &value) in values {
        let stands = before.and_then(|before| before.get(&parameter));
        if stands.is_none_or(|stands| stands.to_bits() != value.to_bits()) {
            put(written, parameter.description().key, number(value));
        }
    }
    for parameter in before.into_iter().flat_map(BTreeMap::keys) {
        if !values.contains_key(parameter) {
            written.remove(parameter.description().key);
        }
    }
}

/// A number whose text reads back to the same bits.
pub(crate) fn number(value: f64) -> Value {
    format!("{value:?}").parse().unwrap_or_else(|_| Value::from(value))
}

/// Sets a key; a comment after the old value is kept.
pub(crate) fn put(table: &mut dyn TableLike, key: &str, mut value: Value) {
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(old) => {
            *value.decor_mut() = old.decor().clone();
            *old = value;
        }
        None => {
            table.insert(key, Item::Value(value));
        }
    }
}

/// A table below another; it is created if it is missing.
pub(crate) fn table<'t>(parent: &'t mut dyn TableLike, name: &str) -> &'t mut dyn TableLike {
    let item = parent.entry(name).or_insert_with(|| Item::Table(Table::new()));
    if !item.is_table_like() {
        *item = Item::Table(Table::new());
    }
    item.as_table_like_mut().expect("the item was just made a table")
}

/// The table with a dotted name; a new parent table gets no header of its own.
fn nested<'t>(document: &'t mut DocumentMut, name: &str) -> &'t mut dyn TableLike {
    match name.split_once('.') {
        None => table(document.as_table_mut(), name),
        Some((parent, child)) => {
            let parent = document.as_table_mut().entry(parent).or_insert_with(|| {
                let mut new = Table::new();
                new.set_implicit(true);
                Item::Table(new)
            });
            table(parent.as_table_like_mut().expect("the text was read, so its parents are tables"), child)
        }
    }
}
