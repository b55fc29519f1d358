//! The command `diagnose`: what the model lacks.

use std::sync::Arc;

use ::recording::Recording as Held;
use diagnosis::agreement::Doubt;
use diagnosis::{Diagnosis, Options, diagnose_with, settle_pressure_zero};
use identification::stop;
use machine_file::MachineFile;
use model_core::machine::Machine as Values;
use pyo3::prelude::*;
use report::evidence::Exhibits;
use report::refused::{self, Refused, check_distinct};
use report::{json, terminal, wording};

use crate::commands::{judged_of, tick};
use crate::error::{OrRaise, Raised};
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
    refused::checked_doubts((&machine.path, file), recordings, as_recorded, "give as_recorded=True")
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
        let mut file = machine.file.clone();
        let mut training = judged_of(&train, machine, &judge)?;
        let mut held_out = judged_of(&holdout, machine, &judge)?;
        check_distinct(&training, &held_out)?;
        let failed = |cause| Refused::diagnose(&machine.path, cause);
        settle_pressure_zero(&mut file, &mut training, &mut held_out, tick).map_err(failed)?;
        let file = &file;
        let all: Vec<&Held> = training.iter().chain(&held_out).collect();
        let doubts = check_doubts(machine, file, &all, as_recorded)?;
        let options = Options { tick, asks_since, limit_s: Some(limit_s) };
        let found = diagnose_with(file, (&training, &held_out), options, &|_| stop::here()).map_err(failed)?;
        let diagnosis = Diagnosis { doubts, ..found };
        let exhibits = Exhibits::of(file, &training, &held_out, &diagnosis, true);
        let exhibits = exhibits.map_err(|cause| Refused::machine(&machine.path, cause))?;
        let (after, notes) = (machine.with(diagnosis.machine_file(file)), notes(&all, &file.machine));
        Ok(Diagnosed { found: Arc::new((diagnosis, exhibits)), after, notes })
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
