//! `host-sim compare`: the fit of every measured signal, end to end and link by link, of one drive or of several.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use comfy_table::{Attribute, Cell, CellAlignment, Table};

use diagnosis::agreement::Doubt;
use diagnosis::base_parameters;
use identification::compare::open_loop::compare_each;
use identification::compare::weakest::weakest;
use identification::compare::{Comparison, judged, mean_fits, rows_simulated};
use machine_file::MachineFile;
use recording::display_unit::{TABLE, arrange, difference, percent};
use recording::files::source_error::printable;
use recording::{Recording, Signal};
use report::html::{self, Compared};
use report::plot;
use report::wording::{mend_first, range_end, sentences, unsettled};
use simulation::Trajectory;

use super::Outcome;
use super::about::about;
use super::console::{Console, Tone};
use super::ending::{DOCUMENT, DRAWING, PAGE, check_ending};
use super::error::CliError;
use super::input::{self, ModelArguments};
use super::target::{Target, check_targets, write, write_document};

/// Arguments of `compare`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim compare train-1.csv train-2.csv --machine M.toml
  host-sim compare run.csv --machine M.toml --map \"position=Kolbenweg [mm]\" --plot run.svg
  host-sim compare run.csv --machine before.toml --machine after.toml --report C.html
  host-sim compare run.csv --machine M.toml --exit-code --tolerance 97

NRMSE fit is 100·(1 − ‖y − ŷ‖/‖y − mean y‖) %: 100 is perfect, 0 no better than the mean. A section \
is simulated from its own measured input, so that a miss in it is made in it. Several machine files, \
each by a --machine of its own, are compared with the same recordings; drawings show them over each \
other.
Recordings: CSV, TwinCAT Scope text, .xlsx, .mat, .mf4, .parquet, each also .gz.")]
pub struct Arguments {
    /// Recordings to compare with
    #[arg(value_name = "R.csv", required_unless_present = "recording")]
    files: Vec<PathBuf>,
    /// Machine file of the drive (TOML, SI units); may be repeated
    #[arg(long, value_name = "M.toml", required = true)]
    machine: Vec<PathBuf>,
    /// Recordings, too
    #[arg(long, value_name = "R.csv", num_args = 1..)]
    recording: Vec<PathBuf>,
    #[command(flatten)]
    model: ModelArguments,
    /// Judge by these signals only: `spool,pressure_a`
    ///
    /// As though the model's others had not been measured
    #[arg(long, value_name = "signal,…", value_delimiter = ',', value_parser = judged::named)]
    judge: Vec<Signal>,
    /// Draw recorded against simulated, with the residual below
    ///
    /// For several recordings a file each, named after it
    #[arg(long, value_name = "P.svg")]
    plot: Option<PathBuf>,
    /// Write every fit for programs; `-` prints it in place of the text
    #[arg(long, value_name = "C.json")]
    json: Option<PathBuf>,
    /// Write a page for people: every signal, residuals, correlations
    #[arg(long, value_name = "C.html")]
    report: Option<PathBuf>,
    /// Answer 1 when a signal's fit end to end is below the tolerance
    ///
    /// By any of the machine files
    #[arg(long)]
    exit_code: bool,
    /// Lowest NRMSE fit that is in tolerance, %
    #[arg(long, value_name = "percent", default_value_t = 95.0, requires = "exit_code")]
    tolerance: f64,
}

/// One machine file, and what it makes of the recordings.
struct Drive {
    path: PathBuf,
    file: MachineFile,
    recordings: Vec<Recording>,
    comparisons: Vec<Comparison>,
    /// What is doubtful about the recordings for it: they are compared as they are all the same.
    doubts: Vec<Doubt>,
}

impl Drive {
    fn as_compared<'a>(&'a self, label: &'a str) -> Compared<'a> {
        let Self { file, recordings, comparisons, doubts, .. } = self;
        Compared { label, file, recordings, comparisons, doubts }
    }
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let (read, targets) = check(arguments)?;
    check_targets(&targets, &read)?;
    let mut drives = arguments
        .machine
        .iter()
        .map(|machine| opened(arguments, machine, console))
        .collect::<Result<Vec<Drive>, CliError>>()?;
    let plots = arguments.plot.as_ref().map_or_else(Vec::new, |path| plot_paths(path, &drives[0].recordings));
    let drawings = plots.iter().map(|path| ("--plot", Some(path.as_path()), DRAWING));
    check_targets(&drawings.chain(targets).collect::<Vec<_>>(), &read)?;
    arguments.plot.as_deref().map_or(Ok(()), |path| check_ending("--plot", path, DRAWING))?;
    for drive in &mut drives {
        drive.comparisons = compared(drive, &arguments.model, console)?;
        if !console.is_quiet() || arguments.report.is_some() {
            drive.doubts = input::doubts(&drive.path, &drive.file, &drive.recordings, true)?;
        }
    }
    let labels = labels(&drives);
    if let Some(path) = &arguments.json {
        let all: Vec<_> = drives.iter().map(|drive| (drive.path.as_path(), &drive.file, &*drive.comparisons)).collect();
        write_document(path, &format!("{:#}\n", report::json::comparisons(&all)), console)?;
    }
    if let Some(path) = &arguments.report {
        let compared: Vec<Compared<'_>> =
            drives.iter().zip(&labels).map(|(drive, label)| drive.as_compared(label)).collect();
        write(path, html::compare(&compared, &about(&arguments.machine)))?;
    }
    for (path, svg) in plots.iter().zip(drawings_of(&drives, &labels)) {
        write(path, svg)?;
    }
    for (drive, label) in drives.iter().zip(&labels) {
        if drives.len() > 1 {
            console.print(format_args!("machine {label} ({})", drive.path.display()))?;
        }
        tell(drive, console)?;
        if drives.len() > 1 {
            console.print("")?;
        }
    }
    if drives.len() > 1 {
        console.print("side by side, end to end, mean NRMSE fit %")?;
        console.print(side_by_side(&drives, &labels, console.width))?;
    }
    for path in &plots {
        console.print(format_args!("plot: {}", path.display()))?;
    }
    if !arguments.exit_code {
        return Ok(Outcome::Done);
    }
    let below: Vec<String> = below(&drives, &labels, arguments.tolerance).collect();
    let tone = if below.is_empty() { Tone::Good } else { Tone::Bad };
    console.verdict(verdict(&below, arguments.tolerance), tone)?;
    Ok(if below.is_empty() { Outcome::Done } else { Outcome::OutOfTolerance })
}

/// Checks what needs no file; the files that are read, and those that are written beside drawings.
fn check(arguments: &Arguments) -> Result<(Vec<PathBuf>, [Target<'_>; 2]), CliError> {
    if !(f64::NEG_INFINITY..=100.0).contains(&arguments.tolerance) {
        let (argument, expected) = ("--tolerance", "at most 100 %");
        return Err(CliError::Number { argument, found: arguments.tolerance, expected });
    }
    let read = [arguments.files.as_slice(), &arguments.recording, &arguments.machine].concat();
    let document = ("--json", arguments.json.as_deref(), DOCUMENT);
    Ok((read, [document, ("--report", arguments.report.as_deref(), PAGE)]))
}

/// A machine file with the recordings as it has their channels, not compared yet.
fn opened(arguments: &Arguments, machine: &Path, console: &Console<'_>) -> Result<Drive, CliError> {
    let (file, channels) = arguments.model.read(machine)?;
    let paths = [arguments.files.as_slice(), &arguments.recording].concat();
    let recordings = input::recordings(&paths, &channels, console)?
        .into_iter()
        .map(|recording| input::judged(recording, &file, &arguments.judge))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(Drive { path: machine.to_owned(), file, recordings, comparisons: Vec::new(), doubts: Vec::new() })
}

/// What the drives are called: by their names, by their files where names repeat, by their paths where these do, too.
fn labels(drives: &[Drive]) -> Vec<String> {
    let stem = |drive: &Drive| drive.path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into());
    let names: Vec<String> = drives.iter().map(|drive| drive.file.name.clone()).collect();
    let stems: Vec<String> = drives.iter().map(stem).collect();
    let are_distinct = |of: &[String]| of.iter().collect::<BTreeSet<_>>().len() == of.len();
    let paths = || drives.iter().map(|drive| drive.path.display().to_string()).collect();
    [names, stems].into_iter().find(|labels| are_distinct(labels)).unwrap_or_else(paths)
}

/// The text of one drive: notes, table, sentences.
fn tell(drive: &Drive, console: &mut Console<'_>) -> Result<(), CliError> {
    let Drive { file, recordings, comparisons, doubts, .. } = drive;
    let quiet = console.is_quiet();
    for note in recordings.iter().filter(|_| !quiet).flat_map(|recording| input::notes(recording, &file.machine)) {
        console.print(format_args!("note: {note}"))?;
    }
    for doubt in doubts.iter().filter(|doubt| doubt.is_certain && !quiet) {
        console.print(format_args!("note: {}", mend_first(doubt)))?;
    }
    for found in comparisons.iter().filter(|_| !quiet) {
        for note in not_judged(found) {
            console.print(format_args!("note: {}: {note}", found.recording))?;
        }
    }
    console.print_styled(table(comparisons, console.terminal, console.width))?;
    for line in sentences(comparisons, file.load_source) {
        console.print(line)?;
    }
    Ok(())
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

fn compared(drive: &Drive, model: &ModelArguments, console: &Console<'_>) -> Result<Vec<Comparison>, CliError> {
    let Drive { path, file, recordings, .. } = drive;
    let (values, load) = (&file.machine, file.load_source);
    let rows = |recording| rows_simulated(values.source, load, recording) as u64;
    let bar = console.share(recordings.iter().map(rows).sum(), "comparing");
    let how = (model.arithmetic.into(), model.tick());
    let found = compare_each(file, &base_parameters(file), recordings, how, &|rows| bar.inc(rows as u64));
    bar.finish_and_clear();
    found.map_err(|cause| CliError::Compare { machine: path.clone(), cause })
}

/// A drawing of each recording, with every drive over each other.
fn drawings_of(drives: &[Drive], labels: &[String]) -> impl Iterator<Item = String> {
    drives[0].recordings.iter().enumerate().map(move |(index, recording)| {
        let simulated = |(drive, label): (_, &'_ String)| {
            let drive: &Drive = drive;
            let whole = drive.comparisons.get(index)?.sections.first()?;
            Some((label.clone(), whole))
        };
        let wholes: Vec<(String, _)> = drives.iter().zip(labels).filter_map(simulated).collect();
        let named: Vec<(&str, &Trajectory)> = match wholes.as_slice() {
            [(_, only)] => vec![("simulated", &only.trajectory)],
            several => several.iter().map(|(label, whole)| (label.as_str(), &whole.trajectory)).collect(),
        };
        let panels = wholes.first().map_or_else(Vec::new, |(_, whole)| {
            let judged: Vec<Signal> = whole.fits.iter().map(|fit| fit.signal).collect();
            plot::panels_of(recording, whole.input_point, &named, &judged)
        });
        let told = format!("recorded against {}, simulated end to end", labels.join(", "));
        plot::svg(recording.name(), &told, &panels)
    })
}

/// A row for each signal, a column for each drive.
fn side_by_side(drives: &[Drive], labels: &[String], width: Option<u16>) -> Table {
    let means: Vec<_> = drives.iter().map(|drive| mean_fits(&drive.comparisons)).collect();
    let signals: Vec<Signal> = means.iter().flatten().map(|(signal, _)| *signal).fold(Vec::new(), |mut all, signal| {
        if !all.contains(&signal) {
            all.push(signal);
        }
        all
    });
    let mut table = Table::new();
    table.load_style(TABLE);
    arrange(&mut table, width);
    table.set_header(std::iter::once("signal").chain(labels.iter().map(String::as_str)));
    for signal in signals {
        let fit = |of: &Vec<(Signal, f64)>| {
            let found = of.iter().find(|(known, _)| *known == signal);
            found.map_or_else(String::new, |(_, fit)| percent(*fit))
        };
        table.add_row(std::iter::once(signal.to_string()).chain(means.iter().map(fit)));
    }
    for (_, column) in table.column_iter_mut().enumerate().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
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

fn below(drives: &[Drive], labels: &[String], tolerance: f64) -> impl Iterator<Item = String> {
    let several = drives.len() > 1;
    drives.iter().zip(labels).flat_map(move |(drive, label)| {
        drive.comparisons.iter().flat_map(move |comparison| {
            let fits = comparison.sections.first().into_iter().flat_map(|whole| &whole.fits);
            fits.filter(move |fit| !(tolerance..).contains(&fit.nrmse_percent)).map(move |fit| {
                let drive = if several { format!("{label}, ") } else { String::new() };
                format!("{drive}{} {} ({} %)", comparison.recording, fit.signal, percent(fit.nrmse_percent))
            })
        })
    })
}

fn verdict(below: &[String], tolerance: f64) -> String {
    if below.is_empty() {
        format!("in tolerance: every signal fits end to end with at least {tolerance} %")
    } else {
        format!("out of tolerance: below {tolerance} % end to end: {}", below.join(", "))
    }
}
