//! A static recording's figures: as text, as JSON, and as a drawing.

use std::fmt::Write;

use serde_json::{Value, json};

use identification::static_curve::{Edge, Port, Statics};

use crate::plot::{Mark, curve};

/// Three digits.
fn short(value: f64) -> String {
    identification::static_curve::indications::short(value)
}

/// The figures as lines of text.
#[must_use]
pub fn text(statics: &Statics) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        // Writing into a text does not fail.
        let _ = writeln!(text, "{name:<18} {value}");
    };
    let (input, output) = (&statics.input, &statics.output);
    let ways = |rising: bool| statics.branches.iter().filter(|branch| **branch == rising).count();
    line("recording", format!("{}, {} rows: {} up, {} down", statics.recording, statics.rows, ways(true), ways(false)));
    line("input", format!("{}: {} to {}", input.header, short(input.low), short(input.high)));
    line("output", format!("{}: {} to {}", output.header, short(output.low), short(output.high)));
    if let Some(gain) = statics.gain {
        line("gain", format!("{} at small outputs", short(gain)));
    }
    if let Some(null) = statics.null {
        let way = |value: Option<f64>| value.map_or_else(|| "not read".to_owned(), short);
        let (rising, falling) = (way(null.rising), way(null.falling));
        line("null", format!("{} (rising {rising}, falling {falling})", short(null.input)));
    }
    if let Some(loops) = statics.hysteresis {
        let null = loops.at_null.map_or_else(String::new, |width| format!("; {} at the null", short(width)));
        let share = 100.0 * loops.share_of_span;
        line(
            "loop",
            format!(
                "{} ± {} wide over {} levels, {share:.2} % of the span{null}",
                short(loops.width),
                short(loops.std),
                loops.levels
            ),
        );
    }
    for (name, edge) in [("positive from", statics.positive), ("negative from", statics.negative)] {
        if let Some(Edge { extrapolated, begins_between, gain }) = edge {
            let seen = begins_between.map_or_else(String::new, |(rest, first)| {
                format!("; at rest until {}, not at {}", short(rest), short(first))
            });
            line(name, format!("{} extrapolated, gain {}{seen}", short(extrapolated), short(gain)));
        }
    }
    for (what, all) in [("gain falls", &statics.saturation), ("spool stops", &statics.spool_saturation)] {
        for fallen in all {
            let end = if fallen.upper { "up" } else { "down" };
            line(what, format!("below {} of it from {} {end}", fallen.share, short(fallen.from)));
        }
    }
    for (name, port) in [("supply", &statics.supply), ("return", &statics.returning)] {
        if let Some(Port { header, at_rest, at_full, scatter, .. }) = port {
            let (rest, full, about) = (short(*at_rest), short(*at_full), short(*scatter));
            line(name, format!("{header}: {rest} without flow, {full} at the largest, ± {about} about the line"));
        }
    }
    for indication in &statics.indications {
        line("found", format!("{}: {}", indication.effect, indication.evidence));
    }
    if statics.indications.is_empty() {
        line("found", "no effect of the vocabulary".to_owned());
    }
    for remark in &statics.remarks {
        line("note", remark.clone());
    }
    text.truncate(text.trim_end().len());
    text
}

/// The figures as JSON.
#[must_use]
pub fn document(statics: &Statics) -> Value {
    json!({ "schema": "host-sim/statics/1", "statics": statics })
}

/// Output over input, with the null and the edges marked.
#[must_use]
pub fn drawing(statics: &Statics, input: &[f64], output: &[f64]) -> String {
    let edges = [statics.positive, statics.negative].into_iter().flatten().map(|edge| ("edge", edge.extrapolated));
    let null = statics.null.iter().map(|null| ("null", null.input));
    let fallen =
        statics.saturation.iter().filter(|fallen| fallen.share > 0.4).map(|fallen| ("half the gain", fallen.from));
    let marks: Vec<Mark> =
        edges.chain(null).chain(fallen).map(|(label, at)| Mark { label: label.to_owned(), at }).collect();
    curve(&statics.recording, (&statics.input.header, input), (&statics.output.header, output), &marks)
}
