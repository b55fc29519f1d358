//! Names are only names: no path in a machine file, a recording or a recorder's stream is opened for reading or writing, and results are
//! written only where an argument says.
//!
//! Every name that a file may hold is here the path of a named pipe outside the folder. A program that opens the pipe to read or write waits
//! for the other end; a program that writes a file as a whole replaces the pipe by the file. So a command that ends, and leaves the pipe a
//! pipe, has not touched it.
#![cfg(unix)]

use std::fmt::Write;
use std::fs;
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use firmware::recorder::frame::FrameWriter;
use firmware::recorder::message::{ChannelHeader, Header, RowsWriter};

use super::{MACHINE, listing, program, text};

/// Longer than any of the commands takes.
const PATIENCE: Duration = Duration::from_mins(1);

/// A folder with a pipe, and in it the folder that the commands run in.
struct Place {
    outer: TempDir,
}

impl Place {
    fn new() -> Self {
        let outer = tempfile::tempdir().unwrap();
        assert!(Command::new("mkfifo").arg(outer.path().join("bait")).status().unwrap().success());
        fs::create_dir(outer.path().join("inner")).unwrap();
        Self { outer }
    }

    fn inner(&self) -> PathBuf {
        self.outer.path().join("inner")
    }

    fn bait(&self) -> PathBuf {
        self.outer.path().join("bait")
    }

    /// Names that lead out of the folder, or are no valid paths.
    fn names(&self) -> Vec<String> {
        let bait = self.bait().display().to_string();
        let long = format!("{}bait", "../inner/".repeat(2000));
        vec![
            "../bait".into(),
            bait.clone(),
            format!("file://{bait}"),
            "inner/../../bait".into(),
            "..".into(),
            "/".into(),
            "a/b".into(),
            "..\\bait".into(),
            "nul\0/../bait".into(),
            "$(cat ../bait)".into(),
            long,
        ]
    }

    /// Runs a command, which must end by itself, and checks that nothing but `written` was added to the folder, and nothing outside it.
    fn run(&self, arguments: &[&str], written: &[&str]) -> Output {
        let (inner, outside) = (self.inner(), listing(self.outer.path()));
        let mut there = listing(&inner);
        there.extend(written.iter().map(|name| inner.join(name)));
        there.sort();
        there.dedup();
        let output = within(PATIENCE, &inner, arguments);
        assert_eq!(listing(self.outer.path()), outside, "{arguments:?}");
        assert!(fs::symlink_metadata(self.bait()).unwrap().file_type().is_fifo(), "{arguments:?}");
        assert_eq!(listing(&inner), there, "{arguments:?}: {}", text(&output.stderr));
        output
    }
}

/// Waits for the program to end by itself; kills it if it waits for something.
fn within(patience: Duration, folder: &Path, arguments: &[&str]) -> Output {
    // Output goes into files: with a pipe that nobody reads, the program could wait for the reader.
    let said = tempfile::tempdir().unwrap();
    let [out, errors] = ["out", "errors"].map(|name| said.path().join(name));
    let mut command = program(folder, arguments);
    command.stdin(Stdio::null()).stdout(fs::File::create(&out).unwrap()).stderr(fs::File::create(&errors).unwrap());
    let (mut child, start) = (command.spawn().unwrap(), Instant::now());
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > patience {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("{arguments:?} waits for something");
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    Output { status, stdout: fs::read(out).unwrap(), stderr: fs::read(errors).unwrap() }
}

/// A text as TOML writes it.
fn quoted(name: &str) -> String {
    let escaped: String = name
        .chars()
        .map(|c| if c.is_control() || "\"\\".contains(c) { format!("\\u{:04X}", u32::from(c)) } else { c.into() })
        .collect();
    format!("\"{escaped}\"")
}

/// A drive of this name, whose spool is in a column of this name.
fn machine(name: &str) -> String {
    format!("name = {}\n{MACHINE}\n[channels]\nspool = {}\n", quoted(name), quoted(name))
}

/// 0.4 s of a step, with a column under this header.
fn recording(header: &str) -> String {
    let mut text = format!("time [s],command [V],position [m],\"{header}\"\n");
    for row in 0..200 {
        let (time_s, rising) = (f64::from(row) * 2e-3, (f64::from(row) - 20.0).max(0.0));
        let command_v = if row < 10 { 0.0 } else { 5.0 };
        let (position_m, spool) = (0.1 + 1e-4 * rising, 0.3 * (1.0 - (-rising / 20.0).exp()));
        writeln!(text, "{time_s},{command_v},{position_m},{spool}").unwrap();
    }
    text
}

/// Two rows of a channel of this name, as the recorder of a machine of this name streams them out: of a long name only its beginning.
fn streamed(name: &str) -> Vec<u8> {
    let header = Header { channels: 1, tick_ns: 1_000_000, first: 0, rows: 2, trigger: 0, machine: name };
    let channel = ChannelHeader { number: 0, step: 0.5, name, unit: name };
    let mut rows = RowsWriter::new(0);
    assert!(rows.push(&[1]) && rows.push(&[2]));
    let (mut line, mut frames) = (Vec::new(), FrameWriter::default());
    for (kind, payload) in [header.written(), channel.written(), rows.written()] {
        frames.write(&mut line, kind, &payload).unwrap();
    }
    line
}

/// A command, and what it writes.
type Writing = (&'static str, &'static [&'static str]);

/// Placeholder in a command for the recording's header.
const HEADER: &str = "HEADER";

/// Commands that read these files.
const COMMANDS: [Writing; 12] = [
    ("simulate --machine m.toml --recording r.csv --out s.csv --plot s.svg", &["s.csv", "s.svg"]),
    ("simulate --machine m.toml --recording r.csv --out s.mat", &["s.mat"]),
    ("simulate --machine m.toml --recording r.csv --out s.parquet", &["s.parquet"]),
    ("compare --machine m.toml --recording r.csv --plot c.svg", &["c.svg"]),
    ("statics --recording r.csv --input command --output HEADER --json t.json --plot t.svg", &["t.json", "t.svg"]),
    ("inspect r.csv --machine m.toml --json i.json", &["i.json"]),
    ("export --machine m.toml --out p.rs", &["p.rs"]),
    ("export --machine m.toml --out p.h", &["p.h"]),
    ("export --machine m.toml --library l.so --out p.fmu", &["p.fmu"]),
    ("import --frames f.bin --out i.csv", &["i.csv"]),
    ("fit --machine m.toml --train r.csv --save-machine f.toml", &["f.toml"]),
    ("testbed --machine m.toml --train zero:0.1s --out .", &["machine.toml", "train-1.csv"]),
];

/// Commands that take longer.
const LONG: [Writing; 2] = [
    (
        "diagnose --machine m.toml --train r.csv --json d.json --save-machine d.toml --report d.html --plot d.svg",
        &["d.json", "d.toml", "d.html", "d.svg"],
    ),
    (
        "plan --machine m.toml --recording r.csv --seconds 6 --out e.csv --json e.json --plot e.svg",
        &["e.csv", "e.json", "e.svg"],
    ),
];

/// Runs commands on files that have each of these names in every place where a name can stand.
fn names_are_names(place: &Place, names: &[String], commands: &[Writing]) {
    fs::write(place.inner().join("l.so"), "fmi2Instantiate fmi3InstantiateCoSimulation").unwrap();
    for name in names {
        // A header is part of a line.
        let header = name.replace(['\n', '\0'], " ");
        fs::write(place.inner().join("m.toml"), machine(name)).unwrap();
        fs::write(place.inner().join("r.csv"), recording(&header)).unwrap();
        fs::write(place.inner().join("f.bin"), streamed(name)).unwrap();
        for (command, written) in commands {
            let arguments: Vec<&str> =
                command.split(' ').map(|word| if word == HEADER { header.as_str() } else { word }).collect();
            let output = place.run(&arguments, written);
            let message = text(&output.stderr);
            assert_eq!(output.status.code(), Some(0), "{arguments:?} with {}: {message}", quoted(name));
            for name in *written {
                fs::remove_file(place.inner().join(name)).unwrap();
            }
        }
    }
}

#[test]
fn a_path_as_a_name_is_a_name() {
    let place = Place::new();
    names_are_names(&place, &place.names(), &COMMANDS);
}

#[test]
fn a_path_as_a_name_is_a_name_to_what_takes_longer() {
    let place = Place::new();
    // Relative, absolute, and as in a browser.
    names_are_names(&place, &place.names()[..3], &LONG);
}
