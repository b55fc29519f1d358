//! The files that a command will write, checked before it begins: a long run must not end without its result.

use std::fs;
use std::path::{Path, PathBuf};

use super::ending::{Kind, check_ending, is_standard_output};
use super::{CliError, Console};
use crate::atomic;

/// Checks each file that an option names: it could be written now, it is none of those read, and its ending promises what is written.
pub(super) fn check_targets(targets: &[(&'static str, Option<&Path>, Kind)], read: &[PathBuf]) -> Result<(), CliError> {
    for &(option, path, kind) in targets {
        let Some(path) = path else { continue };
        check_target(path)?;
        check_not_read(path, read)?;
        check_ending(option, path, kind)?;
    }
    Ok(())
}

/// Checks that this file could be written now. Nothing is left there.
pub(super) fn check_target(path: &Path) -> Result<(), CliError> {
    atomic::check(path).map_err(|cause| CliError::Write { path: path.to_owned(), cause })
}

/// Writes a file whole or not at all.
pub(super) fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), CliError> {
    atomic::write(path, |out| out.write_all(bytes.as_ref()))
        .map_err(|cause| CliError::Write { path: path.to_owned(), cause })
}

/// Writes text to a file, or prints it where that is `-`.
pub(super) fn write_or_print(path: &Path, text: &str, console: &mut Console<'_>) -> Result<(), CliError> {
    if is_standard_output(path) { console.print(text.trim_end()) } else { write(path, text) }
}

/// Checks that files could be written now into this folder, or into one that is made there. Nothing is left there.
pub(super) fn check_folder(folder: &Path) -> Result<(), CliError> {
    // The empty path stands for where the program runs.
    let is_there = |place: &&Path| place.as_os_str().is_empty() || place.exists();
    let place = folder.ancestors().find(is_there).unwrap_or(folder);
    atomic::check(&place.join("any")).map_err(|cause| CliError::Write { path: folder.to_owned(), cause })
}

/// Makes a folder and those above it, where they are not there.
pub(super) fn make_folder(folder: &Path) -> Result<(), CliError> {
    fs::create_dir_all(folder).map_err(|cause| CliError::Write { path: folder.to_owned(), cause })
}

/// Checks that a file to write is none of those that are read, by whatever names.
pub(super) fn check_not_read(target: &Path, read: &[PathBuf]) -> Result<(), CliError> {
    // What is not there yet, or cannot be resolved, is none of them.
    let Ok(resolved) = target.canonicalize() else { return Ok(()) };
    match read.iter().find(|path| path.canonicalize().is_ok_and(|path| path.is_file() && path == resolved)) {
        Some(path) => Err(CliError::Overwrites { target: target.to_owned(), read: path.clone() }),
        None => Ok(()),
    }
}
