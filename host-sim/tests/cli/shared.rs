//! Cases that are not part of the repository, where they are available.

use std::path::Path;

use super::{at_hand, done};

fn recordings(case: &Path) -> Vec<String> {
    let files = std::fs::read_dir(case).unwrap().map(|entry| entry.unwrap().path());
    let mut recordings: Vec<String> = files
        .filter(|path| path.extension().is_some_and(|extension| extension == "csv"))
        .map(|path| path.display().to_string())
        .collect();
    recordings.sort();
    recordings
}

#[test]
fn every_case_at_hand_is_simulated_and_compared() {
    let Some(folder) = at_hand::shared("concealed") else { return };
    let out = tempfile::tempdir().unwrap();
    let mut seen = 0;
    for entry in std::fs::read_dir(&folder).unwrap() {
        let case = entry.unwrap().path();
        let machine = case.join("machine.toml").display().to_string();
        if !Path::new(&machine).is_file() {
            continue;
        }
        let recordings = recordings(&case);
        let mut arguments = vec!["compare", "--machine", &machine, "--recording"];
        arguments.extend(recordings.iter().map(String::as_str));
        let printed = done(out.path(), &arguments);
        assert!(printed.contains("end to end") && printed.contains("weakest is"), "{printed}");
        for recording in &recordings {
            done(out.path(), &["simulate", "--machine", &machine, "--recording", recording, "--out", "out.csv"]);
            let rows = |path: &Path| std::fs::read_to_string(path).unwrap().lines().count();
            assert_eq!(rows(&out.path().join("out.csv")), rows(Path::new(recording)), "{recording}");
        }
        seen += 1;
    }
    assert!(seen > 0, "{} holds no case", folder.display());
    println!("{seen} cases");
}
