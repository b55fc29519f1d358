//! Names that contain a unit where brackets are not allowed: `position_mm`, `velocity_m_per_s`.
//!
//! The unit stands after an underscore as its symbol, or as the symbol in lower case; characters that are not letters are spelt out:
//! `m_per_s`, `percent`, `degC`, `us`, `one`. In writing, symbols keep their case.

use crate::signal::split_header;
use crate::unit::{Dimension, Unit};

/// Longest name that MATLAB accepts.
const LONGEST: usize = 63;

/// A unit's symbol in letters, digits and underscores.
fn suffix(unit: Unit) -> String {
    match unit.symbol() {
        "1" => "one".to_owned(),
        "%" => "percent".to_owned(),
        "°C" => "degC".to_owned(),
        "µs" => "us".to_owned(),
        symbol => symbol.replace('/', "_per_"),
    }
}

/// Splits a name at its unit, where it ends with one: `position_mm` is `position` in `mm`.
pub(crate) fn split_suffix(name: &str) -> Option<(&str, Unit)> {
    let fits = |unit: Unit| {
        let suffix = suffix(unit);
        let before = name.strip_suffix(&suffix).or_else(|| name.strip_suffix(&suffix.to_ascii_lowercase()));
        before.and_then(|before| before.strip_suffix('_')).filter(|before| !before.is_empty()).map(|name| (name, unit))
    };
    // The unit of `speed_mm_per_s` is mm/s and not s.
    Unit::all().filter_map(fits).min_by_key(|(name, _)| name.len())
}

/// The header of a column as a name of letters, digits and underscores, with its unit; it differs from all names in `taken`.
pub(crate) fn variable(header: &str, unit: Unit, taken: &[String]) -> String {
    let (name, _) = split_header(header);
    let name = split_suffix(name).filter(|(_, own)| *own == unit).map_or(name, |(short, _)| short);
    let letters = |character: char| if character.is_ascii_alphanumeric() { character } else { '_' };
    let mut plain: String = name.chars().map(letters).collect();
    if !plain.starts_with(|first: char| first.is_ascii_alphabetic()) {
        plain.insert_str(0, "x_");
    }
    let told = Unit::parse(unit.symbol()).is_some() && unit != Unit::si(Dimension::Ratio);
    let end = if told { format!("_{}", suffix(unit)) } else { String::new() };
    (1..=taken.len() + 1)
        .map(|count| {
            let end = if count == 1 { end.clone() } else { format!("_{count}{end}") };
            format!("{}{end}", &plain[..plain.len().min(LONGEST - end.len().min(LONGEST - 1))])
        })
        .find(|name| !taken.contains(name))
        .expect("there are more numbers than columns")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_is_found_behind_a_name_again() {
        for unit in Unit::all() {
            let name = format!("x_{}", suffix(unit));
            assert_eq!(split_suffix(&name), Some(("x", unit)), "{name}");
            assert!(name.chars().all(|character| character.is_ascii_alphanumeric() || character == '_'), "{name}");
        }
        assert_eq!(split_suffix("pump_speed_rev_per_s").unwrap().0, "pump_speed");
        assert_eq!(split_suffix("pressure_a_pa").unwrap().1.symbol(), "Pa");
        for plain in ["pressure_a", "position", "mm", "_mm", "position_MM", "position_inch"] {
            assert_eq!(split_suffix(plain), None, "{plain}");
        }
    }

    #[test]
    fn headers_become_names_that_differ() {
        let unit = |symbol| Unit::parse(symbol).unwrap();
        let mut taken = Vec::new();
        let mut name = |header, symbol| {
            taken.push(variable(header, unit(symbol), &taken));
            taken.last().cloned().unwrap()
        };
        assert_eq!(name("position [mm]", "mm"), "position_mm");
        assert_eq!(name("spool [1]", "1"), "spool");
        assert_eq!(name("velocity [mm/s]", "mm/s"), "velocity_mm_per_s");
        assert_eq!(name("2. Druck ö [bar]", "bar"), "x_2__Druck___bar");
        assert_eq!(name("2. Druck ä [bar]", "bar"), "x_2__Druck___2_bar");
        let long = name(&"x".repeat(100), "kN");
        assert!(long.len() == LONGEST && long.ends_with("_kN"), "{long}");
    }
}
