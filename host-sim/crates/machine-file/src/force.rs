//! What takes no part in a machine that has neither valve nor pump and is moved by a recorded force: a file that holds it lacks its `[valve]` or `[pump]`.

use toml_edit::{Item, TableLike};

use model_core::machine::{Parameter, Source};

use crate::LoadSource;
use crate::error::MachineFileError;
use crate::keys::{self, EFFECTS};
use crate::reader::Reader;

/// The last quantity of a correction table that acts on a mass, and the last state of a mass: a force, and the position.
const LAST: [(Parameter, f64); 3] =
    [(Parameter::TableQuantity, 1.0), (Parameter::TableOver, 2.0), (Parameter::TableOver2, 2.0)];

/// Checks that the file holds nothing else than mass, load, sensors and their effects.
pub(crate) fn takes_part(reader: &Reader<'_>, root: &dyn TableLike) -> Result<(), MachineFileError> {
    let refused = |table: &dyn TableLike, key: &str, found: String| {
        Err(MachineFileError::WithoutSource { place: reader.key_place(table, key), found })
    };
    let value = |parameter| reader.result.machine.get(parameter);
    for (name, table) in tables(root) {
        if !matches!(name, "effects" | "fit" | "channels") && !keys::belongs(name, Source::Force) {
            return refused(root, name, format!("[{name}]"));
        }
        for (key, item) in table.iter() {
            match name {
                "effects" if !keys::belongs(&format!("{EFFECTS}{key}"), Source::Force) => {
                    return refused(table, key, format!("[{EFFECTS}{key}]"));
                }
                "fit" => {
                    let Some(of) = item.as_table_like() else { continue };
                    let acts = |key: &str| named(key).is_none_or(|parameter| parameter.is_of(Source::Force));
                    if let Some((other, _)) = of.iter().find(|(key, _)| !acts(key)) {
                        return refused(of, other, format!("`{other}` in [fit.{key}]"));
                    }
                }
                "effects" => {
                    let Some(of) = item.as_table_like() else { continue };
                    let is_beyond = |&&(parameter, last): &&(Parameter, f64)| {
                        keys::table_of(parameter) == format!("{EFFECTS}{key}") && value(parameter) > last
                    };
                    if let Some((parameter, _)) = LAST.iter().find(is_beyond) {
                        let found = format!("`{}` is {}", parameter.description().key, value(*parameter));
                        return refused(of, keys::address(*parameter).key, found);
                    }
                }
                "channels" => {}
                _ if keys::at_key(name, key).iter().any(|parameter| !parameter.is_of(Source::Force)) => {
                    return refused(table, key, format!("`{name}.{key}`"));
                }
                _ => {}
            }
        }
    }
    if reader.result.load_source != LoadSource::Constant {
        let found = format!("`load.source` is \"{}\"", reader.result.load_source.name());
        return Err(MachineFileError::WithoutSource { place: reader.key_place(root, "load"), found });
    }
    Ok(())
}

/// The tables at the top, in the order of the file.
fn tables(root: &dyn TableLike) -> impl Iterator<Item = (&str, &dyn TableLike)> {
    root.iter().filter_map(|(name, item): (&str, &Item)| Some((name, item.as_table_like()?)))
}

/// The parameter of this full key.
fn named(key: &str) -> Option<Parameter> {
    Parameter::ALL.iter().copied().find(|parameter| parameter.description().key == key)
}
