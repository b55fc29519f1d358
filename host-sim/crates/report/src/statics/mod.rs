//! A static recording's figures: as text, as JSON, and as a drawing; and what several sweeps at different rates show together.

mod remark;
mod several;

use std::fmt::Write;

use serde_json::{Value, json};

use identification::static_curve::{
    Axis, Edge, Evidence, Extreme, Indication, Port, PortPressure, Remark, Shape, Statics,
};
use recording::files::source_error::rounded;

use crate::plot::{Mark, Series, curve};

pub use several::{document_of_sweeps, drawing_of_sweeps, text_of_sweeps};

/// Three digits.
fn short(value: f64) -> String {
    format!("{value:.2e}").parse::<f64>().map_or_else(|_| value.to_string(), |value| rounded(value).to_string())
}

/// A place on an axis: what is no more than rounding beside its span is zero.
fn place(value: f64, axis: &Axis) -> String {
    short(if value.abs() < 1e-9 * (axis.high - axis.low) { 0.0 } else { value })
}

/// The figures as lines of text.
#[must_use]
pub fn text(statics: &Statics) -> String {
    written(statics, true)
}

/// The same beside a comparison, which tells what the loop is.
fn text_beside(statics: &Statics) -> String {
    written(statics, false)
}

fn written(statics: &Statics, alone: bool) -> String {
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
    line("shape", shape(statics));
    if let Some(found) = statics.shape.extreme() {
        line("", sides(found));
    }
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
            line(name, format!("{} extrapolated, gain {}{seen}", place(extrapolated, input), short(gain)));
        }
    }
    for (what, all) in [("gain falls", &statics.saturation), ("spool stops", &statics.spool_saturation)] {
        for fallen in all {
            let end = if fallen.upper { "up" } else { "down" };
            line(what, format!("below {} of it from {} {end}", fallen.share, place(fallen.from, input)));
        }
    }
    for (name, port) in [("supply", &statics.supply), ("return", &statics.returning)] {
        if let Some(Port { header, at_rest, at_full, scatter, .. }) = port {
            let (rest, full, about) = (short(*at_rest), short(*at_full), short(*scatter));
            line(name, format!("{header}: {rest} without flow, {full} at the largest, ± {about} about the line"));
        }
    }
    for indication in &statics.indications {
        line("found", format!("{}: {}", indication.effect, evidence(indication)));
    }
    if alone && statics.indications.is_empty() {
        line("found", "no effect of the vocabulary".to_owned());
    }
    let told = |remark: &&Remark| alone || !matches!(remark, Remark::LagOrLoop { .. } | Remark::NoRate { .. });
    for remark in statics.remarks.iter().filter(told) {
        line("note", remark::sentence(remark, statics));
    }
    text.truncate(text.trim_end().len());
    text
}

/// The figures as JSON.
#[must_use]
pub fn document(statics: &Statics) -> Value {
    json!({ "schema": "host-sim/statics/1", "statics": figures(statics) })
}

fn figures(statics: &Statics) -> Value {
    let indications: Vec<Value> = statics
        .indications
        .iter()
        .map(|found| json!({ "effect": found.effect, "evidence": evidence(found) }))
        .collect();
    let remarks: Vec<String> = statics.remarks.iter().map(|found| remark::sentence(found, statics)).collect();
    let mut figures = json!(statics);
    figures["indications"] = json!(indications);
    figures["remarks"] = json!(remarks);
    figures["loop_is_sure"] = json!(statics.has_loop());
    figures
}

/// The kind of the curve in words.
fn shape(statics: &Statics) -> String {
    let (input, output) = (&statics.input, &statics.output);
    let places = |turns: &[(f64, f64)]| {
        let each: Vec<String> =
            turns.iter().map(|turn| format!("{} at {}", short(turn.1), place(turn.0, input))).collect();
        each.join(", ")
    };
    match &statics.shape {
        Shape::Monotone { rising: true } => "rises with the input".to_owned(),
        Shape::Monotone { rising: false } => "falls as the input rises".to_owned(),
        Shape::Constant { mean, scatter } => {
            format!("does not depend on the input: {} with a scatter of {}", short(*mean), short(*scatter))
        }
        Shape::Peak(found) => extreme("peak", found, input, output),
        Shape::Valley(found) => extreme("valley", found, input, output),
        Shape::TurnsBack { turns, .. } => format!("turns back: {}", places(turns)),
        Shape::BranchesDiffer => "not told: the ways up and down have curves of different kinds".to_owned(),
    }
}

fn extreme(name: &str, found: &Extreme, input: &Axis, output: &Axis) -> String {
    let ways = found.rising.zip(found.falling).map_or_else(String::new, |(rising, falling)| {
        format!(" (rising {}, falling {})", place(rising, input), place(falling, input))
    });
    let (value, std) = (short(found.output), short(found.std));
    let at = place(found.input, input);
    format!("a {name} of {value} ± {std} ({}) at {at} ({}){ways}", output.header, input.header)
}

fn sides(found: &Extreme) -> String {
    let (width, lower, upper) = (short(found.width_at_half_height), short(found.lower_end), short(found.upper_end));
    format!("{width} wide at half height; {lower} at the lower end, {upper} at the upper")
}

fn evidence(indication: &Indication) -> String {
    match &indication.evidence {
        Evidence::LoopStays { width, std, sweeps } => format!(
            "{} ± {} of the loop stays however slow the sweep, from {sweeps} sweeps",
            short(*width),
            short(*std)
        ),
        Evidence::SpoolStops { from } => {
            format!("the spool follows with less than a tenth of its gain from {} on", short(*from))
        }
        Evidence::UnequalGains { low, high } => {
            format!("the gain is {:.0} to {:.0} % of that at small openings", 100.0 * low, 100.0 * high)
        }
        Evidence::SupplyFalls(PortPressure { header, at_rest, at_full }) => {
            format!("{header} falls from {} at rest to {} at the largest flow", short(*at_rest), short(*at_full))
        }
        Evidence::ReturnRises(PortPressure { header, at_rest, at_full }) => {
            format!("{header} rises from {} at little flow to {} at the largest", short(*at_rest), short(*at_full))
        }
    }
}

/// Output over input, with the null, the edges and the extreme marked.
#[must_use]
pub fn drawing(statics: &Statics, input: &[f64], output: &[f64]) -> String {
    let series = Series { label: String::new(), x: input, y: output };
    curve(&statics.recording, &statics.input.header, &statics.output.header, &[series], &marks(statics))
}

fn marks(statics: &Statics) -> Vec<Mark> {
    let edges = [statics.positive, statics.negative].into_iter().flatten().map(|edge| ("edge", edge.extrapolated));
    let null = statics.null.iter().map(|null| ("null", null.input));
    let fallen =
        statics.saturation.iter().filter(|fallen| fallen.share > 0.4).map(|fallen| ("half the gain", fallen.from));
    let name = if matches!(statics.shape, Shape::Peak(_)) { "peak" } else { "valley" };
    let extreme = statics.shape.extreme().map(|extreme| (name, extreme.input));
    let all = edges.chain(null).chain(fallen).chain(extreme);
    all.map(|(label, at)| Mark { label: label.to_owned(), at }).collect()
}

#[cfg(test)]
mod tests {
    use identification::static_curve::{Columns, analyse};
    use recording::StaticTable;

    use super::*;

    #[test]
    fn what_belongs_to_the_meter_is_said_to() {
        // Up and down, read by a meter that counts in steps of 0.8 from 6 on.
        let input: Vec<f64> = (0..=800).map(|row| 10.0 * (f64::from(row) / 400.0 - 1.0).abs()).rev().collect();
        let meter = |input: &f64| if 2.0 * input > 6.0 { (2.0 * input / 0.8).round() * 0.8 } else { 2.0 * input };
        let output = input.iter().map(meter).collect();
        let columns = vec![("I [mA]".to_owned(), input), ("Q [l/min]".to_owned(), output)];
        let table = StaticTable::new("sweep.csv", columns);
        let asked = Columns { input: "I".to_owned(), output: "Q".to_owned(), ..Columns::default() };
        let found = analyse(&table, &asked).unwrap();
        assert!(text(&found).contains("a staircase of the meter, not of the valve"), "{}", text(&found));
        assert!(text(&found).contains("rises with the input"), "{}", text(&found));
        assert!(document(&found)["statics"]["remarks"].to_string().contains("staircase of the meter"));
    }
}
