//! Files that are written whole or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{NamedTempFile, TempPath};

/// The temporary files of this process that have no name of their own yet.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Writes a file by way of a temporary one beside it, which takes its name when everything is on disk.
///
/// When writing fails, the target is as it was before. A target that exists and is no regular file
/// (a pipe, a terminal) is written directly. No error names the temporary file.
pub fn write(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut begun = Begun::new(path)?;
    fill(&mut begun)?;
    begun.finish()
}

/// A file as [`write()`] writes it, by whoever has it: it is there once it is finished, and never without.
#[derive(Debug)]
pub struct Begun {
    path: PathBuf,
    out: BufWriter<File>,
    /// `None` for what is written directly.
    unfinished: Option<Unfinished>,
}

impl Begun {
    /// Nothing is in it yet.
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

    /// Everything is in it.
    pub fn finish(self) -> io::Result<()> {
        self.whole()?.finish()
    }

    /// Everything is in it and on disk, and it is closed; only its name is still to come.
    pub fn whole(mut self) -> io::Result<Whole> {
        self.out.flush()?;
        let Self { path, out, unfinished } = self;
        drop(out);
        Ok(Whole { path, unfinished: unfinished.map(Unfinished::closed).transpose()? })
    }
}

/// A file that is on disk, and will have its name.
#[derive(Debug)]
pub struct Whole {
    path: PathBuf,
    /// `None` for what is written directly.
    unfinished: Option<Closed>,
}

impl Whole {
    /// Gives it its name.
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

/// Removes every temporary file and lets no other file be begun or finished: the process is about to end.
pub fn abandon() {
    let mut unfinished = unfinished();
    for path in unfinished.drain(..) {
        // What is not there any more need not be removed.
        let _ = fs::remove_file(path);
    }
    mem::forget(unfinished);
}

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    // A list is whole after every operation on it, even where a thread panicked.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A temporary file that [`abandon`] knows.
#[derive(Debug)]
struct Unfinished {
    file: NamedTempFile,
    listed: Listed,
}

/// A line of [`UNFINISHED`], as long as it lives.
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
    /// Gives it its name. Not while another thread abandons: it is given whole, or never.
    fn finish(self, path: &Path) -> io::Result<()> {
        let Self { file, listed } = self;
        let renamed = {
            let _unfinished = unfinished();
            file.persist(path)
        };
        // Which asks for the list as well.
        drop(listed);
        renamed.map_err(|failed| failed.error)
    }
}

/// Checks that [`write()`] could write this file now, and leaves nothing.
pub fn check(path: &Path) -> io::Result<()> {
    if is_stream(path) { Ok(()) } else { Unfinished::beside(&resolved(path))?.file.close() }
}

/// What a link leads to, so that it stays one; else the file's own name in its folder, by the folder's real one.
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

/// A name of this process's standard output, whatever that has been led to.
pub fn leads_to_standard_output(path: &Path) -> bool {
    cfg!(unix) && ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].iter().any(|name| path == Path::new(name))
}

#[cfg(unix)]
fn standard_output() -> io::Result<File> {
    use std::os::fd::AsFd;
    // Opened by its name, a file would be written from its beginning.
    Ok(io::stdout().as_fd().try_clone_to_owned()?.into())
}

#[cfg(not(unix))]
fn standard_output() -> io::Result<File> {
    Err(io::ErrorKind::Unsupported.into())
}

/// What would have been right where [`write()`] or [`check`] has failed; a phrase.
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

/// A pipe, a terminal: something that is there and neither file nor folder; standard output, whatever that is.
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
    // The system's own words where the folder is not there; then those of the kind alone, for `tempfile` adds its path.
    fs::metadata(folder)?;
    let file = builder.tempfile_in(folder).map_err(|error| io::Error::from(error.kind()))?;
    // What takes the place of a file may be read by whom that could.
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
