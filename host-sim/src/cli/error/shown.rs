//! How an error is shown: with the line of its file, or the part of the command line, that it refers to.

use std::io;
use std::path::Path;

use diagnosis::DiagnoseError;
use experiment::sensor::SensorError;
use identification::compare::CompareError;
use identification::compare::judged::JudgeError;
use identification::static_curve::StaticsError;
use recording::files::atomic;
use recording::files::source_error::{self, Explained};
use recording::{MapError, RecordingError};
use simulation::SimulateError;
use watch::WatchError;

use super::CliError;
use crate::cli::command_line::{CommandLine, Mistyped, Part, split};

impl CliError {
    /// The message as it is shown: with the line of the file that it refers to, where there is one.
    #[must_use]
    pub fn render(&self) -> String {
        fn shown(error: &impl Explained) -> String {
            source_error::render(error)
        }
        // The fault lies in the recording, not in the machine file.
        if let Some(too_long @ SimulateError::TooLong { .. }) = self.simulation() {
            return format!("error: {too_long}");
        }
        match self {
            CliError::MachineFile(error) => shown(error),
            CliError::Recording(error) | CliError::Statics(StaticsError::Recording(error)) => shown(error),
            CliError::NothingKnown { cause, guess } => {
                format!("{}\n\nFor the machine file, once checked:\n\n{}", shown(cause.as_ref()), guess.trim_end())
            }
            other => match other.comparison() {
                Some(CompareError::Recording(error)) => shown(error),
                _ => format!("error: {other}"),
            },
        }
    }

    /// The message as it is shown, with the part of the command line that it refers to, where there is one.
    #[must_use]
    pub fn render_on(&self, line: &CommandLine) -> String {
        let place = self.blamed().and_then(|(option, part)| line.place(option, part));
        let Some(place) = place else { return self.render() };
        let (found, expected) = match self {
            CliError::Recording(error) | CliError::Statics(StaticsError::Recording(error)) => {
                (format!("{}: {}", error.place(), error.found()), error.expected())
            }
            other => split(&other.to_string()),
        };
        source_error::render(&Mistyped { place, found, expected })
    }

    /// The option that caused the error, and the part of it; no option where it may be any of them.
    fn blamed(&self) -> Option<(Option<&str>, Part<'_>)> {
        let text = |option, text| Some((Some(option), Part::Text(text)));
        match self {
            CliError::Judge(JudgeError::NotJudgeable { signal, .. }) => text("--judge", signal.name()),
            CliError::Map(MapError::NoEqualsSign { argument } | MapError::NoHeader { argument }) => {
                text("--map", argument)
            }
            CliError::Map(MapError::UnknownSignal { name, .. }) => text("--map", name),
            CliError::Map(MapError::Twice { second, .. }) => text("--map", second),
            CliError::Excitation(error) => Some((Some("--input"), error.part().map_or(Part::Value, Part::Text))),
            CliError::ExportFormat { path } => text("--out", path.to_str()?),
            CliError::Ending { option, path, .. } => text(option, path.to_str()?),
            CliError::Dash { option } | CliError::NoText { option } => text(option, "-"),
            CliError::OnlyInFmu { argument }
            | CliError::OnlyInSource { argument }
            | CliError::OnlyBaked { argument } => Some((Some(argument), Part::Option)),
            CliError::OnlyFixed { argument } => text(argument, "f32"),
            CliError::Sensor(SensorError::Unknown { name, .. }) => text("--sensors", name),
            CliError::Sensor(SensorError::Noise { text: noise, .. }) => text("--sensors", noise),
            CliError::Effect { argument, .. } => text("--effect", argument),
            CliError::EffectName { found, .. } => text("--only", found),
            CliError::Number { argument, found, .. } => Some((Some(argument), Part::Number(*found))),
            CliError::Sheet(error) => Some((Some(error.flag()?), Part::Option)),
            CliError::Recording(RecordingError::MappedColumnAbsent { header, .. }) => text("--map", header),
            CliError::Statics(StaticsError::Recording(RecordingError::ColumnAbsent { header, .. })) => {
                Some((None, Part::Text(header)))
            }
            _ => None,
        }
    }

    /// Why a simulation was not possible, where this is the error.
    fn simulation(&self) -> Option<&SimulateError> {
        match (self, self.comparison()) {
            (CliError::Simulate { cause, .. }, _) | (_, Some(CompareError::Simulate(cause))) => Some(cause),
            _ => None,
        }
    }

    /// Why a recording could not be compared with a model, where this is the error.
    fn comparison(&self) -> Option<&CompareError> {
        match self {
            CliError::Compare { cause, .. } => Some(cause),
            CliError::Watch { cause, .. } => match cause.as_ref() {
                WatchError::Compare(cause) => Some(cause),
                _ => None,
            },
            CliError::Diagnose { cause, .. } => match &**cause {
                DiagnoseError::Recording(cause) => Some(cause),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether the reader of the output has closed it, as `head` does.
    #[must_use]
    pub fn is_closed_pipe(&self) -> bool {
        match self {
            CliError::Output(error) => error.kind() == io::ErrorKind::BrokenPipe,
            // A pipe that was named as a result has a reader that expects all of it: that stays an error.
            CliError::Write { path, cause } => {
                atomic::leads_to_standard_output(path) && cause.kind() == io::ErrorKind::BrokenPipe
            }
            CliError::Recording(RecordingError::Write { place, source }) => {
                atomic::leads_to_standard_output(Path::new(&*place.file)) && source.kind() == io::ErrorKind::BrokenPipe
            }
            _ => false,
        }
    }
}
