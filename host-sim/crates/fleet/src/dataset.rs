//! The nights of a folder of drives.
//!
//! ```text
//! DATASET/drive=press-1/machine.toml                  the drive, with its band in [watch]
//! DATASET/drive=press-1/date=2026-11-30/a.parquet     a recording of that night, in any format
//! ```
//!
//! As a hive-partitioned data set has it; `press-1` and `2026-11-30` alone are as good. What begins with a dot or an underscore is left alone.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use recording::files::folder::is_recording;

/// The machine file of a drive's folder.
const MACHINE: &str = "machine.toml";

/// One drive and one night.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Night {
    /// The drive's name.
    pub drive: String,
    /// The night's name.
    pub name: String,
    /// The drive's machine file; it may not be there.
    pub machine: PathBuf,
    /// The night's recordings, in the order of their names.
    pub recordings: Vec<PathBuf>,
    /// Another folder of a drive, or a night, of this name: then neither can be used.
    pub twin: Option<PathBuf>,
}

/// Every night of every drive in a folder, in the order of their names.
///
/// # Errors
/// A folder cannot be listed.
pub fn nights(dataset: &Path) -> io::Result<Vec<Night>> {
    let mut paths = Vec::new();
    for drive in names(dataset)? {
        let folder = dataset.join(&drive);
        for night in names(&folder)?.into_iter().filter(|night| folder.join(night).is_dir()) {
            // A night without a recording is one, too.
            paths.push(format!("{drive}/{night}/"));
            paths.extend(names(&folder.join(&night))?.into_iter().map(|file| format!("{drive}/{night}/{file}")));
        }
    }
    Ok(nights_of(dataset, paths.iter().map(String::as_str)))
}

/// The names in a folder; none in what is no folder.
fn names(folder: &Path) -> io::Result<Vec<String>> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    fs::read_dir(folder)?.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
}

/// The same of the paths of files below a data set, wherever it is: `drive=press-1/date=2026-11-30/a.parquet`. One that ends in a slash is a night of which
/// nothing else is known.
pub fn nights_of<'a>(dataset: &Path, paths: impl IntoIterator<Item = &'a str>) -> Vec<Night> {
    let mut folders: BTreeMap<(&str, &str), Folders<'_>> = BTreeMap::new();
    for path in paths {
        let mut parts = path.splitn(3, '/');
        let (Some(drive), Some(night), Some(file)) = (parts.next(), parts.next(), parts.next()) else { continue };
        if [drive, night].iter().any(|name| name.starts_with(['.', '_'])) {
            continue;
        }
        let recordings = folders.entry((called(drive), called(night))).or_default().entry((drive, night)).or_default();
        if !file.is_empty() && !file.contains('/') && is_recording(file) {
            recordings.push(dataset.join(path));
        }
    }
    // A drive of which there are two folders, whatever their nights.
    let mut of_drive: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (drive, _) in folders.values().flat_map(BTreeMap::keys) {
        of_drive.entry(called(drive)).or_default().insert(drive);
    }
    let night = |((drive, name), folders): ((&str, &str), Folders<'_>)| {
        let twin_of_drive = of_drive.get(drive).and_then(|all| all.iter().nth(1)).map(|other| dataset.join(other));
        let twin_of_night = folders.keys().nth(1).map(|(drive, night)| dataset.join(drive).join(night));
        let first = folders.keys().next().map_or(drive, |(drive, _)| *drive);
        let machine = dataset.join(first).join(MACHINE);
        let mut recordings: Vec<PathBuf> = folders.into_values().flatten().collect();
        recordings.sort();
        Night {
            drive: drive.to_owned(),
            name: name.to_owned(),
            machine,
            recordings,
            twin: twin_of_drive.or(twin_of_night),
        }
    };
    folders.into_iter().map(night).collect()
}

/// The folders of one drive and one night, a drive's and a night's each, with the recordings in them.
type Folders<'a> = BTreeMap<(&'a str, &'a str), Vec<PathBuf>>;

/// What a folder is called: `drive=` or `date=` taken off.
fn called(folder: &str) -> &str {
    folder.split_once('=').map_or(folder, |(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drives_and_nights_are_found_in_both_spellings_in_their_order_and_twins_are_told() {
        let dataset = tempfile::tempdir().unwrap();
        let root = dataset.path();
        let files = [
            "drive=b/date=2026-01-02/2.csv",
            "drive=b/date=2026-01-02/1.csv",
            "drive=b/date=2026-01-02/notes.md",
            "a/2026-01-03/1.parquet",
            "a/2026-01-01/1.parquet",
            "a/_temporary/1.parquet",
            "c/n/1.csv",
            "drive=c/n/1.csv",
        ];
        for file in files {
            let path = root.join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        let found = nights(root).unwrap();
        let keys: Vec<(&str, &str, usize)> =
            found.iter().map(|night| (&*night.drive, &*night.name, night.recordings.len())).collect();
        assert_eq!(keys, [("a", "2026-01-01", 1), ("a", "2026-01-03", 1), ("b", "2026-01-02", 2), ("c", "n", 2)]);
        assert_eq!(found[2].machine, root.join("drive=b/machine.toml"));
        assert!(found[2].recordings[0].ends_with("1.csv"));
        assert!(found[3].twin.is_some() && found[..3].iter().all(|night| night.twin.is_none()));
    }
}
