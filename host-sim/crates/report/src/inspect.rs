//! The result of an inspection, on the terminal and for programs.

use std::fmt::Write;

use comfy_table::{CellAlignment, Table};
use serde_json::{Value, json};

use experiment::inspect::{InspectedColumn, Inspection, LinkTest, Reach};
use recording::display_unit::{TABLE, arrange, difference, significant};
use recording::{Dimension, Signal, Unit};
use simulation::InputPoint;

use crate::wording::{self, recording_advice};

/// The text of one recording; its table has this number of characters a line, or as many as it needs.
#[must_use]
pub fn text(found: &Inspection, width: Option<u16>) -> String {
    let mut text = format!("{}: {}\n", found.recording, extent(found));
    for note in &found.notes {
        let _ = writeln!(text, "note: {note}");
    }
    let _ = writeln!(text, "{}", channels(&found.channels, width));
    if !found.ignored.is_empty() {
        let _ = writeln!(
            text,
            "ignored    {}: no known signal; --map names them (`host-sim inspect --help`)",
            found.ignored.join(", ")
        );
    }
    for (index, link) in found.links.iter().enumerate() {
        let label = if index == 0 { "tests" } else { "" };
        let _ = writeln!(text, "{label:<10} {:<9} {}", link.link.to_string(), reach(link));
    }
    if let Some(opened) = opened(found) {
        let _ = writeln!(text, "excited    {opened}");
    }
    if let Some(rod) = travelled(found) {
        let _ = writeln!(text, "           {rod}");
    }
    if let Some(unseen) = found.unseen {
        let _ = writeln!(text, "unseen     {}", wording::unseen(&unseen));
    }
    for (index, advice) in found.advice.iter().enumerate() {
        let _ = writeln!(text, "{:<10} {}", if index == 0 { "advice" } else { "" }, recording_advice(advice));
    }
    text
}

/// How many rows a recording has, and on which clock.
pub(crate) fn extent(found: &Inspection) -> String {
    let interval = significant(1e3 * found.stamps.interval_s, 3);
    let rate = significant(1.0 / found.stamps.interval_s, 3);
    format!(
        "{} rows, {} s at {rate} Hz ({interval} ms); {} rows missing, {} intervals uneven",
        found.rows,
        significant(found.duration_s, 4),
        found.stamps.lost,
        found.stamps.uneven
    )
}

/// How far the valve was opened.
pub(crate) fn opened(found: &Inspection) -> Option<String> {
    let opened = found.excited.opened?;
    let unit = opened.unit;
    let shown = |value: f64| significant(unit.from_si(value), 3);
    let is_opening = opened.by == Signal::Command && unit.dimension() == Dimension::Ratio;
    let puts = if is_opening { " puts the spool at" } else { "" };
    let told = format!("{}{puts} {} … {} {unit}", opened.by, shown(opened.low), shown(opened.high));
    Some(match opened.beyond {
        Some((retracting, extending)) => format!(
            "{told}, beyond the dead zone {} % of the time extending, {} % retracting",
            significant(100.0 * extending, 2),
            significant(100.0 * retracting, 2)
        ),
        None => format!("{told}; give a machine file to see whether this leaves the dead zone"),
    })
}

/// How far and how fast the rod was moved.
pub(crate) fn travelled(found: &Inspection) -> Option<String> {
    let rod = found.excited.travelled?;
    let stroke =
        rod.of_stroke.map_or_else(String::new, |share| format!(", {} % of the stroke", significant(100.0 * share, 2)));
    let as_sampled = if found.unseen.is_some() { " as sampled" } else { "" };
    Some(format!(
        "rod {} … {} mm{stroke}, {} … {} mm/s{as_sampled}; moves {} % of the time, holds for {} s at most",
        significant(1e3 * rod.low_m, 4),
        significant(1e3 * rod.high_m, 4),
        significant(1e3 * rod.retracting_m_per_s, 3),
        significant(1e3 * rod.extending_m_per_s, 3),
        significant(100.0 * rod.moving, 2),
        significant(rod.held_s, 2)
    ))
}

fn channels(channels: &[InspectedColumn], width: Option<u16>) -> Table {
    let mut table = Table::new();
    table.load_style(TABLE);
    arrange(&mut table, width);
    table.set_header(["signal", "column", "from", "to", "unit", "noise", "step", "failed rows"]);
    for channel in channels {
        let unit = channel.unit;
        let value = |si: f64| significant(unit.from_si(si), 4);
        let small = |si: Option<f64>| si.map_or_else(String::new, |si| difference(channel.signal, si));
        table.add_row([
            channel.signal.to_string(),
            channel.header.clone(),
            value(channel.low),
            value(channel.high),
            unit.to_string(),
            small(channel.noise),
            small(channel.step),
            if channel.failed == 0 { String::new() } else { channel.failed.to_string() },
        ]);
    }
    for (_, column) in table.column_iter_mut().enumerate().filter(|(index, _)| [2, 3, 5, 6, 7].contains(index)) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn names(signals: &[Signal]) -> String {
    joined(signals, ", ")
}

fn joined(signals: &[Signal], between: &str) -> String {
    signals.iter().map(|signal| signal.name()).collect::<Vec<_>>().join(between)
}

/// What documents and texts call the place where a model is driven.
#[must_use]
pub fn input_point_name(input_point: InputPoint) -> &'static str {
    match input_point {
        InputPoint::Command => "command",
        InputPoint::Spool => "spool",
        InputPoint::Pump => "pump",
        InputPoint::Flow => "flow",
        InputPoint::Force => "force",
    }
}

/// How a recording can test a link, and what is missing to test it otherwise.
pub(crate) fn reach(test: &LinkTest) -> String {
    let add = names(&test.missing);
    match &test.reach {
        Reach::Alone { input_point, judged } => {
            format!("alone: driven by the {}, judged by {}", input_point_name(*input_point), names(judged))
        }
        Reach::Together { input_point, judged } => format!(
            "only with other links: driven by the {}, judged by {}; add {add} to test it alone",
            input_point_name(*input_point),
            names(judged)
        ),
        Reach::No if test.enough.is_empty() || test.missing.iter().all(|signal| test.enough.contains(signal)) => {
            format!("not: add {add}")
        }
        Reach::No => {
            format!("not: add {} to test it with other links, {add} to test it alone", joined(&test.enough, " or "))
        }
    }
}

/// The document of several recordings: SI units, as in a machine file.
#[must_use]
pub fn document(found: &[Inspection]) -> Value {
    json!({ "schema": "host-sim/inspection/1", "recordings": found.iter().map(recording).collect::<Vec<_>>() })
}

fn recording(found: &Inspection) -> Value {
    let channel = |channel: &InspectedColumn| {
        json!({
            "signal": channel.signal.name(), "header": channel.header, "unit": Unit::si(channel.unit.dimension()).symbol(),
            "low": channel.low, "high": channel.high, "noise": channel.noise, "step": channel.step,
            "failed_rows": channel.failed,
            "range_ends": channel.ends.iter().map(|(reading, share)| json!({ "reading": reading, "share": share })).collect::<Vec<_>>(),
            "marks": channel.marks.iter().map(|mark| json!({
                "kind": mark.kind.name(), "from_s": mark.from_s, "to_s": mark.to_s, "reading": mark.reading,
            })).collect::<Vec<_>>(),
        })
    };
    let link = |test: &LinkTest| {
        let names = |signals: &[Signal]| signals.iter().map(|signal| signal.name()).collect::<Vec<_>>();
        let (how, input_point, judged) = match &test.reach {
            Reach::Alone { input_point, judged } => ("by-itself", Some(input_point_name(*input_point)), names(judged)),
            Reach::Together { input_point, judged } => {
                ("together", Some(input_point_name(*input_point)), names(judged))
            }
            Reach::No => ("not", None, Vec::new()),
        };
        json!({ "link": test.link.to_string(), "tested": how, "entry": input_point, "judged_by": judged, "missing": names(&test.missing), "enough": names(&test.enough) })
    };
    let opened = found.excited.opened.map(|opened| {
        let beyond =
            opened.beyond.map(|(retracting, extending)| json!({ "retracting": retracting, "extending": extending }));
        json!({ "by": opened.by.name(), "low": opened.low, "high": opened.high, "share_beyond_dead_zone": beyond })
    });
    let rod = found.excited.travelled.map(|rod| {
        json!({
            "low_m": rod.low_m, "high_m": rod.high_m, "share_of_stroke": rod.of_stroke,
            "retracting_m_per_s": rod.retracting_m_per_s, "extending_m_per_s": rod.extending_m_per_s,
            "share_moving": rod.moving, "longest_hold_s": rod.held_s,
        })
    });
    json!({
        "recording": found.recording, "rows": found.rows, "duration_s": found.duration_s,
        "interval_s": found.stamps.interval_s, "rows_missing": found.stamps.lost, "intervals_uneven": found.stamps.uneven,
        "gaps": found.gaps.iter().map(|(from, to)| json!({ "from_s": from, "to_s": to })).collect::<Vec<_>>(),
        "notes": found.notes, "ignored": found.ignored,
        "source": found.source.name(),
        "channels": found.channels.iter().map(channel).collect::<Vec<_>>(),
        "links": found.links.iter().map(link).collect::<Vec<_>>(),
        "unseen": found.unseen.as_ref().map(|unseen| json!({
            "above_hz": unseen.fastest_hz, "valve_s": unseen.valve_s, "oil_column_hz": unseen.oil_column_hz, "sentence": wording::unseen(unseen),
        })),
        "valve_opened": opened, "rod": rod, "advice": found.advice.iter().map(recording_advice).collect::<Vec<_>>(),
    })
}
