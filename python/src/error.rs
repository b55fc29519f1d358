//! Errors as exceptions: the program's text, and the file, row and key that it is about.

use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use report::refused::Refused;

create_exception!(
    host_sim,
    Error,
    PyException,
    "What cannot be done, in the program's words.\n\nAttributes: `file` (the file, or the name of a recording in memory), `row` (the line of a text, or the row of a \
     table, from 1) and `key` (the column, or the key of a machine file); None where the error is about none."
);

/// What becomes an exception.
pub(crate) trait Raised {
    fn raised(self, py: Python<'_>) -> PyErr;
}

impl Raised for Refused {
    fn raised(self, py: Python<'_>) -> PyErr {
        let error = Error::new_err(self.text());
        let value = error.value(py);
        let set = || {
            value.setattr("file", self.file)?;
            value.setattr("row", self.row)?;
            value.setattr("key", self.key)
        };
        match set() {
            Ok(()) => error,
            Err(other) => other,
        }
    }
}

/// A result with an exception in the place of its error.
pub(crate) trait OrRaise<T> {
    fn or_raise(self, py: Python<'_>) -> PyResult<T>;
}

impl<T, E: Into<Refused>> OrRaise<T> for Result<T, E> {
    fn or_raise(self, py: Python<'_>) -> PyResult<T> {
        self.map_err(|error| error.into().raised(py))
    }
}
