//! A Python for tests that read our files with other tools.

use std::path::PathBuf;
use std::process::Command;

use crate::at_hand::skipped;

/// A Python that has a module: `$HOST_SIM_PYTHON`, or `python3`; where there is none, prints that a test is skipped.
#[must_use]
pub fn python_with(module: &str) -> Option<PathBuf> {
    let python = std::env::var_os("HOST_SIM_PYTHON").map_or_else(|| PathBuf::from("python3"), PathBuf::from);
    let found = Command::new(&python).args(["-c", &format!("import {module}")]).output();
    if found.is_ok_and(|found| found.status.success()) {
        return Some(python);
    }
    skipped(&format!("{} has no {module}; HOST_SIM_PYTHON names one that has", python.display()));
    None
}
