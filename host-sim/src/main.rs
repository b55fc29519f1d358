//! The command line.

use std::io;
use std::process::ExitCode;

use clap::Parser;
use host_sim::cli::{self, Cli, Console};

fn main() -> ExitCode {
    let cli = Cli::parse();
    let result = cli::run(&cli.command, &mut Console::of_process(&mut io::stdout().lock()));
    cli::finish(result, &mut io::stderr())
}
