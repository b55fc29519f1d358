//! The diagnosis as one self-contained page: no script, no network, readable on paper and on a phone.

mod claims;
mod evidence;
mod overlay;
mod style;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::terminal::{SUSPECTED, sentence};
use crate::diagnose::{Diagnosis, Fits, Shown, Verdict};
use crate::exhibits::Exhibits;
use crate::plot::{Figure, Layer, Marks, Style, scatter};
use crate::presentation::{percent, significant};
use crate::recording::Signal;
use crate::shape::Shape;

pub use overlay::{overlay, overlay_of};

/// The page.
#[must_use]
pub fn page(diagnosis: &Diagnosis, exhibits: &Exhibits) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Diagnosis of " (diagnosis.machine) }
                style { (PreEscaped(style::STYLE)) }
            }
            body {
                header {
                    p class="over" { "Diagnosis of " (diagnosis.machine) }
                    h1 class=(class(diagnosis.verdict)) { (sentence(diagnosis)) "." }
                    (improvement(diagnosis))
                }
                (main_picture(diagnosis, exhibits))
                (located(diagnosis))
                (claims::findings(diagnosis, exhibits))
                (claims::how_sure(diagnosis, exhibits))
                (evidence::waterfall(&exhibits.waterfall))
                (fits(diagnosis))
                (recordings(diagnosis))
                (evidence::whiteness(&exhibits.whiteness, diagnosis))
                (claims::parameters(diagnosis))
                (evidence::prepared(&exhibits.found))
                (claims::to_the_controller(diagnosis))
            }
        }
    }
    .into_string()
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::MissingPhysics => "missing",
        Verdict::NothingMissing => "nothing",
        Verdict::Unexplained => "unexplained",
    }
}

/// Fit of each signal before and after, in a line of large numbers.
fn improvement(diagnosis: &Diagnosis) -> Markup {
    let held_out = diagnosis.shown.iter().any(|shown| shown.held_out);
    let (before, after) = (diagnosis.mean_fits(held_out, false), diagnosis.mean_fits(held_out, true));
    let floor = diagnosis.noise_floor(held_out);
    let claimed = !diagnosis.findings.is_empty();
    html! {
        ul class="gains" {
            @for (signal, before) in &before {
                li {
                    span class="name" { (signal) }
                    span class="number" {
                        (percent(*before)) " %"
                        @if claimed { @if let Some(after) = after.get(signal) { " → " strong { (percent(*after)) " %" } } }
                    }
                    @if let Some(floor) = floor.get(signal) { span class="name" { "noise floor " (percent(*floor)) " %" } }
                }
            }
        }
        p class="soft" {
            "NRMSE fit in free run" @if held_out { ", recordings that were held out" } @else { ", training recordings" }
            @if claimed { ": ordinary parameters refitted → with what was found." } @else { ", ordinary parameters refitted." }
        }
    }
}

/// The effect's own picture, or the recording in which most of the error is made.
fn main_picture(diagnosis: &Diagnosis, exhibits: &Exhibits) -> Markup {
    let worst = diagnosis.located.as_ref().map(|location| location.signal);
    html! {
        @if let Some(picture) = exhibits.pictures.first() {
            (chart(&picture.figure))
            p class="soft" { (picture.caption) }
        } @else if let Some(shown) = where_it_is(diagnosis).or(diagnosis.example()) {
            (overlay_figure(&overlay_of(diagnosis, shown, &worst.map_or_else(|| signals(shown), |signal| vec![signal]))))
        }
    }
}

fn signals(shown: &Shown) -> Vec<Signal> {
    shown.prepared.channels.iter().map(|channel| channel.signal).collect()
}

/// The recording that holds the interval with most of the error.
fn where_it_is(diagnosis: &Diagnosis) -> Option<&Shown> {
    let named = &diagnosis.located.as_ref()?.intervals.first()?.recording;
    diagnosis.shown.iter().find(|shown| shown.prepared.name == *named && !shown.held_out)
}

/// A chart as wide as it is readable.
fn chart(figure: &Figure) -> Markup {
    html! { figure class="chart" { (PreEscaped(scatter(figure))) } }
}

/// Panels over time.
fn overlay_figure(svg: &str) -> Markup {
    html! { figure class="overlay" { (PreEscaped(svg)) } }
}

fn located(diagnosis: &Diagnosis) -> Markup {
    let Some(location) = &diagnosis.located else { return html! {} };
    html! {
        section {
            h2 { "Where" }
            div class="fact" {
                p { "In the " strong { (location.subsystem) } " link, seen most in " strong { (location.signal.name()) } ": " (location.region) "." }
                @if let Some(effect) = diagnosis.suspected { p { "Suspected: " strong { (effect.name) } ", " (SUSPECTED) "." } }
                p { (location.intervals.len()) " intervals hold " (significant(100.0 * location.share, 2)) " % of its error, and " (location.shape.to_string()) "." }
            }
            @if let Some(figure) = of_shape(&location.shape) { (chart(&figure)) }
            @if !diagnosis.findings.is_empty() || matches!(location.shape, Shape::Once { .. }) {
                @if let Some(shown) = where_it_is(diagnosis) {
                    (overlay_figure(&overlay_of(diagnosis, shown, &[location.signal])))
                    p class="soft" { "Shaded: where the error before is made." }
                }
            }
            details {
                summary { "The intervals, and every signal" }
                table {
                    tr { th { "recording" } th { "from, s" } th { "to, s" } }
                    @for interval in &location.intervals {
                        tr { td { (interval.recording) } td { (significant(interval.from_s, 4)) } td { (significant(interval.to_s, 4)) } }
                    }
                }
                table {
                    tr { th { "signal" } th { "error before, in standard deviations of its noise" } }
                    @for miss in &location.misses { tr { td { (miss.signal.name()) } td { (significant(miss.over_noise, 3)) } } }
                }
            }
        }
    }
}

/// The error over the state that it follows.
fn of_shape(shape: &Shape) -> Option<Figure> {
    let Shape::Over { state, unit, bins, .. } = shape else { return None };
    let (unit, scale) = match *unit {
        "1" => ("% of travel", 100.0),
        "m" => ("mm", 1e3),
        "m/s" => ("mm/s", 1e3),
        "Pa" => ("bar", 1e-5),
        other => (other, 1.0),
    };
    let steps = bins.iter().flat_map(|bin| [(scale * bin.from, bin.mean), (scale * bin.to, bin.mean)]).collect();
    Some(Figure {
        title: format!("What the model before misses, over the {state}"),
        x: format!("{state} [{unit}]"),
        y: "mean error [standard deviations of the noise]".to_owned(),
        layers: vec![Layer { label: "before".to_owned(), style: Style::Before, marks: Marks::Line(steps) }],
        band: Some(1.0),
    })
}

fn fits(diagnosis: &Diagnosis) -> Markup {
    let cell = |fits: &Fits, signal: &str| fits.get(signal).map_or_else(String::new, |fit| percent(*fit));
    html! {
        section {
            h2 { "Before and after" }
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
            p class="soft" { "Before: ordinary parameters refitted. After: refitted together with the effects found. Noise floor: what a perfect model would reach." }
        }
    }
}

fn recordings(diagnosis: &Diagnosis) -> Markup {
    html! {
        section {
            h2 { "Every recording" }
            p class="soft" { "Free run of the model from the recorded input. Shaded: where the error before is made." }
            @for shown in &diagnosis.shown {
                details {
                    summary {
                        (shown.prepared.name) @if shown.held_out { " (held out)" }
                        @for fit in shown.fits(true) { span class="soft" { " · " (fit.signal.name()) " " (percent(fit.nrmse_percent)) " %" } }
                    }
                    (overlay_figure(&overlay(diagnosis, shown)))
                }
            }
        }
    }
}
