//! The command line.

use std::io;
use std::process::ExitCode;

use clap::Parser;

use host_sim::cli::{self, Cli, CommandLine, Console};
use simulation::number::cpu;

fn main() -> ExitCode {
    if let Err(error) = cpu::check() {
        eprintln!("error: {error}");
        return ExitCode::from(2);
    }
    commanded()
}

/// A separate function, so that none of its instructions is executed before the check of the processor.
#[inline(never)]
fn commanded() -> ExitCode {
    let line = &CommandLine::of_process();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return cli::refuse(&error, line, &mut io::stderr()),
    };
    let mut out = io::stdout().lock();
    let console = &mut Console::of_process(&mut out, cli.volume());
    if let Err(cause) = cli::stop_cleanly() {
        console.note(format_args!("Ctrl-C may leave a temporary file behind: {cause}"));
    }
    let result = cli::run(&cli.command, console);
    cli::finish(result, line, &mut io::stderr())
}
