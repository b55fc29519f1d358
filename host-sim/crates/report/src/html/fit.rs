//! The page of a fit: the values before and after, what they are worth on recordings that took no part, and the residuals.

use maud::{Markup, html};

use diagnosis::agreement::Doubt;
use diagnosis::localisation::Miss;
use diagnosis::{Fits, Refit, Shown, mean_fits, mean_noise_floor};
use recording::Recording;
use recording::display_unit::{difference, percent};

use super::about::About;
use super::budget::Budget;
use super::chart::under_its_name;
use super::document::{READING, document};
use super::evidence::white;
use super::overlay::{before_and_after, signals};
use super::parameters::{fitted, within_tolerances};
use super::used;
use crate::evidence::whiteness::whiteness;
use crate::terminal::missed;
use crate::wording;

/// What the model is called before and after the fit.
const NAMES: (&str, Option<&str>) = ("machine file", Some("fitted"));

/// The page. `recordings` are all that the refit shows, in its order, `doubts` what is doubtful about them for this drive.
#[must_use]
pub fn fit(refit: &Refit, recordings: &[&Recording], doubts: &[Doubt], about: &About) -> String {
    let panels = refit.shown.iter().map(|shown| shown.prepared.channels.len()).max().unwrap_or(1);
    let budget = Budget::shared(refit.shown.len(), panels, 2);
    let held_out = refit.shown.iter().any(|shown| shown.held_out);
    let above = refit.left.iter().any(Miss::is_above_noise);
    let worse = wording::fit_is_worse(refit);
    let top = html! {
        h1 class=(if above || worse.is_some() { "missing" } else { "nothing" }) {
            @if let Some(worse) = &worse { (worse) }
            @else if above { "What is left is more than noise, and no parameter that may move can remove it." }
            @else { "The fitted model follows its recordings to about their noise." }
        }
        @for doubt in doubts { p class="fact" { "Doubt: " (wording::doubt(doubt)) "." } }
        (gains(refit, held_out))
        p class="soft" { "NRMSE fit in free run, " @if held_out { "recordings that were held out" } @else { "the recordings that were fitted to: none was held out" }
            ": machine file → fitted values." }
        p class="fact" { "What is left: " (missed(&refit.left)) "."
            @if above { " " code { "host-sim diagnose" } " looks for what is missing." } }
        @if let Some(moving) = &refit.unsettled { @if !refit.converged { p class="fact" { "The search did not converge: " (wording::still_moving(moving)) "." } } }
        @for far in wording::far_values(&refit.far_values) { p class="fact" { "Far value: " (far) "." } }
        @for used in wording::used_up(&refit.file.machine, &refit.tolerated) { p class="fact" { "Tolerance: " (used) "." } }
    };
    let rest = html! {
        section {
            h2 { "Values" }
            p class="soft" { "The machine file's value, the fitted one with its standard deviation, and how far it moved." }
            (fitted(refit))
        }
        (within_tolerances(&refit.file.machine, &refit.tolerated))
        (before_after(&refit.shown))
        (each(&refit.shown, budget))
        (white(Some(&whiteness(&refit.shown, recordings, false)), &whiteness(&refit.shown, recordings, true)))
    };
    document(&format!("Fit of {}", refit.file.name), (about, &used(&refit.shown)), &top, &rest)
}

fn gains(refit: &Refit, held_out: bool) -> Markup {
    let (before, after) = (mean_fits(&refit.shown, held_out, false), mean_fits(&refit.shown, held_out, true));
    let floor = mean_noise_floor(&refit.shown, held_out);
    html! {
        ul class="gains" {
            @for (signal, before) in &before {
                li {
                    span class="name" { (signal) }
                    span class="number" { (percent(*before)) " %" @if let Some(after) = after.get(signal) { " → " strong { (percent(*after)) " %" } } }
                    @if let Some(floor) = floor.get(signal) { span class="name" { "noise floor " (percent(*floor)) " %" } }
                }
            }
        }
    }
}

fn before_after(shown: &[Shown]) -> Markup {
    let cell = |fits: &Fits, signal: &str| fits.get(signal).map_or_else(String::new, |fit| percent(*fit));
    html! {
        section {
            h2 { "Before and after" }
            table {
                tr { th { "NRMSE fit, % (free run)" } th { "machine file" } th { "fitted" } th { "noise floor" } }
                @for (held_out, label) in [(true, "held out"), (false, "fitted to")] {
                    @let (before, after) = (mean_fits(shown, held_out, false), mean_fits(shown, held_out, true));
                    @let floor = mean_noise_floor(shown, held_out);
                    @for signal in before.keys() {
                        tr { td { (label) " · " (signal) } td { (cell(&before, signal)) } td { (cell(&after, signal)) } td { (cell(&floor, signal)) } }
                    }
                }
            }
            p class="soft" { "Noise floor: what a perfect model would reach. A fit that is good on what it was fitted to and poor on what was held out has learnt the recordings, not the drive." }
        }
    }
}

/// Every recording, the first one open: recorded, before and after, with the residuals.
fn each(all: &[Shown], budget: Budget) -> Markup {
    let drawn = |shown: &Shown| budget.draws(all, shown);
    let left_out = all.iter().filter(|shown| !drawn(shown)).count();
    let first = all.iter().position(|shown| shown.held_out).unwrap_or(0);
    html! {
        section {
            h2 { "Every recording" }
            p class="soft" { "Free run of the model from the recorded input. " (READING)
                @if left_out > 0 { " " (left_out) " of " (all.len()) " recordings are not drawn, so that the page stays small." } }
            @for (index, shown) in all.iter().enumerate().filter(|(_, shown)| drawn(shown)) {
                details open[index == first] {
                    summary {
                        (shown.prepared.name) @if shown.held_out { " (held out)" }
                        @for (before, after) in shown.fits(false).zip(shown.fits(true)) {
                            span class="soft" { " · " (after.signal.name()) " " (percent(before.nrmse_percent)) " → " (percent(after.nrmse_percent)) " %" }
                        }
                    }
                    (under_its_name(shown, &before_and_after(shown, &signals(shown), NAMES, budget.points), budget))
                    (errors(shown))
                }
            }
        }
    }
}

/// Root mean square and largest error of every signal.
fn errors(shown: &Shown) -> Markup {
    html! {
        table class="wide" {
            tr { th { "signal" } th { "RMSE, machine file" } th { "RMSE, fitted" } th { "largest error, fitted" } th { "at, s" } }
            @for (before, after) in shown.fits(false).zip(shown.fits(true)) {
                tr { td { (after.signal.name()) } td { (difference(before.signal, before.rmse)) } td { (difference(after.signal, after.rmse)) }
                    td { (difference(after.signal, after.max_error)) } td { (format!("{:.3}", after.max_at_s)) } }
            }
        }
    }
}
