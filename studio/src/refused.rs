//! Errors as the texts that the program prints.

use std::fmt::Display;

use diagnosis::DiagnoseError;
use diagnosis::agreement::Doubt;
use identification::compare::CompareError;
use machine_file::MachineFileError;
use machine_file::data_sheet::SheetError;
use recording::files::source_error::{Explained, printable, render};
use recording::{MapError, RecordingError};

/// Why something could not be done, for people.
#[derive(Debug)]
pub(crate) struct Refused(String);

impl Refused {
    pub(crate) fn of(text: impl Display) -> Self {
        Self(text.to_string())
    }

    /// With a machine and what it cannot be used for.
    pub(crate) fn machine(file: &str, cause: impl Display) -> Self {
        Self(format!("{file}: {cause}"))
    }

    /// With a comparison that is not possible.
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

    /// With recordings that can hardly be those of the machine file's drive.
    pub(crate) fn disagrees<'a>(file: &str, doubts: impl Iterator<Item = &'a Doubt>) -> Self {
        let doubts: Vec<String> = doubts.map(report::wording::doubt).collect();
        Self(format!(
            "the recordings do not fit {file}: {}; expected recordings of this drive: mend the channel (a sensor's `zero` and `full` in [channels] \
             turn and scale it) or the machine file, or take the recordings as they are",
            doubts.join("; ")
        ))
    }

    /// With an error that shows its place in a file.
    pub(crate) fn explained(error: &impl Explained) -> Self {
        let text = render(error);
        Self(text.strip_prefix("error: ").unwrap_or(&text).to_owned())
    }
}

impl From<Refused> for String {
    fn from(refused: Refused) -> Self {
        printable(&refused.0)
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
        Self::of(error)
    }
}

impl From<SheetError> for Refused {
    fn from(error: SheetError) -> Self {
        Self::of(error)
    }
}
