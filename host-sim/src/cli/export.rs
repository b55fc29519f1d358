//! `host-sim export`: a drive as constants for the firmware, or as an FMU for other tools.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use clap::builder::PossibleValue;
use machine_file::MachineFile;
use model_core::machine::{MachineError, Tick};
use model_core::number::{PerUnit, Single};
use model_export::fmu::{self, Contents, Library, Settings, Version};
use model_export::rust::Constants;
use serde_json::{Value, json};

use super::Outcome;
use super::console::Console;
use super::ending::{ANY, DOCUMENT, is_standard_output};
use super::error::CliError;
use super::input::{ArithmeticArgument, TickArgument};
use super::target::{
    check_apart, check_not_read, check_one_output, check_target, check_targets, tell, write, write_or_print,
};

/// Arguments of `export`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim export --machine M.toml --out params.rs
  host-sim export --machine M.toml --bake --number f32 --out params.rs
  host-sim export --machine M.toml --bake --out drive.h
  host-sim export --machine M.toml --out drive.fmu
  host-sim export --machine M.toml --fmi 2.0 --out drive.fmu

Constants: SI values, from which the firmware builds its coefficients by the code that builds them \
here. With --bake the coefficients are constants of the Rust source too: the controller computes none, \
and its program holds only the effects that the drive has; in C99 it is the header of the static \
library that `cargo build --release -p drive-c` makes from that source. A drive that the coefficients \
cannot hold is refused with the value that does not fit.
FMU: the model for co-simulation by FMI 3.0 or 2.0, with the library that \
`cargo build --release -p drive-fmu` has put beside this program.")]
pub struct Arguments {
    /// Machine file of the drive (TOML, SI units)
    #[arg(long, value_name = "M.toml")]
    machine: PathBuf,
    /// Control period of the firmware, step of the FMU's model, in ms
    #[arg(long, value_enum, value_name = "ms", default_value = "1")]
    tick: TickArgument,
    /// Where to write: .rs is Rust, .h C99, .fmu an FMU; - is standard output
    ///
    /// Standard output needs --format
    #[arg(long, value_name = "params.rs")]
    out: PathBuf,
    /// What to write, whatever the file is called
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Rust: with the coefficients as constants; C99: the header of the library of such a drive
    #[arg(long)]
    bake: bool,
    /// Number type of a baked drive; fixed without it
    ///
    /// f32 is for a controller with an FPU, in Rust alone
    #[arg(long, value_enum)]
    number: Option<NumberArgument>,
    /// Number type of an FMU; fixed without it
    ///
    /// Fixed is what the controller computes
    #[arg(long, value_enum)]
    arithmetic: Option<ArithmeticArgument>,
    /// Version of the standard that an FMU follows; 3.0 without it
    ///
    /// 2.0 is for tools that do not read 3.0
    #[arg(long, value_enum, value_name = "version")]
    fmi: Option<FmiArgument>,
    /// Shared library to put into an FMU, in place of the one beside this program
    #[arg(long, value_name = "library")]
    library: Option<PathBuf>,
    /// Write what was exported for programs; `-` prints it in place of the text
    #[arg(long, value_name = "E.json")]
    json: Option<PathBuf>,
}

/// The number type of a baked drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum NumberArgument {
    /// Fixed point, for any controller
    #[default]
    Fixed,
    /// Single precision, for a controller with an FPU
    F32,
}

/// The version of the standard that an FMU follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum FmiArgument {
    /// FMI 2.0
    #[value(name = "2.0", alias = "2")]
    Two,
    /// FMI 3.0
    #[default]
    #[value(name = "3.0", alias = "3")]
    Three,
}

impl From<FmiArgument> for Version {
    fn from(argument: FmiArgument) -> Self {
        match argument {
            FmiArgument::Two => Version::Two,
            FmiArgument::Three => Version::Three,
        }
    }
}

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// Constants as Rust source
    Rust,
    /// Constants as a C99 header
    C99,
    /// The model for co-simulation
    Fmu,
}

impl Format {
    /// The format of a file with this name.
    fn of(path: &Path) -> Result<Self, CliError> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("rs") => Ok(Format::Rust),
            Some("h") => Ok(Format::C99),
            Some("fmu") => Ok(Format::Fmu),
            _ => Err(CliError::ExportFormat { path: path.to_owned() }),
        }
    }
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let format = arguments.format.map_or_else(|| Format::of(&arguments.out), Ok)?;
    if format != Format::Fmu {
        let given = [
            ("--arithmetic", arguments.arithmetic.is_some()),
            ("--fmi", arguments.fmi.is_some()),
            ("--library", arguments.library.is_some()),
        ];
        if let Some(&(argument, _)) = given.iter().find(|(_, given)| *given) {
            return Err(CliError::OnlyInFmu { argument });
        }
    }
    if arguments.bake && format == Format::Fmu {
        return Err(CliError::OnlyInSource { argument: "--bake" });
    }
    if arguments.number.is_some() && !arguments.bake {
        return Err(CliError::OnlyBaked { argument: "--number" });
    }
    if arguments.number == Some(NumberArgument::F32) && format == Format::C99 {
        return Err(CliError::OnlyFixed { argument: "--number" });
    }
    check_one_output(&arguments.out, arguments.json.as_deref())?;
    let read: Vec<PathBuf> = [&arguments.machine].into_iter().chain(&arguments.library).cloned().collect();
    let document = ("--json", arguments.json.as_deref(), DOCUMENT);
    check_targets(&[document], &read)?;
    let to_console = is_standard_output(&arguments.out);
    if to_console && format == Format::Fmu {
        return Err(CliError::NoText { option: "--out" });
    }
    if !to_console {
        check_target(&arguments.out)?;
        check_apart(&[document, ("--out", Some(arguments.out.as_path()), ANY)])?;
        check_not_read(&arguments.out, &read)?;
    }
    let file = machine_file::read(&arguments.machine)?;
    match format {
        Format::Rust if arguments.bake => write_or_print(&arguments.out, &baked(arguments, &file)?, console)?,
        Format::Rust => write_or_print(&arguments.out, &constants(arguments, &file)?.rust(), console)?,
        Format::C99 if arguments.bake => write_or_print(&arguments.out, &c_header(arguments, &file)?, console)?,
        Format::C99 => write_or_print(&arguments.out, &constants(arguments, &file)?.c99(), console)?,
        Format::Fmu => write(&arguments.out, packed(arguments, &file)?)?,
    }
    tell(arguments.json.as_deref(), || document_of(arguments, format, &file), console)?;
    Ok(Outcome::Done)
}

/// What was exported, for programs.
fn document_of(arguments: &Arguments, format: Format, file: &MachineFile) -> Value {
    let name = |value: &dyn Fn() -> Option<PossibleValue>| value().map(|value| value.get_name().to_owned());
    let number = arguments.bake.then(|| arguments.number.unwrap_or_default());
    let arithmetic = (format == Format::Fmu).then(|| arguments.arithmetic.unwrap_or_default());
    let fmi = (format == Format::Fmu).then(|| arguments.fmi.unwrap_or_default());
    json!({
        "schema": "host-sim/export/1",
        "machine": file.name,
        "out": arguments.out.display().to_string(),
        "format": name(&|| format.to_possible_value()),
        "tick_ms": 1e3 * Tick::from(arguments.tick).seconds(),
        "baked": arguments.bake,
        "number": name(&|| number?.to_possible_value()),
        "arithmetic": name(&|| arithmetic?.to_possible_value()),
        "fmi": name(&|| fmi?.to_possible_value()),
    })
}

fn constants(arguments: &Arguments, file: &MachineFile) -> Result<Constants, CliError> {
    Constants::of(&file.name, &file.machine, Tick::from(arguments.tick)).map_err(|cause| refused(arguments, cause))
}

fn baked(arguments: &Arguments, file: &MachineFile) -> Result<String, CliError> {
    let constants = constants(arguments, file)?;
    let text = match arguments.number.unwrap_or_default() {
        NumberArgument::Fixed => constants.baked::<PerUnit>(),
        NumberArgument::F32 => constants.baked::<Single>(),
    };
    text.map_err(|cause| refused(arguments, cause))
}

fn c_header(arguments: &Arguments, file: &MachineFile) -> Result<String, CliError> {
    constants(arguments, file)?.c_header().map_err(|cause| refused(arguments, cause))
}

fn refused(arguments: &Arguments, cause: MachineError) -> CliError {
    CliError::Export { machine: arguments.machine.clone(), cause }
}

fn packed(arguments: &Arguments, file: &MachineFile) -> Result<Vec<u8>, CliError> {
    let settings =
        Settings { tick: Tick::from(arguments.tick), arithmetic: arguments.arithmetic.unwrap_or_default().into() };
    let refused = |cause| CliError::Fmu { machine: arguments.machine.clone(), cause: Box::new(cause) };
    let contents = Contents::of(&file.name, &file.machine, settings).map_err(|cause| refused(cause.into()))?;
    let library = if let Some(path) = &arguments.library {
        Library::read(path)?
    } else {
        let unread = |cause| CliError::Unread { path: PathBuf::from("this program"), cause };
        Library::beside(&std::env::current_exe().map_err(unread)?)?
    };
    fmu::pack(&contents, arguments.fmi.unwrap_or_default().into(), &library).map_err(refused)
}
