//! A table of what was found, kept beside the tests.

use std::path::PathBuf;

fn file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("on_target").join(name)
}

/// Compares a table with the snapshot of this name line by line, or renews that where `RENEW` is set.
///
/// # Panics
/// They differ by more than `near` allows.
pub(crate) fn compare(name: &str, table: &str, near: impl Fn(&str, &str) -> bool) {
    println!("{table}");
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(file(name), table).unwrap();
        return;
    }
    let snapshot = std::fs::read_to_string(file(name)).unwrap();
    assert_eq!(snapshot.lines().count(), table.lines().count(), "{name} has other rows; RENEW=1 writes it anew");
    for (found, kept) in table.lines().zip(snapshot.lines()) {
        assert!(near(found, kept), "no longer `{kept}` but `{found}`; RENEW=1 writes {name} anew");
    }
}
