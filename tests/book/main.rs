//! Does the documentation say what the code says, and does every link of it lead somewhere?

mod budget;
mod built;
mod crates;
mod effects;
mod links;
mod table;

use std::path::PathBuf;

/// The top of the repository.
fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}
