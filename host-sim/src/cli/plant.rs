//! The commands of the virtual plant, in a program that was built with it and in one that was not.

#[cfg(feature = "virtual-plant")]
pub(super) use super::paper::Arguments as PaperArguments;
#[cfg(feature = "virtual-plant")]
pub(crate) use super::paper::run as paper;
#[cfg(feature = "virtual-plant")]
pub(super) use super::testbed::Arguments as TestbedArguments;
#[cfg(feature = "virtual-plant")]
pub(crate) use super::testbed::run as testbed;
#[cfg(not(feature = "virtual-plant"))]
pub(super) use absent::{PaperArguments, TestbedArguments};
#[cfg(not(feature = "virtual-plant"))]
pub(crate) use absent::{paper, testbed};

#[cfg(not(feature = "virtual-plant"))]
mod absent {
    use std::ffi::OsString;

    use crate::cli::Outcome;
    use crate::cli::console::Console;
    use crate::cli::error::CliError;

    /// Whatever is asked of `paper`.
    #[derive(Clone, Debug, clap::Args)]
    #[command(after_help = "Example:
  cargo run --release --features virtual-plant -- paper

This program was built without the virtual plant.")]
    pub struct PaperArguments {
        /// Arguments of a program that has it
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
        arguments: Vec<OsString>,
    }

    /// Whatever is asked of `testbed`.
    #[derive(Clone, Debug, clap::Args)]
    #[command(after_help = "Example:
  cargo run --release --features virtual-plant -- testbed --help

This program was built without the virtual plant.")]
    pub struct TestbedArguments {
        /// Arguments of a program that has it
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
        arguments: Vec<OsString>,
    }

    pub(crate) fn paper(_: &PaperArguments, _: &mut Console<'_>) -> Result<Outcome, CliError> {
        Err(CliError::WithoutPlant { command: "paper" })
    }

    pub(crate) fn testbed(_: &TestbedArguments, _: &mut Console<'_>) -> Result<Outcome, CliError> {
        Err(CliError::WithoutPlant { command: "testbed" })
    }
}
