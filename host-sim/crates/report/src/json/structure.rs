//! Linear models beside the machine's, and what shows a wrong structure, as JSON.

use serde_json::{Value, json};

use diagnosis::Diagnosis;
use diagnosis::structure::{Measured, Shows};

use super::diagnosis::digits;
use crate::wording;

/// The linear model of each signal.
pub(super) fn yardstick(diagnosis: &Diagnosis) -> Vec<Value> {
    let each = |measured: &Measured| {
        let linear = &measured.linear;
        json!({
            "signal": measured.yardstick.signal.name(),
            "kind": if linear.integrates() { "integrates" } else { "follows" },
            "gains": linear.gains.iter().map(|gain| digits(*gain, 5)).collect::<Vec<_>>(),
            "settling_s": digits(linear.shape.settling_s(), 4),
            "delay_s": digits(linear.delay_s, 4),
            "train": digits(measured.training_percent, 6),
            "holdout": measured.held_out_percent.map(|fit| digits(fit, 6)),
            "better": measured.is_better,
        })
    };
    diagnosis.structure.measured.iter().map(each).collect()
}

/// What shows that the structure is wrong; null where nothing does.
pub(super) fn structure(diagnosis: &Diagnosis) -> Value {
    let Some(sentence) = wording::structure(diagnosis) else { return Value::Null };
    let each = |shows: &Shows| {
        let sentence = wording::shown(diagnosis, shows);
        match shows {
            Shows::Follows { gain, settling_s, follows_percent, integrates_percent } => json!({
                "kind": "follows", "sentence": sentence, "gain": digits(*gain, 5), "settling_s": digits(*settling_s, 4),
                "follows": digits(*follows_percent, 6), "integrates": digits(*integrates_percent, 6),
            }),
            Shows::MovesUncommanded(moves) => json!({
                "kind": "moves-uncommanded", "sentence": sentence, "way_m": digits(moves.all_m, 4),
                "at_neutral_m": digits(moves.at_neutral_m, 4), "against_m": digits(moves.against_m, 4),
                "recording": moves.recording, "from_s": digits(moves.from_s, 6), "to_s": digits(moves.to_s, 6),
            }),
            Shows::SupplySags(sag) => json!({
                "kind": "supply-sags", "sentence": sentence, "by_pa": digits(sag.by_pa, 4),
                "recording": sag.recording, "from_s": digits(sag.from_s, 6), "to_s": digits(sag.to_s, 6),
            }),
        }
    };
    json!({ "sentence": sentence, "shows": diagnosis.structure.shows.iter().map(each).collect::<Vec<_>>() })
}
