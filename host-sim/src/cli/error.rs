//! Why a command could not be done.

mod shown;

use std::io;
use std::path::PathBuf;

use diagnosis::DiagnoseError;
use experiment::plan::PlanError;
use experiment::sensor::SensorError;
use identification::compare::CompareError;
use identification::compare::judged::JudgeError;
use identification::static_curve::StaticsError;
use machine_file::MachineFileError;
use machine_file::data_sheet::SheetError;
use model_core::machine::{MachineError, Source};
use model_export::fmu::{FmuError, LibraryError};
use recording::excitation::text::ExcitationError;
use recording::files::atomic;
use recording::{MapError, RecordingError};
use simulation::SimulateError;
use watch::WatchError;

use crate::frames::ImportError;
use crate::played::PlayedError;

#[cfg(feature = "virtual-plant")]
use crate::paper::PaperError;
#[cfg(feature = "virtual-plant")]
use virtual_plant::{LinkageError, PlantError};

/// Why a command could not be done.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// The machine file.
    #[error(transparent)]
    MachineFile(#[from] MachineFileError),
    /// A recording, or the writing of one.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A recording without a known column, and what its columns may hold, as a block of a machine file.
    #[error("{cause}")]
    NothingKnown {
        /// Why it cannot be read.
        cause: Box<RecordingError>,
        /// The block.
        guess: String,
    },
    /// A static recording.
    #[error(transparent)]
    Statics(#[from] StaticsError),
    /// What `--judge` asks for.
    #[error("--judge: {0}")]
    Judge(#[from] JudgeError),
    /// An argument of `--map`.
    #[error("--map: {0}")]
    Map(#[from] MapError),
    /// An excitation given as text.
    #[error(transparent)]
    Excitation(#[from] ExcitationError),
    /// The machine and the recording do not make a simulation.
    #[error("{machine}: {cause}")]
    Simulate {
        /// The machine file.
        machine: PathBuf,
        /// Why.
        cause: SimulateError,
    },
    /// The machine and the recording do not make a comparison.
    #[error("{machine}: {cause}")]
    Compare {
        /// The machine file.
        machine: PathBuf,
        /// Why.
        cause: CompareError,
    },
    /// A folder that has to be empty and is not.
    #[cfg(feature = "virtual-plant")]
    #[error("{}: there is {} in it already; expected an empty folder, or one that is made there", folder.display(), found.display())]
    NotEmpty {
        /// The folder.
        folder: PathBuf,
        /// What is in it.
        found: std::ffi::OsString,
    },
    /// The nights of many drives, or the table of them.
    #[cfg(feature = "fleet")]
    #[error(transparent)]
    Fleet(#[from] fleet::FleetError),
    /// An argument of `--limit`.
    #[cfg(feature = "fleet")]
    #[error("--limit: {0}")]
    Limit(#[from] trend::LimitError),
    /// A table that says nothing of wear.
    #[cfg(feature = "fleet")]
    #[error("{}: {cause}", table.display())]
    Trend {
        /// The table.
        table: PathBuf,
        /// Why.
        cause: trend::WearError,
    },
    /// The machine and the recordings cannot be watched.
    #[error("{machine}: {cause}{}", if matches!(**cause, WatchError::NoBand) { "; expected one, or --healthy with recordings of the healthy drive" } else { "" })]
    Watch {
        /// The machine file.
        machine: PathBuf,
        /// Why.
        cause: Box<WatchError>,
    },
    /// The drive does not fit the controller.
    #[error("{machine}: {cause}")]
    Export {
        /// The machine file.
        machine: PathBuf,
        /// Why.
        cause: MachineError,
    },
    /// The drive does not become an FMU.
    #[error("{machine}: {cause}")]
    Fmu {
        /// The machine file.
        machine: PathBuf,
        /// Why.
        cause: Box<FmuError>,
    },
    /// The library that an FMU needs.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// A file whose name does not say what to export.
    #[error("{}: its name does not say what it is; expected one that ends in .rs, .h or .fmu, or --format", path.display())]
    ExportFormat {
        /// The file.
        path: PathBuf,
    },
    /// A file to write whose ending belongs to another format than the one that is written.
    #[error("{}: {what} does not match the file name's ending; expected one that ends in {known}", path.display())]
    Ending {
        /// The option.
        option: &'static str,
        /// The file.
        path: PathBuf,
        /// What is written.
        what: &'static str,
        /// The endings of the written format.
        known: String,
    },
    /// Standard output in place of a file that cannot go there.
    #[error("{option} -: standard output is already used for the command's text; expected the name of a file")]
    Dash {
        /// The option.
        option: &'static str,
    },
    /// Standard output for a binary file.
    #[error("{option} -: an FMU is a binary file; expected the name of a file that ends in .fmu")]
    NoText {
        /// The option.
        option: &'static str,
    },
    /// An argument that is used for an FMU only.
    #[error("{argument}: only an FMU has it; expected --out with .fmu, or --format fmu")]
    OnlyInFmu {
        /// The argument.
        argument: &'static str,
    },
    /// An argument that is used for source only.
    #[error("{argument}: only Rust and C have it; expected --out with .rs or .h, or --format rust or c99")]
    OnlyInSource {
        /// The argument.
        argument: &'static str,
    },
    /// An argument that is used for a baked drive only.
    #[error("{argument}: only a baked drive has it; expected --bake")]
    OnlyBaked {
        /// The argument.
        argument: &'static str,
    },
    /// A number type that the library for C does not have.
    #[error("{argument} f32: the library for C has fixed point alone; expected --out with .rs, or {argument} fixed")]
    OnlyFixed {
        /// The argument.
        argument: &'static str,
    },
    /// A file that cannot be read.
    #[error("{}: cannot be read: {cause}; expected a readable file", path.display())]
    Unread {
        /// The file.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
    /// What the firmware streamed out cannot be read as a recording.
    #[error("{}: {cause}", frames.display())]
    Import {
        /// The captured bytes.
        frames: PathBuf,
        /// Why.
        cause: ImportError,
    },
    /// The recordings do not make a diagnosis or a fit.
    #[error("{machine}: {cause}")]
    Diagnose {
        /// The machine file.
        machine: PathBuf,
        /// Why.
        cause: Box<DiagnoseError>,
    },
    /// The search of the recordings of then did not come to its end.
    #[error(
        "{machine}: the search of the recordings of then reached its limit, so it is not known what was there then; expected one that ends by itself: give it longer by --time-limit"
    )]
    ThenUnfinished {
        /// The machine file.
        machine: PathBuf,
    },
    /// The recordings can hardly be those of the machine file's drive.
    #[error(
        "the recordings do not fit {machine}: {doubts}; expected recordings of this drive: mend the channel (a sensor's `zero` and `full` in [channels] turn and scale it) or the machine file, or give --as-recorded"
    )]
    Disagrees {
        /// The machine file.
        machine: PathBuf,
        /// What is certainly wrong.
        doubts: String,
    },
    /// `--since` with what does not say one time.
    #[error(
        "--since: found {found}; expected {}", if *is_now { "a FOLDER or --train with the recordings of now" } else {
        "the machine file of then, without --machine, or recordings of then beside --machine or a FOLDER" }
    )]
    Since {
        /// What was given.
        found: String,
        /// Whether what is missing is of now.
        is_now: bool,
    },
    /// A folder without training recordings.
    #[error("{}: no train-*.csv (.txt, .xlsx, .mat, .mf4, .parquet, .gz); expected machine.toml, train-*.csv and holdout-*.csv, or --machine, --train and --holdout", folder.display())]
    NothingToTrain {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder that cannot be listed.
    #[error("{}: cannot be read: {cause}; expected a folder with machine.toml, train-*.csv and holdout-*.csv", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
    /// A recording cannot be planned.
    #[error("{machine}: {cause}")]
    Plan {
        /// The machine file.
        machine: PathBuf,
        /// Why.
        cause: PlanError,
    },
    /// A plan that the firmware cannot play.
    #[error("{machine}: --firmware: {cause}")]
    Played {
        /// The machine file.
        machine: PathBuf,
        /// Why.
        cause: PlayedError,
    },
    /// A sensor given as text.
    #[error("--sensors: {0}")]
    Sensor(#[from] SensorError),
    /// A command of the virtual plant in a program without it.
    #[cfg(not(feature = "virtual-plant"))]
    #[error(
        "{command}: this program was built without the virtual plant; expected one built by `cargo build --release --features virtual-plant`"
    )]
    WithoutPlant {
        /// The command.
        command: &'static str,
    },
    /// The page of the studio in a program without it.
    #[cfg(not(feature = "studio"))]
    #[error(
        "studio: this program was built without the studio; expected one built by `cargo build --release --features studio` (needs \
         `rustup target add wasm32-unknown-unknown`), or studio.html from a release"
    )]
    WithoutStudio,
    /// The paper's experiment.
    #[cfg(feature = "virtual-plant")]
    #[error(transparent)]
    Paper(#[from] PaperError),
    /// The virtual drive.
    #[cfg(feature = "virtual-plant")]
    #[error("{excitation}: {cause}")]
    Plant {
        /// What it was excited with.
        excitation: String,
        /// Why.
        cause: PlantError,
    },
    /// The encoder's linkage.
    #[cfg(feature = "virtual-plant")]
    #[error("{machine}: {cause}; --position-step measures at the rod instead")]
    Linkage {
        /// The machine file.
        machine: PathBuf,
        /// Why.
        cause: LinkageError,
    },
    /// The rod of the virtual drive leaves its cylinder.
    #[error(
        "{excitation}: the rod goes from {low_mm:.1} to {high_mm:.1} mm; expected it to stay within 0 to {stroke_mm:.1} mm: \
         excite it less, or shorter"
    )]
    LeavesStroke {
        /// What it was excited with.
        excitation: String,
        /// Lowest position, mm.
        low_mm: f64,
        /// Highest position, mm.
        high_mm: f64,
        /// Stroke, mm.
        stroke_mm: f64,
    },
    /// A command in volts for a drive that has none.
    #[error(
        "{machine}: a {} moves the drive; expected a [valve], which is what {what} commands", .source_of_drive.name()
    )]
    NeedsValve {
        /// The machine file.
        machine: PathBuf,
        /// What it has.
        source_of_drive: Source,
        /// The argument or command.
        what: &'static str,
    },
    /// An `--effect` that the test bed does not have.
    #[error(
        "--effect {argument}: no effect of the test bed with its strength; expected one of {known}, then `=` and a number, such as coulomb-friction=800"
    )]
    Effect {
        /// The argument.
        argument: String,
        /// The names with their units.
        known: String,
    },
    /// A name that the test bed cannot draw.
    #[error("--only {found}: no effect of the test bed; expected one of {known}")]
    EffectName {
        /// The name.
        found: String,
        /// The names there are.
        known: String,
    },
    /// A number among the arguments that makes no sense.
    #[error("{argument} is {found}; expected {expected}")]
    Number {
        /// The argument.
        argument: &'static str,
        /// Its value.
        found: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// The folder holds recordings that this run would not replace.
    #[error("{} is there already and would be taken for one of this run's; expected a folder without other train-*.csv or holdout-*.csv", path.display())]
    OtherRecording {
        /// The recording.
        path: PathBuf,
    },
    /// A file or folder that cannot be written.
    #[error("{}: cannot be written: {cause}; expected {}", path.display(), atomic::expected(cause))]
    Write {
        /// Where to.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
    /// A file to write that is also one to read.
    #[error("{} would be written over {}, which is read; expected another name", target.display(), read.display())]
    Overwrites {
        /// Where to.
        target: PathBuf,
        /// What is read.
        read: PathBuf,
    },
    /// One file for two results.
    #[error("{first} and {second} both name {}; expected two files", path.display())]
    SameTarget {
        /// An option.
        first: &'static str,
        /// Another one.
        second: &'static str,
        /// The file.
        path: PathBuf,
    },
    /// The same recording in two places that need different recordings.
    #[error("{first} and {second} hold the same recording; expected {expected}")]
    SameRecording {
        /// A recording.
        first: String,
        /// Another one.
        second: String,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A file that exists, and no order to write over it.
    #[error("{} is there already; expected another name, or --force to write over it", path.display())]
    IsThere {
        /// The file.
        path: PathBuf,
    },
    /// The entries of a data sheet do not make a drive.
    #[error(transparent)]
    Sheet(#[from] SheetError),
    /// An answer cannot be read from the terminal.
    #[error("the terminal: cannot be read: {0}; expected an answer, or the flags of `host-sim init --help`")]
    Input(io::Error),
    /// Ctrl-C at a question.
    #[error("interrupted")]
    Interrupted,
    /// Standard output cannot be written.
    #[error("standard output: cannot be written: {0}; expected a reader, or a file with room for the text")]
    Output(io::Error),
}
