//! What has become of an effect that the machine file holds.

use diagnosis::catalogue::short_name;
use diagnosis::{Diagnosis, Finding};
use identification::fit::Estimate;
use model_core::machine::Machine;

use crate::size::{Size, size};

/// What is found, for a headline: what has changed and how, where that was asked; else what is claimed.
#[must_use]
pub fn found(diagnosis: &Diagnosis, finding: &Finding) -> String {
    match change(&diagnosis.machine_after, finding) {
        Some(change) => change,
        None if diagnosis.since.is_some() => format!("{} is new", super::claimed(finding)),
        None => super::claimed(finding),
    }
}

/// How an effect has changed, by the amount that has changed most: `internal-leakage rose from 1.97e-12 to 3.94e-12 m3/s/Pa (0.83 l/min → 1.7 l/min …)`.
/// `None` of an effect that was not there before.
#[must_use]
pub fn change(machine: &Machine<f64>, finding: &Finding) -> Option<String> {
    let (estimate, before) = most_changed(finding)?;
    let value = estimate.value;
    let verb = if value * before < 0.0 {
        "turned round,"
    } else if value.abs() > before.abs() {
        "rose"
    } else {
        "fell"
    };
    let whose = if finding.before.len() == 1 {
        finding.effect.name.to_owned()
    } else {
        format!("{} of {}", short_name(estimate.parameter), finding.effect.name)
    };
    let unit = estimate.parameter.description().unit;
    let sizes = size(machine, estimate.parameter, before).zip(size(machine, estimate.parameter, value));
    let sizes = sizes.map_or_else(String::new, |(then, now)| {
        let Size { amount, of, .. } = now;
        format!(" ({} → {amount}{of})", then.amount)
    });
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    Some(format!("{whose} {verb} from {before:.2e} to {value:.2e}{unit}{sizes}"))
}

/// The amount of a changed effect that has changed most, by its logarithm, with what it was.
#[must_use]
pub fn most_changed(finding: &Finding) -> Option<(&Estimate, f64)> {
    let amounts = finding.parameters.iter().filter_map(|estimate| {
        let before = finding.before.iter().find(|(parameter, _)| *parameter == estimate.parameter)?.1;
        Some((estimate, before))
    });
    let by = |(estimate, before): &(&Estimate, f64)| {
        let ratio = estimate.value / before;
        if ratio > 0.0 { ratio.ln().abs() } else { f64::INFINITY }
    };
    amounts.max_by(|one, other| by(one).total_cmp(&by(other)))
}
