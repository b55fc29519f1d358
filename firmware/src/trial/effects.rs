//! The forms of a trial: what an installed drive has, the effects of the table in their trial forms, and the correction table.

use model_core::effects::Effect;
use model_core::machine::{BASE_FORMS, Form, Machine, Parameter as P};

/// Every form of every effect, in the order of the chain, then those of the correction table and of the base parameters.
pub fn forms() -> impl Iterator<Item = &'static Form> {
    effect_forms().chain(BASE_FORMS)
}

fn effect_forms() -> impl Iterator<Item = &'static Form> {
    Effect::ALL.iter().flat_map(|effect| effect.trial()).chain(CORRECTION_TABLE)
}

/// The machine with all effects at once, each in its first form.
#[must_use]
pub fn every_effect(machine: &Machine<f64>) -> Machine<f64> {
    let first = Effect::ALL.iter().filter_map(|effect| effect.trial().first()).chain(CORRECTION_TABLE.first());
    first.fold(*machine, |machine, form| machine.with(form.values))
}

/// What a diagnosis finds most often in an installed drive, in the order in which [`several_effects`] takes them.
const USUAL: [Effect; 5] = [
    Effect::CoulombFriction,
    Effect::InternalLeakage,
    Effect::ValveHysteresis,
    Effect::FlowGainNonlinearity,
    Effect::PositionDependentVolume,
];

/// The machine with so many effects at once, 1 to 5 usual ones, each in its first form; and their count in words.
#[must_use]
pub fn several_effects<const COUNT: usize>(machine: &Machine<f64>) -> (&'static str, Machine<f64>) {
    const { assert!(COUNT > 0 && COUNT <= USUAL.len(), "there are five usual effects") };
    let name = ["one usual effect", "two usual effects", "three usual effects", "four usual effects"]
        .get(COUNT - 1)
        .copied()
        .unwrap_or("five usual effects");
    let first = USUAL.iter().take(COUNT).filter_map(|effect| effect.trial().first());
    (name, first.fold(*machine, |machine, form| machine.with(form.values)))
}

/// The correction table for unnamed effects, once for each quantity that it may add to.
const CORRECTION_TABLE: &[Form] = &[
    Form {
        name: "unnamed",
        values: &[
            (P::TableQuantity, 1.0),
            (P::TableOver, 1.0),
            (P::TableOver2, 2.0),
            (P::TableFrom, -0.2),
            (P::TableTo, 0.2),
            (P::TableFrom2, 0.1),
            (P::TableTo2, 0.2),
            (P::TableValue0, 300.0),
            (P::TableValue4, 200.0),
            (P::TableValue8, -100.0),
            (P::TableValue10, 50.0),
            (P::TableValue13, -150.0),
            (P::TableValue17, -250.0),
            (P::TableValue20, -300.0),
        ],
    },
    Form {
        name: "unnamed, flow into A",
        values: &[
            (P::TableQuantity, 2.0),
            (P::TableOver, 4.0),
            (P::TableFrom, 1e6),
            (P::TableTo, 6e6),
            (P::TableValue1, 1e-6),
            (P::TableValue3, -1e-6),
            (P::TableValue6, 2e-6),
        ],
    },
    Form {
        name: "unnamed, flow out of B",
        values: &[
            (P::TableQuantity, 3.0),
            (P::TableOver, 5.0),
            (P::TableFrom, 1e6),
            (P::TableTo, 6e6),
            (P::TableValue1, 1e-6),
            (P::TableValue3, -1e-6),
            (P::TableValue6, 2e-6),
        ],
    },
    Form {
        name: "unnamed, spool travel",
        values: &[
            (P::TableQuantity, 4.0),
            (P::TableOver, 3.0),
            (P::TableFrom, -0.5),
            (P::TableTo, 0.5),
            (P::TableValue1, 0.01),
            (P::TableValue5, -0.02),
        ],
    },
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_table_of_effects_in_a_machine_file_is_tried_and_sets_nothing_else() {
        let of = |parameter: P| Some(parameter.description().key.strip_prefix("effects.")?.split_once('.')?.0);
        let known: BTreeSet<&str> = P::ALL.iter().filter_map(|&parameter| of(parameter)).collect();
        let mut tried = BTreeSet::new();
        for form in effect_forms() {
            let own = form.name.split(',').next();
            assert!(form.values.iter().all(|&(parameter, _)| of(parameter) == own), "{form:?}");
            tried.extend(own);
        }
        assert_eq!(tried, known);
    }
}
