//! The tables of the terminal text.

use comfy_table::{CellAlignment, ContentArrangement, Table};

use diagnosis::agreement::Tolerated;
use diagnosis::{Diagnosis, Fits, Shown, mean_fits, mean_noise_floor};
use identification::fit::Estimate;
use model_core::machine::Machine;
use recording::display_unit::{TABLE, in_si, percent, significant};

use crate::evidence::Exhibits;
use crate::size::size;
use crate::wording::{self, WITHIN};

/// A standard deviation, or why there is none.
#[must_use]
pub fn uncertainty(estimate: &Estimate) -> String {
    if estimate.at_bound {
        "at its bound".to_owned()
    } else if estimate.std.is_finite() {
        in_si(estimate.std, 2)
    } else {
        "not determined".to_owned()
    }
}

fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(TABLE).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header.iter().copied());
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

pub(super) fn fits(diagnosis: &Diagnosis) -> Table {
    let mut table = table(&["NRMSE fit, % (free run)", "before", "after", "noise floor"]);
    for (held_out, label) in [(false, "training"), (true, "held out")] {
        let (before, after) = (diagnosis.mean_fits(held_out, false), diagnosis.mean_fits(held_out, true));
        let floor = diagnosis.noise_floor(held_out);
        for (signal, fit) in &before {
            let of = |fits: &diagnosis::Fits| fits.get(signal).map_or_else(String::new, |fit| format!("{fit:.2}"));
            table.add_row([format!("{label} · {signal}"), format!("{fit:.2}"), of(&after), of(&floor)]);
        }
    }
    table
}

/// A line for each step: what it leaves of the error and which share of the misfit above noise it removed; at the end, what is left.
pub(super) fn waterfall(exhibits: &Exhibits) -> Table {
    let stages = &exhibits.waterfall.stages;
    let which = if exhibits.waterfall.held_out { "held out" } else { "training" };
    let signals: Vec<&str> =
        stages.iter().take(1).flat_map(|stage| &stage.signals).map(|(signal, _)| signal.name()).collect();
    let first = format!("square error over noise², {which}");
    let header: Vec<&str> = std::iter::once(first.as_str()).chain(signals).chain(["all", "share taken"]).collect();
    let mut table = table(&header);
    let shares = exhibits.waterfall.shares();
    for (index, stage) in stages.iter().enumerate() {
        let left = stage.signals.iter().map(|(_, left)| *left).chain([stage.total]).map(|left| significant(left, 3));
        let share = match &shares {
            // The machine file removes nothing: the misfit above noise starts there. The last stage, the noise, stands for what was left.
            Some(shares) if exhibits.waterfall.is_chance(shares[index]) => String::new(),
            Some(shares) if index + 1 == stages.len() => format!("{} left", share_taken(shares[index])),
            Some(shares) if index > 0 => share_taken(shares[index]),
            _ => String::new(),
        };
        table.add_row(std::iter::once(stage.label.clone()).chain(left).chain([share]).collect::<Vec<_>>());
    }
    let white = exhibits.whiteness.iter().map(|of| format!("{} %", significant(100.0 * of.outside(), 2)));
    table.add_row(
        std::iter::once("residual autocorrelations outside the 99 % band".to_owned()).chain(white).collect::<Vec<_>>(),
    );
    table
}

/// A share of the machine file's misfit above noise; the share is negative for a step that makes it worse.
fn share_taken(share: f64) -> String {
    format!("{}{:.1} %", if share < -5e-4 { "−" } else { "" }, (100.0 * share).abs())
}

/// Fitted parameters with their uncertainty.
#[must_use]
pub fn parameters(estimates: &[Estimate]) -> Table {
    let mut table = table(&["refitted parameter", "nominal", "fitted", "±", "unit"]);
    for estimate in estimates {
        let description = estimate.parameter.description();
        table.add_row([
            description.key.to_owned(),
            in_si(estimate.before, 5),
            in_si(estimate.value, 5),
            uncertainty(estimate),
            description.unit.to_owned(),
        ]);
    }
    table
}

/// The mean fit of each signal on held-out recordings, with the values before and after; `None` where none was held out.
#[must_use]
pub fn held_out_fits(shown: &[Shown]) -> Option<Table> {
    let (before, after) = (mean_fits(shown, true, false), mean_fits(shown, true, true));
    let floor = mean_noise_floor(shown, true);
    let mut table = table(&["held out, NRMSE fit %", "nominal", "fitted", "noise floor"]);
    let cell = |fits: &Fits, signal: &str| fits.get(signal).map_or_else(String::new, |fit| percent(*fit));
    for signal in before.keys() {
        table.add_row([(*signal).to_owned(), cell(&before, signal), cell(&after, signal), cell(&floor, signal)]);
    }
    (!before.is_empty()).then_some(table)
}

/// What a fit used of tolerances, in the units of the hall; `None` where there are none.
#[must_use]
pub fn tolerances(machine: &Machine<f64>, tolerated: &[Tolerated]) -> Option<String> {
    let mut table = table(&["tolerance", "limit", "used", "value"]);
    if let Some(column) = table.column_mut(3) {
        column.set_cell_alignment(CellAlignment::Left);
    }
    for one in tolerated {
        let (Some(value), Some(limit)) =
            (size(machine, one.parameter, one.value), size(machine, one.parameter, one.most))
        else {
            continue;
        };
        let used = format!("{} %", significant(100.0 * (one.value / one.most).abs(), 2));
        let thing = wording::tolerated_thing(one.parameter).to_owned();
        let sign = if one.parameter.description().min < 0.0 { "±" } else { "" };
        table.add_row([thing, format!("{sign}{}", limit.amount), used, value.within_tolerance()]);
    }
    (!tolerated.is_empty()).then(|| format!("{WITHIN}:\n{table}"))
}

pub(super) fn trials(diagnosis: &Diagnosis) -> Table {
    let mut table = table(&["refitted with", "log-likelihood gain, penalty subtracted"]);
    for trial in diagnosis.selection.rounds.iter().flatten() {
        let names: Vec<_> = trial.effects.iter().map(|effect| effect.name).collect();
        table.add_row([names.join(" + "), format!("{:.1}", trial.net)]);
    }
    table
}
