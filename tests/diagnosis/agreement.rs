//! Recordings and a machine file that do not belong together are told apart from drives that only lack physics.

use std::path::{Path, PathBuf};
use std::time::Instant;

use diagnosis::agreement::{Doubt, doubts};
use diagnosis::base_parameters;

fn of_folder(folder: &Path) -> Vec<Doubt> {
    let (file, recordings) = test_press::folder(folder);
    doubts(&file, &base_parameters(&file), &recordings.iter().collect::<Vec<_>>()).unwrap()
}

#[test]
fn no_drive_at_hand_is_refused() {
    let mut seen = 0;
    for set in ["concealed", "concealed-hard", "foreign"] {
        let Some(set) = system_tests::at_hand::shared(set) else { continue };
        let mut folders: Vec<PathBuf> = std::fs::read_dir(set).unwrap().map(|entry| entry.unwrap().path()).collect();
        folders.retain(|folder| folder.join("machine.toml").is_file());
        folders.sort();
        for folder in folders {
            let begun = Instant::now();
            let found = of_folder(&folder);
            println!("{}: {:.2} s", folder.display(), begun.elapsed().as_secs_f64());
            for doubt in &found {
                println!("{doubt:?}");
            }
            assert!(found.iter().all(|doubt| !doubt.is_certain), "{}", folder.display());
            seen += 1;
        }
    }
    println!("{seen} drives");
}
