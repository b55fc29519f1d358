//! Reading a machine file.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;

use toml_edit::{Document, Item, TableLike, Value};

use model_core::machine::{Fallback, LOWEST_FLOOR_PA, Machine, Parameter, Source};
use recording::ChannelMap;
use recording::files::source_error::Place;

use crate::band::WATCH;
use crate::error::MachineFileError;
use crate::keys::{self, EFFECTS};
use crate::linkage::{self, LINKAGE};
use crate::{LoadSource, MachineFile, force};

/// Largest machine file, in bytes.
pub const MAX_FILE_BYTES: u64 = 1 << 20;

pub(crate) const NUMBER: &str = "a number";
/// Tables below `[fit]`.
const FIT: [&str; 2] = ["sigma", "tolerance"];
pub(crate) const TABLE: &str = "a table";
const TEXT: &str = "a text in quotation marks";

/// Reads a machine file.
pub fn read(path: &Path) -> Result<MachineFile, MachineFileError> {
    let name = path.display().to_string();
    let place = || Place::file(&name);
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes))
        .map_err(|source| MachineFileError::Io { place: place(), source })?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(MachineFileError::TooLarge { place: place(), most_bytes: MAX_FILE_BYTES });
    }
    match str::from_utf8(&bytes) {
        Ok(text) => read_text(&name, text),
        Err(error) => {
            let good = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
            let place = Place::in_text(&name, &good, good.len()..good.len());
            Err(MachineFileError::NotUtf8 { place })
        }
    }
}

/// Reads the text of a machine file; `file` stands for it in messages and gives the drive its name.
///
/// ```
/// use machine_file::read_text;
/// use model_core::machine::Parameter;
///
/// let text = "
/// [supply]
/// pressure_pa = 7.0e6
/// [valve]
/// gain_per_v = 0.0559
/// [cylinder]
/// area_a_m2 = 3.117e-3
/// area_b_m2 = 1.861e-3
/// [effects.internal-leakage]
/// conductance_m3_per_s_pa = 2.0e-12
/// ";
/// let file = read_text("press.toml", text)?;
/// assert!(file.effects.contains("internal-leakage"));
/// assert_eq!(file.machine.get(Parameter::Stroke), 0.3); // what is not given has its default
///
/// let error = read_text("press.toml", &text.replace("gain_per_v", "gain")).unwrap_err();
/// println!("{error}"); // file, line, key, and what was expected there
/// # Ok::<(), machine_file::MachineFileError>(())
/// ```
pub fn read_text(file: &str, text: &str) -> Result<MachineFile, MachineFileError> {
    let document = Document::parse(text).map_err(|error| MachineFileError::Syntax {
        place: error.span().map_or_else(|| Place::file(file), |span| Place::in_text(file, text, span)),
        message: error.message().replace('\n', "; "),
    })?;
    let mut reader = Reader::new(file, text, source_of(file, text, document.as_table())?);
    reader.root(document.as_table())?;
    reader.finish(document.as_table())
}

/// Whether the drive has a valve or a pump, or neither.
fn source_of(file: &str, text: &str, root: &dyn TableLike) -> Result<Source, MachineFileError> {
    let place = |key| span_of_key(root, key).map_or_else(|| Place::file(file), |span| Place::in_text(file, text, span));
    match (root.contains_key("valve"), root.contains_key("pump")) {
        (true, true) => Err(MachineFileError::TwoSources { place: place("pump") }),
        (_, false) if root.contains_key("directional_valve") => {
            Err(MachineFileError::DirectionalValveWithoutPump { place: place("directional_valve") })
        }
        (false, false) if root.contains_key("cylinder") => Ok(Source::Force),
        (false, false) => Err(MachineFileError::NoSource { place: Place::file(file) }),
        (true, false) => Ok(Source::Valve),
        (false, true) => Ok(Source::Pump),
    }
}

/// A whole number, or one with a fraction.
pub(crate) fn as_number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|number| number as f64))
}

fn span_of_key(table: &dyn TableLike, key: &str) -> Option<Range<usize>> {
    table.get_key_value(key).and_then(|(key, item)| key.span().or_else(|| item.span()))
}

pub(crate) struct Reader<'a> {
    file: &'a str,
    text: &'a str,
    pub(crate) result: MachineFile,
    pub(crate) linkage: linkage::Given,
}

impl<'a> Reader<'a> {
    fn new(file: &'a str, text: &'a str, source: Source) -> Self {
        let stem = Path::new(file).file_stem().and_then(|stem| stem.to_str()).unwrap_or(file);
        let result = MachineFile {
            name: stem.to_owned(),
            machine: Machine::with_defaults(source),
            given: BTreeSet::new(),
            effects: BTreeSet::new(),
            sigma: BTreeMap::new(),
            has_sigma_table: false,
            tolerance: BTreeMap::new(),
            channels: ChannelMap::default(),
            load_source: LoadSource::default(),
            band: None,
            text: text.to_owned(),
        };
        Self { file, text, result, linkage: linkage::Given::default() }
    }

    pub(crate) fn place(&self, span: Option<Range<usize>>) -> Place {
        span.map_or_else(|| Place::file(self.file), |span| Place::in_text(self.file, self.text, span))
    }

    pub(crate) fn key_place(&self, table: &dyn TableLike, key: &str) -> Place {
        self.place(span_of_key(table, key))
    }

    pub(crate) fn wrong_type(&self, item: &Item, key: &str, expected: &'static str) -> MachineFileError {
        let (key, found) = (key.to_owned(), item.type_name().to_owned());
        MachineFileError::WrongType { place: self.place(item.span()), key, found, expected }
    }

    /// The number of a key.
    pub(crate) fn number(&self, item: &Item, key: &str) -> Result<f64, MachineFileError> {
        item.as_value().and_then(as_number).ok_or_else(|| self.wrong_type(item, key, NUMBER))
    }

    /// Refuses a key that is none of these; `name` is that of the table.
    pub(crate) fn only(&self, table: &dyn TableLike, name: &str, known: &[&str]) -> Result<(), MachineFileError> {
        let Some((key, _)) = table.iter().find(|(key, _)| !known.contains(key)) else { return Ok(()) };
        let (place, nearest) = (self.key_place(table, key), keys::nearest(key, known));
        let known = known.iter().map(|key| (*key).to_owned()).collect();
        Err(MachineFileError::UnknownKey { place, table: name.to_owned(), key: key.to_owned(), nearest, known })
    }

    fn table<'t>(&self, item: &'t Item, key: &str) -> Result<&'t dyn TableLike, MachineFileError> {
        item.as_table_like().ok_or_else(|| self.wrong_type(item, key, TABLE))
    }

    pub(crate) fn string<'t>(&self, item: &'t Item, key: &str) -> Result<&'t str, MachineFileError> {
        item.as_str().ok_or_else(|| self.wrong_type(item, key, TEXT))
    }

    fn root(&mut self, root: &dyn TableLike) -> Result<(), MachineFileError> {
        for (key, item) in root.iter() {
            match key {
                "name" => self.result.name = self.string(item, key)?.to_owned(),
                "channels" => self.channels(self.table(item, key)?)?,
                "effects" => self.effects(self.table(item, key)?)?,
                "fit" => self.fit(self.table(item, key)?)?,
                WATCH => self.result.band = Some(self.band(self.table(item, key)?)?),
                _ if keys::keys(key).is_empty() => return Err(self.unknown_at_top(root, key, item)),
                _ => self.parameters(key, self.table(item, key)?)?,
            }
        }
        Ok(())
    }

    fn unknown_at_top(&self, root: &dyn TableLike, key: &str, item: &Item) -> MachineFileError {
        let place = self.key_place(root, key);
        let tables = keys::tables().into_iter().filter(|table| !table.contains('.'));
        let known: Box<[String]> = tables.chain(["channels", "effects", "fit", WATCH]).map(str::to_owned).collect();
        let name = key.to_owned();
        if item.is_table_like() || item.is_array_of_tables() {
            return MachineFileError::UnknownTable { place, table: name, nearest: keys::nearest(key, &*known), known };
        }
        let nearest = keys::suggest("", key);
        let known = Box::new(["name".to_owned(), "and the keys of tables".to_owned()]);
        MachineFileError::UnknownKey { place, table: String::new(), key: name, nearest, known }
    }

    /// Reads a table of parameters; `name` includes its parent tables.
    fn parameters(&mut self, name: &str, table: &dyn TableLike) -> Result<(), MachineFileError> {
        for (key, item) in table.iter() {
            if (name, key) == ("load", "source") {
                self.load_source(item)?;
                continue;
            }
            if name == LINKAGE && linkage::KEYS.contains(&key) {
                self.linkage_key(table, key, item)?;
                continue;
            }
            let parameters = keys::at_key(name, key);
            match parameters.as_slice() {
                [] => {
                    let mut known: Vec<String> = keys::keys(name).into_iter().map(str::to_owned).collect();
                    known.extend((name == "load").then(|| "source".to_owned()));
                    let linkage = linkage::KEYS.iter().filter(|_| name == LINKAGE);
                    let of_linkage = keys::nearest(key, linkage.clone()).map(|key| format!("{LINKAGE}.{key}"));
                    known.extend(linkage.map(|key| (*key).to_owned()));
                    let (place, nearest) =
                        (self.key_place(table, key), of_linkage.or_else(|| keys::suggest(name, key)));
                    let (table, key) = (name.to_owned(), key.to_owned());
                    return Err(MachineFileError::UnknownKey { place, table, key, nearest, known: known.into() });
                }
                [one] if keys::address(*one).index.is_none() => self.value(*one, item.as_value(), item)?,
                several => {
                    let full = format!("{name}.{key}");
                    let array = item.as_array().ok_or_else(|| self.wrong_type(item, &full, "an array of numbers"))?;
                    if array.len() > several.len() {
                        let (place, found, most) = (self.place(item.span()), array.len(), several.len());
                        return Err(MachineFileError::TooManyEntries { place, key: full, found, most });
                    }
                    for (&parameter, value) in several.iter().zip(array) {
                        self.value(parameter, Some(value), item)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn value(&mut self, parameter: Parameter, value: Option<&Value>, item: &Item) -> Result<(), MachineFileError> {
        let what = parameter.description();
        let Some(number) = value.and_then(as_number) else {
            let found = value.map_or(item.type_name(), Value::type_name).to_owned();
            let place = self.place(value.map_or_else(|| item.span(), Value::span));
            return Err(MachineFileError::WrongType { place, key: what.key.to_owned(), found, expected: NUMBER });
        };
        if !(what.min..=what.max).contains(&number) {
            let (place, key) = (self.place(value.and_then(Value::span)), what.key.to_owned());
            let (min, max, unit) = (what.min, what.max, what.unit);
            return Err(MachineFileError::OutOfRange { place, key, value: number, min, max, unit });
        }
        if parameter.is_whole() && number.fract() != 0.0 {
            let (place, key) = (self.place(value.and_then(Value::span)), what.key.to_owned());
            return Err(MachineFileError::NotWhole { place, key, value: number, max: what.max });
        }
        self.result.machine.set(parameter, number);
        self.result.given.insert(parameter);
        Ok(())
    }

    fn effects(&mut self, table: &dyn TableLike) -> Result<(), MachineFileError> {
        for (key, item) in table.iter() {
            let Some(effect) = keys::effects().find(|name| *name == key) else {
                let known: Box<[String]> = keys::effects().map(|name| format!("{EFFECTS}{name}")).collect();
                let (place, name) = (self.key_place(table, key), format!("{EFFECTS}{key}"));
                let nearest = keys::nearest(&name, &*known);
                return Err(MachineFileError::UnknownTable { place, table: name, nearest, known });
            };
            let name = format!("{EFFECTS}{key}");
            self.result.effects.insert(effect);
            self.parameters(&name, self.table(item, &name)?)?;
        }
        Ok(())
    }

    fn load_source(&mut self, item: &Item) -> Result<(), MachineFileError> {
        let found = self.string(item, "load.source")?;
        self.result.load_source = LoadSource::parse(found).ok_or_else(|| MachineFileError::UnknownChoice {
            place: self.place(item.span()),
            key: "load.source".to_owned(),
            found: found.to_owned(),
            choices: "\"constant\" or \"recorded-pressures\"",
        })?;
        Ok(())
    }

    fn fit(&mut self, table: &dyn TableLike) -> Result<(), MachineFileError> {
        for (key, item) in table.iter() {
            match key {
                "sigma" => {
                    self.result.has_sigma_table = true;
                    let all = Parameter::ALL.iter().copied();
                    self.result.sigma = self.by_parameter(self.table(item, "fit.sigma")?, "fit.sigma", all)?;
                }
                "tolerance" => {
                    let of_effects = Parameter::ALL.iter().copied().filter(|parameter| parameter.effect().is_some());
                    self.result.tolerance =
                        self.by_parameter(self.table(item, "fit.tolerance")?, "fit.tolerance", of_effects)?;
                }
                _ => {
                    let (place, nearest) = (self.key_place(table, key), keys::nearest(key, FIT));
                    return Err(MachineFileError::UnknownKey {
                        place,
                        table: "fit".to_owned(),
                        key: key.to_owned(),
                        nearest,
                        known: FIT.map(str::to_owned).into(),
                    });
                }
            }
        }
        Ok(())
    }

    /// A table with a positive number for each of some parameters, by their full keys.
    fn by_parameter(
        &self,
        table: &dyn TableLike,
        name: &'static str,
        known: impl Iterator<Item = Parameter> + Clone,
    ) -> Result<BTreeMap<Parameter, f64>, MachineFileError> {
        let mut found = BTreeMap::new();
        for (key, item) in table.iter() {
            if item.is_table_like() {
                // `valve.gain_per_v = 1` without quotation marks is a table in TOML.
                return Err(self.wrong_type(
                    item,
                    &format!("{name}.{key}"),
                    "a number for a key in quotation marks, \"valve.gain_per_v\"",
                ));
            }
            let Some(parameter) = known.clone().find(|parameter| parameter.description().key == key) else {
                let known: Box<[String]> = known.map(|parameter| parameter.description().key.to_owned()).collect();
                let (place, nearest) = (self.key_place(table, key), keys::nearest(key, &*known));
                let (table, key) = (name.to_owned(), key.to_owned());
                return Err(MachineFileError::UnknownKey { place, table, key, nearest, known });
            };
            let value = self.number(item, key)?;
            if !(value > 0.0 && value.is_finite()) {
                let (place, key) = (self.place(item.span()), key.to_owned());
                return Err(MachineFileError::NotPositive { place, table: name, key, value });
            }
            found.insert(parameter, value);
        }
        Ok(found)
    }

    /// Checks that required values are there, and sets defaults that depend on other values.
    fn finish(mut self, root: &dyn TableLike) -> Result<MachineFile, MachineFileError> {
        let required: &[&'static str] = match self.result.machine.source {
            Source::Valve => &["supply", "cylinder"],
            Source::Pump | Source::Force => &["cylinder"],
        };
        for &table in required {
            if !root.contains_key(table) {
                return Err(MachineFileError::MissingTable { place: Place::file(self.file), table });
            }
        }
        if self.result.machine.source == Source::Force {
            force::takes_part(&self, root)?;
        }
        let has_area = [Parameter::AreaA, Parameter::AreaB].iter().any(|area| self.result.given.contains(area));
        for &parameter in Parameter::ALL {
            let what = parameter.description();
            let given = self.result.given.contains(&parameter);
            let needs_area = has_area && what.default == Fallback::Required;
            if !given && (needs_area || keys::is_required(parameter, self.result.machine.source)) {
                let place = self.key_place(root, keys::address(parameter).table);
                let (key, unit, meaning) = (what.key, what.unit, what.meaning);
                return Err(MachineFileError::MissingKey { place, key, unit, meaning });
            }
            if !given {
                let value = keys::fallback(parameter, &self.result.machine);
                self.result.machine.set(parameter, value);
            }
        }
        self.floor(root)?;
        self.result.channels.linkage = self.linkage(root)?;
        Ok(self.result)
    }

    /// A table for cavitation has to give the lowest pressure: above vacuum, and not above the tank's pressure.
    fn floor(&self, root: &dyn TableLike) -> Result<(), MachineFileError> {
        let what = Parameter::CavitationFloor.description();
        let address = keys::address(Parameter::CavitationFloor);
        let Some(effect) = address.table.strip_prefix(EFFECTS) else { return Ok(()) };
        let Some(effects) = root.get("effects").and_then(Item::as_table_like) else { return Ok(()) };
        let Some(table) = effects.get(effect).and_then(Item::as_table_like) else { return Ok(()) };
        let Some(given) = table.get(address.key) else {
            let (place, key) = (self.key_place(effects, effect), what.key);
            return Err(MachineFileError::MissingKey { place, key, unit: what.unit, meaning: what.meaning });
        };
        let value = |parameter| self.result.machine.get(parameter);
        let (floor_pa, tank_pa) = (value(Parameter::CavitationFloor), value(Parameter::TankPressure));
        // The default means that there is no floor; it is allowed because a saved file may contain it.
        if floor_pa <= what.min || (LOWEST_FLOOR_PA..=tank_pa).contains(&floor_pa) {
            return Ok(());
        }
        let tank_key = Parameter::TankPressure.description().key;
        let place = self.place(given.span());
        Err(MachineFileError::Floor { place, key: what.key, floor_pa, tank_key, tank_pa, vacuum_pa: LOWEST_FLOOR_PA })
    }
}
