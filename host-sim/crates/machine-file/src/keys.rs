//! The tables and keys of a machine file, taken from the table of parameters.

use model_core::machine::{Fallback, Machine, Parameter, Source};

/// A parameter's key, split into its parts: `valve.time_constants_s[0]` is entry 0 of an array in `[valve]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Address {
    pub(crate) table: &'static str,
    pub(crate) key: &'static str,
    /// Entry of an array, for keys that hold several parameters.
    pub(crate) index: Option<usize>,
}

pub(crate) const EFFECTS: &str = "effects.";

/// Where a parameter stands.
pub(crate) fn address(parameter: Parameter) -> Address {
    let full = parameter.description().key;
    let (table, last) = full.rsplit_once('.').unwrap_or(("", full));
    match last.strip_suffix(']').and_then(|rest| rest.split_once('[')) {
        Some((key, index)) => Address { table, key, index: index.parse().ok() },
        None => Address { table, key: last, index: None },
    }
}

/// Every parameter of a table.
pub(crate) fn in_table(table: &str) -> impl Iterator<Item = (Parameter, Address)> {
    Parameter::ALL.iter().map(|&parameter| (parameter, address(parameter))).filter(move |(_, at)| at.table == table)
}

/// The parameters of one key, in the order of its array.
pub(crate) fn at_key(table: &str, key: &str) -> Vec<Parameter> {
    in_table(table).filter(|(_, at)| at.key == key).map(|(parameter, _)| parameter).collect()
}

/// The keys of a table, each once.
pub(crate) fn keys(table: &str) -> Vec<&'static str> {
    let mut keys: Vec<_> = in_table(table).map(|(_, at)| at.key).collect();
    keys.dedup();
    keys
}

/// The tables that hold parameters, each once, in the order of the machine file.
pub(crate) fn tables() -> Vec<&'static str> {
    let mut tables: Vec<_> = Parameter::ALL.iter().map(|&parameter| address(parameter).table).collect();
    tables.dedup();
    tables
}

/// The names of the effects: the tables below `effects`.
pub(crate) fn effects() -> impl Iterator<Item = &'static str> {
    tables().into_iter().filter_map(|table| table.strip_prefix(EFFECTS))
}

/// The table that holds a parameter: `valve`, `effects.internal-leakage`.
pub fn table_of(parameter: Parameter) -> &'static str {
    address(parameter).table
}

/// The effect to which a table belongs.
pub fn effect_of(table: &str) -> Option<&str> {
    table.strip_prefix(EFFECTS)
}

/// Whether a table is meaningful for a drive with this source.
pub fn belongs(table: &str, source: Source) -> bool {
    in_table(table).any(|(parameter, _)| parameter.is_of(source))
}

/// Whether the file of a drive with this source must give a parameter; one area, where it gives the other.
pub(crate) fn is_required(parameter: Parameter, source: Source) -> bool {
    match source {
        Source::Force => matches!(parameter, Parameter::MovingMass | Parameter::ViscousFriction),
        Source::Valve | Source::Pump => parameter.description().default == Fallback::Required,
    }
}

/// The value of a parameter that is not in the file; NaN for a required parameter, and 0 for areas and volumes that a drive does not have.
pub(crate) fn fallback(parameter: Parameter, machine: &Machine<f64>) -> f64 {
    let half_stroke = |area| machine.get(area) * machine.get(Parameter::Stroke) / 2.0;
    match (parameter.description().default, parameter) {
        (Fallback::Value(value), _) => value,
        _ if machine.source == Source::Force => 0.0,
        (Fallback::Required, _) => f64::NAN,
        (Fallback::HalfStrokeVolume, Parameter::VolumeA) => half_stroke(Parameter::AreaA),
        (Fallback::HalfStrokeVolume, _) => half_stroke(Parameter::AreaB),
    }
}

/// The known name most similar to an unknown one, if any is similar enough.
pub(crate) fn nearest<S: AsRef<str>>(found: &str, known: impl IntoIterator<Item = S>) -> Option<String> {
    const ALIKE: f64 = 0.75;
    known
        .into_iter()
        .map(|name| (strsim::jaro_winkler(found, name.as_ref()), name))
        .filter(|(alike, _)| *alike >= ALIKE)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name.as_ref().to_owned())
}

/// The full key that was probably meant by an unknown key of a table.
pub(crate) fn suggest(table: &str, found: &str) -> Option<String> {
    let everywhere = || tables().into_iter().flat_map(|table| keys(table).into_iter().map(move |key| (table, key)));
    let full = |table: &str, key: &str| format!("{table}.{key}");
    everywhere()
        .find(|(_, key)| *key == found)
        .map(|(table, key)| full(table, key))
        .or_else(|| nearest(found, keys(table)).map(|key| full(table, &key)))
        .or_else(|| {
            let key = nearest(found, everywhere().map(|(_, key)| key))?;
            everywhere().find(|(_, known)| *known == key).map(|(table, key)| full(table, key))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_taken_apart() {
        let at = address(Parameter::TimeConstant2);
        assert_eq!(at, Address { table: "valve", key: "time_constants_s", index: Some(1) });
        assert_eq!(at_key("valve", "time_constants_s"), [Parameter::TimeConstant1, Parameter::TimeConstant2]);
        assert_eq!(address(Parameter::CoulombFriction).table, "effects.coulomb-friction");
        assert!(effects().any(|name| name == "internal-leakage"));
    }

    #[test]
    fn every_table_of_parameters_stands_together() {
        let mut tables = tables();
        let listed = tables.len();
        tables.sort_unstable();
        tables.dedup();
        assert_eq!(tables.len(), listed);
    }

    #[test]
    fn a_wrong_key_is_met_with_the_nearest_known_one() {
        assert_eq!(suggest("supply", "pressure_bar").as_deref(), Some("supply.pressure_pa"));
        assert_eq!(suggest("valve", "moving_mass_kg").as_deref(), Some("cylinder.moving_mass_kg"));
        assert_eq!(suggest("valve", "zzz"), None);
    }
}
