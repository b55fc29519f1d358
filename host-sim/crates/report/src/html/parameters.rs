//! Base parameters before and after, with what moved and why.

use maud::{Markup, html};

use diagnosis::agreement::Tolerated;
use diagnosis::{Diagnosis, Refit};
use identification::fit::{Estimate, Free, Freedom};
use model_core::machine::Machine;
use recording::display_unit::significant;

use crate::size::size;
use crate::terminal::{correlated, uncertainty};
use crate::wording::{WITHIN, tolerated_thing};

/// A value counts as moved when its change exceeds this many of its standard deviations.
const MOVED: f64 = 3.0;
/// The recordings determine a value when its standard deviation is below this share of what was allowed.
const TOLD: f64 = 0.5;
/// A value stood in for an effect when adding the effect moves it by this many allowed deviations.
const STOOD_IN: f64 = 0.3;

pub(crate) fn parameters(diagnosis: &Diagnosis) -> Markup {
    if diagnosis.refitted.is_empty() {
        return html! {};
    }
    let changes = diagnosis.changes();
    let alone = |estimate: &Estimate| diagnosis.selection.base.fit.machine.get(estimate.parameter);
    html! {
        section {
            h2 { "Base parameters" }
            p class="soft" { "The machine file's value, what it was refitted to"
                @if changes { " without and with what was found" } ", its standard deviation, and how far it moved." }
            table class="wide" {
                tr { th { "parameter" } th { "machine file" } @if changes { th { "before" } th { "after" } } @else { th { "fitted" } } th { "±" } th { "unit" } th { "moved" } th class="text" { "why" } }
                @for estimate in &diagnosis.base_values() {
                    @let description = estimate.parameter.description();
                    tr {
                        td { (description.key) }
                        td { (number(estimate.before, 4)) }
                        @if changes { td { (number(alone(estimate), 4)) } }
                        td { (number(estimate.value, 4)) }
                        td { (deviation(estimate)) }
                        td { (description.unit) }
                        td { (moved(estimate)) }
                        td class="text" { (why(estimate, prior(&diagnosis.base_parameters, estimate), changes.then(|| alone(estimate)))) }
                    }
                }
            }
            @if let Some(pairs) = correlated(&diagnosis.correlated) { p { "Estimates " (pairs) "." } }
        }
    }
}

/// The values of a refit: the machine file's, the fitted ones with their deviation, how far each moved and what that says.
pub(crate) fn fitted(refit: &Refit) -> Markup {
    html! {
        table class="wide" {
            tr { th { "parameter" } th { "machine file" } th { "fitted" } th { "±" } th { "unit" } th { "moved" } th class="text" { "why" } }
            @for estimate in &refit.estimates {
                @let description = estimate.parameter.description();
                tr {
                    td title=(description.meaning) { (description.key) }
                    td { (number(estimate.before, 4)) }
                    td { (number(estimate.value, 4)) }
                    td { (deviation(estimate)) }
                    td { (description.unit) }
                    td { (moved(estimate)) }
                    td class="text" { (why(estimate, prior(&refit.base_parameters, estimate), None)) }
                }
            }
        }
        @if let Some(pairs) = correlated(&refit.correlations) { p { "Estimates " (pairs) "." } }
    }
}

/// What the fit used of tolerances.
pub(crate) fn tolerances(diagnosis: &Diagnosis) -> Markup {
    within_tolerances(&diagnosis.machine_after, &diagnosis.tolerances())
}

/// What a fit of this drive used of tolerances.
pub(crate) fn within_tolerances(machine: &Machine<f64>, tolerated: &[Tolerated]) -> Markup {
    if tolerated.is_empty() {
        return html! {};
    }
    let sized = |parameter, value| size(machine, parameter, value);
    html! {
        section {
            h2 { (WITHIN) }
            p class="soft" { "What every installed drive has within its drawing: the fit may use it up to the limit of the machine file." }
            table class="wide" {
                tr { th { "tolerance" } th { "value" } th { "±" } th { "limit" } th { "unit" } th { "used" } th class="text" { "size" } }
                @for one in tolerated {
                    tr {
                        td title=(one.parameter.description().key) { (tolerated_thing(one.parameter)) }
                        td { (number(one.value, 3)) }
                        td { @if one.std.is_finite() { (number(one.std, 2)) } @else { "not determined" } }
                        td { @if one.parameter.description().min < 0.0 { "±" } (number(one.most, 2)) }
                        td { (one.parameter.description().unit) }
                        td { (significant(100.0 * (one.value / one.most).abs(), 2)) " %" }
                        td class="text" { @if let Some(size) = sized(one.parameter, one.value) { (size.within_tolerance()) } }
                    }
                }
            }
        }
    }
}

/// What the machine file says of a value.
fn prior<'a>(all: &'a [Free], estimate: &Estimate) -> Option<&'a Free> {
    all.iter().find(|free| free.parameter == estimate.parameter)
}

/// Change relative to the value in the machine file.
fn moved(estimate: &Estimate) -> String {
    let change = estimate.value - estimate.before;
    if change == 0.0 {
        return "–".to_owned();
    }
    let sign = if change < 0.0 { "−" } else { "+" };
    if estimate.before == 0.0 {
        format!("{sign}{}", number(change.abs(), 2))
    } else {
        let share = 100.0 * (change / estimate.before).abs();
        if share < 0.01 { "< 0.01 %".to_owned() } else { format!("{sign}{} %", significant(share, 2)) }
    }
}

/// In words: what the recordings say about the value, and whether it stood in for missing effects. `prior` is what the machine file
/// allows, `alone` the value that was fitted without the effects found.
fn why(estimate: &Estimate, prior: Option<&Free>, alone: Option<f64>) -> String {
    if estimate.at_bound {
        return "at the end of its range: no estimate".to_owned();
    }
    if !estimate.std.is_finite() {
        return "not determined by the recordings".to_owned();
    }
    let change = estimate.value - estimate.before;
    if let (Some(alone), Some(prior)) = (alone, prior) {
        let (then, now) = (prior.deviations(alone).abs(), prior.deviations(estimate.value).abs());
        if then - now > STOOD_IN && (alone - estimate.value).abs() > MOVED * estimate.std {
            return "before, it was pulled from its nominal value to make up for the missing effect".to_owned();
        }
    }
    let told = prior.is_none_or(|prior| estimate.std < TOLD * prior.width(estimate.value));
    let off = change.abs() > MOVED * estimate.std;
    match (told, off, prior) {
        (false, _, _) => "hardly determined by the recordings".to_owned(),
        (true, false, _) => "the recordings agree with the machine file".to_owned(),
        (true, true, Some(prior)) => {
            let off = significant(prior.deviations(estimate.value).abs(), 2);
            format!("determined by the recordings: moved by {off} times its standard deviation ({})", allowed(prior))
        }
        (true, true, None) => "the recordings tell it".to_owned(),
    }
}

/// A standard deviation: a number, or a factor where a value is known only roughly.
fn allowed(prior: &Free) -> String {
    match prior.freedom {
        Freedom::Roughly { least, spread, .. } => {
            // A chamber volume is known by what is in it beyond what the piston displaces.
            let of = if least > 0.0 { format!(" above {}", number(least, 3)) } else { String::new() };
            format!("a factor of {}{of}", significant(libm::exp(spread), 2))
        }
        _ => format!("± {}", number((prior.usually_off()[0] - prior.nominal()).abs(), 2)),
    }
}

pub(crate) fn deviation(estimate: &Estimate) -> String {
    if estimate.std.is_finite() && !estimate.at_bound { number(estimate.std, 2) } else { uncertainty(estimate) }
}

/// A number with this number of digits, with a power of ten where it is far from one.
pub(crate) fn number(value: f64, digits: i32) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-4..1e6).contains(&size) {
        significant(value, digits)
    } else {
        let precision = usize::try_from(digits - 1).unwrap_or(0);
        format!("{value:.precision$e}")
    }
}

#[cfg(test)]
mod tests {
    use model_core::machine::Parameter;

    use super::*;

    fn estimate(value: f64, std: f64) -> Estimate {
        Estimate { parameter: Parameter::BulkModulus, before: 1.0, value, std, at_bound: false }
    }

    #[test]
    fn it_says_what_moved_and_why() {
        let prior = |freedom| Free { parameter: Parameter::MeteringRatio, freedom };
        let around = prior(Freedom::Around { nominal: 1.0, sigma: 0.1 });
        let said = |value, std, alone| why(&estimate(value, std), Some(&around), alone);
        assert!(said(1.001, 0.001, None).contains("agree"), "{}", said(1.001, 0.001, None));
        assert!(
            said(1.05, 0.001, None)
                .starts_with("determined by the recordings: moved by 0.50 times its standard deviation (± 0.10"),
            "{}",
            said(1.05, 0.001, None)
        );
        assert!(said(1.05, 0.09, None).contains("hardly determined"));
        assert!(said(1.01, 0.001, Some(1.2)).contains("make up for"));
        assert!(!said(1.2, 0.001, Some(1.0)).contains("make up for"));
        assert!(said(1.0, f64::NAN, None).contains("not determined"));
        let roughly = prior(Freedom::Roughly { least: 0.0, nominal: 1.0, spread: 2.0_f64.ln() });
        let doubled = why(&estimate(2.0, 0.01), Some(&roughly), None);
        assert!(doubled.ends_with("moved by 1.0 times its standard deviation (a factor of 2.0)"), "{doubled}");
        assert!(why(&estimate(2.0, 0.9), Some(&roughly), None).contains("hardly determined"));
        assert!(why(&Estimate { at_bound: true, ..estimate(1.0, 0.1) }, None, None).contains("end of its range"));
        assert_eq!((moved(&estimate(1.05, 0.1)), moved(&estimate(0.9, 0.1))), ("+5.0 %".into(), "−10 %".into()));
    }
}
