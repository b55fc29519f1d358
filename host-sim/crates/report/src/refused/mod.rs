//! Why something could not be done, for whoever asks by a function and not by a command line: the program's text, and the file, row and key that it is about.

mod recordings;

use std::fmt::Display;

use diagnosis::DiagnoseError;
use identification::compare::CompareError;
use machine_file::MachineFileError;
use machine_file::data_sheet::SheetError;
use recording::files::source_error::{Explained, printable, render};
use recording::{MapError, RecordingError};

pub use recordings::{check_distinct, check_held_out, checked_doubts};

/// Why something could not be done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    text: String,
    /// The file, or the name of a recording in memory.
    pub file: Option<String>,
    /// The line of a text, or the row of a table, from 1.
    pub row: Option<usize>,
    /// The column, the key of a machine file, or the argument.
    pub key: Option<String>,
}

impl Refused {
    /// With what is wrong alone.
    #[must_use]
    pub fn of(text: impl Display) -> Self {
        Self { text: text.to_string(), file: None, row: None, key: None }
    }

    /// The same, about a file.
    #[must_use]
    pub fn in_file(self, file: &str) -> Self {
        Self { file: Some(file.to_owned()), ..self }
    }

    /// The same, about a key of a file.
    #[must_use]
    pub fn about(self, file: &str, key: &str) -> Self {
        Self { key: Some(key.to_owned()), ..self.in_file(file) }
    }

    /// With an argument that cannot be used.
    #[must_use]
    pub fn argument(key: &str, text: impl Display) -> Self {
        Self { key: Some(key.to_owned()), ..Self::of(format_args!("{key}: {text}")) }
    }

    /// With a machine and what it cannot be used for.
    #[must_use]
    pub fn machine(file: &str, cause: impl Display) -> Self {
        Self::of(format_args!("{file}: {cause}")).in_file(file)
    }

    /// With a comparison that is not possible: the fault is the recording's where that says so.
    #[must_use]
    pub fn compare(file: &str, cause: CompareError) -> Self {
        match cause {
            CompareError::Recording(error) => error.into(),
            cause => Self::machine(file, cause),
        }
    }

    /// The same of a diagnosis or a fit.
    #[must_use]
    pub fn diagnose(file: &str, cause: DiagnoseError) -> Self {
        match cause {
            DiagnoseError::Recording(cause) => Self::compare(file, cause),
            cause => Self::machine(file, cause),
        }
    }

    /// With an error that shows its place in a file.
    #[must_use]
    pub fn explained(error: &impl Explained) -> Self {
        let place = error.place();
        let text = render(error);
        Self {
            text: text.strip_prefix("error: ").unwrap_or(&text).to_owned(),
            file: Some(place.file.to_string()),
            row: place.row().or(place.line()),
            key: error.key(),
        }
    }

    /// The text that the program prints, without control characters.
    #[must_use]
    pub fn text(&self) -> String {
        printable(&self.text)
    }
}

impl From<Refused> for String {
    fn from(refused: Refused) -> Self {
        refused.text()
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

impl From<SheetError> for Refused {
    fn from(error: SheetError) -> Self {
        Self::of(error)
    }
}

#[cfg(test)]
mod tests {
    use recording::{ChannelMap, read_from};

    use super::*;

    #[test]
    fn an_error_of_a_file_has_its_place_and_the_text_without_control_characters() {
        let text = b"time [s],position [mm]\n0,1\n0.1,a\x1bc\n0.2,3\n";
        let refused = Refused::from(read_from("run.csv", text.as_slice(), &ChannelMap::default()).unwrap_err());
        let found = (refused.file.as_deref(), refused.row, refused.key.as_deref());
        assert_eq!(found, (Some("run.csv"), Some(3), None));
        assert!(!refused.text().starts_with("error") && !refused.text().contains('\x1b'), "{}", refused.text());
        let map = Refused::from(ChannelMap::from_arguments(["position"]).unwrap_err());
        assert_eq!((map.file.as_deref(), map.key.as_deref()), (None, Some("map")));
    }

    #[test]
    fn the_fault_of_a_recording_is_the_recording_s() {
        let error = || read_from("run.csv", b"".as_slice(), &ChannelMap::default()).unwrap_err();
        let of = |refused: Refused| refused.file;
        let in_a_diagnosis = DiagnoseError::Recording(CompareError::Recording(error()));
        assert_eq!(of(Refused::diagnose("machine.toml", in_a_diagnosis)).as_deref(), Some("run.csv"));
        assert_eq!(of(Refused::diagnose("machine.toml", DiagnoseError::NoTraining)).as_deref(), Some("machine.toml"));
    }
}
