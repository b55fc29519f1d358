//! Where the error was removed, the residuals, and the recordings' preprocessing.

use maud::{Markup, PreEscaped, html};

use diagnosis::Diagnosis;
use recording::display_unit::{difference, percent, significant, unit_for_people};

use super::chart::chart;
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
    let changes = diagnosis.changes();
    let pairs = || exhibits.whiteness_before.iter().zip(&exhibits.whiteness);
    let share = |values: &[f64], outside: f64| {
        if values.is_empty() { "–".to_owned() } else { format!("{} %", significant(100.0 * outside, 2)) }
    };
    let cells = |of: &Whiteness| {
        html! {
            td { (share(&of.auto, of.outside())) }
            td { (share(&of.cross, of.cross_outside())) }
        }
    };
    html! {
        section {
            h2 { "Is the residual white?" }
            p { "The residual of a good model is correlated neither with its own past nor with the input. Share of lags outside the 99 % band; a white residual has about 1 %." }
            table {
                tr { th { "signal" }
                    @if changes { th { "with itself, before" } th { "with the input, before" } th { "with itself, after" } th { "with the input, after" } }
                    @else { th { "with itself" } th { "with the input" } } }
                @for (before, after) in pairs() {
                    tr { td { (after.signal.name()) } @if changes { (cells(before)) } (cells(after)) }
                }
            }
            p { @match in_words(&exhibits.whiteness) {
                Some(told) => { "Not white: " (told) "." }
                None => "The residual is white: no lag is larger than chance allows (99 %).",
            } }
            details {
                summary { "Correlations" }
                div class="pair" { @for (before, after) in pairs() {
                    @let name = title(after.signal);
                    (chart(&correlation(&format!("{name}: with itself"), after.lag_s, 1, (changes.then_some(&before.auto), &after.auto), after.auto_band)))
                    @if !after.cross.is_empty() {
                        @let first = -i32::try_from(after.cross.len() / 2).unwrap_or(0);
                        (chart(&correlation(&format!("{name}: with the input, first from 0 on"), after.lag_s, first, (changes.then_some(&before.cross), &after.cross), after.cross_band)))
                    }
                } }
            }
        }
    }
}

/// Correlations over the lag, of the model before where it differs, and after.
fn correlation(name: &str, lag_s: f64, first: i32, (before, after): (Option<&Vec<f64>>, &[f64]), band: f64) -> Figure {
    let layer = |label: &str, style, values: &[f64]| {
        let points = (first..).zip(values).map(|(lag, value)| (1e3 * lag_s * f64::from(lag), *value)).collect();
        Layer { label: label.to_owned(), style, marks: Marks::Line(points) }
    };
    let mut layers: Vec<Layer> = before.into_iter().map(|values| layer("before", Style::Before, values)).collect();
    layers.push(if before.is_some() {
        layer("after", Style::After, after)
    } else {
        layer("refitted", Style::Before, after)
    });
    Figure {
        title: name.to_owned(),
        x: "lag [ms]".to_owned(),
        y: "correlation (shaded: 99 % band)".to_owned(),
        layers,
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
                    @for note in &of.notes { p { (of.recording) ": " (note) "." } }
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
