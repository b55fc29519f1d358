//! `host-sim export`: a drive as constants for the firmware.

use std::path::PathBuf;

use model_core::machine::Tick;

use super::input::TickArgument;
use super::target::{check_not_read, check_target};
use super::{CliError, Console, Outcome};
use crate::atomic;
use crate::export::Constants;
use crate::machine_file;

/// Arguments of `export`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  host-sim export --machine M.toml --out params.rs

Writes Rust source: name, source of oil, tick, length of the delay line, and every SI value that is not the default, with the
effects. The firmware builds its fixed-point coefficients from them by the code that builds them here; a drive that they
cannot hold is refused with the value that does not fit.")]
pub struct Arguments {
    /// Machine file of the drive (TOML, SI units)
    #[arg(long, value_name = "M.toml")]
    machine: PathBuf,
    /// Control period of the firmware in ms
    #[arg(long, value_enum, value_name = "ms", default_value = "1")]
    tick: TickArgument,
    /// Where to write the constants
    #[arg(long, value_name = "params.rs")]
    out: PathBuf,
}

pub(super) fn run(arguments: &Arguments, _: &mut Console<'_>) -> Result<Outcome, CliError> {
    check_target(&arguments.out)?;
    check_not_read(&arguments.out, std::slice::from_ref(&arguments.machine))?;
    let file = machine_file::read(&arguments.machine)?;
    let constants = Constants::of(&file.name, &file.machine, Tick::from(arguments.tick))
        .map_err(|cause| CliError::Export { machine: arguments.machine.clone(), cause })?;
    atomic::write(&arguments.out, |out| out.write_all(constants.rust().as_bytes()))
        .map_err(|cause| CliError::Write { path: arguments.out.clone(), cause })?;
    Ok(Outcome::Done)
}
