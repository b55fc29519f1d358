//! What the library of an FMU reads: the drive as a machine file, and the settings of its computation.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use fmi_schema::Error as SchemaError;
use zip::result::ZipError;

use machine_file::{MachineFile, MachineFileError};
use model_core::drive::Drive;
use model_core::machine::{Machine, MachineError, Tick};
use model_core::number::PerUnit;
use simulation::{Arithmetic, DELAY_LINE, Inputs};

/// The drive's machine file among the resources of an FMU.
pub(crate) const MACHINE: &str = "machine.toml";
/// The settings of the computation among the resources of an FMU.
pub(crate) const SETTINGS: &str = "settings.json";
/// Largest settings file, in bytes.
const MAX_SETTINGS_BYTES: u64 = 4096;

/// How a drive is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Step of the model.
    pub tick: Tick,
    /// Number type.
    pub arithmetic: Arithmetic,
}

/// A drive in an FMU.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// What the drive is called.
    pub name: String,
    /// The drive.
    pub machine: Machine<f64>,
    /// How it is computed.
    pub settings: Settings,
}

/// Why the resources of an FMU hold no drive.
#[derive(Debug, thiserror::Error)]
pub enum ContentsError {
    /// The machine file.
    #[error(transparent)]
    Machine(#[from] MachineFileError),
    /// The settings cannot be read.
    #[error("{}: cannot be read: {cause}; expected a readable file", path.display())]
    Unread {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        cause: io::Error,
    },
    /// The settings are not valid.
    #[error("{}: {cause}; expected a tick and an arithmetic, as host-sim export writes them", path.display())]
    Settings {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        cause: serde_json::Error,
    },
}

/// Why a drive cannot be made into an FMU.
#[derive(Debug, thiserror::Error)]
pub enum FmuError {
    /// The number type cannot represent the drive at this tick.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// Its machine file could not be read back.
    #[error(transparent)]
    MachineFile(#[from] MachineFileError),
    /// Its settings cannot be written.
    #[error("the settings: {0}")]
    Settings(#[from] serde_json::Error),
    /// Its variables cannot be described.
    #[error("the model description: {0}")]
    Description(#[from] SchemaError),
    /// The archive cannot be made.
    #[error("the archive: {0}")]
    Archive(#[from] ZipError),
    /// The archive cannot be filled.
    #[error("the archive: {0}")]
    Unwritten(#[from] io::Error),
}

impl Contents {
    /// A drive, after checking that its number type can represent it.
    ///
    /// # Errors
    /// The number type cannot represent the drive at this tick; the error names the value that does not fit.
    pub fn of(name: &str, machine: &Machine<f64>, settings: Settings) -> Result<Self, MachineError> {
        match settings.arithmetic {
            Arithmetic::Fixed => drop(Drive::<PerUnit>::new::<DELAY_LINE>(machine, settings.tick)?),
            Arithmetic::Float => drop(Drive::<f64>::new::<DELAY_LINE>(machine, settings.tick)?),
        }
        Ok(Self { name: name.to_owned(), machine: *machine, settings })
    }

    /// The drive in an FMU's resources.
    ///
    /// # Errors
    /// A file is missing, too large, or not what [`pack`](super::archive::pack) wrote there.
    pub fn read(resources: &Path) -> Result<Self, ContentsError> {
        let file = machine_file::read(&resources.join(MACHINE))?;
        let path = resources.join(SETTINGS);
        let mut bytes = Vec::new();
        let read = File::open(&path).and_then(|file| file.take(MAX_SETTINGS_BYTES).read_to_end(&mut bytes));
        if let Err(cause) = read {
            return Err(ContentsError::Unread { path, cause });
        }
        match serde_json::from_slice(&bytes) {
            Ok(settings) => Ok(Self { name: file.name, machine: file.machine, settings }),
            Err(cause) => Err(ContentsError::Settings { path, cause }),
        }
    }

    /// The resources as files: names and bytes.
    pub(crate) fn resources(&self) -> Result<[(&'static str, Vec<u8>); 2], FmuError> {
        let machine = MachineFile::from_machine(&self.name, self.machine).to_text(MACHINE)?;
        let mut settings = serde_json::to_vec(&self.settings)?;
        settings.push(b'\n');
        Ok([(MACHINE, machine.into_bytes()), (SETTINGS, settings)])
    }

    /// The inputs before a tool sets any: all zero, except the oil temperature, which is the one that the machine's values are for.
    #[must_use]
    pub fn inputs_at_start(&self) -> Inputs {
        super::variable::inputs_at_start(&self.machine)
    }
}

#[cfg(test)]
mod tests {
    use model_core::machine::Parameter;
    use test_press::press;

    use super::*;

    fn leaking() -> Contents {
        let machine = press(&[(Parameter::InternalLeakage, 1.0 / 3e11), (Parameter::TransportDelay, 0.0071)]);
        let settings = Settings { tick: Tick::HalfMillisecond, arithmetic: Arithmetic::Float };
        Contents::of("press \"63-40\"", &machine, settings).unwrap()
    }

    fn written(contents: &Contents) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in contents.resources().unwrap() {
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        folder
    }

    #[test]
    fn resources_read_back_to_the_last_bit() {
        let folder = written(&leaking());
        assert_eq!(Contents::read(folder.path()).unwrap(), leaking());
    }

    #[test]
    fn a_drive_that_the_fixed_point_does_not_hold_may_still_go_by_float() {
        let machine = press(&[(Parameter::MovingMass, 0.01), (Parameter::ViscousFriction, 0.0)]);
        let by = |arithmetic| Contents::of("light", &machine, Settings { tick: Tick::OneMillisecond, arithmetic });
        assert!(by(Arithmetic::Fixed).unwrap_err().to_string().starts_with("cylinder.moving_mass_kg = 0.01 kg"));
        by(Arithmetic::Float).unwrap();
    }

    #[test]
    fn other_settings_are_refused_with_their_place() {
        let folder = written(&leaking());
        std::fs::write(folder.path().join(SETTINGS), "{\"tick\": \"OneMillisecond\"}").unwrap();
        let refused = Contents::read(folder.path()).unwrap_err().to_string();
        assert!(refused.contains("settings.json: missing field `arithmetic`"), "{refused}");
        std::fs::remove_file(folder.path().join(SETTINGS)).unwrap();
        assert!(Contents::read(folder.path()).unwrap_err().to_string().contains("settings.json: cannot be read"));
    }
}
