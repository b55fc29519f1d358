//! Errors as exceptions: the program's text, and the file, row and key that it is about.

use std::fmt::Display;

use ::recording::files::source_error::{Explained, printable, render};
use ::recording::{MapError, RecordingError};
use diagnosis::DiagnoseError;
use identification::compare::CompareError;
use machine_file::MachineFileError;
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

create_exception!(
    host_sim,
    Error,
    PyException,
    "What cannot be done, in the program's words.\n\nAttributes: `file` (the file, or the name of a recording in memory), `row` (the line of a text, or the row of a \
     table, from 1) and `key` (the column, or the key of a machine file); None where the error is about none."
);

/// Why a function of the module did not return a result.
#[derive(Debug)]
pub(crate) struct Refused {
    text: String,
    file: Option<String>,
    row: Option<usize>,
    key: Option<String>,
}

impl Refused {
    /// With what is wrong alone.
    pub(crate) fn of(text: impl Display) -> Self {
        Self { text: text.to_string(), file: None, row: None, key: None }
    }

    /// The same, about a file.
    pub(crate) fn in_file(self, file: &str) -> Self {
        Self { file: Some(file.to_owned()), ..self }
    }

    /// The same, about a key of a file.
    pub(crate) fn about(self, file: &str, key: &str) -> Self {
        Self { file: Some(file.to_owned()), key: Some(key.to_owned()), ..self }
    }

    /// With an argument that cannot be used.
    pub(crate) fn argument(key: &str, text: impl Display) -> Self {
        Self { key: Some(key.to_owned()), ..Self::of(format_args!("{key}: {text}")) }
    }

    /// With a machine and what it cannot be used for.
    pub(crate) fn machine(file: &str, cause: impl Display) -> Self {
        Self { file: Some(file.to_owned()), ..Self::of(format_args!("{file}: {cause}")) }
    }

    /// With a comparison that is not possible: the fault is the recording's where that says so.
    pub(crate) fn compare(file: &str, cause: CompareError) -> Self {
        match cause {
            CompareError::Recording(error) => error.into(),
            cause => Self::machine(file, cause),
        }
    }

    /// The same of a diagnosis or a fit.
    pub(crate) fn diagnose(file: &str, cause: DiagnoseError) -> Self {
        match cause {
            DiagnoseError::Recording(cause) => Self::compare(file, cause),
            cause => Self::machine(file, cause),
        }
    }

    fn explained(error: &impl Explained) -> Self {
        let place = error.place();
        let text = render(error);
        Self {
            text: text.strip_prefix("error: ").unwrap_or(&text).to_owned(),
            file: Some(place.file.to_string()),
            row: place.row().or(place.line()),
            key: error.key(),
        }
    }

    /// As an exception.
    pub(crate) fn raised(self, py: Python<'_>) -> PyErr {
        let error = Error::new_err(printable(&self.text));
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

impl From<RecordingError> for Refused {
    fn from(error: RecordingError) -> Self {
        Self::explained(&error)
    }
}

impl From<MachineFileError> for Refused {
    fn from(error: MachineFileError) -> Self {
        Self::explained(&error)
    }
}

impl From<MapError> for Refused {
    fn from(error: MapError) -> Self {
        Self::argument("map", error)
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
