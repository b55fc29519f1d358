//! A recording, from a file or from memory.

use std::path::{self, PathBuf};
use std::sync::Arc;

use ::recording::files::folder;
use ::recording::{ChannelMap, Signal};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use report::refused::Refused;

use crate::error::{OrRaise, Raised};
use crate::machine::{Machine, maps_of};
use crate::table::{Table, bytes_of};
use crate::unlocked::unlocked;

/// A recording: signals in SI units on one time base.
#[pyclass(frozen, module = "host_sim", skip_from_py_object)]
#[derive(Clone, Debug)]
pub(crate) struct Recording {
    pub(crate) held: Arc<::recording::Recording>,
    /// The file that it was read from, wherever the process is now. A recording from memory has none, whatever its name is.
    pub(crate) file: Option<PathBuf>,
}

impl Recording {
    /// A recording that no file holds.
    pub(crate) fn from_memory(held: ::recording::Recording) -> Self {
        Self { held: Arc::new(held), file: None }
    }
}

/// Which columns hold which signals, by a machine file and by maps.
pub(crate) fn channels(machine: Option<&Machine>, maps: &[String]) -> Result<ChannelMap, Refused> {
    machine.map_or_else(|| maps_of(maps), |machine| machine.channels(maps))
}

/// The recordings that Python passes.
pub(crate) fn held(recordings: &[Py<Recording>]) -> Vec<Arc<::recording::Recording>> {
    recordings.iter().map(|recording| Arc::clone(&recording.get().held)).collect()
}

/// Their files, those of recordings from memory missing.
pub(crate) fn files(recordings: &[Py<Recording>]) -> Vec<Option<PathBuf>> {
    recordings.iter().map(|recording| recording.get().file.clone()).collect()
}

/// Reads a file.
#[pyfunction]
pub(crate) fn read(
    py: Python<'_>,
    path: PathBuf,
    machine: Option<Py<Machine>>,
    maps: Vec<String>,
) -> PyResult<Recording> {
    let channels = channels(machine.as_ref().map(Py::get), &maps).or_raise(py)?;
    let held = unlocked(py, Some(1), || Ok(::recording::read(&path, &channels)?))?;
    Ok(Recording { held: Arc::new(held), file: path::absolute(&path).ok() })
}

/// The recordings of a folder whose names begin with this prefix, each in one format.
#[pyfunction]
pub(crate) fn listed(py: Python<'_>, folder: PathBuf, prefix: &str) -> PyResult<Vec<PathBuf>> {
    let name = folder.display().to_string();
    let found = folder::listed(&folder, prefix).map_err(|cause| {
        let text =
            format!("cannot be read: {cause}; expected a folder with machine.toml, train-*.csv and holdout-*.csv");
        Refused::machine(&name, text).raised(py)
    })?;
    if let Some((first, second)) = folder::in_two_formats(&found) {
        let (first, second) = (first.display(), second.display());
        let text = format!("{first} and {second} hold the same recording; expected each recording in one format");
        return Err(Refused::of(text).in_file(&name).raised(py));
    }
    Ok(found)
}

#[pymethods]
impl Recording {
    #[getter]
    fn name(&self) -> &str {
        self.held.name()
    }

    #[getter]
    fn path(&self) -> &str {
        self.held.path()
    }

    #[getter]
    fn rows(&self) -> usize {
        self.held.rows()
    }

    /// Signal, header and unit of each known column.
    #[getter]
    fn columns(&self) -> Vec<(&'static str, &str, &'static str)> {
        let columns = self.held.columns().iter();
        columns.map(|column| (column.signal.name(), column.header.as_str(), column.unit.symbol())).collect()
    }

    #[getter]
    fn ignored(&self) -> Vec<String> {
        self.held.ignored().to_vec()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.held.notes().iter().map(ToString::to_string).collect()
    }

    /// The values of a signal in its SI unit, as the bytes of doubles.
    fn si<'py>(&self, py: Python<'py>, name: &str) -> PyResult<(Bound<'py, PyBytes>, &'static str)> {
        let absent = || {
            let held: Vec<&str> = self.held.columns().iter().map(|column| column.signal.name()).collect();
            let text = format!("{}: there is no {name}; expected one of {}", self.held.name(), held.join(", "));
            Refused::of(text).about(self.held.path(), name)
        };
        let signal = Signal::parse(name).filter(|signal| self.held.has(*signal)).ok_or_else(absent).or_raise(py)?;
        let values = self.held.signal(signal).unwrap_or_default();
        Ok((bytes_of(py, values), signal.si_unit().symbol()))
    }

    /// As it is written: headers and units of the recording.
    fn table(&self, py: Python<'_>) -> PyResult<Table> {
        let columns = self.held.written(&[], &[]).or_raise(py)?;
        Ok(Table::of(columns))
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        self.held.write(&path, &[], &[]).or_raise(py)
    }
}
