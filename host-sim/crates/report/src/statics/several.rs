//! Several sweeps of the same thing at different rates: as text, as JSON, and in one drawing.

use std::fmt::Write;

use identification::static_curve::{Cause, Comparison, Estimate, RateFrom, Shape, Statics};
use serde_json::{Value, json};

use super::{evidence, figures, marks, place, short, text_beside};
use crate::plot::{Series, curve};

/// The comparison, then the figures of the slowest sweep; `sweeps` in the order of the files.
#[must_use]
pub fn text_of_sweeps(sweeps: &[Statics], comparison: &Comparison) -> String {
    let slowest = slowest(sweeps, comparison);
    let mut text_of_all = String::new();
    for line in lines(sweeps, slowest, comparison) {
        // Writing into a text does not fail.
        let _ = writeln!(text_of_all, "{line}");
    }
    let _ = write!(text_of_all, "\nThe slowest sweep:\n\n{}", text_beside(slowest));
    text_of_all
}

/// The comparison, the slowest sweep under `statics`, and all of them under `sweeps` in the order of the files.
#[must_use]
pub fn document_of_sweeps(sweeps: &[Statics], comparison: &Comparison) -> Value {
    let slowest = slowest(sweeps, comparison);
    let mut compared = json!(comparison);
    let indications = comparison.indications();
    let named = indications.iter().map(|found| json!({ "effect": found.effect, "evidence": evidence(found) }));
    compared["indications"] = named.collect();
    compared["summary"] = json!(cause(slowest, comparison));
    json!({
        "schema": "host-sim/statics/1",
        "statics": figures(slowest),
        "sweeps": sweeps.iter().map(figures).collect::<Vec<_>>(),
        "comparison": compared,
    })
}

/// All sweeps over one axis, each with its input and output, the slowest one's marks.
#[must_use]
pub fn drawing_of_sweeps(sweeps: &[Statics], values: &[(&[f64], &[f64])], comparison: &Comparison) -> String {
    let label = |index: usize| {
        let recording = &sweeps[index].recording;
        let period = comparison.loops.iter().find(|one| one.sweep == index).map(|one| one.period);
        match (period, comparison.rate_from) {
            (None, _) => recording.clone(),
            (Some(period), _) => format!("{recording}, {}", time(period, comparison)),
        }
    };
    let series = values.iter().enumerate().map(|(index, &(x, y))| Series { label: label(index), x, y });
    let series: Vec<Series<'_>> = series.collect();
    let slowest = slowest(sweeps, comparison);
    let title = format!("{} sweeps", sweeps.len());
    curve(&title, &slowest.input.header, &slowest.output.header, &series, &marks(slowest))
}

/// The sweep of the lowest rate; the first one where no loop was read.
fn slowest<'a>(sweeps: &'a [Statics], comparison: &Comparison) -> &'a Statics {
    &sweeps[comparison.loops.first().map_or(0, |one| one.sweep)]
}

fn pair(found: Estimate) -> String {
    format!("{} ± {}", short(found.value), short(found.std))
}

fn unit_of_time(comparison: &Comparison) -> &'static str {
    if comparison.rate_from == RateFrom::Rows { "rows" } else { "s" }
}

fn time(period: f64, comparison: &Comparison) -> String {
    if comparison.rate_from == RateFrom::Rows { format!("{period:.0} rows") } else { format!("{} s", short(period)) }
}

fn lines(sweeps: &[Statics], slowest: &Statics, comparison: &Comparison) -> Vec<String> {
    let line = |name: &str, value: String| format!("{name:<18} {value}");
    let mut lines = Vec::new();
    for found in &comparison.loops {
        let wide = if found.narrow { "" } else { "; wider than the curve's flank" };
        let width = pair(Estimate { value: found.width, std: found.std_error });
        let time = time(found.period, comparison);
        lines.push(line("loop", format!("{width} wide at {time} up and down: {}{wide}", found.recording)));
    }
    lines.extend(comparison.without_loop.iter().map(|recording| line("loop", format!("not read: {recording}"))));
    lines.push(line("compared", cause(slowest, comparison)));
    let found = comparison.indications();
    lines.extend(found.iter().map(|found| line("found", format!("{}: {}", found.effect, evidence(found)))));
    if found.is_empty() && slowest.indications.is_empty() {
        lines.push(line("found", "no effect of the vocabulary".to_owned()));
    }
    let kind = |statics: &Statics| std::mem::discriminant::<Shape>(&statics.shape);
    if sweeps.iter().any(|statics| kind(statics) != kind(slowest)) {
        lines.push(line("note", "the sweeps do not all show a curve of the same kind".to_owned()));
    }
    lines.extend(notes(comparison).into_iter().map(|note| line("note", note)));
    lines
}

/// What the loops are due to, in one sentence.
fn cause(slowest: &Statics, comparison: &Comparison) -> String {
    let supposed = comparison.rate_from == RateFrom::Rows;
    let shrinks = matches!(comparison.cause, Cause::Lag | Cause::Both);
    if supposed && shrinks && !on_a_line(comparison) {
        return "the loops differ by more than their scatter, so hysteresis alone does not make them; the numbers of rows do not tell the rates: \
                give --period"
            .to_owned();
    }
    let known = cause_at_known_rates(slowest, comparison);
    if supposed { format!("if all sweeps were sampled alike: {known}") } else { known }
}

fn cause_at_known_rates(slowest: &Statics, comparison: &Comparison) -> String {
    let rough = if comparison.hysteresis.is_some() { "" } else { " (a rough figure)" };
    let lag =
        comparison.lag.map_or_else(String::new, |lag| format!(" of {} {}{rough}", pair(lag), unit_of_time(comparison)));
    let of_lag = "of valve or meter, which the loop does not tell apart";
    let stays = comparison.hysteresis.map_or_else(String::new, pair);
    let least = comparison.loops.first().map_or_else(String::new, |one| place(one.width, &slowest.input));
    let rest = if comparison.hysteresis.is_some() {
        format!("what would stay at rate zero, {stays}, is not surely above zero")
    } else {
        format!(
            "whether a part stays is not known, since fewer than three loops are narrower than the curve's flank: hysteresis is no more than the \
             slowest sweep's {least}"
        )
    };
    match comparison.cause {
        Cause::Lag => format!("the loop shrinks with the rate: a lag{lag} {of_lag}; {rest}"),
        Cause::Hysteresis => {
            format!("the loop does not surely change with the rate, and {stays} stay at rate zero: hysteresis")
        }
        Cause::Both => {
            format!(
                "a part of the loop shrinks with the rate: a lag{lag} {of_lag}; {stays} stay at rate zero: hysteresis"
            )
        }
        Cause::NoLoop => "no sweep has a loop wider than its scatter".to_owned(),
        Cause::Undecided if comparison.loops.len() < 2 => {
            "fewer than two sweeps have a loop: hysteresis and lag are not told apart".to_owned()
        }
        Cause::Undecided => {
            "the loops do not tell hysteresis from a lag: their rates or widths differ too little".to_owned()
        }
    }
}

/// Whether the widths lie on a line over the rate, within three standard errors.
fn on_a_line(comparison: &Comparison) -> bool {
    comparison.misfit.is_none_or(|misfit| misfit < 9.0)
}

fn notes(comparison: &Comparison) -> Vec<String> {
    let mut notes = Vec::new();
    if comparison.rate_from == RateFrom::Rows {
        notes.push(
            "no clock and no --period: the number of rows of a sweep stands for its period, as if all had been sampled alike; no effect is named from that. If the \
             periods are known, give --period"
                .to_owned(),
        );
    }
    if let Some(misfit) = comparison.misfit.filter(|_| !on_a_line(comparison)) {
        let off = short(misfit.sqrt());
        notes.push(format!(
            "the loops lie {off} standard errors off a line over the rate: lag and hysteresis are less certain by that"
        ));
    }
    notes
}
