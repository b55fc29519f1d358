//! The command line.

use std::io;
use std::process::ExitCode;

use clap::Parser;
use host_sim::cli::{self, Cli, Console};

fn main() -> ExitCode {
    let cli = Cli::parse();
    let mut out = io::stdout().lock();
    let console = &mut Console::of_process(&mut out, cli.volume());
    if let Err(cause) = cli::stop_cleanly() {
        console.note(format_args!("Ctrl-C may leave a temporary file behind: {cause}"));
    }
    let result = cli::run(&cli.command, console);
    cli::finish(result, &mut io::stderr())
}
