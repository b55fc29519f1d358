//! The numbers behind a drawing, as compact JSON that the page's script reads.
//!
//! A series is written as the differences between neighbouring values, in whole steps of a small unit: two or three letters a value.

use serde_json::{Value, json};

use crate::plot::cells::{EDGES, HEIGHT, WIDTH};
use crate::plot::{Cells, Figure, Marks, Panel, Rows, Style, Trace, kept_rows};

/// Number of units in the range of the shown values: fine enough to zoom in.
const FINE: f64 = 20_000.0;
/// Largest deviation of times from even spacing, in intervals, that still counts as even.
const EVEN: f64 = 1e-3;

/// Panels over time, each with at most this number of rows. Residuals are not written: the script subtracts.
pub(crate) fn time(panels: &[Panel], most_rows: usize) -> Value {
    let panels: Vec<Value> = panels.iter().map(|panel| one_panel(panel, most_rows)).collect();
    json!({ "kind": "time", "panels": panels })
}

fn one_panel(panel: &Panel, most_rows: usize) -> Value {
    let series: Vec<&[f64]> = panel.traces.iter().map(|trace| trace.values.as_slice()).collect();
    let kept = kept_rows(&series, most_rows.min(panel.time_s.len()));
    let unit = fine(panel.traces.iter().flat_map(|trace| &trace.values));
    let traces: Vec<Value> = panel
        .traces
        .iter()
        .map(|trace| packed_trace(trace, &kept.iter().map(|row| trace.values[*row]).collect::<Vec<_>>(), unit))
        .collect();
    json!({
        "title": panel.title, "unit": panel.unit, "time": times(&panel.time_s, &kept), "traces": traces,
        "shade": panel.intervals, "note": panel.note,
    })
}

/// One row for each recording.
pub(crate) fn rows(figure: &Rows) -> Value {
    let all: Vec<usize> = (0..figure.time_s.len()).collect();
    let rows: Vec<Value> = figure
        .rows
        .iter()
        .map(|row| {
            let unit = fine(row.traces.iter().flat_map(|trace| &trace.values));
            let traces: Vec<Value> = row.traces.iter().map(|trace| packed_trace(trace, &trace.values, unit)).collect();
            json!({ "label": row.label, "traces": traces, "shade": row.intervals })
        })
        .collect();
    json!({
        "kind": "rows", "title": figure.title, "unit": figure.unit, "most": figure.most,
        "time": times(&figure.time_s, &all), "rows": rows,
    })
}

/// One quantity over another.
pub(crate) fn figure(figure: &Figure) -> Value {
    let layers: Vec<Value> = figure
        .layers
        .iter()
        .map(|layer| {
            let pairs = |points: &[(f64, f64)]| -> Vec<Vec<f64>> {
                let finite = points.iter().filter(|(x, y)| x.is_finite() && y.is_finite());
                finite.map(|(x, y)| vec![short(*x), short(*y)]).collect()
            };
            let (marks, points) = match &layer.marks {
                Marks::Dots(points) => ("dots", pairs(points)),
                Marks::Line(points) => ("line", pairs(points)),
                Marks::Bins(bins) => {
                    let of =
                        |x: f64, [low, middle, high]: [f64; 3]| vec![short(x), short(low), short(middle), short(high)];
                    ("bins", bins.iter().map(|bin| of(bin.x, bin.quartiles)).collect())
                }
            };
            json!({ "label": layer.label, "style": name(layer.style), "marks": marks, "points": points })
        })
        .collect();
    json!({ "kind": "figure", "title": figure.title, "x": figure.x, "y": figure.y, "band": figure.band, "layers": layers })
}

/// Cells over two states, with where they are in the drawing.
pub(crate) fn cells(figure: &Cells) -> Value {
    let [left, right, top, bottom] = EDGES;
    let cells: Vec<Value> =
        figure.cells.iter().map(|cell| cell.map_or(Value::Null, |(value, rows)| json!([short(value), rows]))).collect();
    json!({
        "kind": "map", "x": figure.axes[0], "y": figure.axes[1], "unit": figure.unit, "width": WIDTH, "height": HEIGHT,
        "left": left, "right": right, "top": top, "bottom": bottom, "columns": figure.count[0], "rows": figure.count[1],
        "from": figure.from.map(short), "step": figure.step, "cells": cells,
    })
}

/// JSON that may stand in a page whatever names it holds: none of its characters begins a tag, a comment or an entity.
pub(crate) fn for_page(data: &Value) -> String {
    let text = data.to_string();
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '<' => safe.push_str("\\u003c"),
            '>' => safe.push_str("\\u003e"),
            '&' => safe.push_str("\\u0026"),
            '\u{2028}' => safe.push_str("\\u2028"),
            '\u{2029}' => safe.push_str("\\u2029"),
            letter => safe.push(letter),
        }
    }
    safe
}

fn name(style: Style) -> &'static str {
    /// As many as there are [`MODELS`](crate::plot::canvas::MODELS).
    const NAMES: [&str; 6] = ["model-0", "model-1", "model-2", "model-3", "model-4", "model-5"];
    match style {
        Style::Input => "input",
        Style::Channel => "channel",
        Style::Recorded => "recorded",
        Style::Simulated => "simulated",
        Style::Before => "before",
        Style::After => "after",
        Style::Model(index) => NAMES[usize::from(index) % NAMES.len()],
    }
}

fn packed_trace(trace: &Trace, values: &[f64], unit: f64) -> Value {
    let mut packed = packed(values, unit);
    packed["label"] = json!(trace.label);
    packed["style"] = json!(name(trace.style));
    packed
}

/// Values in whole steps of a unit; a value that is not finite becomes null.
fn packed(values: &[f64], unit: f64) -> Value {
    let mut at = 0_i64;
    let steps: Vec<Option<i64>> = values
        .iter()
        .map(|value| {
            #[expect(clippy::cast_possible_truncation, reason = "a count of units; beyond it the end of the range")]
            let next = value.is_finite().then(|| (value / unit).round() as i64)?;
            let step = next.saturating_sub(at);
            at = next;
            Some(step)
        })
        .collect();
    json!({ "unit": unit, "from": 0, "steps": steps })
}

/// The times of some rows: start and interval where all rows are kept and evenly spaced, else differences.
fn times(time_s: &[f64], kept: &[usize]) -> Value {
    let (Some(first), Some(last)) = (time_s.first(), time_s.last()) else { return packed(&[], 1.0) };
    let interval = (last - first) / (time_s.len().max(2) - 1) as f64;
    let even = |(row, time): (usize, &f64)| (time - first - row as f64 * interval).abs() <= EVEN * interval;
    if interval > 0.0 && time_s.iter().enumerate().all(even) {
        if kept.len() == time_s.len() {
            return json!({ "from": first, "interval": interval, "rows": time_s.len() });
        }
        let before = std::iter::once(&0).chain(kept);
        let steps: Vec<usize> = kept.iter().zip(before).map(|(row, before)| row - before).collect();
        return json!({ "unit": interval, "from": first / interval, "steps": steps });
    }
    packed(&kept.iter().map(|row| time_s[*row]).collect::<Vec<_>>(), 1e-6)
}

/// A round unit that is a small part of the range of these values.
fn fine<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::MAX, f64::MIN), |all: (f64, f64), value| (all.0.min(*value), all.1.max(*value)));
    let range = if high > low { high - low } else { 1.0 };
    let unit = libm::pow(10.0_f64, libm::log10(range / FINE).ceil());
    // 1e-3 and not 0.0010000000000000002.
    format!("{unit:.0e}").parse().unwrap_or(unit)
}

/// A number with five digits.
fn short(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unpacked(packed: &Value) -> Vec<Option<f64>> {
        let (mut at, unit) = (packed["from"].as_f64().unwrap(), packed["unit"].as_f64().unwrap());
        let step = |step: &Value| {
            at += step.as_f64()?;
            Some(at * unit)
        };
        packed["steps"].as_array().unwrap().iter().map(step).collect()
    }

    #[test]
    fn a_series_comes_back_as_fine_as_its_unit_with_its_gaps() {
        let values: Vec<f64> = (0..500).map(|k| 150.0 + 20.0 * (f64::from(k) * 0.1).sin()).collect();
        let unit = fine(values.iter());
        assert!(unit > 40.0 / FINE && unit < 10.1 * 40.0 / FINE, "{unit}");
        let mut holed = values.clone();
        holed[77] = f64::NAN;
        let back = unpacked(&packed(&holed, unit));
        assert_eq!(back[77], None);
        let off = |(value, back): (&f64, &Option<f64>)| back.map_or(0.0, |back| (value - back).abs());
        assert!(values.iter().zip(&back).map(off).fold(0.0, f64::max) <= 0.51 * unit);
    }

    #[test]
    fn times_of_thinned_and_of_uneven_rows_come_back() {
        let even: Vec<f64> = (0..1000).map(|row| 2.5 + f64::from(row) * 1e-3).collect();
        let all: Vec<usize> = (0..1000).collect();
        assert_eq!(times(&even, &all)["rows"], 1000);
        let thinned = unpacked(&times(&even, &[3, 10, 999]));
        for (time, row) in thinned.iter().zip([3, 10, 999]) {
            assert!((time.unwrap() - even[row]).abs() < 1e-9);
        }
        let uneven = unpacked(&times(&[0.0, 0.1, 0.4], &[0, 1, 2]));
        assert!((uneven[2].unwrap() - 0.4).abs() < 1e-6);
        assert_eq!(times(&[], &[])["steps"], json!([]));
    }

    #[test]
    fn no_name_breaks_out_of_its_script() {
        let name = "</script><script>alert(1)</script><!-- & \u{2028}";
        let panel = Panel::new(name, "mm", vec![0.0, 1.0]).trace(Trace::new(name, vec![0.0, 1.0], Style::Recorded));
        let text = for_page(&time(&[panel], 100));
        assert!(!text.contains(['<', '>', '&', '\u{2028}']), "{text}");
        let back: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(back["panels"][0]["title"], name);
    }
}
