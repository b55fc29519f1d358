//! The tool as a process of its own: this program again, called by another name, which reports its time and memory at its end.

use std::error::Error;
use std::io;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use clap::Parser;

use host_sim::cli::{self, Cli, CommandLine, Console};

use crate::machine;

/// The first argument of a process that runs as the tool.
pub(crate) const CALLED: &str = "as-host-sim";

/// Beginning of the line with the time and memory.
const TOOK: &str = "took ";

/// Time and memory of a run of the tool.
#[derive(Debug)]
pub(crate) struct Took {
    /// From its start to its end, s.
    pub(crate) wall_s: f64,
    /// Computing time of all threads together, s.
    pub(crate) computed_s: f64,
    /// Peak memory, MB.
    pub(crate) peak_mb: f64,
    /// What it printed.
    pub(crate) printed: String,
}

/// The tool itself.
pub(crate) fn main(arguments: &[String]) -> ExitCode {
    let line = &CommandLine::of_process();
    let cli = match Cli::try_parse_from([CALLED.to_owned()].iter().chain(arguments)) {
        Ok(cli) => cli,
        Err(error) => return cli::refuse(&error, line, &mut io::stderr()),
    };
    let mut out = io::stdout().lock();
    let result = cli::run(&cli.command, &mut Console::of_process(&mut out, cli.volume()));
    if let Some(peak_kb) = machine::peak_kb() {
        eprintln!("{TOOK}{} {peak_kb}", machine::computed_s());
    }
    cli::finish(result, line, &mut io::stderr())
}

/// A path as an argument.
pub(crate) fn text(path: &Path) -> Result<&str, Box<dyn Error>> {
    path.to_str().ok_or_else(|| "a temporary folder whose name is not text".into())
}

/// Runs the tool in a process of its own.
pub(crate) fn host_sim(threads: usize, arguments: &[&str]) -> Result<Took, Box<dyn Error>> {
    let start = Instant::now();
    let output = Command::new(std::env::current_exe()?)
        .arg(CALLED)
        .arg("--quiet")
        .args(arguments)
        .env("RAYON_NUM_THREADS", threads.to_string())
        .stdin(Stdio::null())
        .output()?;
    let wall_s = start.elapsed().as_secs_f64();
    let said = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(format!("host-sim {}: {said}", arguments.join(" ")).into());
    }
    let took =
        said.lines().find_map(|line| line.strip_prefix(TOOK)).ok_or("this system does not say what a process took")?;
    let (computed_s, peak_kb) = took.split_once(' ').ok_or("two numbers")?;
    Ok(Took {
        wall_s,
        computed_s: computed_s.parse()?,
        peak_mb: peak_kb.parse::<f64>()? / 1024.0,
        printed: String::from_utf8_lossy(&output.stdout).into_owned(),
    })
}
