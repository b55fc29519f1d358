//! The opponents: the peers' programs, in a process that runs one of them for each request.

use std::error::Error;
use std::io::{BufRead, BufReader, Lines, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::Value;

use system_tests::at_hand::shared;

/// The peers' folder.
fn folder() -> Option<PathBuf> {
    shared("peers/speed")
}

/// Where their `run.sh` puts what it builds, as `benches/run` says.
fn built() -> Option<PathBuf> {
    std::env::var_os("SPEED_BUILD").map(PathBuf::from).filter(|built| built.join("venv").is_dir())
}

/// The Python that their programs run in; another one where they are not installed.
pub(crate) fn python() -> PathBuf {
    built().map_or_else(|| PathBuf::from("python3"), |built| built.join("venv/bin/python"))
}

/// Whether that Python finds these modules.
pub(crate) fn can_import(modules: &str) -> bool {
    let import = Command::new(python()).args(["-c", &format!("import {modules}")]).output();
    import.is_ok_and(|output| output.status.success())
}

/// Whether the peers are available and installed.
pub(crate) fn are_there() -> bool {
    folder().is_some() && built().is_some()
}

/// The result of their measurement on the target, where it was run.
pub(crate) fn on_target() -> Result<Option<Value>, Box<dyn Error>> {
    let Some(file) = built().map(|built| built.join("target.json")).filter(|file| file.is_file()) else {
        return Ok(None);
    };
    Ok(Some(serde_json::from_str(&std::fs::read_to_string(file)?)?))
}

/// A process of the peers.
#[derive(Debug)]
pub(crate) struct Peers {
    process: Child,
    asked: ChildStdin,
    answers: Lines<BufReader<ChildStdout>>,
}

impl Peers {
    /// Starts one of the programs in `benches/peers`, and returns what it says about itself; `None` where the peers are not there.
    pub(crate) fn start(program: &str) -> Result<Option<(Self, Value)>, Box<dyn Error>> {
        let (Some(folder), Some(built)) = (folder(), built()) else { return Ok(None) };
        let mut process = Command::new(python())
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("peers").join(program))
            .arg(folder)
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .env("NUMBA_CACHE_DIR", built.join("numba"))
            // With more threads than that, their fit takes several times as long on a shared machine.
            .env("OPENBLAS_NUM_THREADS", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let asked = process.stdin.take().ok_or("its input is a pipe")?;
        let answers = BufReader::new(process.stdout.take().ok_or("its output is a pipe")?).lines();
        let mut peers = Self { process, asked, answers };
        let said = peers.answer()?;
        Ok(Some((peers, said)))
    }

    fn answer(&mut self) -> Result<Value, Box<dyn Error>> {
        let line = self.answers.next().ok_or("the peers' program ended; what it said is above")??;
        Ok(serde_json::from_str(&line)?)
    }

    /// Sends a line and returns the answer.
    pub(crate) fn ask(&mut self, line: &str) -> Result<Value, Box<dyn Error>> {
        writeln!(self.asked, "{line}")?;
        self.asked.flush()?;
        self.answer()
    }
}

impl Drop for Peers {
    fn drop(&mut self) {
        // The process waits for the next line, and has nothing to lose.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A number in an answer.
pub(crate) fn number(value: &Value) -> Result<f64, Box<dyn Error>> {
    value.as_f64().ok_or_else(|| format!("{value} is not a number").into())
}

/// A list in an answer.
pub(crate) fn list(value: &Value) -> Result<&Vec<Value>, Box<dyn Error>> {
    value.as_array().ok_or_else(|| format!("{value} is no list").into())
}

/// A text in an answer.
pub(crate) fn text(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}
