//! The columns of a table that hold amounts of effects.

use model_core::machine::Parameter;

/// The column of an effect's amount: `internal_leakage_conductance_m3_per_s_pa` of `effects.internal-leakage.conductance_m3_per_s_pa`; so that a query
/// needs no quotation marks. `None` of what is no effect.
#[must_use]
pub fn column_of(parameter: Parameter) -> Option<String> {
    parameter.effect()?;
    let key = parameter.description().key;
    let name = key.strip_prefix("effects.").unwrap_or(key);
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    Some(name.chars().map(plain).collect::<String>().trim_end_matches('_').to_owned())
}

/// The column of its standard deviation.
#[must_use]
pub fn deviation_of(parameter: Parameter) -> Option<String> {
    Some(format!("{}_std", column_of(parameter)?))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_amount_has_a_column_of_its_own() {
        let all: Vec<String> =
            Parameter::ALL.iter().flat_map(|&one| column_of(one).into_iter().chain(deviation_of(one))).collect();
        assert!(all.contains(&"internal_leakage_conductance_m3_per_s_pa".to_owned()), "{all:?}");
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), all.len(), "{all:?}");
    }
}
