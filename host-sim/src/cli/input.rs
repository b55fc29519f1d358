//! Arguments that several commands share, and the values that they become.

use std::path::{Path, PathBuf};

use diagnosis::agreement::{Doubt, doubts as doubts_of};
use diagnosis::base_parameters;
use identification::compare::judged::judged_by;
use identification::fit::FitError;
use machine_file::MachineFile;
use model_core::machine::Tick;
use recording::{ChannelMap, Recording, Signal};
use report::wording::doubt;
pub(crate) use report::wording::{notes, own_notes, unit_notes};
use simulation::Arithmetic;

use super::console::{Console, Progress};
use super::error::CliError;

/// The drive, how its recordings are to be read, and how it is computed.
#[derive(Clone, Debug, clap::Args)]
pub struct MachineArguments {
    /// Machine file of the drive (TOML, SI units)
    #[arg(long, value_name = "M.toml")]
    pub machine: PathBuf,
    /// The rest.
    #[command(flatten)]
    pub model: ModelArguments,
}

/// How recordings are to be read, and how a drive is computed.
#[derive(Clone, Debug, clap::Args)]
pub struct ModelArguments {
    /// Column of a signal, where its header does not say; may be repeated
    #[arg(long = "map", value_name = "name=header")]
    pub maps: Vec<String>,
    /// Number type of the simulation; fixed is what the controller computes
    #[arg(long, value_enum, default_value_t)]
    pub arithmetic: ArithmeticArgument,
    /// Step of the model in ms
    ///
    /// Without it 1, or 0.5 for recordings faster than that, or 2 below 50 Hz
    #[arg(long, value_enum, value_name = "ms")]
    pub tick: Option<TickArgument>,
}

/// The number type of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum ArithmeticArgument {
    /// What the controller computes
    #[default]
    Fixed,
    /// f64
    Float,
}

impl From<ArithmeticArgument> for Arithmetic {
    fn from(argument: ArithmeticArgument) -> Self {
        match argument {
            ArithmeticArgument::Fixed => Arithmetic::Fixed,
            ArithmeticArgument::Float => Arithmetic::Float,
        }
    }
}

/// Step of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum TickArgument {
    /// 0.5 ms
    #[value(name = "0.5")]
    Half,
    /// 1 ms
    #[value(name = "1")]
    One,
    /// 2 ms
    #[value(name = "2")]
    Two,
}

impl From<TickArgument> for Tick {
    fn from(argument: TickArgument) -> Self {
        match argument {
            TickArgument::Half => Tick::HalfMillisecond,
            TickArgument::One => Tick::OneMillisecond,
            TickArgument::Two => Tick::TwoMilliseconds,
        }
    }
}

impl MachineArguments {
    /// The machine file, and which columns hold which signals.
    pub fn read(&self) -> Result<(MachineFile, ChannelMap), CliError> {
        self.model.read(&self.machine)
    }
}

impl ModelArguments {
    /// A machine file, and which columns hold which signals: the command line takes precedence over the machine file.
    pub fn read(&self, machine: &Path) -> Result<(MachineFile, ChannelMap), CliError> {
        let maps = ChannelMap::from_arguments(self.maps.iter().map(String::as_str))?;
        let file = machine_file::read(machine)?;
        let channels = file.channels.clone().overlaid_with(&maps);
        Ok((file, channels))
    }

    /// The step that was asked for.
    #[must_use]
    pub fn tick(&self) -> Option<Tick> {
        self.tick.map(Tick::from)
    }
}

/// The recordings of files.
pub(crate) fn recordings(
    paths: &[PathBuf],
    channels: &ChannelMap,
    console: &Console<'_>,
) -> Result<Vec<Recording>, CliError> {
    let bar = bar(paths, console, "reading");
    let read = |path: &PathBuf| Ok(recording::read_through(path, channels, |file| bar.counting(file))?);
    let found = paths.iter().map(read).collect();
    bar.finish_and_clear();
    found
}

/// Checks the share of a healthy drive's recordings that may leave its band by chance.
pub(crate) fn check_false_alarms(found: f64) -> Result<(), CliError> {
    let (argument, expected) = ("--false-alarms", "a share between 0 and 1, such as 0.001");
    if found > 0.0 && found < 1.0 { Ok(()) } else { Err(CliError::Number { argument, found, expected }) }
}

/// A bar over the bytes of the files while they are read.
pub(crate) fn bar(paths: &[PathBuf], console: &Console<'_>, doing: &'static str) -> Progress {
    let bytes = paths.iter().filter_map(|path| path.metadata().ok()).map(|file| file.len()).sum();
    // The length of a pipe is unknown.
    if bytes > 0 { console.share(bytes, doing) } else { console.working(doing) }
}

/// The recording of a file.
pub(crate) fn recording(path: &Path, channels: &ChannelMap, console: &Console<'_>) -> Result<Recording, CliError> {
    let mut found = recordings(&[path.to_owned()], channels, console)?;
    Ok(found.swap_remove(0))
}

/// A recording limited to the signals that `--judge` names; whole where it names none.
pub(crate) fn judged(recording: Recording, file: &MachineFile, wanted: &[Signal]) -> Result<Recording, CliError> {
    Ok(judged_by(recording, file.machine.source, file.load_source, wanted)?)
}

/// What is doubtful about recordings for this drive. What is certainly wrong is an error, unless the recordings are to be taken as they are.
pub(crate) fn doubts<'a>(
    machine: &Path,
    file: &MachineFile,
    recordings: impl IntoIterator<Item = &'a Recording>,
    as_recorded: bool,
) -> Result<Vec<Doubt>, CliError> {
    let failed = |cause: FitError| CliError::Diagnose { machine: machine.to_owned(), cause: Box::new(cause.into()) };
    let found = doubts_of(file, &base_parameters(file), &recordings.into_iter().collect::<Vec<_>>()).map_err(failed)?;
    let certain: Vec<String> = found.iter().filter(|doubt| doubt.is_certain).map(doubt).collect();
    if certain.is_empty() || as_recorded {
        return Ok(found);
    }
    Err(CliError::Disagrees { machine: machine.to_owned(), doubts: certain.join("; ") })
}
