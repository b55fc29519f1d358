//! Does the diagnosis name what is missing, and nothing else?
//!
//! The shipped example and a real drive, from start to end; cases drawn on the virtual test bed, whose effects have other forms
//! than the hypotheses; events that happen once; and the parts that everything depends on: derivatives and the fit.

mod agreement;
mod bed;
mod cavitation;
mod confusion;
mod derivatives;
mod drawn;
mod entered;
mod faults;
mod hall;
mod in_a_hall;
mod joint_angle;
mod limit;
mod load_holding;
mod long;
mod measured_force;
mod oil;
mod once;
mod outside;
mod pressure_zero;
mod real;
mod real_actuator;
mod real_excavator;
mod real_statics;
mod real_tank;
mod real_valve;
mod recover;
mod shared_supply;
mod shipped;
mod sparse;
mod start;
mod strengths;
mod stress;
mod table;
mod threads;
mod tutorial;

use std::path::{Path, PathBuf};

use clap::Parser;

use host_sim::cli::{self, Cli, Console, Outcome};

/// The top of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Runs the program in this process; returns what it printed.
fn done(arguments: &[&str]) -> String {
    let cli = Cli::try_parse_from(["host-sim"].iter().chain(arguments)).unwrap();
    let mut out = Vec::new();
    let outcome = cli::run(&cli.command, &mut Console::into_buffer(&mut out)).unwrap();
    assert_eq!(outcome, Outcome::Done, "{arguments:?}");
    String::from_utf8(out).unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}
