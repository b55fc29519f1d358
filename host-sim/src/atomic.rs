//! Files that are written whole or not at all.

use std::fs::{self, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;

use tempfile::NamedTempFile;

/// Writes a file by way of a temporary one beside it, which takes its name when everything is on disk.
///
/// When writing fails, the target is as it was before. A target that exists and is no regular file
/// (a pipe, a terminal) is written directly. No error names the temporary file.
pub fn write(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    if is_stream(path) {
        let mut out = BufWriter::new(OpenOptions::new().write(true).open(path)?);
        fill(&mut out)?;
        return out.flush();
    }
    let file = temporary(path)?;
    let mut out = BufWriter::new(file.as_file());
    fill(&mut out)?;
    out.flush()?;
    drop(out);
    file.as_file().sync_all()?;
    file.persist(path).map_err(|failed| failed.error)?;
    Ok(())
}

/// Checks that [`write()`] could write this file now, and leaves nothing.
pub fn check(path: &Path) -> io::Result<()> {
    if is_stream(path) { Ok(()) } else { temporary(path).map(drop) }
}

/// What would have been right where [`write()`] or [`check`] has failed; a phrase.
#[must_use]
pub fn expected(error: &io::Error) -> &'static str {
    if error.kind() == io::ErrorKind::IsADirectory {
        "the name of a file, and this is a folder"
    } else {
        "a folder that can be written to"
    }
}

/// A pipe, a terminal: something that is there and neither file nor folder.
fn is_stream(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|meta| !meta.is_file() && !meta.is_dir())
}

fn temporary(path: &Path) -> io::Result<NamedTempFile> {
    if path.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".host-sim-");
    // A temporary file is private by default; the result is an ordinary file under the user's umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // The system's own words where the folder is not there; then those of the kind alone, for `tempfile` adds its path.
    fs::metadata(folder)?;
    builder.tempfile_in(folder).map_err(|error| error.kind().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.csv");
        write(&path, |out| out.write_all(b"old")).unwrap();
        let failed = write(&path, |out| {
            out.write_all(&vec![b'x'; 100_000])?;
            Err(io::Error::other("disk full"))
        });
        assert!(failed.is_err());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_target_that_cannot_be_written_is_told_without_the_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("no/such/out.csv");
        for error in [write(&missing, |_| Ok(())).unwrap_err(), check(&missing).unwrap_err()] {
            assert_eq!(error.kind(), io::ErrorKind::NotFound);
            assert!(!error.to_string().contains(".host-sim-"), "{error}");
            assert_eq!(expected(&error), "a folder that can be written to");
        }
        for error in [write(folder.path(), |_| Ok(())).unwrap_err(), check(folder.path()).unwrap_err()] {
            assert!(expected(&error).contains("this is a folder"), "{error}");
        }
        check(&folder.path().join("out.csv")).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
