//! The command `simulate`: the signals of the model for a recording or for an input signal.

use std::sync::Arc;

use ::recording::Recording as Held;
use ::recording::excitation::signals::Excitation;
use experiment::standard_tests::StandardTest;
use identification::compare::judged;
use identification::{along, stop};
use machine_file::LoadSource;
use model_core::machine::{Source, Tick};
use pyo3::prelude::*;
use report::refused::Refused;
use report::{plot, wording};
use simulation::{StartOffset, Stimulus, first_input_point, tick_for};

use crate::commands::{arithmetic, tick};
use crate::diagnose::notes;
use crate::error::OrRaise;
use crate::machine::Machine;
use crate::recording::Recording;
use crate::table::Table;
use crate::unlocked::unlocked;

/// What was simulated.
#[pyclass(frozen, module = "host_sim._native", skip_from_py_object)]
#[derive(Debug)]
pub(crate) struct Simulated {
    /// What the command writes.
    #[pyo3(get)]
    table: Py<Table>,
    #[pyo3(get)]
    tick_ms: f64,
    #[pyo3(get)]
    notes: Vec<String>,
    /// Recorded against simulated; none for an input signal.
    #[pyo3(get)]
    drawing: Option<String>,
}

/// Simulates along a recording, or from a signal at the command.
#[pyfunction]
pub(crate) fn simulate(
    py: Python<'_>,
    machine: Py<Machine>,
    recording: Option<Py<Recording>>,
    input: Option<String>,
    number: &str,
    tick_ms: Option<f64>,
    threads: Option<usize>,
) -> PyResult<Simulated> {
    let (asked, number) = (tick(tick_ms).or_raise(py)?, arithmetic(number).or_raise(py)?);
    let (machine, given) = (machine.get(), recording.map(|recording| Arc::clone(&recording.get().held)));
    let (table, tick, notes, drawing) = unlocked(py, threads, || {
        let file = &machine.file;
        let failed = |cause| Refused::machine(&machine.path, cause);
        let (recording, load) = match (&given, &input) {
            (Some(recording), None) => (Arc::clone(recording), file.load_source),
            (None, Some(input)) => (Arc::new(of_input(machine, input, asked)?), LoadSource::Constant),
            _ => return Err(Refused::argument("recording", "expected a recording or an input, and not both")),
        };
        let input_point = first_input_point(file.machine.source, &recording).map_err(failed)?;
        let tick = asked.unwrap_or_else(|| tick_for(&recording, &file.machine));
        let mut notes = notes(&[&recording], &file.machine);
        notes.extend(wording::starts_anywhere(&recording));
        let shift = along::start_in_play(&file.machine, &recording, load, tick);
        notes.extend(shift.map(|shift_m| wording::starts_in_play(&recording, shift_m)));
        let start = StartOffset { shift_m: shift.unwrap_or_default(), ..StartOffset::none() };
        let stimulus = Stimulus::new(&recording, &file.machine, input_point, load, tick).map_err(failed)?;
        let told = |_| stop::here();
        let simulated = number.simulate_with_progress(&file.machine, &stimulus, start, &told);
        let mut simulated = simulated.map_err(failed)?;
        for (signal, ends) in along::end_with_sensors(&recording, &mut simulated) {
            notes.push(wording::sensor_ends(&recording, signal, &ends));
        }
        if let Some(linkage) = file.channels.linkage.as_deref()
            && along::add_angle(linkage, &mut simulated)
        {
            notes.push(wording::linkage_ends(&recording, linkage));
        }
        if given.is_none() {
            let written = along::response(&recording, &simulated)?.written(&[], &[])?;
            return Ok((Table::of(written), tick, notes, None));
        }
        let panels = plot::panels(&recording, input_point, &simulated, &judged(&recording, input_point, load));
        let (replaced, added) = along::columns(&recording, &simulated);
        let table = Table::of(recording.written(&replaced, &added)?);
        Ok((table, tick, notes, Some(plot::svg(recording.name(), &file.name, &panels))))
    })?;
    Ok(Simulated { table: Py::new(py, table)?, tick_ms: 1e3 * tick.seconds(), notes, drawing })
}

/// The recording of an input signal.
fn of_input(machine: &Machine, input: &str, tick: Option<Tick>) -> Result<Held, Refused> {
    let (excitation, unit) = Excitation::read(input, machine.file.channels.command_unit())
        .map_err(|error| Refused::argument("input", error))?;
    let values = &machine.file.machine;
    if values.source != Source::Valve {
        let text =
            format!("a {} moves the drive; expected a [valve], which is what input commands", values.source.name());
        return Err(Refused::machine(&machine.path, text));
    }
    let test = StandardTest::of_input(&excitation, input, tick.unwrap_or(Tick::OneMillisecond));
    Ok(test.recording_in(unit, values)?)
}
