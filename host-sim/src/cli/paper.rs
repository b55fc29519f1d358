//! `host-sim paper`: the paper's tables, from the virtual test bed.

use std::path::PathBuf;

use comfy_table::{CellAlignment, Table};

use recording::display_unit::TABLE;
use serde_json::{Value, json};
use simulation::figures_of_merit::SignalFit;

use super::Outcome;
use super::console::Console;
use super::ending::DOCUMENT;
use super::error::CliError;
use super::input::ArithmeticArgument;
use super::target::{check_targets, tell};
use crate::paper::{
    CHARACTERISTIC, COMMANDS_V, DEVIATIONS, DITHER, Experiment, FRICTION_N, LEAKAGE_M3_PER_S_PA, SETTLED_S,
    TABLE_2_PERCENT, experiment,
};

/// Arguments of `paper`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  host-sim paper

The model is presets/paper-as-printed.toml.")]
pub struct Arguments {
    /// Number type of the simulation; fixed is what the controller computes
    #[arg(long, value_enum, default_value_t)]
    arithmetic: ArithmeticArgument,
    /// Write the figures of both tables for programs; `-` prints it in place of the text
    #[arg(long, value_name = "P.json")]
    json: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    check_targets(&[("--json", arguments.json.as_deref(), DOCUMENT)], &[])?;
    let bar = console.progress(COMMANDS_V.len(), "running the steps");
    let found = experiment(arguments.arithmetic.into(), || bar.inc(1))?;
    bar.finish_and_clear();
    tell(arguments.json.as_deref(), || document_of(&found), console)?;
    console.print(introduction())?;
    console.print("\nTable 1. Similarity of the spool for step responses: from the command, by static characteristic, rate limit and (16)")?;
    console.print(table_1(&found))?;
    console.print(
        "The paper's Table 1 is lost from its text, which says of it: worst at 2 and 4 V; at 6, 8 and 10 V \"97%\".",
    )?;
    console.print("\nTable 2. Similarity of the position for step responses: from the command (Fig. 6b), and from the measured spool (Fig. 3)")?;
    console.print(table_2(&found))?;
    console.print(characteristic(&found))?;
    Ok(Outcome::Done)
}

/// The figures of both tables, for programs.
fn document_of(found: &Experiment) -> Value {
    let fit = |of: &SignalFit| json!({ "nrmse_percent": of.nrmse_percent, "rmse": of.rmse, "max_error": of.max_error });
    let steps = found.steps.iter().zip(TABLE_2_PERCENT).map(|(step, paper)| {
        json!({
            "command_v": step.command_v,
            "spool": fit(&step.spool),
            "position": fit(&step.position),
            "position_from_spool": fit(&step.position_from_spool),
            "position_of_the_paper_percent": paper,
        })
    });
    json!({
        "schema": "host-sim/paper/1",
        "steps": steps.collect::<Vec<_>>(),
        "characteristic": { "slope_per_v": found.slope_per_v, "offset": found.offset },
        "characteristic_of_the_paper": { "slope_per_v": CHARACTERISTIC.0, "offset": CHARACTERISTIC.1 },
    })
}

fn introduction() -> String {
    let deviations: Vec<String> = DEVIATIONS
        .iter()
        .map(|(parameter, factor)| format!("{} {:+.1} %", parameter.description().key, 100.0 * (factor - 1.0)))
        .collect();
    format!(
        "The paper's recordings were not published: these are synthetic, made on a virtual test bed.\n\
         Its drive is the preset paper-as-printed with\n{},\n\
         {FRICTION_N} N of dry friction and {LEAKAGE_M3_PER_S_PA:e} m3/s/Pa of leakage past the piston, which the model does not have;\n\
         16-bit LVDT with noise, joint encoder of 3600 impulses, dither of {} V at {} Hz.\n\
         These differences were chosen, so how near the figures come to the paper's was chosen too: they show the procedure and\n\
         the order of size, and are no check of the model against the paper's drive.\n\
         Similarity is the NRMSE fit, 100·(1 − ‖y − ŷ‖/‖y − mean y‖) %; the paper does not define its own.",
        deviations.chunks(3).map(|three| three.join(", ")).collect::<Vec<_>>().join(",\n"),
        DITHER.amplitude_v,
        DITHER.frequency_hz
    )
}

fn table(header: &[&str], rows: Vec<Vec<String>>) -> Table {
    let mut table = Table::new();
    table.load_style(TABLE).force_no_tty().set_header(header).add_rows(rows);
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn table_1(found: &Experiment) -> Table {
    let rows = found.steps.iter().map(|step| {
        let fit = step.spool;
        let paper = if step.command_v < 5.0 { "lost" } else { "lost (97)" };
        vec![
            format!("{}", step.command_v),
            format!("{:.2}", fit.nrmse_percent),
            paper.to_owned(),
            format!("{:.3}", 100.0 * fit.rmse),
            format!("{:.3}", 100.0 * fit.max_error),
        ]
    });
    table(
        &["input [V]", "similarity [%]", "paper [%]", "RMSE [% of travel]", "max error [% of travel]"],
        rows.collect(),
    )
}

fn table_2(found: &Experiment) -> Table {
    let rows = found.steps.iter().zip(TABLE_2_PERCENT).map(|(step, paper)| {
        vec![
            format!("{}", step.command_v),
            format!("{:.2}", step.position.nrmse_percent),
            format!("{paper:.2}"),
            format!("{:.3}", 1e3 * step.position.rmse),
            format!("{:.2}", step.position_from_spool.nrmse_percent),
            format!("{:.3}", 1e3 * step.position_from_spool.rmse),
        ]
    });
    let header =
        ["input [V]", "from command [%]", "paper [%]", "RMSE [mm]", "from measured spool [%]", "RMSE from spool [mm]"];
    table(&header, rows.collect())
}

fn characteristic(found: &Experiment) -> String {
    format!(
        "\nStatic characteristic by linear regression on the spool later than {SETTLED_S} s after the step\n\
         \x20 here          y = {:.4} U + {:.4}\n\
         \x20 paper's (15)  y = {:.4} U + {:.4}",
        found.slope_per_v, found.offset, CHARACTERISTIC.0, CHARACTERISTIC.1
    )
}
