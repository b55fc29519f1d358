//! The command `diagnose`: what the model lacks.

use std::sync::Arc;

use ::recording::{PressureZero, Recording as Held};
use diagnosis::agreement::{Doubt, doubts};
use diagnosis::{Diagnosis, Options, base_parameters, diagnose_with, read_absolute};
use identification::stop;
use machine_file::MachineFile;
use model_core::machine::Machine as Values;
use pyo3::prelude::*;
use report::evidence::Exhibits;
use report::{json, terminal, wording};

use crate::commands::{judged_of, tick};
use crate::error::{OrRaise, Refused};
use crate::machine::Machine;
use crate::page::{Of, Page};
use crate::recording::{Recording, held};
use crate::table::Table;
use crate::unlocked::unlocked;

/// A diagnosis, with the evidence of its page.
#[pyclass(frozen, module = "host_sim._native", skip_from_py_object)]
#[derive(Debug)]
pub(crate) struct Diagnosed {
    found: Arc<(Diagnosis, Exhibits)>,
    after: Machine,
    #[pyo3(get)]
    notes: Vec<String>,
}

/// What was noted as recordings were read, and doubts about their units, each with the recording's name.
pub(crate) fn notes(recordings: &[&Held], values: &Values<f64>) -> Vec<String> {
    recordings.iter().flat_map(|recording| wording::notes(recording, values)).collect()
}

/// What is doubtful about recordings for this drive. What is certainly wrong is an error, unless they are to be taken as they are.
pub(crate) fn check_doubts(
    machine: &Machine,
    file: &MachineFile,
    recordings: &[&Held],
    as_recorded: bool,
) -> Result<Vec<Doubt>, Refused> {
    let found = doubts(file, &base_parameters(file), recordings);
    let found = found.map_err(|cause| Refused::machine(&machine.path, cause))?;
    let certain: Vec<String> = found.iter().filter(|doubt| doubt.is_certain).map(wording::doubt).collect();
    if certain.is_empty() || as_recorded {
        return Ok(found);
    }
    let text = format!(
        "the recordings do not fit {}: {}; expected recordings of this drive: mend the channel (a sensor's `zero` and `full` in [channels] turn \
         and scale it) or the machine file, or give as_recorded=True",
        machine.path,
        certain.join("; ")
    );
    Err(Refused::of(text).in_file(&machine.path))
}

/// A recording cannot confirm effects that it was used to choose, and counts only once, even as a copy.
fn check_distinct(training: &[Held], held_out: &[Held]) -> Result<(), Refused> {
    let all: Vec<&Held> = training.iter().chain(held_out).collect();
    let Some((first, second)) = Held::held_twice(&all) else { return Ok(()) };
    let (first, second) = (all[first].path(), all[second].path());
    Err(Refused::of(format_args!("{first} and {second} hold the same recording; expected each once")).in_file(second))
}

/// Diagnoses a drive.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "those of the command")]
pub(crate) fn diagnose(
    py: Python<'_>,
    machine: Py<Machine>,
    train: Vec<Py<Recording>>,
    holdout: Vec<Py<Recording>>,
    asks_since: bool,
    judge: Vec<String>,
    tick_ms: Option<f64>,
    limit_s: f64,
    as_recorded: bool,
    threads: Option<usize>,
) -> PyResult<Diagnosed> {
    let (machine, train, holdout) = (machine.get(), held(&train), held(&holdout));
    let tick = tick(tick_ms).or_raise(py)?;
    if !(limit_s.is_finite() && limit_s > 0.0) {
        let text = format_args!("{limit_s} is no limit of time; expected seconds above 0, such as 300");
        return Err(Refused::argument("time_limit_s", text).raised(py));
    }
    unlocked(py, threads, || {
        let file = &machine.file;
        let mut training = judged_of(&train, machine, &judge)?;
        let mut held_out = judged_of(&holdout, machine, &judge)?;
        check_distinct(&training, &held_out)?;
        let failed = |cause| Refused::diagnose(&machine.path, cause);
        let absolute = read_absolute(file, &training, tick).map_err(failed)?;
        if absolute {
            training.iter_mut().chain(&mut held_out).for_each(Held::take_as_absolute);
        }
        let all: Vec<&Held> = training.iter().chain(&held_out).collect();
        let doubts = check_doubts(machine, file, &all, as_recorded)?;
        let options = Options { tick, asks_since, limit_s: Some(limit_s) };
        let found = diagnose_with(file, (&training, &held_out), options, &|_| stop::here()).map_err(failed)?;
        let diagnosis = Diagnosis { doubts, ..found };
        let exhibits = Exhibits::of(file, &training, &held_out, &diagnosis, true);
        let exhibits = exhibits.map_err(|cause| Refused::machine(&machine.path, cause))?;
        let mut after = diagnosis.machine_file(file);
        if absolute {
            after.channels.pressure = PressureZero::Absolute;
        }
        let notes = notes(&all, &file.machine);
        Ok(Diagnosed { found: Arc::new((diagnosis, exhibits)), after: machine.with(after), notes })
    })
}

#[pymethods]
impl Diagnosed {
    /// What the command writes with `--json`.
    fn json(&self) -> String {
        json::document(&self.found.0, &self.found.1).to_string()
    }

    /// What it prints.
    fn text(&self) -> String {
        terminal::text(&self.found.0, &self.found.1)
    }

    /// What it writes with `--report`.
    fn page(&self) -> Page {
        Page { of: Of::Diagnosis(Arc::clone(&self.found)), machine_file: Some(self.after.path.clone()) }
    }

    /// The machine with refitted parameters and the effects found.
    fn machine(&self) -> Machine {
        self.after.clone()
    }

    /// The names of the recordings, training first.
    fn recordings(&self) -> Vec<String> {
        self.found.0.shown.iter().map(|shown| shown.prepared.name.clone()).collect()
    }

    /// Every judged signal of a recording in SI units: recorded, and simulated before and after.
    fn trajectories(&self, index: usize) -> Option<Table> {
        let shown = self.found.0.shown.get(index)?;
        let case = &shown.prepared;
        let numbers = |values: &[f64]| values.iter().copied().map(Some).collect::<Vec<_>>();
        let mut columns = vec![("time [s]".to_owned(), numbers(&case.time_s))];
        for channel in &case.channels {
            let (signal, unit) = (channel.signal, channel.signal.si_unit());
            let series = [
                ("recorded", Some(channel.recorded.as_slice())),
                ("before", shown.before.signal(signal)),
                ("after", shown.after.signal(signal)),
            ];
            let given = series.into_iter().filter_map(|(which, values)| Some((which, values?)));
            columns.extend(given.map(|(which, values)| (format!("{signal} {which} [{unit}]"), numbers(values))));
        }
        Some(Table::of(columns))
    }
}
