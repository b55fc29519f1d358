//! The pages of `inspect`, `compare`, `fit` and `diagnose`: what a command writes with `--report`, made when somebody asks for it.

use std::path::PathBuf;
use std::sync::Arc;

use ::recording::{Recording as Held, unknown_columns};
use diagnosis::agreement::Doubt;
use diagnosis::{Diagnosis, Refit};
use experiment::inspect::Inspection;
use identification::compare::Comparison;
use machine_file::MachineFile;
use pyo3::prelude::*;
use report::evidence::Exhibits;
use report::html::{self, About, Compared, Inspected};

/// What a page is made of.
#[derive(Debug)]
pub(crate) enum Of {
    /// Recordings with their files, and what was found in them; the drive's name where there is one.
    Inspection(Option<String>, Vec<(Arc<Held>, Option<PathBuf>)>, Vec<Inspection>),
    /// A machine file on recordings, and what is doubtful about them.
    Comparison { file: Box<MachineFile>, recordings: Vec<Held>, found: Vec<Comparison>, doubts: Vec<Doubt> },
    /// A refit, its recordings in its order, and what is doubtful about them.
    Fit(Box<Refit>, Vec<Held>, Vec<Doubt>),
    /// A diagnosis with its evidence.
    Diagnosis(Arc<(Diagnosis, Exhibits)>),
}

/// A page that can be made.
#[pyclass(frozen, module = "host_sim._native", skip_from_py_object)]
#[derive(Debug)]
pub(crate) struct Page {
    pub(crate) of: Of,
    /// The machine file as it was named, where there is one.
    pub(crate) machine_file: Option<String>,
}

#[pymethods]
impl Page {
    /// What the command writes with `--report`, made at this time by this call.
    #[pyo3(signature = (written, command))]
    fn html(&self, written: Option<String>, command: Option<String>) -> String {
        let about = About { written, command, machine_files: self.machine_file.iter().cloned().collect() };
        match &self.of {
            Of::Inspection(machine, recordings, found) => inspection(machine.as_deref(), recordings, found, &about),
            Of::Comparison { file, recordings, found, doubts } => {
                let label = &file.name;
                html::compare(&[Compared { label, file, recordings, comparisons: found, doubts }], &about)
            }
            Of::Fit(refit, recordings, doubts) => {
                html::fit(refit, &recordings.iter().collect::<Vec<_>>(), doubts, &about)
            }
            Of::Diagnosis(found) => html::page(&found.0, &found.1, &about),
        }
    }
}

fn inspection(
    machine: Option<&str>,
    recordings: &[(Arc<Held>, Option<PathBuf>)],
    found: &[Inspection],
    about: &About,
) -> String {
    // A file that is gone, and a recording from memory, which has none, show their known channels alone.
    let further = |(recording, file): &(Arc<Held>, Option<PathBuf>)| unknown_columns(file.as_deref()?, recording).ok();
    let unknown: Vec<_> = recordings.iter().map(|one| further(one).unwrap_or_default()).collect();
    let inspected = Inspected::each(found, recordings.iter().map(|(recording, _)| recording.as_ref()), &unknown);
    html::inspect(machine, &inspected, about)
}
