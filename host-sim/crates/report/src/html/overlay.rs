//! Recorded, before and after over each other, with the located intervals shaded.

use diagnosis::{Diagnosis, Shown};
use recording::Signal;
use recording::display_unit::unit_for_people;

use crate::plot::{Panel, Style, Trace, svg, title};

/// Approximate limit of the bytes of drawings in a file.
const BYTES: usize = 1_600_000;
/// Approximate number of bytes of a point.
const PER_POINT: usize = 11;

/// Recorded, before and after with residuals, as SVG: every judged signal of one recording.
#[must_use]
pub fn overlay(diagnosis: &Diagnosis, shown: &Shown) -> String {
    let panels = panels(diagnosis, shown, &signals(shown), points(diagnosis));
    let (title, subtitle) = named(shown);
    svg(title, subtitle, &panels)
}

/// Every judged signal of a recording.
pub(crate) fn signals(shown: &Shown) -> Vec<Signal> {
    shown.prepared.channels.iter().map(|channel| channel.signal).collect()
}

/// A recording's name, and what it was used for.
pub(crate) fn named(shown: &Shown) -> (&str, &'static str) {
    (&shown.prepared.name, if shown.held_out { "held out" } else { "training" })
}

/// A panel for each of these signals, drawn with at most this number of points a trace.
pub(crate) fn panels(diagnosis: &Diagnosis, shown: &Shown, signals: &[Signal], points: usize) -> Vec<Panel> {
    let after = diagnosis.changes().then_some("after");
    let mut panels = before_and_after(shown, signals, (diagnosis.before_is_called(), after), points);
    for (panel, signal) in panels.iter_mut().zip(signals_of(shown, signals)) {
        let located = diagnosis.located.as_ref().filter(|location| location.signal == signal);
        for interval in located.into_iter().flat_map(|location| &location.intervals) {
            if interval.recording == shown.prepared.name && !shown.held_out {
                panel.intervals.push((interval.from_s, interval.to_s));
            }
        }
    }
    panels
}

fn signals_of<'a>(shown: &'a Shown, signals: &'a [Signal]) -> impl Iterator<Item = Signal> + 'a {
    shown.prepared.channels.iter().map(|channel| channel.signal).filter(|signal| signals.contains(signal))
}

/// A panel for each of these signals: recorded, before and, where that has a name, after; with residuals.
pub(crate) fn before_and_after(
    shown: &Shown,
    signals: &[Signal],
    (before_is, after_is): (&str, Option<&str>),
    points: usize,
) -> Vec<Panel> {
    let channels = shown.prepared.channels.iter().filter(|channel| signals.contains(&channel.signal));
    channels
        .map(|channel| {
            let readable = |values: &[f64]| readable(channel.signal, values);
            let unit = unit_for_people(channel.signal);
            let unit = if channel.signal == Signal::Spool { "% of travel" } else { unit.symbol() };
            let mut panel = Panel::new(title(channel.signal), unit, shown.prepared.time_s.clone()).trace(Trace::new(
                "recorded",
                readable(&channel.recorded),
                Style::Recorded,
            ));
            if let Some(before) = shown.before.signal(channel.signal) {
                panel = panel.trace(Trace::new(before_is, readable(before), Style::Before));
            }
            if let (Some(after), Some(name)) = (shown.after.signal(channel.signal), after_is) {
                panel = panel.trace(Trace::new(name, readable(after), Style::After));
            }
            Panel { points: Some(points), ..panel }.residuals()
        })
        .collect()
}

/// Points that a trace may have, so that all recordings would fit into one file.
fn points(diagnosis: &Diagnosis) -> usize {
    let traces = if diagnosis.changes() { 5 } else { 3 };
    let all: usize = diagnosis.shown.iter().map(|shown| traces * shown.prepared.channels.len()).sum();
    (BYTES / PER_POINT / all.max(1)).clamp(200, 2000)
}

fn readable(signal: Signal, values: &[f64]) -> Vec<f64> {
    let unit = unit_for_people(signal);
    values.iter().map(|value| unit.from_si(*value)).collect()
}
