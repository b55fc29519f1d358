//! `host-sim completions`: what a shell needs to complete commands, options and their values.

use clap::CommandFactory;
use clap_complete::{Shell, generate};

use super::console::Console;
use super::error::CliError;
use super::{Cli, Outcome};

/// Arguments of `completions`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  source <(host-sim completions bash)
  host-sim completions zsh > ~/.zfunc/_host-sim
  host-sim completions fish > ~/.config/fish/completions/host-sim.fish
  host-sim completions powershell | Out-String | Invoke-Expression")]
pub struct Arguments {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    // Into memory first: a reader that closes the pipe early must not cause a panic.
    let mut script = Vec::new();
    generate(arguments.shell, &mut Cli::command(), "host-sim", &mut script);
    let mut script = String::from_utf8_lossy(&script).into_owned();
    if arguments.shell == Shell::Bash {
        // clap_complete cuts a name with a hyphen in two on one side of a comparison but not on the other (clap-rs/clap#6421).
        script = script.replace("host__subcmd__sim", "host__sim");
    }
    console.print(script.trim_end())?;
    Ok(Outcome::Done)
}
