//! The commands `inspect`, `compare`, `fit` and `plan`: each what the command line does between its files and its output.

use std::sync::Arc;

use ::recording::excitation::signals::Excitation;
use ::recording::{Recording as Held, Signal};
use diagnosis::{Refitting, base_parameters, settle_pressure_zero};
use experiment::at_hand::AtHand;
use experiment::inspect::Inspection;
use experiment::plan::{Planned, plan as planned};
use experiment::sensor::Sensor;
use identification::along;
use identification::compare::judged::judged_by;
use identification::compare::open_loop::compare_each;
use identification::compare::{Comparison, judged};
use identification::{parallel, stop};
use machine_file::MachineFile;
use model_core::machine::Tick;
use pyo3::prelude::*;
use report::refused::{Refused, check_held_out};
use report::{json, plot, terminal, wording};
use simulation::Arithmetic;

use crate::diagnose::{check_doubts, notes};
use crate::error::OrRaise;
use crate::machine::Machine;
use crate::page::{Of, Page};
use crate::recording::{Recording, files, held};
use crate::table::Table;
use crate::unlocked::unlocked;

/// The step of the model that is asked for, in ms.
pub(crate) fn tick(tick_ms: Option<f64>) -> Result<Option<Tick>, Refused> {
    let all = [Tick::HalfMillisecond, Tick::OneMillisecond, Tick::TwoMilliseconds];
    let Some(ms) = tick_ms else { return Ok(None) };
    let found = all.into_iter().find(|tick| (1e3 * tick.seconds()).total_cmp(&ms).is_eq());
    found.map(Some).ok_or_else(|| Refused::argument("tick_ms", format_args!("{ms}; expected 0.5, 1 or 2")))
}

/// The number type that is asked for.
pub(crate) fn arithmetic(name: &str) -> Result<Arithmetic, Refused> {
    match name {
        "fixed" => Ok(Arithmetic::Fixed),
        "float" => Ok(Arithmetic::Float),
        other => Err(Refused::argument("arithmetic", format_args!("`{other}`; expected fixed or float"))),
    }
}

/// The recordings, limited to the signals to judge by.
pub(crate) fn judged_of(recordings: &[Arc<Held>], machine: &Machine, names: &[String]) -> Result<Vec<Held>, Refused> {
    let wanted: Vec<Signal> = names
        .iter()
        .map(|name| judged::named(name).map_err(|text| Refused::argument("judge", text)))
        .collect::<Result<_, _>>()?;
    let (source, load) = (machine.file.machine.source, machine.file.load_source);
    let limited = |recording: &Arc<Held>| {
        judged_by(Held::clone(recording), source, load, &wanted).map_err(|error| Refused::argument("judge", error))
    };
    recordings.iter().map(limited).collect()
}

/// What recordings hold, as JSON and as the command's text, and their page.
#[pyfunction]
pub(crate) fn inspect(
    py: Python<'_>,
    recordings: Vec<Py<Recording>>,
    machine: Option<Py<Machine>>,
    threads: Option<usize>,
) -> PyResult<(String, String, Page)> {
    let (recordings, files) = (held(&recordings), files(&recordings));
    let machine = machine.as_ref().map(Py::get);
    let file = machine.map(|machine| &machine.file);
    unlocked(py, threads, || {
        let found: Vec<Inspection> = parallel::each(&recordings, |recording| Inspection::of(recording, file));
        let texts: Vec<String> = found.iter().map(|found| report::inspect::text(found, None)).collect();
        let document = report::inspect::document(&found).to_string();
        let of = recordings.iter().cloned().zip(files).collect();
        let of = Of::Inspection(file.map(|file| file.name.clone()), of, found);
        let page = Page { of, machine_file: machine.map(|machine| machine.path.clone()) };
        Ok((document, texts.join("\n"), page))
    })
}

/// What `compare` gives: JSON, notes, a drawing of each recording, and its table, simulated end to end; and the page.
type Compared = (String, Vec<String>, Vec<String>, Vec<Table>, Page);

/// The fit of every measured signal.
#[pyfunction]
pub(crate) fn compare(
    py: Python<'_>,
    machine: Py<Machine>,
    recordings: Vec<Py<Recording>>,
    judge: Vec<String>,
    number: &str,
    tick_ms: Option<f64>,
    threads: Option<usize>,
) -> PyResult<Compared> {
    let (machine, recordings) = (machine.get(), held(&recordings));
    let (tick, number) = (tick(tick_ms).or_raise(py)?, arithmetic(number).or_raise(py)?);
    unlocked(py, threads, || {
        let recordings = judged_of(&recordings, machine, &judge)?;
        let file = &machine.file;
        let free = base_parameters(file);
        let found = compare_each(file, &free, &recordings, (number, tick), &|_| stop::here());
        let found: Vec<Comparison> = found.map_err(|cause| Refused::compare(&machine.path, cause))?;
        let (mut drawings, mut tables) = (Vec::new(), Vec::new());
        for (recording, comparison) in recordings.iter().zip(&found) {
            let Some(whole) = comparison.sections.first() else { continue };
            let judged: Vec<Signal> = whole.fits.iter().map(|fit| fit.signal).collect();
            let panels = plot::panels(recording, whole.input_point, &whole.trajectory, &judged);
            let told = format!("recorded against {}, simulated end to end", file.name);
            drawings.push(plot::svg(recording.name(), &told, &panels));
            let (replaced, added) = along::columns(recording, &whole.trajectory);
            tables.push(Table::of(recording.written(&replaced, &added)?));
        }
        let all: Vec<&Held> = recordings.iter().collect();
        // They are compared as they are all the same.
        let doubts = check_doubts(machine, file, &all, true)?;
        let mut notes = notes(&all, &file.machine);
        notes.extend(doubts.iter().filter(|doubt| doubt.is_certain).map(wording::mend_first));
        let document = json::comparison(file, &found).to_string();
        let of = Of::Comparison { file: Box::new(file.clone()), recordings, found, doubts };
        let page = Page { of, machine_file: Some(machine.path.clone()) };
        Ok((document, notes, drawings, tables, page))
    })
}

/// What `fit` gives: JSON, the machine with the fitted values, notes, the command's table, and the page.
type Fitted = (String, Machine, Vec<String>, String, Page);

/// A refit of the base parameters.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "those of the command")]
pub(crate) fn fit(
    py: Python<'_>,
    machine: Py<Machine>,
    train: Vec<Py<Recording>>,
    holdout: Vec<Py<Recording>>,
    judge: Vec<String>,
    tick_ms: Option<f64>,
    as_recorded: bool,
    threads: Option<usize>,
) -> PyResult<Fitted> {
    let (machine, training) = (machine.get(), held(&train));
    let recordings = [training.clone(), held(&holdout)].concat();
    let tick = tick(tick_ms).or_raise(py)?;
    unlocked(py, threads, || {
        if training.is_empty() {
            return Err(Refused::argument("train", "no recording; expected at least one"));
        }
        let mut recordings = judged_of(&recordings, machine, &judge)?;
        let mut file: MachineFile = machine.file.clone();
        let failed = |cause| Refused::diagnose(&machine.path, cause);
        let (trained, held_out) = recordings.split_at_mut(training.len());
        check_held_out(trained, held_out)?;
        settle_pressure_zero(&mut file, trained, held_out, tick).map_err(failed)?;
        let all: Vec<&Held> = recordings.iter().collect();
        let mut notes = notes(&all, &file.machine);
        let doubts = check_doubts(machine, &file, &all, as_recorded)?;
        notes.extend(doubts.iter().map(wording::doubt));
        let (training, held_out) = recordings.split_at(training.len());
        let refitting = Refitting::of(&file, training, tick).map_err(failed)?;
        let refitting = refitting.with_held_out(held_out, tick).map_err(failed)?;
        let refit = refitting.search(&|_| stop::here()).map_err(failed)?;
        let table = terminal::parameters(&refit.estimates).to_string();
        let (document, after) = (json::refit(&refit).to_string(), machine.with(refit.file.clone()));
        let page = Page { of: Of::Fit(Box::new(refit), recordings, doubts), machine_file: Some(machine.path.clone()) };
        Ok((document, after, notes, table, page))
    })
}

/// What could be seen and told apart: JSON, the excitation that separates most, and the drawing of its isolability matrix.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "those of the command")]
pub(crate) fn plan(
    py: Python<'_>,
    machine: Py<Machine>,
    sensors: Vec<String>,
    excitation: (Option<String>, Option<Py<Recording>>),
    largest_v: Option<f64>,
    longest_s: f64,
    can_load: bool,
    threads: Option<usize>,
) -> PyResult<(String, Recording, String, String)> {
    let machine = machine.get();
    let recording = excitation.1.map(|recording| Arc::clone(&recording.get().held));
    unlocked(py, threads, || {
        let file = &machine.file;
        let at_hand = at_hand(machine, excitation.0.as_deref(), recording.as_deref())?;
        let mut named: Vec<Sensor> = Vec::new();
        for text in &sensors {
            let sensor = Sensor::parse(text, &file.machine).map_err(|error| Refused::argument("sensors", error))?;
            // If a sensor is named twice, the last one counts.
            named.retain(|known| known.signal != sensor.signal);
            named.push(sensor);
        }
        if let (true, Some(at_hand)) = (named.is_empty(), &at_hand) {
            named.clone_from(&at_hand.sensors);
        }
        let positive = |key: &str, value: f64| {
            let is_positive = value.is_finite() && value > 0.0;
            let refused = || Refused::argument(key, format_args!("{value}; expected a positive number"));
            is_positive.then_some(value).ok_or_else(refused)
        };
        let largest_v = largest_v.or(at_hand.as_ref().map(|at_hand| at_hand.largest_v)).unwrap_or(10.0);
        let asked = Planned {
            machine: &file.machine,
            base_parameters: &base_parameters(file),
            sensors: &named,
            largest_v: positive("largest_v", largest_v)?,
            can_load,
            longest_s: positive("longest_s", longest_s)?,
        };
        let given = at_hand.as_ref().map(|at_hand| &at_hand.stimulus);
        let plan = planned(&asked, given, &stop::here).map_err(|cause| Refused::machine(&machine.path, cause))?;
        let text = report::plan::text(&file.name, &named, &plan, None);
        let test = &plan.excitation;
        let excitation = Recording::from_memory(Held::new(test.name, test.columns().collect())?);
        let drawing = plot::grid(&report::plan::matrix(&plan.best));
        Ok((report::plan::document(&file.name, &named, &plan).to_string(), excitation, drawing, text))
    })
}

fn at_hand(machine: &Machine, input: Option<&str>, recording: Option<&Held>) -> Result<Option<AtHand>, Refused> {
    let failed = |cause| Refused::compare(&machine.path, cause);
    match (input, recording) {
        (None, None) => Ok(None),
        (_, Some(recording)) => AtHand::of_recording(recording, &machine.file).map(Some).map_err(failed),
        (Some(text), None) => {
            let (signal, _) = Excitation::read(text, machine.file.channels.command_unit())
                .map_err(|error| Refused::argument("input", error))?;
            AtHand::of_input(&signal, text, &machine.file).map(Some).map_err(failed)
        }
    }
}
