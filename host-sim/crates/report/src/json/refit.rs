//! A refit as JSON, schema `host-sim/fit/1`: SI units, as in a machine file.

use serde_json::{Value, json};

use diagnosis::localisation::Miss;
use diagnosis::{Refit, mean_fits, mean_noise_floor, worse_held_out};

use super::diagnosis::{correlation, estimate, far_value, rounded, still_above_noise, tolerance, unsettled};
use crate::terminal::missed;
use crate::wording::fit_is_worse;

/// The document.
#[must_use]
pub fn refit(refit: &Refit) -> Value {
    let fits = |held_out: bool| {
        json!({
            "before": rounded(&mean_fits(&refit.shown, held_out, false)),
            "after": rounded(&mean_fits(&refit.shown, held_out, true)),
            "noise_floor": rounded(&mean_noise_floor(&refit.shown, held_out)),
        })
    };
    json!({
        "schema": "host-sim/fit/1",
        "machine": refit.file.name,
        "converged": refit.converged,
        "unsettled": refit.unsettled.as_ref().map(unsettled),
        "parameters": refit.estimates.iter().map(estimate).collect::<Vec<_>>(),
        "tolerances": refit.tolerated.iter().map(|one| tolerance(&refit.file.machine, one)).collect::<Vec<_>>(),
        "far_values": refit.far_values.iter().map(far_value).collect::<Vec<_>>(),
        "correlations": refit.correlations.iter().map(correlation).collect::<Vec<_>>(),
        "left": {
            "sentence": missed(&refit.left),
            "signals": still_above_noise(&refit.left),
            "is_above_noise": refit.left.iter().any(Miss::is_above_noise),
        },
        "held_out": worse_held_out(&refit.shown).map(|falls| {
            json!({ "is_worse": !falls.is_empty(), "sentence": fit_is_worse(refit) })
        }),
        "fit": { "train": fits(false), "holdout": fits(true) },
    })
}
