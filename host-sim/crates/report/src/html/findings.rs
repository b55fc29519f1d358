//! Accepted effects, how certain they are, and how they are brought to the controller.

use std::fmt::Write;

use maud::{Markup, html};

use diagnosis::catalogue::{Kind, short_name};
use diagnosis::selection::Confirmation;
use diagnosis::{Diagnosis, Finding, Verdict};
use experiment::discriminate::Separation;
use model_core::effects::Effect;
use model_core::machine::{Parameter, Source};
use recording::display_unit::significant;

use super::chart::chart;
use super::parameters::{deviation, number};
use crate::evidence::Exhibits;
use crate::size::size;
use crate::terminal::still_missing;
use crate::wording::{self, capital};

/// What was found, as the people at the machine know it, with its size and what to check; and what is left.
pub(crate) fn in_words(diagnosis: &Diagnosis) -> Markup {
    html! {
        @for finding in &diagnosis.findings {
            @if let Some(cause) = Effect::named(finding.effect.name).map(wording::cause) {
                div class="finding" {
                    p { strong { (capital(cause.happens)) } @if let Some(size) = size_of(diagnosis, finding) { ": " (size) } "." }
                    p { "Check " (cause.check) "." }
                }
            }
        }
        @if !diagnosis.findings.is_empty() && !diagnosis.left.is_empty() { p class="fact" { (still_missing(diagnosis)) "." } }
    }
}

/// How large a finding is: the change of what was there already, or the amount of what is new.
fn size_of(diagnosis: &Diagnosis, finding: &Finding) -> Option<String> {
    let sizes = finding.parameters.iter().filter_map(|estimate| {
        Some((estimate.parameter, size(&diagnosis.machine_after, estimate.parameter, estimate.value)?))
    });
    let is_amount = |parameter: Parameter| {
        let mut of_effect = finding.effect.effect_parameters();
        of_effect.any(|of| of.parameter == parameter && matches!(of.kind, Kind::Amount(_) | Kind::Signed(_)))
    };
    let sizes: Vec<_> = sizes.collect();
    let amount = sizes.iter().find(|(parameter, _)| is_amount(*parameter)).or(sizes.first());
    wording::change(&diagnosis.machine_after, finding).or(amount.map(|(_, size)| size.to_string()))
}

pub(crate) fn findings(diagnosis: &Diagnosis, exhibits: &Exhibits) -> Markup {
    html! {
        @if diagnosis.verdict == Verdict::Unexplained {
            section {
                h2 { "What" }
                @if diagnosis.selection.searched.is_finished() {
                    p { "No effect that was tried explains it on recordings left out of the fit. Its place and shape are described above." }
                } @else {
                    p { "The search ended at its limit: no effect was held against recordings left out of the fit." }
                }
                (not_confirmed(diagnosis))
                @if let Some(unnamed) = &diagnosis.unnamed {
                    p class="fact" { (capital(&wording::correction_table(unnamed))) ". It can be used in the controller, but it does not explain the cause." }
                }
            }
        }
        @for (index, finding) in diagnosis.findings.iter().enumerate() {
            section {
                h2 { "What: " (finding.effect.name) }
                @if let Some(change) = wording::change(&diagnosis.machine_after, finding) { p class="fact" { (capital(&change)) "." } }
                div class="fact" { p { "In the " (finding.effect.subsystem) " link: " code { (finding.effect.equation) } } }
                table {
                    tr { th { "parameter" } th { "value" } th { "±" } th { "unit" } th class="text" { "size" } }
                    @for estimate in &finding.parameters {
                        tr { td { (short_name(estimate.parameter)) } td { (number(estimate.value, 4)) } td { (deviation(estimate)) }
                            td { (estimate.parameter.description().unit) }
                            td class="text" { @if let Some(size) = size(&diagnosis.machine_after, estimate.parameter, estimate.value) { (size) } } }
                    }
                }
                @for (number, picture) in exhibits.pictures.iter().filter(|picture| picture.effect == finding.effect.name).enumerate() {
                    // The first picture of all is at the top of the page.
                    @if index > 0 || number > 0 { (chart(&picture.figure)) p class="soft" { (picture.caption) } }
                }
                @if wording::look_alikes(finding.effect, diagnosis.machine_after.source).next().is_some() {
                    h3 { "What looks alike" }
                    ul { @for (other, test) in wording::look_alikes(finding.effect, diagnosis.machine_after.source) { li { (other) ": " (test) "." } } }
                }
                p class="soft" { "Source: " (finding.effect.source) "." }
            }
        }
    }
}

fn not_confirmed(diagnosis: &Diagnosis) -> Markup {
    html! {
        @for effect in &diagnosis.not_confirmed {
            p { (effect.name) " was chosen on the training recordings, but the held-out recordings do not confirm it: they gain nothing, or too little of what it promised." }
        }
    }
}

/// How much of its promise the choice keeps.
fn kept(confirmation: &Confirmation) -> String {
    let percent = |fall: f64| significant(100.0 * libm::exp(-fall), 3);
    format!(
        "With it, the squared error falls to {} % in training and to {} % on the held-out recordings (mean of the signals).",
        percent(confirmation.promised),
        percent(confirmation.kept)
    )
}

pub(crate) fn how_sure(diagnosis: &Diagnosis, exhibits: &Exhibits) -> Markup {
    html! {
        section {
            h2 { "How sure" }
            @for finding in &diagnosis.findings { (sureness(finding, exhibits, diagnosis.machine_after.source)) }
            @if let Some(confirmation) = &diagnosis.confirmation {
                p { "Held-out recordings, opened after the choice: better on " (confirmation.improved) " of " (confirmation.recordings) "." }
                p { (kept(confirmation)) }
            } @else if !diagnosis.findings.is_empty() {
                p { "No recording was held out to confirm it." }
            }
            p { "How often the diagnosis is wrong, on virtual drives with nothing missing and with causes outside the catalogue: "
                code { "docs/diagnosis.md" } "." }
            details {
                summary { "All refitted candidate models" }
                p class="soft" { "Simulated as a whole, on all training recordings together. Gain in log-likelihood, less a penalty for its parameters." }
                table {
                    tr { th { "refitted with" } th { "gain" } }
                    @for trial in diagnosis.selection.rounds.iter().flatten() {
                        tr {
                            td { (trial.effects.iter().map(|effect| effect.name).collect::<Vec<_>>().join(" + ")) }
                            td { (format!("{:.1}", trial.net)) }
                        }
                    }
                }
            }
            @if !diagnosis.not_testable.is_empty() {
                p class="soft" { "Not testable with these recordings: "
                    (diagnosis.not_testable.iter().map(|effect| effect.name).collect::<Vec<_>>().join(", ")) "." }
            }
        }
    }
}

/// A finding's probability, and the test that would settle it.
fn sureness(finding: &Finding, exhibits: &Exhibits, source: Source) -> Markup {
    let rivals: Vec<&Separation> = exhibits.rivals(finding).collect();
    html! {
        p { strong { (finding.effect.name) } ": confidence " (significant(finding.confidence, 3)) " among the effects tried."
            @if finding.alternatives.is_empty() { " No other effect is nearly as likely." } @else {
                " Could also be "
                @for (index, (effect, confidence)) in finding.alternatives.iter().enumerate() {
                    @if index > 0 { ", " } (effect.name) " (" (significant(*confidence, 2)) ")"
                }
                "."
            }
        }
        @if let Some(jumps) = finding.jumps {
            p { "Evidence: " (wording::jumps(jumps)) "." }
        }
        @if rivals.is_empty() {
            p { "To be sure: " (exhibits.separated_by(finding, source)) "." }
        } @else {
            table {
                tr { th { "against" } th class="text" { "test with the channels at hand" } th { "distance" } th class="text" { "with one more sensor" } }
                @for rival in rivals {
                    tr {
                        td { (rival.rival) }
                        td class="text" { @if let Some(best) = rival.tests.first() { (best.test) ": " (best.how) " (" (significant(best.duration_s, 2)) " s)" } }
                        td { @if let Some(best) = rival.tests.first() { (significant(best.over_noise, 2)) " × noise in " (best.signal.name()) } }
                        td class="text" { @match &rival.sensor {
                            Some((sensor, best)) => { (sensor.name()) ": " (best.test) ", " (significant(best.over_noise, 2)) " × noise in " (best.signal.name()) }
                            None => "–",
                        } }
                    }
                }
            }
            p class="soft" { "Both fitted drives were simulated in the standard tests; differences that a refit within the uncertainties could remove are subtracted. "
                "Chosen: the test that separates most per 20 s. A sensor is named where it at least doubles that." }
        }
    }
}

pub(crate) fn to_the_controller(diagnosis: &Diagnosis) -> Markup {
    html! {
        section {
            h2 { "To the controller" }
            ol {
                li { "The same command with " code { "--save-machine after.toml" } " writes the machine file with everything fitted"
                    @if !diagnosis.findings.is_empty() { " and what was found switched on" } "." }
                li { code { "host-sim compare --machine after.toml --recording new.csv" } " compares it with a new recording." }
                li { code { "host-sim export --machine after.toml --out params.rs" } " makes the constants for the firmware of it: "
                    code { "FIRMWARE_MACHINE=params.rs" } " when the firmware is built." }
            }
            @if !diagnosis.findings.is_empty() {
                p { "What is new in the machine file:" }
                @for finding in &diagnosis.findings {
                    pre { (snippet(finding)) }
                }
            }
        }
    }
}

/// The effect's tables in the machine file: its own, and the table of the bristles that several frictions share.
fn snippet(finding: &Finding) -> String {
    let (mut text, mut table) = (String::new(), "");
    for estimate in &finding.parameters {
        let there = estimate.parameter.description().key.rsplit_once('.').map_or("", |(table, _)| table);
        if there != table {
            let _ = writeln!(text, "[{there}]");
            table = there;
        }
        let rounded: f64 = format!("{:.5e}", estimate.value).parse().unwrap_or(estimate.value);
        let value = if (1e-3..1e6).contains(&rounded.abs()) { format!("{rounded:?}") } else { format!("{rounded:e}") };
        let unit = estimate.parameter.description().unit;
        let _ = writeln!(text, "{} = {value}  # {unit}", short_name(estimate.parameter));
    }
    text
}
