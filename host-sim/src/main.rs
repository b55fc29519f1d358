//! The command line.

use std::io;
use std::process::ExitCode;

use clap::Parser;
use host_sim::cli::{self, Cli, Console};

fn main() -> ExitCode {
    let cli = Cli::parse();
    let mut out = io::stdout().lock();
    let console = &mut Console::of_process(&mut out, cli.volume());
    if cli::stop_cleanly().is_err() {
        console.note("Ctrl-C may leave a temporary file behind: this system takes no handler");
    }
    let result = cli::run(&cli.command, console);
    cli::finish(result, &mut io::stderr())
}
