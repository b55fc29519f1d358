//! The page of an inspection: what can be tested, and every channel over time with what is suspicious marked.

use maud::{Markup, html};

use experiment::inspect::{InspectedColumn, Inspection, LinkTest, Reach};
use recording::display_unit::{difference, significant};
use recording::{Recording, Signal, UnknownColumn};

use super::about::About;
use super::budget::Budget;
use super::chart::in_panels;
use super::document::{READING, document, prose};
use super::spoken::{own, said};
use crate::inspect::{extent, opened, reach, travelled};
use crate::plot::{Panel, Style, Trace, title};
use crate::wording;

/// Marks nearer to each other than this part of a recording are one in its charts.
const FINEST: f64 = 400.0;

/// One inspected recording.
#[derive(Clone, Copy, Debug)]
pub struct Inspected<'a> {
    /// What was found.
    pub found: &'a Inspection,
    /// The recording.
    pub recording: &'a Recording,
    /// The columns of its file that hold no known signal.
    pub unknown: &'a [UnknownColumn],
}

impl<'a> Inspected<'a> {
    /// What was found, the recordings and their further columns, each in the same order.
    pub fn each(
        found: &'a [Inspection],
        recordings: impl IntoIterator<Item = &'a Recording>,
        unknown: &'a [Vec<UnknownColumn>],
    ) -> Vec<Self> {
        let all = found.iter().zip(recordings).zip(unknown);
        all.map(|((found, recording), unknown)| Inspected { found, recording, unknown }).collect()
    }
}

/// The page of some recordings, looked at beside this machine file where there is one.
#[must_use]
pub fn inspect(machine: Option<&str>, all: &[Inspected<'_>], about: &About) -> String {
    let of = match all {
        [one] => one.found.recording.clone(),
        several => format!("{} recordings", several.len()),
    };
    let beside = machine.map_or_else(String::new, |machine| format!(" for {machine}"));
    let remarks = all.iter().map(|one| remarks(one.found).count()).sum::<usize>();
    let panels = all.iter().map(|one| one.found.channels.len() + one.unknown.len()).max().unwrap_or(1);
    let budget = Budget::shared(all.len(), panels.max(1), 0);
    let top = html! {
        h1 class=(if remarks == 0 { "nothing" } else { "remarks" }) { (tested(all)) "; " (looked(remarks)) "." }
        p class="soft" { (READING) }
    };
    let rest = html! {
        (links(all))
        @for (index, one) in all.iter().enumerate() {
            section {
                h2 { (one.found.recording) }
                (facts(one.found))
                @if index < budget.recordings { (in_panels(&panels_of(one, budget.points), budget.rows)) }
                @else { p class="soft" { "Not drawn, so that the page stays small: inspect it by itself." } }
                (not_drawn(one))
                (channels(&one.found.channels))
            }
        }
    };
    document(
        &format!("Inspection of {of}{beside}"),
        (about, &[("Recordings", all.iter().map(|one| one.found.recording.as_str()).collect())]),
        &top,
        &rest,
    )
}

/// How many links can be tested, each by the recording that tests it best.
fn tested(all: &[Inspected<'_>]) -> String {
    let links = all.first().map_or(&[][..], |one| one.found.links.as_slice());
    let rank = |test: &LinkTest| match test.reach {
        Reach::Alone { .. } => 2,
        Reach::Together { .. } => 1,
        Reach::No => 0,
    };
    let best = |link: &LinkTest| {
        let same = all.iter().flat_map(|one| &one.found.links).filter(|test| test.link == link.link);
        same.map(rank).max().unwrap_or(0)
    };
    let count = |wanted: i32| links.iter().filter(|link| best(link) == wanted).count();
    let said = format!("{} of {} links can be tested alone", count(2), links.len());
    let further = [(count(1), "only with other links"), (count(0), "not at all")];
    let further = further.into_iter().filter(|(count, _)| *count > 0).map(|(count, how)| format!("{count} {how}"));
    std::iter::once(said).chain(further).collect::<Vec<_>>().join(", ")
}

fn looked(remarks: usize) -> String {
    match remarks {
        0 => "nothing looks suspicious".to_owned(),
        1 => "1 remark on what was recorded".to_owned(),
        several => format!("{several} remarks on what was recorded"),
    }
}

/// Everything worth a look in a recording, each with the signal that it is about.
fn remarks(found: &Inspection) -> impl Iterator<Item = (Option<Signal>, String)> {
    let notes = found.notes.iter().map(|note| (None, note.clone()));
    let advice = found.advice.iter().map(|advice| (wording::about(advice), wording::recording_advice(advice)));
    let marks = found.channels.iter().flat_map(|channel| {
        wording::marks(channel.signal, &channel.marks).into_iter().map(|said| (Some(channel.signal), said))
    });
    notes.chain(advice).chain(marks)
}

/// Which links can be tested, by groups of recordings that can test the same.
fn links(all: &[Inspected<'_>]) -> Markup {
    let mut groups: Vec<(Vec<&str>, &[LinkTest])> = Vec::new();
    for one in all {
        match groups.iter_mut().find(|(_, links)| *links == one.found.links.as_slice()) {
            Some((names, _)) => names.push(&one.found.recording),
            None => groups.push((vec![&one.found.recording], &one.found.links)),
        }
    }
    html! {
        section {
            h2 { "What can be tested" }
            p class="soft" { "A link is tested alone where its input and its output are recorded: a misfit is then made in it. With other links together, a misfit may be made in any of them." }
            @for (names, tests) in &groups {
                @if groups.len() > 1 { h3 { (names.join(", ")) } }
                table class="links" {
                    @for test in *tests {
                        @let (class, sign) = sign(&test.reach);
                        tr class=(class) { th { (sign) " " (test.link) } td class="text" { (reach(test)) } }
                    }
                }
            }
        }
    }
}

const fn sign(reach: &Reach) -> (&'static str, &'static str) {
    match reach {
        Reach::Alone { .. } => ("alone", "●"),
        Reach::Together { .. } => ("together", "◐"),
        Reach::No => ("not", "○"),
    }
}

/// What a recording holds and what is worth a look in it.
fn facts(found: &Inspection) -> Markup {
    html! {
        p { (extent(found)) "." }
        @if let Some(opened) = opened(found) { p { "Excited: " (opened) "." } }
        @if let Some(rod) = travelled(found) { p { "Moved: " (rod) "." } }
        @if let Some(unseen) = &found.unseen { p { "Not to be seen: " (wording::unseen(unseen)) "." } }
        @if remarks(found).next().is_some() {
            ul class="fact remark" {
                @for (signal, said) in remarks(found) {
                    @let named = signal.filter(|signal| !said.starts_with(signal.name()));
                    li { @if let Some(signal) = named { (signal) ": " } (prose(&said)) @if !said.ends_with('?') { "." } }
                }
            }
        }
        @if !found.gaps.is_empty() {
            p class="soft" { "Shaded in every chart: " (found.gaps.len()) @if found.gaps.len() == 1 { " gap" } @else { " gaps" } " in the time stamps." }
        }
    }
}

/// A panel for every channel, those that the model does not know last.
fn panels_of(one: &Inspected<'_>, points: usize) -> Vec<Panel> {
    let known = one.found.channels.iter().filter_map(|channel| known_panel(one, channel));
    let drawn = one.unknown.iter().filter(|column| !column.values.is_empty());
    let unknown = drawn.map(|column| unknown_panel(column, &one.found.gaps));
    known.chain(unknown).map(|panel| Panel { points: Some(points), ..panel }).collect()
}

fn known_panel(one: &Inspected<'_>, channel: &InspectedColumn) -> Option<Panel> {
    let is_set =
        matches!(channel.signal, Signal::Command | Signal::Reference | Signal::ValveDirection | Signal::PumpSpeed);
    let values = one.recording.signal(channel.signal)?;
    let readable: Vec<f64> = values.iter().map(|value| channel.unit.from_si(*value)).collect();
    let (time_s, readable) = broken(one.recording.time_s(), &readable, &one.found.gaps);
    let of_spool = channel.signal == Signal::Spool;
    let unit = if of_spool { "% of travel" } else { channel.unit.symbol() };
    let own = channel.header.to_lowercase();
    let name = if own.starts_with(channel.signal.name()) {
        title(channel.signal).to_owned()
    } else {
        format!("{} ({})", title(channel.signal), without_unit(&channel.header).0)
    };
    let style = if is_set { Style::Input } else { Style::Channel };
    let of_channel = remarks(one.found).filter(|(signal, _)| *signal == Some(channel.signal));
    let remarks: Vec<String> = of_channel.map(|(_, remark)| remark).collect();
    let mut panel =
        Panel::new(&name, unit, time_s).trace(Trace::new("recorded", readable, style)).note(&said(&remarks.join("; ")));
    let marked: Vec<(f64, f64)> = channel.marks.iter().map(|mark| (mark.from_s, mark.to_s)).collect();
    panel.intervals = merged(&marked, one.found.duration_s / FINEST);
    panel.intervals.extend(merged(&one.found.gaps, one.found.duration_s / FINEST));
    Some(panel)
}

fn unknown_panel(column: &UnknownColumn, gaps: &[(f64, f64)]) -> Panel {
    let (name, own) = without_unit(&column.header);
    let unit = column.unit.map_or(own, |unit| unit.symbol());
    let (time_s, values) = broken(&column.time_s, &column.values, gaps);
    let trace = Trace::new("recorded", values, Style::Channel);
    let mut panel = Panel::new(name, if unit.is_empty() { "unit unknown" } else { unit }, time_s)
        .trace(trace)
        .note("no known signal: the model does not use it");
    let last = column.time_s.last().copied().unwrap_or(0.0);
    panel.intervals = merged(gaps, last / FINEST);
    panel
}

/// A header's name and what stands in its brackets.
fn without_unit(header: &str) -> (&str, &str) {
    let split = header.strip_suffix(']').and_then(|header| header.rsplit_once('['));
    split.map_or((header, ""), |(name, unit)| (name.trim_end(), unit))
}

/// Stretches of time in their order, those that follow each other within this time as one: a channel that is clipped in every other row would
/// fill the page with its marks.
fn merged(stretches: &[(f64, f64)], within_s: f64) -> Vec<(f64, f64)> {
    let mut sorted = stretches.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut all: Vec<(f64, f64)> = Vec::new();
    for (from, to) in sorted {
        match all.last_mut() {
            Some((_, last)) if from - *last <= within_s => *last = last.max(to),
            _ => all.push((from, to)),
        }
    }
    all
}

/// Times and values with a row without value in every gap, so that no line is drawn across it.
fn broken(time_s: &[f64], values: &[f64], gaps: &[(f64, f64)]) -> (Vec<f64>, Vec<f64>) {
    let mut rows: Vec<(f64, f64)> = time_s.iter().copied().zip(values.iter().copied()).collect();
    rows.extend(gaps.iter().map(|(from, to)| (f64::midpoint(*from, *to), f64::NAN)));
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    rows.into_iter().unzip()
}

/// Columns that cannot be drawn over time.
fn not_drawn(one: &Inspected<'_>) -> Markup {
    let names: Vec<&str> =
        one.unknown.iter().filter(|column| column.values.is_empty()).map(|column| column.header.as_str()).collect();
    html! {
        @if !names.is_empty() {
            p class="soft" { "Not drawn, as not every row holds a number: " @for (index, name) in names.iter().enumerate() { @if index > 0 { ", " } (own(name)) } "." }
        }
        @if one.unknown.iter().any(|column| !column.values.is_empty() && column.values.len() < one.found.rows) {
            p class="soft" { "Of channels that the model does not know, the first rows are drawn." }
        }
    }
}

fn channels(channels: &[InspectedColumn]) -> Markup {
    html! {
        details {
            summary { "Noise, steps and range of every channel" }
            table class="wide" {
                tr { th { "signal" } th class="text" { "column" } th { "from" } th { "to" } th { "unit" } th { "noise" } th { "step" } th { "failed rows" } }
                @for channel in channels {
                    @let value = |si: f64| significant(channel.unit.from_si(si), 4);
                    @let small = |si: Option<f64>| si.map_or_else(|| "–".to_owned(), |si| difference(channel.signal, si));
                    tr {
                        td { (channel.signal) } td class="text" { code { (channel.header) } }
                        td { (value(channel.low)) } td { (value(channel.high)) } td { (channel.unit) }
                        td { (small(channel.noise)) } td { (small(channel.step)) } td { (channel.failed) }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_line_is_drawn_across_a_gap() {
        let (time_s, values) = broken(&[0.0, 0.1, 0.6, 0.7], &[1.0, 2.0, 3.0, 4.0], &[(0.1, 0.6)]);
        assert_eq!(time_s, [0.0, 0.1, 0.35, 0.6, 0.7]);
        assert!(values[2].is_nan() && (values[3] - 3.0).abs() < 1e-12);
    }

    #[test]
    fn marks_that_follow_each_other_closely_are_one() {
        let found = merged(&[(2.0, 2.5), (0.0, 0.1), (0.11, 0.2)], 0.05);
        assert_eq!(found, [(0.0, 0.2), (2.0, 2.5)]);
    }

    #[test]
    fn a_header_without_brackets_has_no_unit() {
        assert_eq!(without_unit("Motorstrom [A]"), ("Motorstrom", "A"));
        assert_eq!(without_unit("Motorstrom"), ("Motorstrom", ""));
    }
}
