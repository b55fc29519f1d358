//! Files that are written whole or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{NamedTempFile, TempPath};

/// The temporary files of this process that do not have their final name yet.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Writes a file through a temporary one in the same folder, which is renamed to the target when everything is on disk.
///
/// When writing fails, the target is as it was before. A target that exists and is not a regular file
/// (a pipe, a terminal) is written directly. No error names the temporary file.
pub fn write(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut begun = Begun::new(path)?;
    fill(&mut begun)?;
    begun.finish()
}

/// A file that is written as by [`write()`], but piece by piece: it appears when it is finished, and otherwise not at all.
#[derive(Debug)]
pub struct Begun {
    path: PathBuf,
    out: BufWriter<File>,
    /// `None` for a target that is written directly.
    unfinished: Option<Unfinished>,
}

impl Begun {
    /// Begins an empty file.
    pub fn new(path: &Path) -> io::Result<Self> {
        let path = resolved(path);
        let (file, unfinished) = if leads_to_standard_output(&path) {
            (standard_output()?, None)
        } else if is_stream(&path) {
            (OpenOptions::new().write(true).open(&path)?, None)
        } else {
            let unfinished = Unfinished::beside(&path)?;
            (unfinished.file.as_file().try_clone()?, Some(unfinished))
        };
        Ok(Self { path, out: BufWriter::new(file), unfinished })
    }

    /// Ends the file: everything has been written into it.
    pub fn finish(self) -> io::Result<()> {
        self.whole()?.finish()
    }

    /// Closes the file with everything in it and on disk; only the renaming to its final name is left to do.
    pub fn whole(mut self) -> io::Result<Whole> {
        self.out.flush()?;
        let Self { path, out, unfinished } = self;
        drop(out);
        Ok(Whole { path, unfinished: unfinished.map(Unfinished::closed).transpose()? })
    }
}

/// A file that is on disk and still has to be renamed to its final name.
#[derive(Debug)]
pub struct Whole {
    path: PathBuf,
    /// `None` for a target that is written directly.
    unfinished: Option<Closed>,
}

impl Whole {
    /// Renames it to its final name.
    pub fn finish(self) -> io::Result<()> {
        self.unfinished.map_or(Ok(()), |closed| closed.finish(&self.path))
    }
}

impl Write for Begun {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Removes every temporary file and prevents any other file from being begun or finished: the process is about to end.
pub fn abandon() {
    let mut unfinished = unfinished();
    for path in unfinished.drain(..) {
        // A file that no longer exists need not be removed.
        let _ = fs::remove_file(path);
    }
    mem::forget(unfinished);
}

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    // The list is consistent after every operation on it, even where a thread panicked.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A temporary file that [`abandon`] knows.
#[derive(Debug)]
struct Unfinished {
    file: NamedTempFile,
    listed: Listed,
}

/// An entry of [`UNFINISHED`]; it is removed when this value is dropped.
#[derive(Debug)]
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().retain(|known| *known != self.0);
    }
}

impl Unfinished {
    fn beside(path: &Path) -> io::Result<Self> {
        let mut unfinished = unfinished();
        let file = temporary(path)?;
        let temporary = file.path().to_owned();
        unfinished.push(temporary.clone());
        Ok(Self { file, listed: Listed(temporary) })
    }

    fn closed(self) -> io::Result<Closed> {
        let Self { file, listed } = self;
        file.as_file().sync_all()?;
        Ok(Closed { file: file.into_temp_path(), listed })
    }
}

/// An [`Unfinished`] that is on disk.
#[derive(Debug)]
struct Closed {
    file: TempPath,
    listed: Listed,
}

impl Closed {
    /// Renames it to its final name. The lock excludes a concurrent call that abandons: the file is renamed completely or not at all.
    fn finish(self, path: &Path) -> io::Result<()> {
        let Self { file, listed } = self;
        let renamed = {
            let _unfinished = unfinished();
            file.persist(path)
        };
        // Dropping it locks the list as well, so the lock above is released first.
        drop(listed);
        renamed.map_err(|failed| failed.error)
    }
}

/// Checks that [`write()`] could write this file now, and leaves no file behind.
pub fn check(path: &Path) -> io::Result<()> {
    if is_stream(path) { Ok(()) } else { Unfinished::beside(&resolved(path))?.file.close() }
}

/// The target of a link, so that the link stays a link; for any other path the file's name in its folder, with links in the folder's path resolved.
pub fn resolved(path: &Path) -> PathBuf {
    if leads_to_standard_output(path) {
        return path.to_owned();
    }
    let folder = |folder: &Path| if folder.as_os_str().is_empty() { Path::new(".") } else { folder }.canonicalize();
    path.canonicalize().unwrap_or_else(|_| match (path.parent().map(folder), path.file_name()) {
        (Some(Ok(folder)), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    })
}

/// Whether the path names this process's standard output, wherever that is redirected to.
pub fn leads_to_standard_output(path: &Path) -> bool {
    cfg!(unix) && ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].iter().any(|name| path == Path::new(name))
}

#[cfg(unix)]
fn standard_output() -> io::Result<File> {
    use std::os::fd::AsFd;
    // If it were opened by its name, a redirected file would be written from its beginning.
    Ok(io::stdout().as_fd().try_clone_to_owned()?.into())
}

#[cfg(not(unix))]
fn standard_output() -> io::Result<File> {
    Err(io::ErrorKind::Unsupported.into())
}

/// What was expected where [`write()`] or [`check`] has failed; a phrase.
#[must_use]
pub fn expected(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::IsADirectory => "the name of a file, and this is a folder",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
            "room for it on the disk; what was there is as it was"
        }
        _ => "a folder that can be written to",
    }
}

/// A pipe or a terminal: something that exists and is neither file nor folder. Standard output always counts as one.
pub fn is_stream(path: &Path) -> bool {
    leads_to_standard_output(path) || fs::metadata(path).is_ok_and(|meta| !meta.is_file() && !meta.is_dir())
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
    // For a missing folder, the system's own message; for other errors only the kind, because `tempfile` adds the path of its temporary file.
    fs::metadata(folder)?;
    let file = builder.tempfile_in(folder).map_err(|error| io::Error::from(error.kind()))?;
    // A file that replaces another keeps its permissions.
    if let Ok(old) = fs::metadata(path) {
        file.as_file().set_permissions(old.permissions())?;
    }
    Ok(file)
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

    #[cfg(unix)]
    #[test]
    fn a_link_stays_one_and_a_file_keeps_its_permissions() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
        symlink("file", &link).unwrap();
        write(&link, |out| out.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    }
}
