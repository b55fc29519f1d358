//! Recordings that are not part of the repository, where they are available, and the message where they are not.
#![allow(unreachable_pub, reason = "several test programs hold this file as a module, and a library does")]

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A folder of `$HOST_SIM_SHARED`, or of `shared` beside the repository; where it does not exist, prints that a test is skipped.
pub fn shared(part: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let folder = std::env::var_os("HOST_SIM_SHARED").map_or(beside, PathBuf::from).join(part);
    if folder.is_dir() {
        return Some(folder);
    }
    skipped(&format!("there is no {}; set HOST_SIM_SHARED to a folder that holds `{part}`", folder.display()));
    None
}

/// Reports that a test is skipped: on its output, which cargo shows only for failed tests, and in the file `$HOST_SIM_SKIPPED`.
///
/// # Panics
/// That file cannot be written.
pub fn skipped(why: &str) {
    let test = std::thread::current().name().unwrap_or("a test").to_owned();
    let line = format!("skipped: {test}: {why}\n");
    print!("{line}");
    if let Some(path) = std::env::var_os("HOST_SIM_SKIPPED") {
        let mut file = OpenOptions::new().create(true).append(true).open(path).unwrap();
        // One write for each line: tests of several threads and processes append to the file.
        file.write_all(line.as_bytes()).unwrap();
    }
}
