//! Do the exports compute the drive that the program simulates: constants in C, and the model in a tool for co-simulation?

mod archive;
mod c99;
mod c_library;
mod fmpy;

use std::path::{Path, PathBuf};

use clap::Parser;

use host_sim::cli::{self, Cli, Console, Outcome};

/// A drive with an effect: the shipped example with the leakage that its recordings have.
fn leaking_press() -> String {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/press-63-40/machine.toml");
    let machine = std::fs::read_to_string(example).unwrap();
    format!("{machine}\n[effects.internal-leakage]\nconductance_m3_per_s_pa = 2.0e-12\n")
}

/// A pump-controlled drive.
const PUMP: &str = "name = \"pump \\\"ü\\\" ??/\"\n[pump]\ndisplacement_m3_per_rev = 1.6e-6\n\
    [cylinder]\narea_a_m2 = 3.117e-3\narea_b_m2 = 1.861e-3\n";

/// A mass that a force moves.
const MASS: &str = "name = \"mass\"\n[cylinder]\nmoving_mass_kg = 40.0\nviscous_friction_n_s_per_m = 2000.0\n";

/// The versions of the standard for FMUs.
const VERSIONS: [&str; 2] = ["2.0", "3.0"];

/// Runs the program in this process; an error is returned as its text on standard error.
fn run(arguments: &[&str]) -> Result<Outcome, String> {
    let cli = Cli::try_parse_from(["host-sim"].iter().chain(arguments)).unwrap();
    cli::run(&cli.command, &mut Console::into_buffer(&mut Vec::new())).map_err(|error| error.render())
}

fn done(arguments: &[&str]) {
    assert_eq!(run(arguments), Ok(Outcome::Done));
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// The shared library, which cargo builds beside this test.
fn library() -> PathBuf {
    let name = format!("{}drive_fmu{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    std::env::current_exe().unwrap().with_file_name(name)
}

/// An FMU of this drive in a folder.
fn exported(folder: &Path, name: &str, drive: &str, further: &[&str]) -> PathBuf {
    let [machine, fmu] = ["toml", "fmu"].map(|ending| folder.join(format!("{name}.{ending}")));
    std::fs::write(&machine, drive).unwrap();
    let library = library();
    let always = ["export", "--machine", text(&machine), "--out", text(&fmu), "--library", text(&library)];
    done(&[&always, further].concat());
    fmu
}
