//! Nights of many drives: found, judged and kept as `host-sim fleet` does it, all at once or one by one for an engine that spreads them.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use ::fleet::{How, Night, Pending, Row, Tally, Upto, of_parquet, to_parquet};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};
use report::refused::Refused;

use crate::error::OrRaise;
use crate::unlocked::unlocked;

/// A night as Python passes it: drive, name, machine file, recordings, and another folder of the same name.
type Passed = (String, String, PathBuf, Vec<PathBuf>, Option<PathBuf>);

/// How nights are judged, as Python passes it: how far, share of false alarms, limit of a search in s.
type Asked = (String, f64, f64);

fn passed(Night { drive, name, machine, recordings, twin }: Night) -> Passed {
    (drive, name, machine, recordings, twin)
}

fn night((drive, name, machine, recordings, twin): Passed) -> Night {
    Night { drive, name, machine, recordings, twin }
}

fn how((upto, false_alarms, limit_s): Asked) -> Result<How, Refused> {
    let known = Upto::ALL.into_iter().find(|(name, _)| *name == upto);
    let (_, upto) = known.ok_or_else(|| {
        Refused::argument("upto", format_args!("`{upto}`; expected {}", Upto::ALL.map(|(name, _)| name).join(", ")))
    })?;
    if !(false_alarms > 0.0 && false_alarms < 1.0) {
        let text = format_args!("{false_alarms}; expected a share between 0 and 1, such as 0.001");
        return Err(Refused::argument("false_alarms", text));
    }
    if !(limit_s > 0.0 && limit_s.is_finite()) {
        return Err(Refused::argument(
            "time_limit_s",
            format_args!("{limit_s}; expected seconds above 0, such as 300"),
        ));
    }
    Ok(How { upto, false_alarms, limit_s })
}

/// Every night of every drive in a folder.
#[pyfunction]
pub(crate) fn nights(py: Python<'_>, dataset: PathBuf) -> PyResult<Vec<Passed>> {
    let found = ::fleet::nights(&dataset).map_err(|cause| Refused::machine(&dataset.display().to_string(), cause));
    Ok(found.or_raise(py)?.into_iter().map(passed).collect())
}

/// The same of the paths of files below a data set, wherever it is.
#[pyfunction]
pub(crate) fn nights_of(dataset: PathBuf, paths: Vec<String>) -> Vec<Passed> {
    ::fleet::nights_of(&dataset, paths.iter().map(String::as_str)).into_iter().map(passed).collect()
}

/// The rows of a night as a part of a table.
#[pyfunction]
pub(crate) fn judge(py: Python<'_>, one: Passed, asked: Asked, threads: Option<usize>) -> PyResult<Py<PyBytes>> {
    let (night, how) = (night(one), how(asked).or_raise(py)?);
    let part = unlocked(py, threads, || to_parquet(&::fleet::judge(&night, &how)).map_err(Refused::of))?;
    Ok(PyBytes::new(py, &part).unbind())
}

/// The row of a night that no worker could judge, as a part of a table.
#[pyfunction]
pub(crate) fn unusable(py: Python<'_>, one: Passed, reason: String) -> PyResult<Py<PyBytes>> {
    let part = to_parquet(&[::fleet::unusable(&night(one), reason)]).map_err(Refused::of).or_raise(py)?;
    Ok(PyBytes::new(py, &part).unbind())
}

/// A table that rows are appended to; while it is open, no other run writes to it.
#[pyclass(module = "host_sim")]
#[derive(Debug)]
pub(crate) struct FleetTable {
    table: Mutex<Option<::fleet::Table>>,
}

/// How many nights ended how, by the names of a table.
fn named(tally: &Tally) -> BTreeMap<&'static str, usize> {
    tally.iter().map(|(judgement, count)| (judgement.name(), count)).collect()
}

#[pymethods]
impl FleetTable {
    #[new]
    fn new(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let table = ::fleet::Table::open(&folder).map_err(Refused::of).or_raise(py)?;
        Ok(Self { table: Mutex::new(Some(table)) })
    }

    /// Whether a night's rows are there.
    fn has(&self, drive: &str, night: &str) -> bool {
        let table = self.table.lock().unwrap_or_else(PoisonError::into_inner);
        table.as_ref().is_some_and(|table| table.has(drive, night))
    }

    /// Adds the rows of parts; gives how many nights ended how.
    fn append(&self, py: Python<'_>, parts: Vec<Vec<u8>>) -> PyResult<BTreeMap<&'static str, usize>> {
        let mut rows = Vec::new();
        for part in parts {
            rows.extend(of_parquet("what a worker sent", part).map_err(Refused::of).or_raise(py)?);
        }
        let mut table = self.table.lock().unwrap_or_else(PoisonError::into_inner);
        let open = table.as_mut().ok_or_else(|| Refused::of("the table is closed")).or_raise(py)?;
        open.append(&rows).map_err(Refused::of).or_raise(py)?;
        let mut tally = Tally::default();
        tally.add(&rows);
        Ok(named(&tally))
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_error))]
    fn __exit__(&self, _error: &Bound<'_, PyTuple>) {
        self.close();
    }

    /// Lets others write to it.
    fn close(&self) {
        *self.table.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

/// Judges every night that the table does not have yet; gives how many ended how.
#[pyfunction]
pub(crate) fn fleet(
    py: Python<'_>,
    dataset: PathBuf,
    out: PathBuf,
    asked: Asked,
    threads: Option<usize>,
) -> PyResult<BTreeMap<&'static str, usize>> {
    let how = how(asked).or_raise(py)?;
    unlocked(py, threads, || {
        let tally = Mutex::new(Tally::default());
        let told = |rows: &[Row]| tally.lock().unwrap_or_else(PoisonError::into_inner).add(rows);
        let pending = Pending::of(&dataset, &out).map_err(Refused::of)?;
        pending.run(&how, &told).map_err(Refused::of)?;
        Ok(named(&tally.into_inner().unwrap_or_else(PoisonError::into_inner)))
    })
}
