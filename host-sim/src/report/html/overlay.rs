//! Recorded, before and after over each other, with the located intervals shaded.

use crate::diagnose::{Diagnosis, Shown};
use crate::plot::{Panel, Style, Trace, svg, title};
use crate::presentation::unit_for_people;
use crate::recording::Signal;

/// About how many bytes of drawing a page may hold.
const BYTES: usize = 1_600_000;
/// About how many bytes a point takes.
const PER_POINT: usize = 11;

/// Recorded, before and after with residuals, as SVG: every judged signal of one recording.
#[must_use]
pub fn overlay(diagnosis: &Diagnosis, shown: &Shown) -> String {
    let signals: Vec<Signal> = shown.prepared.channels.iter().map(|channel| channel.signal).collect();
    overlay_of(diagnosis, shown, &signals)
}

/// The same of some signals.
#[must_use]
pub fn overlay_of(diagnosis: &Diagnosis, shown: &Shown, signals: &[Signal]) -> String {
    let claimed = !diagnosis.findings.is_empty();
    let channels = shown.prepared.channels.iter().filter(|channel| signals.contains(&channel.signal));
    let panels: Vec<Panel> =
        channels
            .map(|channel| {
                let readable = |values: &[f64]| readable(channel.signal, values);
                let unit = unit_for_people(channel.signal);
                let unit = if channel.signal == Signal::Spool { "% of travel" } else { unit.symbol() };
                let mut panel = Panel::new(title(channel.signal), unit, shown.prepared.time_s.clone())
                    .trace(Trace::new("recorded", readable(&channel.recorded), Style::Recorded));
                if let Some(before) = shown.before.signal(channel.signal) {
                    panel = panel.trace(Trace::new("before", readable(before), Style::Before));
                }
                if let Some(after) = shown.after.signal(channel.signal).filter(|_| claimed) {
                    panel = panel.trace(Trace::new("after", readable(after), Style::After));
                }
                let located = diagnosis.located.as_ref().filter(|location| location.signal == channel.signal);
                for interval in located.into_iter().flat_map(|location| &location.intervals) {
                    if interval.recording == shown.prepared.name && !shown.held_out {
                        panel = panel.shade(interval.from_s, interval.to_s);
                    }
                }
                Panel { points: Some(points(diagnosis)), ..panel }.residuals()
            })
            .collect();
    let subtitle = if shown.held_out { "held out" } else { "training" };
    svg(&shown.prepared.name, subtitle, &panels)
}

/// Points a trace may have, so that all recordings go into one page.
fn points(diagnosis: &Diagnosis) -> usize {
    let traces = if diagnosis.findings.is_empty() { 3 } else { 5 };
    let all: usize = diagnosis.shown.iter().map(|shown| traces * shown.prepared.channels.len()).sum();
    (BYTES / PER_POINT / all.max(1)).clamp(200, 2000)
}

fn readable(signal: Signal, values: &[f64]) -> Vec<f64> {
    let unit = unit_for_people(signal);
    values.iter().map(|value| unit.from_si(*value)).collect()
}
