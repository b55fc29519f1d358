//! The files that a command will write, checked before it begins: a long run must not end without its result.

use std::fs;
use std::io;
#[cfg(feature = "virtual-plant")]
use std::io::Write as _;
use std::path::{Path, PathBuf};

use machine_file::{MachineFile, carried};
use model_core::machine::Tick;
use recording::files::atomic;
#[cfg(feature = "virtual-plant")]
use recording::files::atomic::Begun;
use serde_json::Value;

use super::console::Console;
use super::ending::{DOCUMENT, Kind, check_ending, is_standard_output};
use super::error::CliError;

/// A file that an option names, and what is written there.
pub(crate) type Target<'a> = (&'static str, Option<&'a Path>, Kind);

/// Checks each file that an option names: it could be written now, it is not one of the input files, its ending fits its format, and no
/// other option names it.
pub(crate) fn check_targets(targets: &[Target<'_>], read: &[PathBuf]) -> Result<(), CliError> {
    check_apart(targets)?;
    for &(option, path, kind) in targets {
        let Some(path) = path else { continue };
        if kind == DOCUMENT && is_standard_output(path) {
            continue;
        }
        check_target(path)?;
        check_not_read(path, read)?;
        check_ending(option, path, kind)?;
    }
    Ok(())
}

/// Checks that no file is to be written by two options, whatever names they use. A pipe may be named twice.
pub(crate) fn check_apart(targets: &[Target<'_>]) -> Result<(), CliError> {
    let mut known: Vec<(&'static str, PathBuf)> = Vec::new();
    for &(second, path, _) in targets {
        let Some(path) = path.filter(|path| !atomic::is_stream(path)) else { continue };
        let place = atomic::resolved(path);
        if let Some(&(first, _)) = known.iter().find(|(_, other)| *other == place) {
            return Err(CliError::SameTarget { first, second, path: path.to_owned() });
        }
        known.push((second, place));
    }
    Ok(())
}

/// Checks that this file could be written now. Nothing is left there.
pub(crate) fn check_target(path: &Path) -> Result<(), CliError> {
    atomic::check(path).map_err(unwritten(path))
}

/// Writes a machine file with fitted values, if the tick that was asked for computes them; without one 1 ms or, with a note, 0.5 ms.
pub(crate) fn save_fitted(
    path: &Path,
    file: &MachineFile,
    asked: Option<Tick>,
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    let shown = path.display().to_string();
    let tick = file.tick_of_fitted(&shown, asked)?;
    file.save(path)?;
    if let Err(cause) = carried(&file.machine, Tick::OneMillisecond) {
        let tick_ms = 1e3 * tick.seconds();
        console.note(format_args!("{shown} needs --tick {tick_ms} in `export`, as 1 ms does not compute it: {cause}"));
    }
    Ok(())
}

/// The error for a file that cannot be written.
pub(crate) fn unwritten(path: &Path) -> impl FnOnce(io::Error) -> CliError {
    move |cause| CliError::Write { path: path.to_owned(), cause }
}

/// Writes a file whole or not at all.
pub(crate) fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), CliError> {
    atomic::write(path, |out| out.write_all(bytes.as_ref())).map_err(unwritten(path))
}

/// Writes a document for programs to a file; where the path is `-` it is all that the command prints.
pub(crate) fn write_document(path: &Path, document: &str, console: &mut Console<'_>) -> Result<(), CliError> {
    if is_standard_output(path) { console.print_alone(document.trim_end()) } else { write(path, document) }
}

/// Writes this document where `--json` asks for it.
pub(crate) fn tell(
    path: Option<&Path>,
    document: impl FnOnce() -> Value,
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    path.map_or(Ok(()), |path| write_document(path, &format!("{:#}\n", document()), console))
}

/// Checks that standard output is not asked for twice: what `--out -` prints and a document would follow each other.
pub(crate) fn check_one_output(out: &Path, json: Option<&Path>) -> Result<(), CliError> {
    match json {
        Some(json) if is_standard_output(json) && is_standard_output(out) => {
            Err(CliError::SameTarget { first: "--out", second: "--json", path: json.to_owned() })
        }
        _ => Ok(()),
    }
}

/// Writes files that belong together: the first takes its name when all of them are on disk.
#[cfg(feature = "virtual-plant")]
pub(crate) fn write_together(files: &[(PathBuf, String)]) -> Result<(), CliError> {
    let whole = files.iter().map(|(path, text)| {
        let on_disk = || {
            let mut begun = Begun::new(path)?;
            begun.write_all(text.as_bytes())?;
            begun.whole()
        };
        Ok((path, on_disk().map_err(unwritten(path))?))
    });
    for (path, whole) in whole.collect::<Result<Vec<_>, CliError>>()? {
        whole.finish().map_err(unwritten(path))?;
    }
    Ok(())
}

/// Writes text to a file, or prints it where the path is `-`.
pub(crate) fn write_or_print(path: &Path, text: &str, console: &mut Console<'_>) -> Result<(), CliError> {
    if is_standard_output(path) { console.print(text.trim_end()) } else { write(path, text) }
}

/// Checks that files could be written now into this folder, or into one that is made there. Nothing is left there.
pub(crate) fn check_folder(folder: &Path) -> Result<(), CliError> {
    // The empty path means the current directory.
    let is_there = |place: &&Path| place.as_os_str().is_empty() || place.exists();
    let place = folder.ancestors().find(is_there).unwrap_or(folder);
    atomic::check(&place.join("any")).map_err(unwritten(folder))
}

/// Makes a folder and those above it, where they are not there.
pub(crate) fn make_folder(folder: &Path) -> Result<(), CliError> {
    fs::create_dir_all(folder).map_err(unwritten(folder))
}

/// Checks that a file to write is not one of the input files, whatever names they have.
pub(crate) fn check_not_read(target: &Path, read: &[PathBuf]) -> Result<(), CliError> {
    // A file that does not exist yet, or cannot be resolved, is not one of them.
    let Ok(resolved) = target.canonicalize() else { return Ok(()) };
    match read.iter().find(|path| path.canonicalize().is_ok_and(|path| path.is_file() && path == resolved)) {
        Some(path) => Err(CliError::Overwrites { target: target.to_owned(), read: path.clone() }),
        None => Ok(()),
    }
}
