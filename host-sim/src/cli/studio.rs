//! `host-sim studio`: the page that does in a browser what this program does.

use std::path::PathBuf;

use super::Outcome;
use super::console::Console;
use super::ending::PAGE;
use super::error::CliError;
use super::target::check_targets;

/// The page, which the build script has built.
#[cfg(feature = "studio")]
const STUDIO: &str = include_str!(env!("HOST_SIM_STUDIO_PAGE"));

/// Arguments of `studio`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  host-sim studio --out studio.html

One HTML file with this program in it, for a computer on which nothing may be installed: open it in a \
browser, drop recordings and a machine file on it, and diagnose. It needs no network, and nothing \
leaves the computer.")]
pub struct Arguments {
    /// Page to write
    #[arg(long, value_name = "S.html", default_value = "studio.html")]
    out: PathBuf,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    check_targets(&[("--out", Some(&arguments.out), PAGE)], &[])?;
    #[cfg(feature = "studio")]
    {
        super::target::write(&arguments.out, STUDIO.to_owned())?;
        console.print(arguments.out.display())?;
        Ok(Outcome::Done)
    }
    #[cfg(not(feature = "studio"))]
    {
        let _ = console;
        Err(CliError::WithoutStudio)
    }
}
