//! What is shown beside the diagnosis, as JSON.

use serde_json::{Map, Value, json};

use diagnosis::Finding;
use experiment::discriminate::Distance;

use super::diagnosis::digits;
use crate::evidence::Exhibits;
use crate::evidence::preprocessing::{AtEnd, FailedRows, Preprocessing};
use crate::evidence::waterfall::Waterfall;
use crate::evidence::whiteness::Whiteness;
use crate::wording;

/// What each stage leaves of the error.
pub(crate) fn waterfall(waterfall: &Waterfall) -> Value {
    let shares = waterfall.shares();
    let stages: Vec<Value> = waterfall
        .stages
        .iter()
        .enumerate()
        .map(|(index, stage)| {
            let signals: Map<String, Value> = stage
                .signals
                .iter()
                .map(|(signal, left)| (signal.name().to_owned(), json!(digits(*left, 4))))
                .collect();
            json!({
                "stage": stage.label,
                "effect": stage.effect,
                "square_over_noise": signals,
                "total": digits(stage.total, 4),
                "share_taken": shares.as_ref().and_then(|shares| digits(shares[index], 3)),
            })
        })
        .collect();
    json!({ "recordings": if waterfall.held_out { "holdout" } else { "train" }, "stages": stages })
}

/// Whiteness of the residuals, for each signal.
pub(crate) fn residuals(signals: &[Whiteness]) -> Value {
    signals
        .iter()
        .map(|of| {
            let with_input = (!of.cross.is_empty()).then(|| digits(of.cross_outside(), 3));
            let value = json!({
                "lags": of.auto.len(),
                "lag_s": digits(of.lag_s, 6),
                "outside_band": digits(of.outside(), 3),
                "band": digits(of.auto_band, 3),
                "with_input_outside_band": with_input,
                "with_input_band": digits(of.cross_band, 3),
            });
            (of.signal.name().to_owned(), value)
        })
        .collect::<Map<_, _>>()
        .into()
}

/// What was found in each recording.
pub(crate) fn prepared(found: &[Preprocessing]) -> Value {
    let of = |of: &Preprocessing| {
        let channels: Map<String, Value> = of
            .channels
            .iter()
            .map(|channel| {
                let value = json!({
                    "noise": digits(channel.noise, 3),
                    "step": channel.step.and_then(|step| digits(step, 4)),
                    "spikes": channel.spikes,
                    "failures": channel.failures.iter().map(failure).collect::<Vec<_>>(),
                    "range_ends": channel.ends.iter().map(range_end).collect::<Vec<_>>(),
                    "start": digits(channel.start, 6),
                    "unit": channel.signal.si_unit().symbol(),
                });
                (channel.signal.name().to_owned(), value)
            })
            .collect();
        let bridged: Map<String, Value> = of
            .bridged
            .iter()
            .map(|bridged| {
                let failures: Vec<Value> = bridged.failures.iter().map(failure).collect();
                (
                    bridged.signal.name().to_owned(),
                    json!({
                        "spikes": bridged.spikes, "failures": failures,
                        "range_ends": bridged.ends.iter().map(range_end).collect::<Vec<_>>(),
                    }),
                )
            })
            .collect();
        let dither =
            of.dither.map(|line| json!({ "hz": digits(line.hz, 4), "amplitude_v": digits(line.amplitude, 3) }));
        json!({
            "recording": of.recording, "rows": of.rows, "duration_s": digits(of.duration_s, 6),
            "unsettled_s": digits(of.unsettled_s, 3),
            "channels": channels, "bridged": bridged, "dither": dither, "clock": clock(of), "notes": of.notes,
        })
    };
    found.iter().map(of).collect::<Vec<_>>().into()
}

/// Where a sensor failed for more than a moment.
fn failure(failure: &FailedRows) -> Value {
    json!({
        "kind": failure.kind.name(), "from_s": digits(failure.from_s, 6), "to_s": digits(failure.to_s, 6),
        "reading": digits(failure.reading, 6),
    })
}

/// Where a sensor is at an end of its range.
fn range_end(end: &AtEnd) -> Value {
    json!({ "reading": digits(end.reading, 6), "rows": end.rows })
}

/// Time stamps, and channels that are late against the model.
fn clock(of: &Preprocessing) -> Value {
    let late: Map<String, Value> = of
        .shifts
        .iter()
        .map(|shift| {
            let value = json!({ "late_s": digits(shift.late_s, 3), "std_s": digits(shift.std_s, 2) });
            (shift.signal.name().to_owned(), value)
        })
        .collect();
    json!({
        "interval_s": digits(of.stamps.interval_s, 6), "lost_rows": of.stamps.lost,
        "uneven_intervals": of.stamps.uneven, "channels": late,
    })
}

/// The test that would distinguish a finding from its rivals.
pub(crate) fn separation(exhibits: &Exhibits, finding: &Finding) -> Value {
    let distance = |distance: &Distance| {
        json!({
            "test": distance.test, "how": distance.how, "duration_s": digits(distance.duration_s, 4),
            "signal": distance.signal.name(), "over_noise": digits(distance.over_noise, 3),
            "per_20_s": digits(distance.per_20_s, 3),
        })
    };
    let rivals: Vec<Value> = exhibits
        .rivals(finding)
        .map(|rival| {
            let sensor =
                rival.sensor.as_ref().map(|(sensor, best)| json!({ "sensor": sensor.name(), "best": distance(best) }));
            json!({
                "effect": rival.rival, "confidence": digits(rival.confidence, 3), "told_apart": rival.is_separated(),
                "advice": wording::advice(rival), "tests": rival.tests.iter().take(3).map(distance).collect::<Vec<_>>(),
                "with_sensor": sensor,
            })
        })
        .collect();
    json!({ "rivals": rivals })
}
