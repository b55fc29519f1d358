//! Does the documentation agree with the code, and does every link in it have a target?

mod budget;
mod built;
mod circles;
mod crates;
mod cycles;
mod effects;
mod gallery;
mod links;
mod programs;
mod symptoms;
mod table;

use std::path::PathBuf;

/// The top of the repository.
fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}
