//! The diagnosis as JSON, schema `host-sim/diagnosis/1`.

use serde_json::{Value, json};

use diagnosis::agreement::{Change, Doubt, FarValue, Tolerated};
use diagnosis::catalogue::{Hypothesis, short_name};
use diagnosis::correction_table::{Axis, Unnamed};
use diagnosis::localisation::error_shape::Shape;
use diagnosis::localisation::{Habit, Miss};
use diagnosis::outside::{Cause, Outside, Push};
use diagnosis::selection::Selection;
use diagnosis::{Diagnosis, Finding};
use identification::fit::{Correlation, Estimate, Unsettled};
use model_core::machine::Machine;

use super::{evidence, structure};
use crate::evidence::Exhibits;
use crate::size::size;
use crate::wording;

/// The document.
#[must_use]
pub fn document(diagnosis: &Diagnosis, exhibits: &Exhibits) -> Value {
    let fits = |held_out: bool| {
        json!({
            "before": rounded(&diagnosis.mean_fits(held_out, false)),
            "after": rounded(&diagnosis.mean_fits(held_out, true)),
            "noise_floor": rounded(&diagnosis.noise_floor(held_out)),
        })
    };
    let located = diagnosis.located.as_ref().map_or(json!({}), |location| {
        let intervals: Vec<Value> = location
            .intervals
            .iter()
            .map(|interval| {
                json!({ "recording": interval.recording, "from_s": digits(interval.from_s, 6), "to_s": digits(interval.to_s, 6), "share": digits(interval.share, 3) })
            })
            .collect();
        json!({
            "subsystem": location.subsystem,
            "signal": location.signal.name(),
            "share": digits(location.share, 3),
            "share_of_time": digits(location.of_time, 3),
            "intervals": intervals,
            "region": wording::region(location.region),
            "shape": shape(&location.shape),
            "slider": location.spool.iter().map(spool).collect::<Vec<_>>(),
        })
    });
    let mut told = json!({
        "schema": "host-sim/diagnosis/1",
        "machine": diagnosis.machine,
        "since": diagnosis.since.as_ref().map(|held| names(held)),
        "verdict": diagnosis.verdict,
        "unfinished": unfinished(&diagnosis.selection),
        "plausibility": diagnosis.doubts.iter().map(doubt).collect::<Vec<_>>(),
        "far_values": diagnosis.far_values().iter().map(far_value).collect::<Vec<_>>(),
        "unsettled": diagnosis.unsettled.as_ref().map(unsettled),
        "tolerances": diagnosis.tolerances().iter().map(|one| tolerance(&diagnosis.machine_after, one)).collect::<Vec<_>>(),
        "pressures_taken_as_absolute": exhibits.preprocessing.iter().any(|of| of.taken_as_absolute),
        "located": located,
        "suspected": diagnosis.suspected.map(|effect| effect.name),
        "findings": diagnosis.findings.iter().map(|finding| finding_of(diagnosis, exhibits, finding)).collect::<Vec<_>>(),
        "outside": diagnosis.outside.as_ref().map(outside),
        "unnamed": diagnosis.unnamed.as_ref().map(unnamed),
        "confirmed": diagnosis.confirmation.map(|_| !diagnosis.findings.is_empty()),
        "confirmation": diagnosis.confirmation.as_ref().map(|confirmation| json!({
            "improved": confirmation.improved,
            "recordings": confirmation.recordings,
            "promised": digits(confirmation.promised, 4),
            "kept": digits(confirmation.kept, 4),
        })),
        "still_above_noise": still_above_noise(&diagnosis.left),
        "still_above_noise_held_out": still_above_noise(&diagnosis.left_held_out),
        "training_too_narrow": diagnosis.training_is_too_narrow,
        "not_confirmed": names(&diagnosis.not_confirmed),
        "not_testable": names(&diagnosis.not_testable),
        "parameters": diagnosis.refitted.iter().map(estimate).collect::<Vec<_>>(),
        "correlations": diagnosis.correlated.iter().map(correlation).collect::<Vec<_>>(),
        "level_at_rest": diagnosis.level_at_rest.map(|level| digits(level, 6)),
        "fit": { "train": fits(false), "holdout": fits(true) },
        "yardstick": structure::yardstick(diagnosis),
        "structure": structure::structure(diagnosis),
        "waterfall": evidence::waterfall(&exhibits.waterfall),
        "residuals": evidence::residuals(&exhibits.whiteness),
        "prepared": evidence::prepared(&exhibits.preprocessing),
    });
    if diagnosis.since.is_some() {
        since(diagnosis, &mut told);
    }
    told
}

/// What was asked of then, beside the findings.
fn since(diagnosis: &Diagnosis, told: &mut Value) {
    told["since_untested"] = json!(names(&diagnosis.untested));
    told["since_otherwise"] = json!(names(&diagnosis.otherwise));
    told["then"] = json!(diagnosis.then);
    told["oil"] = json!(diagnosis.other_oil.as_ref().map(|oil| {
        json!({
            "then_c": digits(oil.then_c, 4), "now_c": digits(oil.now_c, 4), "viscosity": digits(oil.viscosity, 3),
            "sentence": wording::other_oil(oil),
        })
    }));
}

fn names(effects: &[&Hypothesis]) -> Vec<&'static str> {
    effects.iter().map(|effect| effect.name).collect()
}

/// Signals that are missed, and by how much.
pub(super) fn still_above_noise(misses: &[Miss]) -> Vec<Value> {
    misses
        .iter()
        .map(|miss| json!({ "signal": miss.signal.name(), "rmse_over_noise": digits(miss.over_noise, 3) }))
        .collect()
}

/// A cause outside the drive.
fn outside(outside: &Outside) -> Value {
    let each = |key: &'static str| move |(recording, newtons): &(String, f64)| json!({ "recording": recording, key: digits(*newtons, 5) });
    let mut told = match &outside.cause {
        Cause::Load(loads) => json!({ "kind": "load", "in": loads.iter().map(each("force_n")).collect::<Vec<_>>() }),
        Cause::Push(pushes) => {
            let push = |push: &Push| {
                json!({
                    "recording": push.recording,
                    "from_s": digits(push.from_s, 5),
                    "to_s": digits(push.to_s, 5),
                    "mean_n": digits(push.mean_n, 4),
                    "impulse_n_s": digits(push.impulse_n_s, 4),
                })
            };
            json!({ "kind": "push", "in": pushes.iter().map(push).collect::<Vec<_>>() })
        }
        Cause::Periodic { hz, amplitude_n } => json!({
            "kind": "periodic", "frequency_hz": digits(*hz, 5), "in": amplitude_n.iter().map(each("amplitude_n")).collect::<Vec<_>>(),
        }),
        Cause::Structure { hz, damping, mass_kg } => json!({
            "kind": "structure",
            "frequency_hz": digits(*hz, 5),
            "damping": digits(*damping, 3),
            "mass_kg": digits(*mass_kg, 4),
        }),
    };
    told["explains"] = json!(digits(outside.explains, 4));
    told["explains_held_out"] = json!(outside.explains_held_out.map(|share| digits(share, 4)));
    told["sentence"] = json!(wording::outside_cause(&outside.cause));
    told
}

/// A refitted value far from its nominal value.
pub(super) fn far_value(far: &FarValue) -> Value {
    json!({
        "name": far.parameter.description().key, "nominal": digits(far.nominal, 6), "value": digits(far.value, 6),
        "sigmas": digits(far.sigmas, 3), "impossible": far.is_impossible, "sentence": wording::far_value(far),
    })
}

/// A value that had not come to rest.
pub(super) fn unsettled(moving: &Unsettled) -> Value {
    json!({
        "name": moving.parameter.description().key, "value": digits(moving.value, 6), "towards": digits(moving.towards, 6),
        "sentence": wording::still_moving(moving),
    })
}

/// A fitted value.
pub(super) fn estimate(estimate: &Estimate) -> Value {
    let description = estimate.parameter.description();
    json!({
        "name": description.key,
        "before": digits(estimate.before, 6),
        "value": digits(estimate.value, 6),
        "std": digits(estimate.std, 3),
        "unit": description.unit,
        "at_bound": estimate.at_bound,
    })
}

/// A pair of fitted values of which only a combination is well determined.
pub(super) fn correlation(pair: &Correlation) -> Value {
    json!({
        "parameters": [pair.one.description().key, pair.other.description().key],
        "coefficient": digits(pair.coefficient, 5),
    })
}

/// What the fit used of a tolerance; the sentence where it was used up.
pub(super) fn tolerance(machine: &Machine<f64>, one: &Tolerated) -> Value {
    json!({
        "name": one.parameter.description().key,
        "value": digits(one.value, 6),
        "most": digits(one.most, 6),
        "std": digits(one.std, 3),
        "unit": one.parameter.description().unit,
        "at_limit": one.at_limit,
        "size": size(machine, one.parameter, one.value).map(|size| size.within_tolerance()),
        "sentence": wording::at_limit(machine, one),
    })
}

/// What a search that its limit has ended did not try, and what its parts cost; null where it came to its own end.
fn unfinished(selection: &Selection) -> Value {
    let searched = &selection.searched;
    let part = |(part, seconds): (String, f64)| json!({ "part": part, "seconds": seconds });
    let told = wording::left_out(searched).map(|sentence| {
        json!({
            "sentence": sentence, "limit_s": searched.limit_s, "not_tried": wording::not_tried(searched),
            "spent": wording::spent(searched).into_iter().map(part).collect::<Vec<_>>(),
            "best_so_far": wording::best_so_far(selection),
        })
    });
    told.unwrap_or_default()
}

/// A doubt about the recordings: the sentence, the changes that remove it, and the numbers behind it.
fn doubt(doubt: &Doubt) -> Value {
    let change = |change: &Change| match change {
        Change::Reversed(signal) => json!({ "kind": "reversed", "signal": signal.name() }),
        Change::PortsExchanged => json!({ "kind": "ports-exchanged" }),
        Change::PressuresExchanged => json!({ "kind": "pressures-exchanged" }),
        Change::Cylinder { bore_mm, rod_mm } => json!({ "kind": "cylinder", "bore_mm": bore_mm, "rod_mm": rod_mm }),
        Change::Moved(signal, by) => json!({ "kind": "moved", "signal": signal.name(), "by": digits(*by, 6) }),
        Change::Earlier(signal, by_s) => {
            json!({ "kind": "earlier", "signal": signal.name(), "by_s": digits(*by_s, 4) })
        }
        Change::Scaled(signal, factor) => {
            json!({ "kind": "scaled", "signal": signal.name(), "factor": digits(*factor, 6) })
        }
    };
    json!({
        "sentence": wording::doubt(doubt),
        "certain": doubt.is_certain,
        "recordings": doubt.recordings,
        "signals": doubt.signals.iter().map(|signal| signal.name()).collect::<Vec<_>>(),
        "changes": doubt.changed.changes.iter().map(change).collect::<Vec<_>>(),
        "fit": { "as_recorded": digits(doubt.as_recorded.fit_percent, 6), "changed": digits(doubt.changed.fit_percent, 6) },
    })
}

/// The behaviour of a recorded spool: its kind, the sentence, and the numbers behind it.
fn spool(habit: &Habit) -> Value {
    let (kind, sentence) = (habit.name(), wording::spool_habit(habit));
    match habit {
        Habit::Sticks { recording, from_s, to_s, at, modelled, recordings, of } => json!({
            "kind": kind, "sentence": sentence, "recording": recording, "from_s": digits(*from_s, 6), "to_s": digits(*to_s, 6),
            "at": digits(*at, 3), "modelled": digits(*modelled, 3), "recordings": recordings, "of": of,
        }),
        Habit::BreaksAway { recording, at_s, speed_per_s, modelled_per_s } => json!({
            "kind": kind, "sentence": sentence, "recording": recording, "at_s": digits(*at_s, 6),
            "speed_per_s": digits(*speed_per_s, 3), "modelled_per_s": digits(*modelled_per_s, 3),
        }),
        Habit::RestsElsewhere { command_v, rests, modelled } => {
            let rests: Vec<Value> =
                rests.iter().map(|(recording, at)| json!({ "recording": recording, "at": digits(*at, 3) })).collect();
            json!({
                "kind": kind, "sentence": sentence, "command_v": digits(*command_v, 3), "rests": rests,
                "modelled": digits(*modelled, 3),
            })
        }
    }
}

/// The shape of an error: its kind, the sentence, and the numbers behind it.
fn shape(shape: &Shape) -> Value {
    let sentence = wording::error_shape(shape);
    match shape {
        Shape::Once { recording, from_s, to_s, share } => json!({
            "kind": "once", "sentence": sentence, "recording": recording,
            "from_s": digits(*from_s, 6), "to_s": digits(*to_s, 6), "share": digits(*share, 3),
        }),
        Shape::Periodic { hz, amplitude, signal } => json!({
            "kind": "periodic", "sentence": sentence, "hz": digits(*hz, 4),
            "amplitude": digits(*amplitude, 3), "unit": signal.si_unit().symbol(), "signal": signal.name(),
        }),
        Shape::Over { state, unit, explained, bins, pair } => {
            let bins: Vec<Value> = bins
                .iter()
                .map(|bin| {
                    json!({
                        "from": digits(bin.from, 4), "to": digits(bin.to, 4),
                        "mean_over_noise": digits(bin.mean, 3), "rows": bin.count,
                    })
                })
                .collect();
            let pair = pair.map(|(one, other, share)| json!({ "states": [one, other], "explained": digits(share, 3) }));
            json!({
                "kind": "over", "sentence": sentence, "state": state, "unit": unit,
                "explained": digits(*explained, 3), "bins": bins, "pair": pair,
            })
        }
        Shape::Everywhere => json!({ "kind": "everywhere", "sentence": sentence }),
    }
}

/// A table for an unnamed effect.
fn unnamed(found: &Unnamed) -> Value {
    let axis = |axis: &Axis| {
        json!({
            "state": axis.state.name(), "unit": axis.state.unit(),
            "from": digits(axis.from, 6), "to": digits(axis.to, 6), "nodes": axis.nodes,
        })
    };
    json!({
        "quantity": found.quantity.name(),
        "unit": found.quantity.unit(),
        "over": found.over.iter().map(axis).collect::<Vec<_>>(),
        "values": found.values.iter().map(|estimate| {
            json!({ "value": digits(estimate.value, 6), "std": digits(estimate.std, 3) })
        }).collect::<Vec<_>>(),
        "improved": found.confirmation.improved,
        "recordings": found.confirmation.recordings,
        "sentence": wording::correction_table(found),
    })
}

fn finding_of(diagnosis: &Diagnosis, exhibits: &Exhibits, finding: &Finding) -> Value {
    let parameters: Vec<Value> = finding
        .parameters
        .iter()
        .map(|estimate| {
            let mut told = json!({
                "name": short_name(estimate.parameter),
                "value": digits(estimate.value, 6),
                "std": digits(estimate.std, 3),
                "unit": estimate.parameter.description().unit,
                "size": size(&diagnosis.machine_after, estimate.parameter, estimate.value).map(|size| size.to_string()),
            });
            if let Some((_, before)) = finding.before.iter().find(|(parameter, _)| *parameter == estimate.parameter) {
                told["before"] = json!(digits(*before, 6));
            }
            told
        })
        .collect();
    let alternatives: Vec<Value> = finding
        .alternatives
        .iter()
        .map(|(effect, confidence)| json!({ "effect": effect.name, "confidence": digits(*confidence, 3) }))
        .collect();
    let mut found = json!({
        "effect": finding.effect.name,
        "claimed": wording::claimed(finding),
        "subsystem": finding.effect.subsystem,
        "confidence": digits(finding.confidence, 3),
        "parameters": parameters,
        "evidence": {
            "holdout_fit_before": rounded(&diagnosis.mean_fits(true, false)),
            "holdout_fit_after": rounded(&diagnosis.mean_fits(true, true)),
        },
        "alternatives": alternatives,
        "separated_by": exhibits.separated_by(finding, diagnosis.machine_after.source),
        "separation": evidence::separation(exhibits, finding),
    });
    if let Some((estimate, before)) = wording::most_changed(finding) {
        found["change"] = json!({
            "name": short_name(estimate.parameter),
            "before": digits(before, 6),
            "value": digits(estimate.value, 6),
            "ratio": digits(estimate.value / before, 4),
            "unit": estimate.parameter.description().unit,
            "sentence": wording::change(&diagnosis.machine_after, finding),
        });
    }
    if let Some(jumps) = finding.jumps {
        found["jumps"] = json!({
            "length": digits(jumps.jump_spacing.length, 3),
            "log_likelihood": digits(jumps.jump_spacing.evidence, 3),
            "kept_alone": digits(jumps.kept_alone, 3),
            "sentence": wording::jumps(jumps),
        });
    }
    found
}

pub(super) fn rounded(fits: &diagnosis::Fits) -> Value {
    fits.iter()
        .map(|(name, fit)| ((*name).to_owned(), json!(digits(*fit, 6))))
        .collect::<serde_json::Map<_, _>>()
        .into()
}

/// A number with this number of significant digits: further digits are noise, and short numbers are easy to compare. An unknown value is null.
pub(crate) fn digits(value: f64, significant: usize) -> Option<f64> {
    let precision = significant.saturating_sub(1);
    value.is_finite().then(|| format!("{value:.precision$e}").parse().unwrap_or(value))
}
