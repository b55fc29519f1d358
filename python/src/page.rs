//! The pages of `inspect`, `compare` and `fit`: what a command writes with `--report`, made when somebody asks for it.

use std::path::Path;
use std::sync::Arc;

use ::recording::{Recording as Held, unknown_columns};
use diagnosis::Refit;
use experiment::inspect::Inspection;
use identification::compare::Comparison;
use machine_file::MachineFile;
use pyo3::prelude::*;
use report::html::{self, About, Compared, Inspected};

/// What a page is made of.
#[derive(Debug)]
pub(crate) enum Of {
    /// Recordings, and what was found in them; the drive's name where there is one.
    Inspection(Option<String>, Vec<Arc<Held>>, Vec<Inspection>),
    /// A machine file on recordings.
    Comparison(MachineFile, Vec<Held>, Vec<Comparison>),
    /// A refit, and its recordings in its order.
    Fit(Refit, Vec<Held>),
}

/// A page that can be made.
#[pyclass(frozen, module = "host_sim._native", skip_from_py_object)]
#[derive(Debug)]
pub(crate) struct Page {
    pub(crate) of: Of,
}

#[pymethods]
impl Page {
    /// What the command writes with `--report`.
    fn html(&self) -> String {
        match &self.of {
            Of::Inspection(machine, recordings, found) => inspection(machine.as_deref(), recordings, found),
            Of::Comparison(file, recordings, comparisons) => {
                html::compare(&[Compared { label: &file.name, file, recordings, comparisons }], &About::default())
            }
            Of::Fit(refit, recordings) => html::fit(refit, &recordings.iter().collect::<Vec<_>>(), &About::default()),
        }
    }
}

fn inspection(machine: Option<&str>, recordings: &[Arc<Held>], found: &[Inspection]) -> String {
    // A recording from memory has no file with further columns.
    let columns = |recording: &Arc<Held>| unknown_columns(Path::new(recording.path()), recording).unwrap_or_default();
    let unknown: Vec<_> = recordings.iter().map(columns).collect();
    let inspected = Inspected::each(found, recordings.iter().map(Arc::as_ref), &unknown);
    html::inspect(machine, &inspected, &About::default())
}
