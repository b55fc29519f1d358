//! The files that were dropped on the page, and what a request takes of them.

use std::collections::BTreeMap;

use diagnosis::agreement::Doubt;
use machine_file::MachineFile;
use model_core::machine::Machine;
use recording::{ChannelMap, Recording, read_from};
use report::html::About;
use report::refused::{self, Refused};
use report::wording;
use serde::Deserialize;

/// The bytes of the recordings' files, by their names.
#[derive(Debug, Default)]
pub(crate) struct Desk {
    files: BTreeMap<String, Vec<u8>>,
}

/// A machine file as the page holds it.
#[derive(Debug, Deserialize)]
pub(crate) struct MachineText {
    name: String,
    text: String,
}

/// What a command is asked for.
#[derive(Debug, Deserialize)]
pub(crate) struct Request {
    pub(crate) machine: Option<MachineText>,
    /// Recordings to work on; of a diagnosis, those to train on.
    pub(crate) train: Vec<String>,
    /// Recordings that only confirm.
    #[serde(default)]
    pub(crate) holdout: Vec<String>,
    /// Columns mapped by hand: `position=Kolbenweg [mm]`.
    #[serde(default)]
    pub(crate) maps: Vec<String>,
    /// Headers of columns that are not to be used.
    #[serde(default)]
    pub(crate) unused: Vec<String>,
    #[serde(default)]
    pub(crate) as_recorded: bool,
    pub(crate) limit_s: Option<f64>,
    /// Date and time of the request, for the page that it makes: a worker has no clock of its own.
    #[serde(default)]
    pub(crate) made: Option<String>,
}

/// A drive and its name in messages.
#[derive(Debug)]
pub(crate) struct Drive {
    pub(crate) name: String,
    pub(crate) file: MachineFile,
}

impl Request {
    /// The drive, where there is a machine file.
    pub(crate) fn machine(&self) -> Result<Option<Drive>, Refused> {
        let read = |MachineText { name, text }: &MachineText| {
            Ok(Drive { name: name.clone(), file: machine_file::read_text(name, text)? })
        };
        self.machine.as_ref().map(read).transpose()
    }

    /// What a page says of how it was made.
    pub(crate) fn about(&self) -> About {
        let machine_files = self.machine.iter().map(|machine| machine.name.clone()).collect();
        About { written: self.made.clone(), command: None, machine_files }
    }

    /// The drive of a command that needs one.
    pub(crate) fn drive(&self) -> Result<Drive, Refused> {
        let missing = || Refused::of("there is no machine file; expected one, dropped or made from the data sheet");
        self.machine()?.ok_or_else(missing)
    }

    /// Which columns hold which signals: what is mapped by hand takes precedence over the machine file.
    pub(crate) fn channels(&self, drive: Option<&Drive>) -> Result<ChannelMap, Refused> {
        let maps = ChannelMap::from_arguments(self.maps.iter().map(String::as_str))?;
        let mut channels = drive.map(|drive| drive.file.channels.clone()).unwrap_or_default().overlaid_with(&maps);
        self.unused.iter().for_each(|header| channels.leave_unused(header));
        Ok(channels)
    }
}

impl Desk {
    pub(crate) fn put(&mut self, name: String, bytes: Vec<u8>) {
        self.files.insert(name, bytes);
    }

    pub(crate) fn remove(&mut self, name: &str) {
        self.files.remove(name);
    }

    /// The bytes of a file.
    pub(crate) fn bytes(&self, name: &str) -> Result<&[u8], Refused> {
        let absent =
            || Refused::machine(name, "is not among the files of the page; expected one that was dropped on it");
        self.files.get(name).map(Vec::as_slice).ok_or_else(absent)
    }

    /// The recordings of these files; at least one.
    pub(crate) fn recordings(&self, names: &[String], channels: &ChannelMap) -> Result<Vec<Recording>, Refused> {
        if names.is_empty() {
            return Err(Refused::of("there is no recording; expected at least one"));
        }
        self.any_recordings(names, channels)
    }

    /// The same; also none.
    pub(crate) fn any_recordings(&self, names: &[String], channels: &ChannelMap) -> Result<Vec<Recording>, Refused> {
        names.iter().map(|name| Ok(read_from(name, self.bytes(name)?, channels)?)).collect()
    }
}

/// What was noted as recordings were read, and doubts about their units, each with the recording's name.
pub(crate) fn notes(recordings: &[&Recording], values: &Machine<f64>) -> Vec<String> {
    recordings.iter().flat_map(|recording| wording::notes(recording, values)).collect()
}

/// What is doubtful about recordings for this drive. What is certainly wrong is an error, unless they are to be taken as they are.
pub(crate) fn checked_doubts(
    drive: &Drive,
    recordings: &[&Recording],
    as_recorded: bool,
) -> Result<Vec<Doubt>, Refused> {
    refused::checked_doubts((&drive.name, &drive.file), recordings, as_recorded, "take the recordings as they are")
}
