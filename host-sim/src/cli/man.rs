//! `host-sim man`: manual pages, from the same source as the help.

use std::path::PathBuf;

use clap::{Command, CommandFactory};
use clap_mangen::Man;

use super::console::Console;
use super::error::CliError;
use super::target::{check_folder, make_folder, write};
use super::{Cli, Outcome};

/// Arguments of `man`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim man init | man -l -
  host-sim man --out ~/.local/share/man/man1")]
pub struct Arguments {
    /// Command whose page is printed; without it the program's
    #[arg(value_name = "COMMAND", conflicts_with = "out", value_parser = known)]
    command: Option<String>,
    /// Folder for a page of the program and one of each command, made where it is not there
    #[arg(long, value_name = "folder")]
    out: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let mut cli = Cli::command();
    cli.build();
    let Some(folder) = &arguments.out else {
        let asked = arguments.command.as_deref().and_then(|name| cli.find_subcommand(name));
        console.print(page(asked.unwrap_or(&cli)).1.trim_end())?;
        return Ok(Outcome::Done);
    };
    check_folder(folder)?;
    make_folder(folder)?;
    let mut pages = Vec::new();
    add(&cli, &mut pages);
    for (name, text) in &pages {
        let path = folder.join(name);
        write(&path, text)?;
        console.print(path.display())?;
    }
    Ok(Outcome::Done)
}

/// A command of the program.
fn known(name: &str) -> Result<String, String> {
    let names: Vec<String> = Cli::command().get_subcommands().map(|command| command.get_name().to_owned()).collect();
    if names.iter().any(|known| known == name) {
        Ok(name.to_owned())
    } else {
        Err(format!("`{name}` is no command; expected one of {}", names.join(", ")))
    }
}

/// The pages of a command and of its commands.
fn add(command: &Command, pages: &mut Vec<(String, String)>) {
    pages.push(page(command));
    for other in command.get_subcommands().filter(|command| command.get_name() != "help") {
        add(other, pages);
    }
}

/// A page's file name, and its text.
fn page(command: &Command) -> (String, String) {
    let man = Man::new(command.clone());
    let mut text = Vec::new();
    // Memory takes everything.
    let _ = man.render(&mut text);
    (man.get_filename(), String::from_utf8_lossy(&text).into_owned())
}
