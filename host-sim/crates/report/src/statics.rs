//! A static recording's figures: as text, as JSON, and as a drawing.

use std::fmt::Write;

use serde_json::{Value, json};

use identification::static_curve::{Edge, Evidence, Indication, Port, PortPressure, Remark, Statics};
use recording::files::source_error::rounded;

use crate::plot::{Mark, curve};

/// Three digits.
fn short(value: f64) -> String {
    format!("{value:.2e}").parse::<f64>().map_or_else(|_| value.to_string(), |value| rounded(value).to_string())
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
        line("found", format!("{}: {}", indication.effect, evidence(indication, statics)));
    }
    if statics.indications.is_empty() {
        line("found", "no effect of the vocabulary".to_owned());
    }
    for remark in &statics.remarks {
        line("note", self::remark(remark, statics));
    }
    text.truncate(text.trim_end().len());
    text
}

/// The figures as JSON.
#[must_use]
pub fn document(statics: &Statics) -> Value {
    let indications: Vec<Value> = statics
        .indications
        .iter()
        .map(|found| json!({ "effect": found.effect, "evidence": evidence(found, statics) }))
        .collect();
    let remarks: Vec<String> = statics.remarks.iter().map(|found| remark(found, statics)).collect();
    let mut figures = json!(statics);
    figures["indications"] = json!(indications);
    figures["remarks"] = json!(remarks);
    json!({ "schema": "host-sim/statics/1", "statics": figures })
}

fn evidence(indication: &Indication, statics: &Statics) -> String {
    match &indication.evidence {
        Evidence::Loop { width, std, levels, share_of_span } => format!(
            "the way back is {} ± {} from the way up at {levels} levels of {}: {:.1} % of the span",
            short(*width),
            short(*std),
            statics.output.header,
            100.0 * share_of_span,
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

fn remark(remark: &Remark, statics: &Statics) -> String {
    let output = &statics.output.header;
    let plain = match remark {
        Remark::NoRate { clock: true } => "the clock is not used: only what does not depend on the rate is read",
        Remark::NoRate { clock: false } => {
            "rows in the order of the file, no clock: only what does not depend on the rate is read"
        }
        Remark::LagOrLoop => "a lag would also open a loop; the sweep is assumed to be slow against the valve",
        Remark::Staircase(stairs) => {
            let coarse = stairs.from_magnitude > 0.0;
            let from = if coarse { format!(" from ±{} on", short(stairs.from_magnitude)) } else { String::new() };
            let also = if coarse { ", and a different gain there is attributed to the meter" } else { "" };
            return format!(
                "instrument: {output} stands on {} levels {} apart{from}: a staircase of the meter, not of the valve; the loop is read at the \
                 edges of its steps{also}",
                stairs.levels,
                short(stairs.step),
            );
        }
        Remark::Jump(jump) => {
            return format!(
                "instrument: {output} jumps from {} to {} near {} on every branch and nowhere else: attributed to the meter",
                short(jump.output.0),
                short(jump.output.1),
                short(jump.input)
            );
        }
        Remark::PressureEnds => {
            "the output is a pressure and ends at the supply's: this is not saturation of the valve"
        }
        Remark::SpoolOrOrifice => {
            "without a measured spool it cannot be decided whether spool or orifice stops following at the end"
        }
        Remark::EdgesOrOffset => {
            "edges of unequal distance from zero may be a dead-zone-asymmetry or an offset of the input: not separable here"
        }
        Remark::NoEdge => "no output from which an edge could be read",
        Remark::OneDirection => "one direction only: neither null nor the other side's dead zone",
        Remark::LimitStopOrSensor => {
            "a spool that stops may be at its solenoid's limit, at its stop or at the end of its sensor: not separable here"
        }
        Remark::PortHoldsEdge => {
            "a pressure at the valve's port holds the drop of the edge behind it as well as that of the line"
        }
    };
    plain.to_owned()
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
        assert!(document(&found)["statics"]["remarks"].to_string().contains("staircase of the meter"));
    }
}
