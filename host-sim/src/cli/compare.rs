//! `host-sim compare`: the fit of every measured signal, end to end and link by link.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use comfy_table::{Attribute, Cell, CellAlignment, Table};
use identification::parallel;

use diagnosis::base_parameters;
use identification::compare::open_loop::put_sways;
use identification::compare::weakest::{Weakest, missed_by_the_whole, obstacles, unjudged, weakest};
use identification::compare::{Comparison, Section, compare_with_progress, judged, rows_simulated};
use machine_file::{LoadSource, MachineFile};
use model_core::machine::Tick;
use recording::display_unit::{TABLE, arrange, difference, percent};
use recording::files::source_error::printable;
use recording::{Recording, Signal};
use report::plot;
use report::wording::{range_end, unsettled};
use simulation::Arithmetic;

use super::Outcome;
use super::console::{Console, Tone};
use super::ending::{DOCUMENT, DRAWING, check_ending};
use super::error::CliError;
use super::input::{self, MachineArguments};
use super::target::{check_targets, write, write_document};

/// Arguments of `compare`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim compare --machine M.toml --recording train-1.csv train-2.csv
  host-sim compare --machine M.toml --recording run.csv --map \"position=Kolbenweg [mm]\" --plot run.svg
  host-sim compare --machine M.toml --recording run.csv --exit-code --tolerance 97

NRMSE fit is 100·(1 − ‖y − ŷ‖/‖y − mean y‖) %: 100 is perfect, 0 no better than the mean. A section is simulated from its own
measured input, so that a miss in it is made in it.")]
pub struct Arguments {
    #[command(flatten)]
    machine: MachineArguments,
    /// Recordings to compare with (CSV, TwinCAT Scope text, .xlsx, .mat, .mf4, .parquet, each also .gz)
    #[arg(long, value_name = "R.csv", required = true, num_args = 1..)]
    recording: Vec<PathBuf>,
    /// Judge by these signals only, as though the model's others had not been measured: `spool,pressure_a`
    #[arg(long, value_name = "signal,…", value_delimiter = ',', value_parser = judged::named)]
    judge: Vec<Signal>,
    /// Draw recorded against simulated, with the residual below; for several recordings a file each, named after it
    #[arg(long, value_name = "P.svg")]
    plot: Option<PathBuf>,
    /// Write every fit for programs; `-` prints it in place of the text
    #[arg(long, value_name = "C.json")]
    json: Option<PathBuf>,
    /// Answer 1 when a signal's fit end to end is below the tolerance
    #[arg(long)]
    exit_code: bool,
    /// Lowest NRMSE fit that is in tolerance, %
    #[arg(long, value_name = "percent", default_value_t = 95.0, requires = "exit_code")]
    tolerance: f64,
}

/// What is compared, checked.
struct Job {
    file: MachineFile,
    recordings: Vec<Recording>,
    tick: Option<Tick>,
    arithmetic: Arithmetic,
    /// A path for each recording; empty without `--plot`.
    plots: Vec<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let job = job(arguments, console)?;
    let comparisons = compared(&job, &arguments.machine.machine, console)?;
    if let Some(path) = &arguments.json {
        write_document(path, &format!("{:#}\n", report::json::comparison(&job.file, &comparisons)), console)?;
    }
    for (path, svg) in job.plots.iter().zip(drawings(&job, &comparisons)) {
        write(path, svg)?;
    }
    let quiet = console.is_quiet();
    for note in
        job.recordings.iter().filter(|_| !quiet).flat_map(|recording| input::notes(recording, &job.file.machine))
    {
        console.print(format_args!("note: {note}"))?;
    }
    // They are compared as they are all the same.
    let doubts =
        if quiet { Vec::new() } else { input::doubts(&arguments.machine.machine, &job.file, &job.recordings, true)? };
    for doubt in doubts.iter().filter(|doubt| doubt.is_certain) {
        console.print(format_args!(
            "note: {}; mend this first: what follows is of the recordings as they are",
            report::wording::doubt(doubt)
        ))?;
    }
    for found in comparisons.iter().filter(|_| !quiet) {
        for note in not_judged(found) {
            console.print(format_args!("note: {}: {note}", found.recording))?;
        }
    }
    console.print_styled(table(&comparisons, console.terminal, console.width))?;
    for line in sentences(&comparisons, job.file.load_source) {
        console.print(line)?;
    }
    for path in &job.plots {
        console.print(format_args!("plot: {}", path.display()))?;
    }
    if !arguments.exit_code {
        return Ok(Outcome::Done);
    }
    let below: Vec<String> = below(&comparisons, arguments.tolerance).collect();
    let tone = if below.is_empty() { Tone::Good } else { Tone::Bad };
    console.verdict(verdict(&below, arguments.tolerance), tone)?;
    Ok(if below.is_empty() { Outcome::Done } else { Outcome::OutOfTolerance })
}

fn job(arguments: &Arguments, console: &Console<'_>) -> Result<Job, CliError> {
    if !(f64::NEG_INFINITY..=100.0).contains(&arguments.tolerance) {
        let (argument, expected) = ("--tolerance", "at most 100 %");
        return Err(CliError::Number { argument, found: arguments.tolerance, expected });
    }
    let (file, channels) = arguments.machine.read()?;
    let recordings = input::recordings(&arguments.recording, &channels, console)?
        .into_iter()
        .map(|recording| input::judged(recording, &file, &arguments.judge))
        .collect::<Result<Vec<_>, _>>()?;
    let plots = arguments.plot.as_ref().map_or_else(Vec::new, |path| plot_paths(path, &recordings));
    let read = [arguments.recording.as_slice(), std::slice::from_ref(&arguments.machine.machine)].concat();
    let document = ("--json", arguments.json.as_deref(), DOCUMENT);
    let drawings = plots.iter().map(|path| ("--plot", Some(path.as_path()), DRAWING));
    check_targets(&drawings.chain([document]).collect::<Vec<_>>(), &read)?;
    arguments.plot.as_deref().map_or(Ok(()), |path| check_ending("--plot", path, DRAWING))?;
    Ok(Job { file, recordings, tick: arguments.machine.tick(), arithmetic: arguments.machine.arithmetic.into(), plots })
}

/// Which rows of a recording are not judged, and why.
fn not_judged(found: &Comparison) -> Vec<String> {
    let start = (found.unsettled_s > 0.0).then(|| unsettled(found.unsettled_s));
    let ends = found.ends.iter().map(|(signal, end)| {
        let share = end.count() as f64 / end.rows.len() as f64;
        format!("{}; these are not judged", range_end(*signal, end.reading, share))
    });
    start.into_iter().chain(ends).collect()
}

/// `out.svg` for one recording; `out-train-1.svg` … for several, numbered when their names repeat.
fn plot_paths(path: &Path, recordings: &[Recording]) -> Vec<PathBuf> {
    if recordings.len() == 1 {
        return vec![path.to_owned()];
    }
    let text =
        |part: Option<&std::ffi::OsStr>| part.map_or_else(String::new, |part| part.to_string_lossy().into_owned());
    let names: Vec<String> = recordings.iter().map(|recording| text(Path::new(recording.name()).file_stem())).collect();
    let distinct = names.iter().collect::<BTreeSet<_>>().len() == names.len();
    let extension = path.extension().map_or_else(String::new, |extension| format!(".{}", extension.to_string_lossy()));
    let named = |(index, name): (usize, &String)| {
        let number = if distinct { String::new() } else { format!("{}-", index + 1) };
        path.with_file_name(format!("{}-{number}{name}{extension}", text(path.file_stem())))
    };
    names.iter().enumerate().map(named).collect()
}

fn compared(job: &Job, machine: &Path, console: &Console<'_>) -> Result<Vec<Comparison>, CliError> {
    let rows = |recording| rows_simulated(job.file.machine.source, job.file.load_source, recording) as u64;
    let bar = console.share(job.recordings.iter().map(rows).sum(), "comparing");
    let free = base_parameters(&job.file);
    let comparisons = parallel::try_each(&job.recordings, |recording| {
        let MachineFile { machine: values, load_source, .. } = &job.file;
        let told = |rows| bar.inc(rows as u64);
        let failed = |cause| CliError::Compare { machine: machine.to_owned(), cause };
        let mut found =
            compare_with_progress(values, *load_source, recording, job.arithmetic, job.tick, &told).map_err(failed)?;
        put_sways(&mut found, values, *load_source, recording, job.tick, &free).map_err(failed)?;
        Ok(found)
    });
    bar.finish_and_clear();
    comparisons
}

fn drawings<'a>(job: &'a Job, comparisons: &'a [Comparison]) -> impl Iterator<Item = String> + 'a {
    job.recordings.iter().zip(comparisons).map(|(recording, comparison)| {
        let panels = comparison.sections.first().map_or_else(Vec::new, |whole| {
            let judged: Vec<Signal> = whole.fits.iter().map(|fit| fit.signal).collect();
            plot::panels(recording, whole.input_point, &whole.trajectory, &judged)
        });
        plot::svg(recording.name(), &format!("recorded against {}, simulated end to end", job.file.name), &panels)
    })
}

/// One row for each recording, section and signal; the weakest part of each recording in bold on a terminal.
fn table(comparisons: &[Comparison], terminal: bool, width: Option<u16>) -> Table {
    const NUMBERS: std::ops::RangeInclusive<usize> = 3..=7;
    let mut table = Table::new();
    table.load_style(TABLE);
    arrange(&mut table, width);
    if terminal {
        table.enforce_styling();
    }
    table.set_header(["recording", "section", "signal", "NRMSE fit %", "R²", "RMSE", "max error", "at s"]);
    for comparison in comparisons {
        let worst = weakest(std::slice::from_ref(comparison));
        for (index, section) in comparison.sections.iter().enumerate() {
            for (row, fit) in section.fits.iter().enumerate() {
                let recording = if index + row == 0 { printable(&comparison.recording) } else { String::new() };
                let name = if row == 0 { section.section.to_string() } else { String::new() };
                let bold = worst.is_some_and(|w| (w.section, w.signal) == (section.section, fit.signal));
                let cells = [
                    recording,
                    name,
                    fit.signal.to_string(),
                    percent(fit.nrmse_percent),
                    format!("{:.6}", fit.r_squared),
                    difference(fit.signal, fit.rmse),
                    difference(fit.signal, fit.max_error),
                    format!("{:.3}", fit.max_at_s),
                ];
                table.add_row(cells.map(|text| {
                    let cell = Cell::new(text);
                    if bold { cell.add_attribute(Attribute::Bold) } else { cell }
                }));
            }
        }
    }
    for (_, column) in table.column_iter_mut().enumerate().filter(|(index, _)| NUMBERS.contains(index)) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// Which part is weakest, in each recording and over all, what that means, and what prevents parts from being distinguished.
fn sentences(comparisons: &[Comparison], load: LoadSource) -> Vec<String> {
    let mut lines: Vec<String> = comparisons
        .iter()
        .filter_map(|comparison| {
            let found = weakest(std::slice::from_ref(comparison))?;
            Some(format!("{}: weakest is {}", comparison.recording, described(found)))
        })
        .collect();
    if let Some(found) = weakest(comparisons) {
        if comparisons.len() > 1 {
            lines.push(format!("over all {}: weakest is {} on average", comparisons.len(), described(found)));
        }
        lines.push(meaning(found, missed_by_the_whole(comparisons)));
    }
    lines.extend(unjudged(comparisons).iter().map(|part| format!("{}.", report::wording::unjudged(part))));
    let missing: BTreeSet<&str> =
        comparisons.iter().flat_map(|comparison| obstacles(comparison, load)).map(report::wording::obstacle).collect();
    lines.extend(missing.into_iter().map(|missing| format!("But {missing}.")));
    lines
}

fn described(found: Weakest) -> String {
    format!("{}, {} at {} %", found.section, found.signal, percent(found.nrmse_percent))
}

fn meaning(found: Weakest, whole: Option<(Signal, f64)>) -> String {
    if found.follows()
        && let Some((signal, fit)) = whole
    {
        return format!(
            "What could be judged by itself follows its recordings within about their noise. But end to end {signal} is at {} %:\n\
             physics is missing in a part that could not be judged by itself, or a parameter of it is off.",
            percent(fit)
        );
    }
    if found.follows() {
        return "Every part follows its recordings to about their noise; there is no sign of missing physics."
            .to_owned();
    }
    if !found.is_judged && found.section != Section::EndToEnd {
        return match whole {
            Some((signal, fit)) => format!(
                "No part that can be judged by itself misses its recordings. But end to end {signal} is at {} %, more than small errors of\n\
                 sensors and parameters make: `host-sim diagnose` refits and looks closer.",
                percent(fit)
            ),
            None => "Nothing is missed by more than small errors of sensors and parameters make; `host-sim diagnose` refits and looks closer."
                .to_owned(),
        };
    }
    let signal = found.signal;
    let told = match found.section {
        Section::EndToEnd => {
            return "This is the whole chain: whatever it misses may be missed anywhere in it.".to_owned();
        }
        Section::Valve => format!("Driven by the recorded command, the valve alone misses the recorded {signal}"),
        Section::BelowSpool => {
            format!("Driven by the recorded spool, flow, chambers and mechanics together miss the recorded {signal}")
        }
        Section::BelowFlow => format!("Driven by the recorded flow, chambers and mechanics together miss the {signal}"),
        Section::FlowAndChambers => format!(
            "At the recorded pressures, the flow minus the compression of the oil does not give the recorded {signal} (orifices,\n\
             pump, leakage or compressibility)"
        ),
        Section::Mechanics => {
            format!("Driven by the recorded pressures, mass, friction and load alone miss the recorded {signal}")
        }
    };
    match (found.rival(), found.runner_up) {
        (Some((rival, fit)), _) => format!(
            "{told}.\nBut {rival} misses nearly as much ({} %): which of the two lacks physics, or has a parameter off, is not \
             settled by these figures.",
            percent(fit)
        ),
        (None, Some(_)) => {
            format!(
                "{told}; the other parts fit better.\n\
                 This part does not follow: an effect is missing in it, or a parameter is further off than its standard deviation."
            )
        }
        (None, None) => format!("{told}.\nIt is the only part that could be judged by itself."),
    }
}

fn below(comparisons: &[Comparison], tolerance: f64) -> impl Iterator<Item = String> + '_ {
    comparisons.iter().flat_map(move |comparison| {
        let fits = comparison.sections.first().into_iter().flat_map(|whole| &whole.fits);
        fits.filter(move |fit| !(tolerance..).contains(&fit.nrmse_percent))
            .map(|fit| format!("{} {} ({} %)", comparison.recording, fit.signal, percent(fit.nrmse_percent)))
    })
}

fn verdict(below: &[String], tolerance: f64) -> String {
    if below.is_empty() {
        format!("in tolerance: every signal fits end to end with at least {tolerance} %")
    } else {
        format!("out of tolerance: below {tolerance} % end to end: {}", below.join(", "))
    }
}
