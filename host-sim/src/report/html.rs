//! The diagnosis as one self-contained page: no script, no network, readable on paper and on a phone.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::terminal::{sentence, still_missing, uncertainty};
use crate::diagnose::{Diagnosis, Fits, Shown};
use crate::hypothesis::short_name;
use crate::plot::{Panel, Style, Trace, svg, title};
use crate::presentation::{percent, significant, unit_for_people};
use crate::recording::Signal;

const STYLE: &str = "
:root { color-scheme: light dark; --line: #8885; --soft: #8881; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.4rem; line-height: 1.3; } h2 { font-size: 1.1rem; margin-top: 2rem; }
table { border-collapse: collapse; margin: .5rem 0; display: block; overflow-x: auto; }
th, td { padding: .2rem .8rem .2rem 0; border-bottom: 1px solid var(--line); text-align: right; font-variant-numeric: tabular-nums; }
th:first-child, td:first-child { text-align: left; }
figure { margin: 1rem 0; background: #fff; border-radius: 4px; } figure svg { width: 100%; height: auto; display: block; }
.fact { padding: .6rem .8rem; background: var(--soft); border-radius: 4px; margin: .5rem 0; }
summary { cursor: pointer; padding: .3rem 0; }
@media print { details > * { display: block; } }
";

/// The page.
#[must_use]
pub fn page(diagnosis: &Diagnosis) -> String {
    let verdict = sentence(diagnosis);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Diagnosis of " (diagnosis.machine) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (verdict) }
                (fits(diagnosis))
                @if let Some(shown) = diagnosis.example() { (figure(diagnosis, shown)) }
                (located(diagnosis))
                (findings(diagnosis))
                (parameters(diagnosis))
                (trials(diagnosis))
                h2 { "Every recording" }
                p { "Free run of the model from the recorded input; before: ordinary parameters refitted; after: with the effects. "
                    "Shaded: where the error before is made." }
                @for shown in &diagnosis.shown {
                    details { summary { (shown.prepared.name) @if shown.held_out { " (held out)" } } (figure(diagnosis, shown)) }
                }
            }
        }
    }
    .into_string()
}

fn fits(diagnosis: &Diagnosis) -> Markup {
    let cell = |fits: &Fits, signal: &str| fits.get(signal).map_or_else(String::new, |fit| percent(*fit));
    html! {
        table {
            tr { th { "NRMSE fit, % (free run)" } th { "before" } th { "after" } th { "noise floor" } }
            @for (held_out, label) in [(true, "held out"), (false, "training")] {
                @let (before, after) = (diagnosis.mean_fits(held_out, false), diagnosis.mean_fits(held_out, true));
                @let floor = diagnosis.noise_floor(held_out);
                @for signal in before.keys() {
                    tr { td { (label) " · " (signal) } td { (cell(&before, signal)) } td { (cell(&after, signal)) } td { (cell(&floor, signal)) } }
                }
            }
        }
    }
}

fn located(diagnosis: &Diagnosis) -> Markup {
    html! {
        @if let Some(location) = &diagnosis.located {
            h2 { "Where" }
            div class="fact" {
                strong { (location.subsystem) } ", seen in " (location.signal.name()) ": " (location.region) ". "
                (location.intervals.len()) " intervals hold " (significant(100.0 * location.share, 2)) " % of the error. The error: " (location.shape.to_string()) "."
            }
            table {
                tr { th { "signal" } th { "RMSE before, in standard deviations of its noise" } }
                @for miss in &location.misses { tr { td { (miss.signal.name()) } td { (significant(miss.over_noise, 3)) } } }
            }
        }
    }
}

fn findings(diagnosis: &Diagnosis) -> Markup {
    html! {
        @for finding in &diagnosis.findings {
            h2 { (finding.effect.name) }
            div class="fact" {
                "In the " (finding.effect.subsystem) " link: " code { (finding.effect.equation) } ". Confidence "
                (significant(finding.confidence, 3)) " among the effects tried."
            }
            table {
                tr { th { "parameter" } th { "value" } th { "±" } th { "unit" } }
                @for estimate in &finding.parameters {
                    tr { td { (short_name(estimate.parameter)) } td { (format!("{:.4e}", estimate.value)) } td { (uncertainty(estimate)) }
                        td { (estimate.parameter.description().unit) } }
                }
            }
            @if !finding.alternatives.is_empty() {
                p { "Could also be: " @for (effect, confidence) in &finding.alternatives { (effect.name) " (" (significant(*confidence, 2)) ") " } }
            }
            ul { @for other in finding.effect.look_alikes { li { "Not to be taken for " (other.effect) ": " (other.told_apart_by) "." } } }
            p { "To be sure: " (finding.effect.separated_by) ". Source: " (finding.effect.source) "." }
        }
        @if !diagnosis.findings.is_empty() && !diagnosis.left.is_empty() { p { (still_missing(diagnosis)) "." } }
        @for effect in &diagnosis.not_confirmed {
            p { (effect.name) " was chosen on the training recordings; the held-out ones do not bear it out." }
        }
    }
}

fn parameters(diagnosis: &Diagnosis) -> Markup {
    html! {
        @if !diagnosis.refitted.is_empty() {
            h2 { "Ordinary parameters, fitted together with what was found" }
            table {
                tr { th { "parameter" } th { "nominal" } th { "fitted" } th { "±" } th { "unit" } }
                @for estimate in &diagnosis.refitted {
                    @let description = estimate.parameter.description();
                    tr { td { (description.key) } td { (format!("{:.4e}", estimate.before)) } td { (format!("{:.4e}", estimate.value)) }
                        td { (uncertainty(estimate)) } td { (description.unit) } }
                }
            }
        }
    }
}

fn trials(diagnosis: &Diagnosis) -> Markup {
    html! {
        h2 { "What was tried" }
        p { "Every set of effects was refitted in the chain on all training recordings; the gain is in log-likelihood, less a penalty for its parameters." }
        table {
            tr { th { "refitted with" } th { "gain" } }
            @for trial in diagnosis.selection.rounds.iter().flatten() {
                tr {
                    td { (trial.effects.iter().map(|effect| effect.name).collect::<Vec<_>>().join(" + ")) }
                    td { (format!("{:.1}", trial.net)) }
                }
            }
        }
        @if !diagnosis.not_testable.is_empty() {
            p { "Not testable with these recordings: "
                (diagnosis.not_testable.iter().map(|effect| effect.name).collect::<Vec<_>>().join(", ")) "." }
        }
    }
}

fn figure(diagnosis: &Diagnosis, shown: &Shown) -> Markup {
    html! { figure { (PreEscaped(overlay(diagnosis, shown))) } }
}

/// Recorded, before and after with residuals, as SVG: every judged signal of one recording.
#[must_use]
pub fn overlay(diagnosis: &Diagnosis, shown: &Shown) -> String {
    let claimed = !diagnosis.findings.is_empty();
    let panels: Vec<Panel> = shown
        .prepared
        .channels
        .iter()
        .map(|channel| {
            let readable = |values: &[f64]| readable(channel.signal, values);
            let unit = unit_for_people(channel.signal);
            let mut panel = Panel::new(title(channel.signal), unit.symbol(), shown.prepared.time_s.clone())
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
            panel.residuals()
        })
        .collect();
    let subtitle = if shown.held_out { "held out" } else { "training" };
    svg(&shown.prepared.name, subtitle, &panels)
}

fn readable(signal: Signal, values: &[f64]) -> Vec<f64> {
    let unit = unit_for_people(signal);
    values.iter().map(|value| unit.from_si(*value)).collect()
}
