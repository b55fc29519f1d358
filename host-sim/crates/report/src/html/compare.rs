//! The page of a comparison: every signal recorded and simulated, end to end and link by link, with the residuals and their correlations.

use maud::{Markup, html};

use diagnosis::agreement::Doubt;
use identification::compare::weakest::{obstacles, unjudged, weakest};
use identification::compare::{Comparison, Section, SectionFit, mean_fits};
use machine_file::MachineFile;
use recording::display_unit::{difference, percent};
use recording::{Recording, Signal};
use simulation::Trajectory;

use super::about::About;
use super::budget::Budget;
use super::chart::in_panels;
use super::document::{READING, document, prose};
use super::evidence::{of_signal, shares};
use crate::evidence::whiteness::{Whiteness, in_words, of_section};
use crate::inspect::input_point_name;
use crate::plot::{Panel, Style, panels_of};
use crate::wording;

/// Sections in the chain's order.
const SECTIONS: [Section; 6] = [
    Section::EndToEnd,
    Section::Valve,
    Section::BelowSpool,
    Section::BelowFlow,
    Section::FlowAndChambers,
    Section::Mechanics,
];

/// One machine file, compared with recordings.
#[derive(Clone, Copy, Debug)]
pub struct Compared<'a> {
    /// What it is called beside the others.
    pub label: &'a str,
    /// The machine file.
    pub file: &'a MachineFile,
    /// The recordings.
    pub recordings: &'a [Recording],
    /// What was found, one for each recording.
    pub comparisons: &'a [Comparison],
    /// What is doubtful about the recordings for this drive.
    pub doubts: &'a [Doubt],
}

impl<'a> Compared<'a> {
    /// This section of a recording.
    fn section(&self, recording: usize, section: Section) -> Option<&'a SectionFit> {
        self.comparisons.get(recording)?.sections.iter().find(|known| known.section == section)
    }

    /// The section of every recording that has it.
    fn sections(self, section: Section) -> impl Iterator<Item = &'a SectionFit> {
        (0..self.comparisons.len()).filter_map(move |recording| self.section(recording, section))
    }
}

/// The page of machine files on the same recordings: at least one of each.
#[must_use]
pub fn compare(all: &[Compared<'_>], about: &About) -> String {
    let labels: Vec<&str> = all.iter().map(|one| one.label).collect();
    let recordings = all.first().map_or(&[][..], |one| one.recordings);
    let of = match recordings {
        [one] => one.name().to_owned(),
        several => format!("{} recordings", several.len()),
    };
    let here: Vec<Section> =
        SECTIONS.into_iter().filter(|section| all.iter().any(|one| one.sections(*section).next().is_some())).collect();
    let panels: usize = here.iter().map(|section| signals(all, *section).len() + 1).sum();
    let budget = Budget::shared(recordings.len(), panels, all.len());
    let top = html! {
        (headline(all))
        (doubtful(all))
        (gains(all))
        p class="soft" { "Mean NRMSE fit end to end" @if all.len() > 1 { ": " (labels.join(" · ")) } ". 100 % is perfect, 0 % no better than the mean." }
    };
    let rest = html! {
        (side_by_side(all, &here))
        (told(all))
        p class="soft" { (READING) }
        @for section in &here { (section_of(all, *section, budget)) }
        (white(all, &here))
    };
    document(
        &format!("Comparison of {} with {of}", labels.join(" and ")),
        (about, &[("Recordings", recordings.iter().map(Recording::name).collect())]),
        &top,
        &rest,
    )
}

/// What is certainly wrong with the recordings for a drive, and units that can hardly be right.
fn doubtful(all: &[Compared<'_>]) -> Markup {
    html! {
        @for one in all {
            @let of_units = one.recordings.iter().flat_map(|recording| wording::unit_notes(recording, &one.file.machine));
            @for said in one.doubts.iter().filter(|doubt| doubt.is_certain).map(wording::mend_first).chain(of_units) {
                p class="fact" { "Doubt: " @if all.len() > 1 { (one.label) ": " } (prose(&said)) @if !said.ends_with('?') { "." } }
            }
        }
    }
}

/// One drive: its weakest part. Several: how many signals each fits best.
fn headline(all: &[Compared<'_>]) -> Markup {
    if let [one] = all {
        let Some(found) = weakest(one.comparisons) else {
            return html! { h1 { "No part could be judged by itself." } };
        };
        let (part, fit) = (format!("{}, {}", found.section, found.signal), percent(found.nrmse_percent));
        return html! {
            @if found.follows() { h1 class="nothing" { "Every part that could be judged follows; the weakest is " (part) " at " (fit) " %." } }
            @else if found.cannot_be_judged() {
                h1 { "No part that can be judged by itself misses its recordings. The weakest, " (part) " at " (fit) " %, cannot be judged." }
            }
            @else { h1 class=[found.is_judged.then_some("missing")] { "The weakest part is " (part) " at " (fit) " %." } }
        };
    }
    let means: Vec<Vec<(Signal, f64)>> = all.iter().map(|one| mean_fits(one.comparisons)).collect();
    let common: Vec<Signal> = means[0]
        .iter()
        .map(|(signal, _)| *signal)
        .filter(|signal| means.iter().all(|of| of.iter().any(|(known, _)| known == signal)))
        .collect();
    let fit = |of: &[(Signal, f64)], signal: Signal| {
        of.iter().find(|(known, _)| *known == signal).map_or(f64::NEG_INFINITY, |(_, fit)| *fit)
    };
    // As they are shown: what looks alike is a tie, and nobody's.
    let best = |signal: Signal| {
        let shown: Vec<String> = means.iter().map(|of| percent(fit(of, signal))).collect();
        let best = (0..means.len()).max_by(|a, b| fit(&means[*a], signal).total_cmp(&fit(&means[*b], signal)))?;
        (shown.iter().filter(|other| **other == shown[best]).count() == 1).then_some(best)
    };
    let won: Vec<usize> =
        (0..all.len()).map(|index| common.iter().filter(|signal| best(**signal) == Some(index)).count()).collect();
    let first = (0..all.len()).max_by_key(|index| (won[*index], usize::MAX - index)).unwrap_or(0);
    html! {
        h1 {
            @if won[first] > 0 { (all[first].label) " fits best end to end in " (won[first]) " of " (common.len()) " signals." }
            @else { "No machine file fits better end to end than the others." }
        }
    }
}

fn gains(all: &[Compared<'_>]) -> Markup {
    let means: Vec<Vec<(Signal, f64)>> = all.iter().map(|one| mean_fits(one.comparisons)).collect();
    html! {
        ul class="gains" {
            @for signal in signals(all, Section::EndToEnd) {
                li {
                    span class="name" { (signal) }
                    span class="number" {
                        @for (index, of) in means.iter().enumerate() {
                            @if index > 0 { " · " }
                            @match of.iter().find(|(known, _)| *known == signal) {
                                Some((_, fit)) => { (percent(*fit)) " %" }
                                None => "–",
                            }
                        }
                    }
                }
            }
        }
    }
}

/// What the comparison says of each drive.
fn told(all: &[Compared<'_>]) -> Markup {
    html! {
        @for one in all {
            div class="fact" {
                @if all.len() > 1 { p { strong { (one.label) } } }
                @for sentence in wording::sentences(one.comparisons, one.file.load_source) { p { (prose(&sentence)) } }
            }
        }
    }
}

/// The signals by which any drive is judged in a section.
fn signals(all: &[Compared<'_>], section: Section) -> Vec<Signal> {
    let mut found = Vec::new();
    for fit in all.iter().flat_map(|one| one.sections(section)).flat_map(|section| &section.fits) {
        if !found.contains(&fit.signal) {
            found.push(fit.signal);
        }
    }
    found
}

/// Mean fit, % and root mean square error, SI, over all recordings.
fn mean_of(one: Compared<'_>, section: Section, signal: Signal) -> Option<(f64, f64)> {
    let fits = one.sections(section).flat_map(|section| &section.fits).filter(|fit| fit.signal == signal);
    let (sum, square, count) = fits.fold((0.0, 0.0, 0.0), |(sum, square, count), fit| {
        (sum + fit.nrmse_percent, square + fit.rmse * fit.rmse, count + 1.0)
    });
    (count > 0.0).then(|| (sum / count, (square / count).sqrt()))
}

fn side_by_side(all: &[Compared<'_>], here: &[Section]) -> Markup {
    html! {
        section {
            h2 { "Every part" }
            table class="wide" {
                tr { th { "part, signal" }
                    @for one in all { th { @if all.len() > 1 { (one.label) ", " } "fit, %" } th { "RMSE" } } }
                @for section in here {
                    @let driven = all.iter().find_map(|one| one.sections(*section).next());
                    tr class="part" { td colspan=(1 + 2 * all.len()) { (section) @if let Some(driven) = driven { span class="soft" { ", from " (input_point_name(driven.input_point)) } } } }
                    @for signal in signals(all, *section) {
                        @let means: Vec<_> = all.iter().map(|one| mean_of(*one, *section, signal)).collect();
                        @let best = means.iter().flatten().map(|(fit, _)| *fit).fold(f64::NEG_INFINITY, f64::max);
                        tr {
                            td { (signal) }
                            @for mean in &means {
                                @match mean {
                                    Some((fit, rmse)) => {
                                        td { @if all.len() > 1 && *fit >= best { strong { (percent(*fit)) } } @else { (percent(*fit)) } }
                                        td { (difference(signal, *rmse)) }
                                    }
                                    None => { td { "–" } td { "–" } }
                                }
                            }
                        }
                    }
                }
            }
            p class="soft" { "NRMSE fit in free run from the part's own recorded input, mean over the recordings; RMSE over all of them." }
        }
    }
}

/// Why a section cannot be judged, where it cannot, of each drive.
fn doubts(all: &[Compared<'_>], section: Section) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for one in all {
        for part in unjudged(one.comparisons).iter().filter(|part| part.section == section) {
            let of = if all.len() > 1 { format!("{}: ", one.label) } else { String::new() };
            found.push(format!("{of}{}", wording::unjudged(part)));
        }
        if section == Section::EndToEnd {
            let missing = one.comparisons.iter().flat_map(|found| obstacles(found, one.file.load_source));
            for said in missing.map(wording::obstacle) {
                if !found.iter().any(|known| known == said) {
                    found.push(said.to_owned());
                }
            }
        }
    }
    found
}

fn section_of(all: &[Compared<'_>], section: Section, budget: Budget) -> Markup {
    let recordings = all.first().map_or(&[][..], |one| one.recordings);
    let drawn: Vec<(usize, &Recording)> = recordings.iter().enumerate().take(budget.recordings).collect();
    html! {
        section {
            h2 { (heading(section)) }
            p { (described(section)) }
            @for doubt in doubts(all, section) { p class="fact" { (prose(&doubt)) "." } }
            @for (index, recording) in &drawn {
                details open[*index == 0 && section == Section::EndToEnd] {
                    summary { (recording.name())
                        @for signal in signals(all, section) { span class="soft" { " · " (signal.name()) " " (fits(all, *index, section, signal)) " %" } } }
                    (unsettled(all, *index))
                    (in_panels(&panels(all, *index, section, budget.points), budget.rows))
                }
            }
            @if drawn.len() < recordings.len() {
                p class="soft" { (recordings.len() - drawn.len()) " of " (recordings.len()) " recordings are not drawn, so that the page stays small." }
            }
        }
    }
}

fn unsettled(all: &[Compared<'_>], recording: usize) -> Markup {
    let of = all.iter().filter_map(|one| one.comparisons.get(recording)).map(|found| found.unsettled_s);
    let longest = of.fold(0.0_f64, f64::max);
    html! { @if longest > 0.0 { p class="soft" { "It " (wording::unsettled(longest)) "." } } }
}

fn fits(all: &[Compared<'_>], recording: usize, section: Section, signal: Signal) -> String {
    let fit = |one: &Compared<'_>| {
        let found = one.section(recording, section)?.fits.iter().find(|fit| fit.signal == signal)?;
        Some(percent(found.nrmse_percent))
    };
    all.iter().map(|one| fit(one).unwrap_or_else(|| "–".to_owned())).collect::<Vec<_>>().join(" | ")
}

/// What a section's charts show of one recording.
fn panels(all: &[Compared<'_>], recording: usize, section: Section, points: usize) -> Vec<Panel> {
    let here: Vec<(&Compared<'_>, &SectionFit)> =
        all.iter().filter_map(|one| Some((one, one.section(recording, section)?))).collect();
    let Some((first, driven)) = here.first() else { return Vec::new() };
    let named: Vec<(&str, &Trajectory)> =
        here.iter().map(|(one, fit)| (if all.len() == 1 { "simulated" } else { one.label }, &fit.trajectory)).collect();
    let found = panels_of(&first.recordings[recording], driven.input_point, &named, &signals(all, section));
    found.into_iter().map(|panel| Panel { points: Some(points), ..panel }).collect()
}

const fn heading(section: Section) -> &'static str {
    match section {
        Section::EndToEnd => "End to end",
        Section::Valve => "Link: valve",
        Section::BelowSpool => "Links below the spool",
        Section::BelowFlow => "Links below the flow",
        Section::FlowAndChambers => "Links: flow and chambers",
        Section::Mechanics => "Link: mechanics",
    }
}

const fn described(section: Section) -> &'static str {
    match section {
        Section::EndToEnd => {
            "Driven by what is recorded furthest upstream. A misfit may be made anywhere in the chain."
        }
        Section::Valve => {
            "Driven by the recorded command, judged by the recorded spool: a misfit is made in the valve."
        }
        Section::BelowSpool => {
            "Driven by the recorded spool: a misfit is made in flow, chambers or mechanics, not in the valve."
        }
        Section::BelowFlow => "Driven by the recorded flow: a misfit is made in chambers or mechanics.",
        Section::FlowAndChambers => {
            "Driven by the recorded spool or pump at the recorded pressures: what the flow brings less what the oil gives way."
        }
        Section::Mechanics => "Driven by the recorded pressures or force: a misfit is made by mass, friction or load.",
    }
}

/// Whether the residuals are white, section by section, of each drive.
fn white(all: &[Compared<'_>], here: &[Section]) -> Markup {
    let found: Vec<(Section, Vec<Vec<Whiteness>>)> = here
        .iter()
        .map(|section| {
            (*section, all.iter().map(|one| of_section(one.recordings, one.comparisons, *section)).collect())
        })
        .collect();
    html! {
        section {
            h2 { "Are the residuals white?" }
            p { "The residual of a good model is correlated neither with its own past nor with the command. Share of lags outside the 99 % band; a white residual has about 1 %. Where the shares are high, fit the model first: " code { "host-sim fit" } "." }
            table class="wide" {
                tr { th { "part, signal" } @for one in all { th { @if all.len() > 1 { (one.label) ", " } "with itself" } th { "with the command" } } }
                @for (section, of) in &found {
                    tr class="part" { td colspan=(1 + 2 * all.len()) { (section) } }
                    @for signal in signals(all, *section) {
                        tr { td { (signal) }
                            @for one in of { @match one.iter().find(|known| known.signal == signal) {
                                Some(known) => (shares(known)),
                                None => { td { "–" } td { "–" } }
                            } } }
                    }
                }
            }
            @for (section, of) in &found {
                details {
                    summary { "Correlations: " (section) }
                    @for (one, known) in all.iter().zip(of) {
                        @if let Some(told) = in_words(known) { p class="soft" { @if all.len() > 1 { (one.label) ": " } (told) "." } }
                    }
                    div class="pair" { @for signal in signals(all, *section) { (correlations(all, of, signal)) } }
                }
            }
        }
    }
}

/// The correlations of one signal's residual, of all drives over each other.
fn correlations(all: &[Compared<'_>], of: &[Vec<Whiteness>], signal: Signal) -> Markup {
    let known: Vec<(&str, Style, &Whiteness)> = all
        .iter()
        .zip(of)
        .zip(0_u8..)
        .filter_map(|((one, found), number)| {
            let found = found.iter().find(|known| known.signal == signal)?;
            let (label, style) =
                if all.len() == 1 { ("residual", Style::Simulated) } else { (one.label, Style::Model(number)) };
            Some((label, style, found))
        })
        .collect();
    let Some((_, _, first)) = known.first() else { return html! {} };
    of_signal(first, &|values| known.iter().map(|(label, style, of)| (*label, *style, values(of))).collect())
}
