//! The cost of the model and the tool, against what a user would choose instead: `benches/run` prints it and writes `BENCHMARKS.md`.
//!
//! The opponents are the peers' own programs, called as they are; for names it is `PySINDy`, as `peers/sindy.py` uses it. Programs that are compared
//! run in turns, round by round, and the shortest of the rounds counts, because the computer does other work as well.

mod accurate;
mod child;
mod desktop;
mod diagnose;
mod fit;
mod fleet;
mod growth;
mod machine;
mod names;
mod page;
mod peers;
mod range;
mod target;

use std::error::Error;
use std::process::ExitCode;

use page::{Page, Part};

/// A part of the comparison by its name on the command line.
type Measured = fn() -> Result<Part, Box<dyn Error>>;

const PARTS: [(&str, Measured); 6] = [
    ("desktop", desktop::part),
    ("target", target::part),
    ("fit", fit::part),
    ("diagnose", diagnose::part),
    ("names", names::part),
    ("fleet", fleet::part),
];

fn measured(wanted: &[String]) -> Result<(), Box<dyn Error>> {
    let of_name = |name: &str| PARTS.iter().find(|(known, _)| *known == name);
    if let Some(unknown) = wanted.iter().find(|name| of_name(name).is_none()) {
        return Err(format!("{unknown} is none of desktop, target, fit, diagnose, names, fleet").into());
    }
    let mut page = Page::of_this_machine()?;
    for (name, part) in PARTS {
        if wanted.is_empty() || wanted.iter().any(|wanted| wanted == name) {
            eprintln!("measuring: {name}");
            page.add(part()?);
        }
    }
    println!("{}", page.text());
    if wanted.is_empty() && peers::are_there() {
        page.write()?;
    } else {
        eprintln!("BENCHMARKS.md stays as it was: it holds all parts, with the peers");
    }
    Ok(())
}

fn main() -> ExitCode {
    // Cargo passes `--bench`, which is not used here.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    if arguments.first().is_some_and(|first| first == child::CALLED) {
        return child::main(&arguments[1..]);
    }
    match measured(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
