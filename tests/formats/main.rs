//! Recordings in the formats that engineers have: each file of `fixtures/formats`, written by the tools that people use, against the
//! CSV of the same rows; written files, read again; and files that are cut or damaged.

mod chapter;
mod commands;
mod damaged;
mod fixtures;
mod others;
mod written;

use std::path::PathBuf;

use recording::{ChannelMap, Recording, RecordingError};

/// A file of the fixtures.
fn fixture(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fixtures/formats").join(name)
}

fn read_mapped(name: &str, maps: &[&str]) -> Result<Recording, RecordingError> {
    recording::read(&fixture(name), &ChannelMap::from_arguments(maps.iter().copied()).unwrap())
}

fn read(name: &str) -> Recording {
    read_mapped(name, &[]).unwrap_or_else(|error| panic!("{error}"))
}
