//! A value that was still moving where a search ended.

use identification::fit::{Unrest, Unsettled};
use model_core::machine::Parameter;
use recording::display_unit::{in_si, significant};

/// Which value it was, why, and what to do.
#[must_use]
pub fn still_moving(unsettled: &Unsettled) -> String {
    let description = unsettled.parameter.description();
    let unit = if description.unit == "1" { String::new() } else { format!(" {}", description.unit) };
    let (value, towards) = (in_si(unsettled.value, 4), in_si(unsettled.towards, 4));
    let why = match unsettled.why {
        Unrest::AtBound => {
            "it is at the end of its range: look for a wrong unit or a wrong value beside it, or take it out of [fit.sigma]".to_owned()
        }
        Unrest::With(other, coefficient) => format!(
            "only its combination with {} is determined (r = {}): take one of the two out of [fit.sigma], or give it less freedom",
            key(other),
            significant(coefficient, 2)
        ),
        Unrest::Bent => {
            "it is bent by what the model lacks: find that first, or give it less freedom in [fit.sigma] or [fit.tolerance]".to_owned()
        }
    };
    format!("{} was still moving from {value} towards {towards}{unit}; {why}", description.key)
}

fn key(parameter: Parameter) -> &'static str {
    parameter.description().key
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_is_told_with_what_holds_it_loosely() {
        let told =
            |why| still_moving(&Unsettled { parameter: Parameter::VolumeA, value: 1.2e-4, towards: 1.9e-4, why });
        assert_eq!(
            told(Unrest::With(Parameter::BulkModulus, -0.98)),
            "cylinder.volume_a_m3 was still moving from 1.200e-4 towards 1.900e-4 m3; only its combination with cylinder.bulk_modulus_pa is \
             determined (r = -0.98): take one of the two out of [fit.sigma], or give it less freedom"
        );
        assert!(told(Unrest::AtBound).contains("the end of its range"));
        assert!(told(Unrest::Bent).contains("bent by what the model lacks"));
    }
}
