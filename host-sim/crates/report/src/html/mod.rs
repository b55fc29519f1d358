//! Diagnosis, inspection, comparison and fit, each as one self-contained page: no network, readable on paper and on a phone, with interactive charts where scripts
//! run and drawings where they do not.

mod about;
mod budget;
mod chart;
mod compare;
mod data;
mod document;
mod evidence;
mod findings;
mod fit;
mod inspect;
mod located;
mod overlay;
mod parameters;
mod spoken;
mod style;

use budget::Budget;
use chart::{chart, over_time};
use maud::{Markup, html};
use overlay::signals;

use diagnosis::selection::decision_rule::MOSTLY_NOISE_PERCENT;
use diagnosis::{Diagnosis, Fits, Shown, Verdict};
use identification::experiment::JudgedSignal;
use recording::Signal;
use recording::display_unit::{difference, percent};

use crate::evidence::Exhibits;
use crate::terminal::{is_structure_wrong, sentence};
use crate::wording;

pub use about::{About, Used};
pub use compare::{Compared, compare};
pub use document::document;
pub use fit::fit;
pub use inspect::{Inspected, inspect};
pub use overlay::overlay;

/// The page of a diagnosis.
#[must_use]
pub fn page(diagnosis: &Diagnosis, exhibits: &Exhibits, about: &About) -> String {
    let budget = Budget::of(diagnosis);
    let said = sentence(diagnosis);
    let top = html! {
        h1 class=(class(diagnosis.verdict)) { (said) @if !said.ends_with('?') { "." } }
        (findings::in_words(diagnosis))
        (improvement(diagnosis))
        (unfinished(diagnosis))
        (doubtful(diagnosis))
        (outside(diagnosis))
    };
    let rest = html! {
        (main_picture(diagnosis, exhibits, budget))
        @if !is_structure_wrong(diagnosis) && diagnosis.verdict != Verdict::NothingMissing { (located::located(diagnosis, exhibits, budget)) }
        (findings::findings(diagnosis, exhibits))
        (findings::how_sure(diagnosis, exhibits))
        (evidence::waterfall(&exhibits.waterfall))
        (fits(diagnosis))
        (recordings(diagnosis, budget))
        (evidence::whiteness(exhibits, diagnosis))
        (parameters::parameters(diagnosis))
        (parameters::tolerances(diagnosis))
        (evidence::prepared(&exhibits.preprocessing))
        (findings::to_the_controller(diagnosis))
    };
    document(&format!("Diagnosis of {}", diagnosis.machine), (about, &used(&diagnosis.shown)), &top, &rest)
}

/// The recordings by their use.
fn used(shown: &[Shown]) -> [(&'static str, Vec<&str>); 2] {
    let names = |held_out: bool| {
        shown.iter().filter(|shown| shown.held_out == held_out).map(|shown| shown.prepared.name.as_str()).collect()
    };
    [("Training", names(false)), ("Held out", names(true))]
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
    let changes = diagnosis.changes();
    html! {
        ul class="gains" {
            @for (signal, before) in before.iter().filter(|(signal, _)| floor.get(*signal).is_none_or(|floor| *floor > MOSTLY_NOISE_PERCENT)) {
                li {
                    span class="name" { (signal) }
                    span class="number" {
                        (percent(*before)) " %"
                        @if changes { @if let Some(after) = after.get(signal) { " → " strong { (percent(*after)) " %" } } }
                    }
                    @if let Some(floor) = floor.get(signal) { span class="name" { "noise floor " (percent(*floor)) " %" } }
                }
            }
        }
        p class="soft" {
            "NRMSE fit in free run" @if held_out { ", recordings that were held out" } @else { ", training recordings" }
            @if diagnosis.unnamed.is_some() { ": base parameters refitted → with a correction table." }
            @else if changes { ": base parameters refitted → with what was found." } @else { ", base parameters refitted." }
        }
    }
}

/// What is doubtful about the recordings for this drive, and values that the refit has moved far.
fn doubtful(diagnosis: &Diagnosis) -> Markup {
    html! {
        @for shown in wording::structure_shown(diagnosis) { p class="fact" { "Structure: " (shown) @if !shown.ends_with('?') { "." } } }
        @for doubt in &diagnosis.doubts { p class="fact" { "Doubt: " (wording::doubt(doubt)) "." } }
        @if let Some(oil) = &diagnosis.other_oil { p class="fact" { "Oil: " (wording::other_oil(oil)) "." } }
        @for effect in &diagnosis.otherwise { p class="fact" { "Acts otherwise than then: " (effect.name) ". " (wording::TRADED) "." } }
        @if !is_structure_wrong(diagnosis) {
            @for far in wording::far_values(&diagnosis.far_values()) { p class="fact" { "Far value: " (far) "." } }
            @if let Some(moving) = &diagnosis.unsettled { p class="fact" { "The refit did not converge: " (wording::still_moving(moving)) "." } }
            @for used in wording::used_up(&diagnosis.machine_after, &diagnosis.tolerances()) { p class="fact" { "Tolerance: " (used) "." } }
        }
    }
}

/// What a search that its limit has ended did not try, and what was slow.
fn unfinished(diagnosis: &Diagnosis) -> Markup {
    let searched = &diagnosis.selection.searched;
    html! {
        @if !searched.left_out.is_empty() {
            p class="fact" { "Not tried, or not to the end: " (wording::not_tried(searched).join(", ")) "." }
            p class="fact" { "Slow: " (wording::slow(searched)) "." }
            @if let Some(best) = wording::best_so_far(&diagnosis.selection).filter(|_| !searched.is_finished()) { p class="fact" { "Best so far: " (best) "." } }
        }
    }
}

/// A cause outside the drive, and how much of the misfit it explains.
fn outside(diagnosis: &Diagnosis) -> Markup {
    html! {
        @if let Some(outside) = &diagnosis.outside {
            p class="fact" { "From outside: " (wording::outside_cause(&outside.cause)) ". It explains " (wording::outside_explains(outside)) "." }
        }
    }
}

/// The effect's own picture, or the recording in which most of the error is made.
fn main_picture(diagnosis: &Diagnosis, exhibits: &Exhibits, budget: Budget) -> Markup {
    html! {
        @if let Some(picture) = exhibits.pictures.first() {
            (chart(&picture.figure))
            p class="soft" { (picture.caption) }
        } @else if let Some(shown) = located::where_it_is(diagnosis).or(diagnosis.example()) {
            (over_time(diagnosis, shown, &[most_telling(diagnosis, shown)], budget))
        }
    }
}

/// The signal with the largest misfit in its link; where nothing is located, the position, or else the last signal.
fn most_telling(diagnosis: &Diagnosis, shown: &Shown) -> Signal {
    let last =
        || signals(shown).into_iter().find(|signal| *signal == Signal::Position).or(signals(shown).last().copied());
    let located = diagnosis.located.as_ref().map(|location| location.signal);
    located.or_else(last).unwrap_or(Signal::Position)
}

fn fits(diagnosis: &Diagnosis) -> Markup {
    let changes = diagnosis.changes();
    let cell = |fits: &Fits, signal: &str| fits.get(signal).map_or_else(String::new, |fit| percent(*fit));
    html! {
        section {
            h2 { "Before and after" }
            table {
                tr { th { "NRMSE fit, % (free run)" } @if changes { th { "before" } th { "after" } } @else { th { "refitted" } } th { "noise floor" } }
                @for (held_out, label) in [(true, "held out"), (false, "training")] {
                    @let (before, after) = (diagnosis.mean_fits(held_out, false), diagnosis.mean_fits(held_out, true));
                    @let floor = diagnosis.noise_floor(held_out);
                    @for signal in before.keys() {
                        tr { td { (label) " · " (signal) } td { (cell(&before, signal)) } @if changes { td { (cell(&after, signal)) } } td { (cell(&floor, signal)) } }
                    }
                }
            }
            p class="soft" {
                @if changes { "Before: base parameters refitted. After: refitted together with what was found"
                    @if diagnosis.unnamed.is_some() { ", here a correction table" } ". " }
                "Noise floor: what a perfect model would reach."
                @if let Some(linear) = wording::yardstick(diagnosis) { " Beside it, a " (linear) "." } }
            details {
                summary { "Each recording by itself" }
                (each(diagnosis))
            }
        }
    }
}

/// Fit and largest error of every signal in every recording.
fn each(diagnosis: &Diagnosis) -> Markup {
    let changes = diagnosis.changes();
    html! {
        table class="wide" {
            tr { th { "recording" } th class="text" { "signal" } th { "before, %" } @if changes { th { "after, %" } } th { "noise floor, %" } th { "RMSE before" } @if changes { th { "RMSE after" } } }
            @for shown in &diagnosis.shown {
                @for (index, (before, after)) in shown.fits(false).zip(shown.fits(true)).enumerate() {
                    @let floor = shown.prepared.channels.iter().find(|channel| channel.signal == before.signal).map(JudgedSignal::noise_floor_percent);
                    tr {
                        td { @if index == 0 { (shown.prepared.name) @if shown.held_out { " (held out)" } } }
                        td class="text" { (before.signal.name()) }
                        td { (percent(before.nrmse_percent)) }
                        @if changes { td { (percent(after.nrmse_percent)) } }
                        td { @if let Some(floor) = floor { (percent(floor)) } }
                        td { (difference(before.signal, before.rmse)) }
                        @if changes { td { (difference(after.signal, after.rmse)) } }
                    }
                }
            }
        }
    }
}

fn recordings(diagnosis: &Diagnosis, budget: Budget) -> Markup {
    let drawn = |shown: &Shown| budget.draws(&diagnosis.shown, shown);
    let left_out = diagnosis.shown.iter().filter(|shown| !drawn(shown)).count();
    html! {
        section {
            h2 { "Every recording" }
            p class="soft" { "Free run of the model from the recorded input. Shaded: where the error before is made."
                @if left_out > 0 { " " (left_out) " of " (diagnosis.shown.len()) " recordings are not drawn, so that the page stays small." } }
            @for shown in diagnosis.shown.iter().filter(|shown| drawn(shown)) {
                details {
                    summary {
                        (shown.prepared.name) @if shown.held_out { " (held out)" }
                        @for fit in shown.fits(true) { span class="soft" { " · " (fit.signal.name()) " " (percent(fit.nrmse_percent)) " %" } }
                    }
                    (over_time(diagnosis, shown, &signals(shown), budget))
                }
            }
        }
    }
}
