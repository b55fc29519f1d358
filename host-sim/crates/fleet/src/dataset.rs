//! The nights of a folder of drives.
//!
//! ```text
//! DATASET/drive=press-1/machine.toml                  the drive, with its band in [watch]
//! DATASET/drive=press-1/date=2026-11-30/a.parquet     a recording of that night, in any format
//! ```
//!
//! As a hive-partitioned data set has it; `press-1` and `2026-11-30` alone are as good. What begins with a dot or an underscore is left alone.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use recording::files::folder::listed;

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

/// Every night of every drive, in the order of their names.
///
/// # Errors
/// A folder cannot be listed.
pub fn nights(dataset: &Path) -> io::Result<Vec<Night>> {
    let mut all = Vec::new();
    for (drive, folders) in named(dataset)? {
        let twin = folders.get(1);
        for folder in &folders {
            for (name, nights) in named(folder)? {
                let twin = twin.or(nights.get(1)).cloned();
                let mut recordings = Vec::new();
                for night in &nights {
                    recordings.extend(listed(night, "")?);
                }
                let machine = folder.join(MACHINE);
                all.push(Night { drive: drive.clone(), name, machine, recordings, twin });
            }
        }
    }
    // Of a drive with two folders each night comes once: neither can be used.
    all.sort_by(|one, other| (&one.drive, &one.name).cmp(&(&other.drive, &other.name)));
    all.dedup_by(|later, first| (&first.drive, &first.name) == (&later.drive, &later.name));
    Ok(all)
}

/// The folders in a folder by what they are called, `drive=` or `date=` taken off.
fn named(folder: &Path) -> io::Result<BTreeMap<String, Vec<PathBuf>>> {
    let mut found: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        if !path.is_dir() || name.starts_with(['.', '_']) {
            continue;
        }
        let name = name.split_once('=').map_or(name.as_str(), |(_, value)| value).to_owned();
        found.entry(name).or_default().push(path);
    }
    for folders in found.values_mut() {
        folders.sort();
    }
    Ok(found)
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
        assert_eq!(keys, [("a", "2026-01-01", 1), ("a", "2026-01-03", 1), ("b", "2026-01-02", 2), ("c", "n", 1)]);
        assert_eq!(found[2].machine, root.join("drive=b/machine.toml"));
        assert!(found[2].recordings[0].ends_with("1.csv"));
        assert!(found[3].twin.is_some() && found[..3].iter().all(|night| night.twin.is_none()));
    }
}
