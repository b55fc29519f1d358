//! `studio`: the page, or how to get it.

use tempfile::tempdir;

#[cfg(not(feature = "studio"))]
#[test]
fn a_program_without_the_studio_says_how_to_get_it_and_writes_nothing() {
    let said = crate::refused(tempdir().unwrap().path(), &["studio", "--out", "studio.html"]);
    assert!(said.contains("--features studio") && said.contains("from a release"), "{said}");
}

#[cfg(feature = "studio")]
#[test]
fn the_studio_is_one_page() {
    let folder = tempdir().unwrap();
    crate::done(folder.path(), &["studio", "--out", "studio.html"]);
    let text = std::fs::read_to_string(folder.path().join("studio.html")).unwrap();
    assert!(text.starts_with("<!doctype html>") && text.contains("Nothing leaves this computer"));
}
