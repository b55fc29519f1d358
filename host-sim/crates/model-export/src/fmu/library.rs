//! The shared library that computes an FMU's variables.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::path::{Path, PathBuf};
use std::{fs, io};

/// A function of each version of the standard that every library of an FMU exports; their names identify such a library.
const FUNCTIONS: [&str; 2] = ["fmi2Instantiate", "fmi3InstantiateCoSimulation"];

/// A shared library with the functions of FMI 2.0 and 3.0.
#[derive(Clone, PartialEq, Eq)]
pub struct Library {
    bytes: Vec<u8>,
}

/// Why there is no library.
#[derive(Debug, thiserror::Error)]
pub enum LibraryError {
    /// It is not beside the program.
    #[error(
        "no {name} beside this program, in {}; expected the library that computes the model in other tools: \
         `cargo build --release -p drive-fmu` builds it, or --library names it", folder.display()
    )]
    Missing {
        /// Its file name on this computer.
        name: String,
        /// The folder that was searched.
        folder: PathBuf,
    },
    /// It cannot be read.
    #[error("{}: cannot be read: {cause}; expected the library that `cargo build --release -p drive-fmu` builds", path.display())]
    Unread {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        cause: io::Error,
    },
    /// It is something else.
    #[error(
        "{}: no function {function}; expected the library that `cargo build --release -p drive-fmu` builds",
        path.display()
    )]
    Other {
        /// The file.
        path: PathBuf,
        /// What it lacks.
        function: &'static str,
    },
}

impl Library {
    /// The library in a file.
    ///
    /// # Errors
    /// The file cannot be read, or it is not such a library.
    pub fn read(path: &Path) -> Result<Self, LibraryError> {
        let bytes = fs::read(path).map_err(|cause| LibraryError::Unread { path: path.to_owned(), cause })?;
        let lacks = |function: &&&str| bytes.windows(function.len()).all(|window| window != function.as_bytes());
        match FUNCTIONS.iter().find(lacks) {
            Some(function) => Err(LibraryError::Other { path: path.to_owned(), function }),
            None => Ok(Self { bytes }),
        }
    }

    /// The library that cargo has built beside a program.
    ///
    /// # Errors
    /// There is none, or it cannot be read.
    pub fn beside(program: &Path) -> Result<Self, LibraryError> {
        let name = format!("{DLL_PREFIX}drive_fmu{DLL_SUFFIX}");
        let folder = program.parent().unwrap_or(Path::new("."));
        let path = folder.join(&name);
        if path.exists() { Self::read(&path) } else { Err(LibraryError::Missing { name, folder: folder.to_owned() }) }
    }

    /// What is in the file.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

impl std::fmt::Debug for Library {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Library").field("bytes", &self.bytes.len()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_library_is_refused_by_what_it_lacks_and_how_to_get_it() {
        let folder = tempfile::tempdir().unwrap();
        let missing = Library::beside(&folder.path().join("host-sim")).unwrap_err().to_string();
        assert!(missing.contains("cargo build --release -p drive-fmu") && missing.contains("--library"), "{missing}");
        let other = folder.path().join("other.so");
        fs::write(&other, b"\x7fELF").unwrap();
        let refused = Library::read(&other).unwrap_err().to_string();
        assert!(refused.contains("other.so: no function fmi2Instantiate"), "{refused}");
        // One of before FMI 2.0.
        fs::write(&other, b"..fmi3InstantiateCoSimulation..").unwrap();
        let refused = Library::read(&other).unwrap_err().to_string();
        assert!(refused.contains("other.so: no function fmi2Instantiate"), "{refused}");
        let gone = Library::read(&folder.path().join("gone.so")).unwrap_err().to_string();
        assert!(gone.contains("gone.so: cannot be read"), "{gone}");
        fs::write(&other, b"fmi2Instantiate fmi3InstantiateCoSimulation").unwrap();
        assert_eq!(Library::read(&other).unwrap().bytes().len(), 43);
    }
}
