//! Why a machine file cannot be used.

use std::{fmt, io};

use model_core::machine::{MachineError, Tick};
use recording::files::atomic;
use recording::files::source_error::{Explained, Place, after_number, quoted};
use recording::linkage::LinkageError;

/// Why a machine file cannot be read or written.
#[expect(missing_docs, reason = "every field is named in the text of its variant; `place` is where it was found")]
#[derive(Debug, thiserror::Error)]
pub enum MachineFileError {
    /// The file cannot be opened or read.
    Io { place: Place, source: io::Error },
    /// The file cannot be written.
    Write { place: Place, source: io::Error },
    /// The file is larger than any machine file.
    TooLarge { place: Place, most_bytes: u64 },
    /// The file is not UTF-8 text.
    NotUtf8 { place: Place },
    /// The file is not TOML.
    Syntax { place: Place, message: String },
    /// An unknown table.
    UnknownTable { place: Place, table: String, nearest: Option<String>, known: Box<[String]> },
    /// A key that is not known in its table; `table` is empty at the top of the file.
    UnknownKey { place: Place, table: String, key: String, nearest: Option<String>, known: Box<[String]> },
    /// A table that is required in every machine file of this drive.
    MissingTable { place: Place, table: &'static str },
    /// A key that is required in its table.
    MissingKey { place: Place, key: &'static str, unit: &'static str, meaning: &'static str },
    /// A value of the wrong type.
    WrongType { place: Place, key: String, found: String, expected: &'static str },
    /// A value outside the range of the parameter, including NaN.
    OutOfRange { place: Place, key: String, value: f64, min: f64, max: f64, unit: &'static str },
    /// A floor of the pressures that is below vacuum or above the tank's pressure.
    Floor { place: Place, key: &'static str, floor_pa: f64, tank_key: &'static str, tank_pa: f64, vacuum_pa: f64 },
    /// A number of a list that is not a whole number.
    NotWhole { place: Place, key: String, value: f64, max: f64 },
    /// A standard deviation or a tolerance that is not a positive finite number.
    NotPositive { place: Place, table: &'static str, key: String, value: f64 },
    /// An array with too many entries.
    TooManyEntries { place: Place, key: String, found: usize, most: usize },
    /// Both `[valve]` and `[pump]`.
    TwoSources { place: Place },
    /// Neither `[valve]` nor `[pump]` nor `[cylinder]`.
    NoSource { place: Place },
    /// What takes no part in a machine with neither `[valve]` nor `[pump]`.
    WithoutSource { place: Place, found: String },
    /// `[directional_valve]` in a drive without pump.
    DirectionalValveWithoutPump { place: Place },
    /// A text that is not one of the choices of its key.
    UnknownChoice { place: Place, key: String, found: String, choices: &'static str },
    /// A key of `[channels]` that is not a signal.
    UnknownSignal { place: Place, found: String, nearest: &'static str },
    /// A signal is mapped to the empty text, or a column without a name is to be left unused.
    EmptyHeader { place: Place, signal: &'static str },
    /// A sensor whose reading does not change with the signal.
    NoSpan { place: Place, key: String },
    /// A linkage that is given twice.
    TwoLinkages { place: Place, one: &'static str, other: &'static str },
    /// Sides or a table that make no linkage.
    Linkage { place: Place, cause: LinkageError },
    /// A drive that is too fast, too slow or too uneven for the model's shortest step.
    NotCarried { place: Place, cause: MachineError },
    /// Fitted values that make a drive which a tick does not compute.
    FittedNotCarried { place: Place, tick: Tick, shorter_computes: bool, cause: MachineError },
}

use MachineFileError as E;

impl Explained for MachineFileError {
    fn place(&self) -> &Place {
        match self {
            E::Io { place, .. }
            | E::Write { place, .. }
            | E::TooLarge { place, .. }
            | E::NotUtf8 { place }
            | E::Syntax { place, .. }
            | E::UnknownTable { place, .. }
            | E::UnknownKey { place, .. }
            | E::MissingTable { place, .. }
            | E::MissingKey { place, .. }
            | E::WrongType { place, .. }
            | E::OutOfRange { place, .. }
            | E::Floor { place, .. }
            | E::NotWhole { place, .. }
            | E::NotPositive { place, .. }
            | E::TooManyEntries { place, .. }
            | E::TwoSources { place }
            | E::NoSource { place }
            | E::WithoutSource { place, .. }
            | E::DirectionalValveWithoutPump { place }
            | E::UnknownChoice { place, .. }
            | E::UnknownSignal { place, .. }
            | E::EmptyHeader { place, .. }
            | E::NoSpan { place, .. }
            | E::TwoLinkages { place, .. }
            | E::Linkage { place, .. }
            | E::NotCarried { place, .. }
            | E::FittedNotCarried { place, .. } => place,
        }
    }

    fn found(&self) -> String {
        match self {
            E::Io { source, .. } => format!("cannot be read: {source}"),
            E::Write { source, .. } => format!("cannot be written: {source}"),
            E::TooLarge { most_bytes, .. } => format!("more than {most_bytes} bytes"),
            E::NotUtf8 { .. } => "bytes that are not UTF-8 text".into(),
            E::Syntax { message, .. } => format!("not TOML: {message}"),
            E::UnknownTable { table, .. } => format!("unknown table [{table}]"),
            E::UnknownKey { table, key, .. } if table.is_empty() => format!("unknown key {}", quoted(key)),
            E::UnknownKey { table, key, .. } => format!("unknown key {} in [{table}]", quoted(key)),
            E::MissingTable { table, .. } => format!("there is no table [{table}]"),
            E::MissingKey { key, .. } => format!("`{key}` is missing"),
            E::WrongType { key, found, .. } => format!("`{key}` is of type {found}"),
            E::OutOfRange { key, value, unit, .. } => format!("`{key}` is {value:?}{}", after_number(unit)),
            E::Floor { key, floor_pa, .. } => format!("`{key}` is {floor_pa:?} Pa"),
            E::NotWhole { key, value, .. } => format!("`{key}` is {value:?}"),
            E::NotPositive { table, key, value, .. } => format!("`{key}` in [{table}] is {value:?}"),
            E::TooManyEntries { key, found, .. } => format!("`{key}` has {found} entries"),
            E::TwoSources { .. } => "both [valve] and [pump]".into(),
            E::NoSource { .. } => "neither [valve] nor [pump], and no [cylinder]".into(),
            E::WithoutSource { found, .. } => format!("{found}, but neither [valve] nor [pump]"),
            E::DirectionalValveWithoutPump { .. } => "[directional_valve] in a drive without [pump]".into(),
            E::UnknownChoice { key, found, .. } => format!("`{key}` is {}", quoted(found)),
            E::UnknownSignal { found, .. } => format!("{} is not a known signal", quoted(found)),
            E::EmptyHeader { signal, .. } => format!("`channels.{signal}` names a column without a header"),
            E::NoSpan { key, .. } => format!("`{key}` is 0"),
            E::TwoLinkages { one, other, .. } => format!("`linkage.{other}` beside `linkage.{one}`"),
            E::NotCarried { cause, .. } => {
                format!("a drive that the model's shortest step of 0.5 ms does not compute: {cause}")
            }
            E::FittedNotCarried { tick, cause, .. } => {
                let tick_ms = 1e3 * tick.seconds();
                format!("not written: the model's step of {tick_ms} ms does not compute the fitted values: {cause}")
            }
            E::Linkage { cause, .. } => match cause {
                LinkageError::NoTriangle { length_m, .. } => {
                    format!("the sides of [linkage] make no triangle with a cylinder of {} m", rounded(*length_m))
                }
                LinkageError::Entries { angles, positions } => {
                    format!("the table of [linkage] has {angles} angles and {positions} positions")
                }
                LinkageError::TurnsBack { in_positions, entry, before, found } => {
                    let (key, unit) = if *in_positions { ("positions_m", "m") } else { ("the angles", "rad") };
                    let [before, found] = [before, found].map(|value| rounded(*value));
                    format!("in [linkage], entry {entry} of {key} is {found} {unit} after {before} {unit}")
                }
            },
        }
    }

    fn expected(&self) -> String {
        match self {
            E::Io { .. } => "a readable machine file".into(),
            E::Write { source, .. } => atomic::expected(source).into(),
            E::TooLarge { .. } => "a machine file, which is a page of text".into(),
            E::NotUtf8 { .. } => "text in UTF-8".into(),
            E::Syntax { message, .. } if message.contains("duplicate key") => {
                "each table and each key once: the lines of a second table [channels] belong below the first".into()
            }
            E::Syntax { .. } => "tables such as [valve] with lines `key = value`".into(),
            E::UnknownTable { nearest, known, .. } | E::UnknownKey { nearest, known, .. } => {
                let known = if known.is_empty() { "no keys".into() } else { known.join(", ") };
                nearest
                    .as_ref()
                    .map_or_else(|| format!("one of: {known}"), |name| format!("perhaps `{name}`; known here: {known}"))
            }
            E::MissingTable { table, .. } => format!("a table [{table}]"),
            E::MissingKey { key, unit, meaning, .. } => match *unit {
                "1" => format!("`{key}`: {meaning}"),
                unit => format!("`{key}` in {unit}: {meaning}"),
            },
            E::WrongType { expected, .. } => (*expected).to_owned(),
            E::OutOfRange { min, max, unit, .. } if max.is_infinite() => {
                format!("at least {min:?}{}", after_number(unit))
            }
            E::OutOfRange { min, max, unit, .. } => format!("{min:?} to {max:?}{}", after_number(unit)),
            E::Floor { tank_key, tank_pa, vacuum_pa, .. } => {
                format!("{vacuum_pa:?} Pa (vacuum) to `{tank_key}`, which is {tank_pa:?} Pa")
            }
            E::NotWhole { max, .. } => format!("a whole number from 0 to {max}"),
            E::NotPositive { .. } => "a positive number; a value that does not move is not listed".into(),
            E::TooManyEntries { most, .. } => format!("at most {most}"),
            E::TwoSources { .. } => "[valve] for a valve-controlled drive, or [pump] for a pump-controlled one".into(),
            E::NoSource { .. } => "[valve] for a valve-controlled drive, [pump] for a pump-controlled one, or [cylinder] alone for a mass that a \
                recorded force moves"
                .into(),
            E::WithoutSource { .. } => "[valve] or [pump] beside it: is one missing? A machine with neither is a mass that a recorded force moves: its \
                file has [cylinder] (moving_mass_kg, viscous_friction_n_s_per_m, stroke_m, and both areas where the chamber pressures are that \
                force), [load], [sensing], [linkage], and effects of the mechanics and of its sensors"
                .into(),
            E::DirectionalValveWithoutPump { .. } => "[directional_valve] only beside [pump]".into(),
            E::UnknownChoice { choices, .. } => (*choices).to_owned(),
            E::UnknownSignal { nearest, .. } => format!("the name of a signal, perhaps `{nearest}`"),
            E::EmptyHeader { .. } => "the header of a column, such as \"Kolbenweg [mm]\"".into(),
            E::NoSpan { .. } => "a number that is not 0: by how much the reading rises when the signal rises by one SI unit, or the flow at the full reading".into(),
            E::TwoLinkages { .. } => "one linkage: its sides, or a table of angles and positions".into(),
            E::NotCarried { .. } => "numbers of one drive: check bore, stroke, mass and rated flow with their units, and give the hoses and the dead volume".into(),
            E::FittedNotCarried { shorter_computes: true, .. } => {
                "--tick 0.5, which computes them, or a smaller standard deviation of the value in [fit.sigma]".into()
            }
            E::FittedNotCarried { .. } => {
                "a smaller standard deviation of the value in [fit.sigma], or a smaller [fit.tolerance]".into()
            }
            E::Linkage { cause, .. } => match cause {
                LinkageError::NoTriangle { shortest_m, longest_m, .. } => {
                    let [shortest, longest] = [shortest_m, longest_m].map(|length| rounded(*length));
                    format!(
                        "from foot to eye {shortest} to {longest} m, the difference and the sum of base_m and arm_m, over the whole stroke"
                    )
                }
                LinkageError::Entries { .. } => "as many positions as angles, at least two".into(),
                LinkageError::TurnsBack { .. } => "values that rise throughout, or fall throughout".into(),
            },
        }
    }

    fn key(&self) -> Option<String> {
        match self {
            E::UnknownTable { table, .. } => Some(table.clone()),
            E::UnknownKey { table, key, .. } if table.is_empty() => Some(key.clone()),
            E::UnknownKey { table, key, .. } => Some(format!("{table}.{key}")),
            E::MissingTable { table, .. } => Some((*table).to_owned()),
            E::MissingKey { key, .. } | E::Floor { key, .. } => Some((*key).to_owned()),
            E::WrongType { key, .. }
            | E::OutOfRange { key, .. }
            | E::NotWhole { key, .. }
            | E::NotPositive { key, .. }
            | E::TooManyEntries { key, .. }
            | E::UnknownChoice { key, .. }
            | E::NoSpan { key, .. } => Some(key.clone()),
            E::UnknownSignal { found, .. } => Some(format!("channels.{found}")),
            E::EmptyHeader { signal, .. } => Some(format!("channels.{signal}")),
            E::TwoLinkages { other, .. } => Some(format!("linkage.{other}")),
            E::Io { .. }
            | E::Write { .. }
            | E::TooLarge { .. }
            | E::NotUtf8 { .. }
            | E::Syntax { .. }
            | E::TwoSources { .. }
            | E::NoSource { .. }
            | E::WithoutSource { .. }
            | E::DirectionalValveWithoutPump { .. }
            | E::Linkage { .. }
            | E::NotCarried { .. }
            | E::FittedNotCarried { .. } => None,
        }
    }
}

/// A length or an angle to a micrometre or a millionth of a radian.
fn rounded(value: f64) -> f64 {
    (1e6 * value).round() / 1e6
}

impl fmt::Display for MachineFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; expected {}", self.place(), self.found(), self.expected())
    }
}
