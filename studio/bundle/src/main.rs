//! `cargo run -p studio-page -- studio.html`: builds the studio's page and writes it.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(out), target, None) = (arguments.next(), arguments.next(), arguments.next()) else {
        eprintln!("error: expected the file to write, such as studio.html, and if wanted a folder to build in");
        return ExitCode::from(2);
    };
    let target = target.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/studio"));
    let written = studio_page::html(&target).map_err(|error| error.to_string()).and_then(|page| {
        std::fs::write(&out, page).map_err(|cause| format!("{}: cannot be written: {cause}", out.display()))
    });
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}
