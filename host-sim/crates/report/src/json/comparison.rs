//! A comparison as JSON, schema `host-sim/comparison/1`: SI units, as in a machine file.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::{Value, json};

use identification::compare::weakest::{Weakest, obstacles, unjudged, weakest};
use identification::compare::{Comparison, SectionFit};
use machine_file::MachineFile;
use simulation::figures_of_merit::SignalFit;

use super::diagnosis::digits;
use crate::inspect::input_point_name;
use crate::wording;

/// The document of several recordings.
#[must_use]
pub fn comparison(file: &MachineFile, comparisons: &[Comparison]) -> Value {
    let missing: BTreeSet<&str> = comparisons
        .iter()
        .flat_map(|comparison| obstacles(comparison, file.load_source))
        .map(wording::obstacle)
        .collect();
    json!({
        "schema": "host-sim/comparison/1",
        "machine": file.name,
        "recordings": comparisons.iter().map(recording).collect::<Vec<_>>(),
        "weakest": weakest(comparisons).as_ref().map(part),
        "not_judged": unjudged(comparisons).iter().map(wording::unjudged).collect::<Vec<_>>(),
        "obstacles": missing,
    })
}

/// The document of several machine files on the same recordings, schema `host-sim/comparisons/1`; of one, that of [`comparison`].
#[must_use]
pub fn comparisons(drives: &[(&Path, &MachineFile, &[Comparison])]) -> Value {
    if let [(_, file, found)] = drives {
        return comparison(file, found);
    }
    let machines = drives.iter().map(
        |(path, file, found)| json!({ "file": path.display().to_string(), "comparison": comparison(file, found) }),
    );
    json!({ "schema": "host-sim/comparisons/1", "machines": machines.collect::<Vec<_>>() })
}

fn recording(found: &Comparison) -> Value {
    let ends = found
        .ends
        .iter()
        .map(|(signal, end)| json!({ "signal": signal.name(), "reading": end.reading, "rows": end.count() }));
    json!({
        "recording": found.recording,
        "unsettled_s": digits(found.unsettled_s, 6),
        "range_ends": ends.collect::<Vec<_>>(),
        "sections": found.sections.iter().map(section).collect::<Vec<_>>(),
        "weakest": weakest(std::slice::from_ref(found)).as_ref().map(part),
    })
}

fn section(found: &SectionFit) -> Value {
    json!({
        "section": found.section.to_string(),
        "entry": input_point_name(found.input_point),
        "signals": found.fits.iter().map(signal).collect::<Vec<_>>(),
    })
}

fn signal(fit: &SignalFit) -> Value {
    json!({
        "signal": fit.signal.name(),
        "unit": fit.signal.si_unit().symbol(),
        "nrmse_percent": digits(fit.nrmse_percent, 6),
        "r_squared": digits(fit.r_squared, 6),
        "rmse": digits(fit.rmse, 6),
        "max_error": digits(fit.max_error, 6),
        "max_at_s": digits(fit.max_at_s, 6),
        "over_noise": digits(fit.over_noise, 4),
    })
}

fn part(found: &Weakest) -> Value {
    json!({
        "section": found.section.to_string(),
        "signal": found.signal.name(),
        "nrmse_percent": digits(found.nrmse_percent, 6),
        "follows": found.follows(),
    })
}
