//! Where the error was removed, the residuals, and the recordings' preprocessing.

use maud::{Markup, PreEscaped, html};

use diagnosis::Diagnosis;
use recording::display_unit::{difference, percent, significant, unit_for_people};

use super::chart::chart;
use super::document::prose;
use crate::evidence::Exhibits;
use crate::evidence::preprocessing::Preprocessing;
use crate::evidence::waterfall::Waterfall;
use crate::evidence::whiteness::{Whiteness, in_words};
use crate::plot::{Bar, BarGroup, Figure, Layer, Marks, Style, bars, title};

pub(crate) fn waterfall(waterfall: &Waterfall) -> Markup {
    let which = if waterfall.held_out { "held-out" } else { "training" };
    html! {
        section {
            h2 { "Where the error went" }
            figure class="bars" { (PreEscaped(bars(
                &format!("Error left after each step, {which} recordings"),
                "mean square error over the noise's variance, 1 is the noise itself",
                &groups(waterfall),
            ))) }
            @if let Some(shares) = waterfall.shares() {
                p { "Of what the machine file leaves above the noise, in all signals together: "
                    @for (index, (stage, share)) in waterfall.stages.iter().zip(&shares).enumerate().skip(1) {
                        @if index > 1 { "; " }
                        @if index + 1 == waterfall.stages.len() { (significant(100.0 * share.max(0.0), 2)) " % is left" } @else { (stage.label) " " (significant(100.0 * share, 3)) " %" }
                    }
                    "."
                }
            }
        }
    }
}

/// One group of bars for each signal.
fn groups(waterfall: &Waterfall) -> Vec<BarGroup> {
    let signals = waterfall.stages.first().map_or(&[][..], |stage| &stage.signals);
    let last = waterfall.stages.len().saturating_sub(1);
    signals
        .iter()
        .enumerate()
        .map(|(index, (signal, _))| BarGroup {
            title: title(*signal).to_owned(),
            bars: waterfall
                .stages
                .iter()
                .enumerate()
                .take(last)
                .filter_map(|(number, stage)| {
                    let style = if stage.effect.is_some() {
                        Style::After
                    } else if number == 0 {
                        Style::Recorded
                    } else {
                        Style::Before
                    };
                    Some(Bar { label: stage.label.clone(), value: stage.signals.get(index)?.1, style })
                })
                .collect(),
        })
        .collect()
}

pub(crate) fn whiteness(exhibits: &Exhibits, diagnosis: &Diagnosis) -> Markup {
    let before = diagnosis.changes().then_some(exhibits.whiteness_before.as_slice());
    white(before, &exhibits.whiteness)
}

/// Whether residuals are white: of the model before, where it differs, and after.
pub(crate) fn white(before: Option<&[Whiteness]>, after: &[Whiteness]) -> Markup {
    let pairs = || after.iter().enumerate().map(|(index, after)| (before.and_then(|all| all.get(index)), after));
    html! {
        section {
            h2 { "Is the residual white?" }
            p { "The residual of a good model is correlated neither with its own past nor with the input. Share of lags outside the 99 % band; a white residual has about 1 %." }
            table {
                tr { th { "signal" }
                    @if before.is_some() { th { "with itself, before" } th { "with the input, before" } th { "with itself, after" } th { "with the input, after" } }
                    @else { th { "with itself" } th { "with the input" } } }
                @for (before, after) in pairs() {
                    tr { td { (after.signal.name()) } @if let Some(before) = before { (shares(before)) } (shares(after)) }
                }
            }
            p { @match in_words(after) {
                Some(told) => { "Not white: " (told) "." }
                None => "The residual is white: no lag is larger than chance allows (99 %).",
            } }
            details {
                summary { "Correlations" }
                div class="pair" { @for (before, after) in pairs() {
                    @let of = |values: Which| match before {
                        Some(before) => vec![("before", Style::Before, values(before)), ("after", Style::After, values(after))],
                        None => vec![("refitted", Style::Before, values(after))],
                    };
                    (of_signal(after, &of))
                } }
            }
        }
    }
}

/// The shares of lags outside the band, as two cells.
pub(crate) fn shares(of: &Whiteness) -> Markup {
    let share = |values: &[f64], outside: f64| {
        if values.is_empty() { "–".to_owned() } else { format!("{} %", significant(100.0 * outside, 2)) }
    };
    html! {
        td { (share(&of.auto, of.outside())) }
        td { (share(&of.cross, of.cross_outside())) }
    }
}

/// Name, style and correlations of a model.
type Named<'a> = (&'a str, Style, &'a Vec<f64>);

/// Which of the two: with itself, or with the input.
type Which = fn(&Whiteness) -> &Vec<f64>;

/// The correlations of a signal's residual with itself and with the input, each of all models.
pub(crate) fn of_signal<'a>(signal: &'a Whiteness, models: &dyn Fn(Which) -> Vec<Named<'a>>) -> Markup {
    let name = title(signal.signal);
    let first = -i32::try_from(signal.cross.len() / 2).unwrap_or(0);
    html! {
        (chart(&correlation(&format!("{name}: with itself"), signal.lag_s, 1, &models(|of| &of.auto), signal.auto_band)))
        @if !signal.cross.is_empty() {
            (chart(&correlation(&format!("{name}: with the input, first from 0 on"), signal.lag_s, first, &models(|of| &of.cross), signal.cross_band)))
        }
    }
}

/// Correlations over the lag, of every model.
fn correlation(name: &str, lag_s: f64, first: i32, models: &[Named<'_>], band: f64) -> Figure {
    let layers = models.iter().map(|(label, style, values)| {
        let points = (first..).zip(*values).map(|(lag, value)| (1e3 * lag_s * f64::from(lag), *value)).collect();
        Layer { label: (*label).to_owned(), style: *style, marks: Marks::Line(points) }
    });
    Figure {
        title: name.to_owned(),
        x: "lag [ms]".to_owned(),
        y: "correlation (shaded: 99 % band)".to_owned(),
        layers: layers.collect(),
        band: Some(band),
    }
}

pub(crate) fn prepared(found: &[Preprocessing]) -> Markup {
    html! {
        section {
            h2 { "Preprocessing" }
            details {
                summary { "Noise, sensor steps, failed rows, dither, clock and start of every recording" }
                table {
                    tr { th { "recording" } th { "signal" } th { "noise" } th { "sensor step" } th { "spikes" } th { "starts at" } th { "perfect fit" } }
                    @for of in found {
                        @for (index, channel) in of.channels.iter().enumerate() {
                            @let unit = unit_for_people(channel.signal);
                            tr {
                                td { @if index == 0 { (of.recording) } }
                                td { (channel.signal.name()) }
                                td { (difference(channel.signal, channel.noise)) }
                                td { @match channel.step { Some(step) => (difference(channel.signal, step)), None => "–" } }
                                td { (channel.spikes) }
                                td { (significant(unit.from_si(channel.start), 4)) " " (unit) }
                                td { (percent(channel.ceiling_percent)) " %" }
                            }
                        }
                    }
                }
                @for of in found {
                    @if let Some(line) = of.dither { p { (of.recording) ": dither of " (significant(line.amplitude, 2)) " V at " (significant(line.hz, 3)) " Hz in the command." } }
                    @for (failure, fate) in of.failures() { p { (of.recording) ": " (failure) "; " (fate) "." } }
                    @for said in of.of_start_and_clock() { p { (of.recording) ": " (said) "." } }
                    @for note in &of.notes { p { (of.recording) ": " (prose(note)) "." } }
                }
            }
            @let failed: usize = found.iter().flat_map(|of| &of.channels).map(|channel| channel.spikes).sum();
            @let longer = found.iter().map(|of| of.failures().count()).sum::<usize>();
            @let rows: usize = found.iter().map(|of| of.rows).sum();
            p class="soft" { (found.len()) " recordings, " (rows) " rows; " (failed) " readings failed for a moment and are not judged"
                @if longer > 0 { "; a sensor failed for longer " (longer) " times" }
                @if found.iter().any(|of| of.dither.is_some()) { "; dither in the command" } "." }
        }
    }
}
