//! A refit as JSON, schema `host-sim/fit/1`: SI units, as in a machine file.

use serde_json::{Value, json};

use diagnosis::Refit;
use diagnosis::localisation::Miss;

use super::diagnosis::{correlation, estimate, far_value, still_above_noise, tolerance, unsettled};
use crate::terminal::missed;

/// The document.
#[must_use]
pub fn refit(refit: &Refit) -> Value {
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
    })
}
