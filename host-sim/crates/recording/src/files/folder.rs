//! The recordings of a folder, by the beginnings of their names.

use std::io;
use std::path::{Path, PathBuf};

use crate::formats::format::Format;

/// The recordings of a folder whose names begin with this prefix and end as a format's do, in the order of their names.
///
/// # Errors
/// If the folder cannot be listed.
pub fn listed(folder: &Path, prefix: &str) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in folder.read_dir()? {
        let path = entry?.path();
        let named = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(prefix));
        if named && Format::of_extension(&path).is_some() {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Whether a file's name ends as a format's do.
#[must_use]
pub fn is_recording(name: &str) -> bool {
    Format::of_extension(Path::new(name)).is_some()
}

/// Two of these files with one name in two formats: the same recording would count twice, and the copies may differ in the last digit.
#[must_use]
pub fn in_two_formats(listed: &[PathBuf]) -> Option<(&Path, &Path)> {
    listed.iter().enumerate().find_map(|(index, second)| {
        let first = listed[..index].iter().find(|first| stem(first) == stem(second))?;
        Some((first.as_path(), second.as_path()))
    })
}

/// A file's name without the ending of its format, and without that of its packing.
fn stem(path: &Path) -> PathBuf {
    let unpacked =
        if Format::of_extension(path) == Some(Format::Gzip) { path.with_extension("") } else { path.to_owned() };
    if Format::of_extension(&unpacked).is_some() { unpacked.with_extension("") } else { unpacked }
}
