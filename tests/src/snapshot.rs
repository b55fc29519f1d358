//! A table of results, kept beside the tests.

use std::path::PathBuf;

/// Prints a table and compares it with a snapshot line by line, or renews the snapshot where `RENEW` is set. `file` is below this package.
///
/// # Panics
/// They differ by more than `near` allows; it gets a line that was found and the line that was kept.
pub fn compare(file: &str, table: &str, near: impl Fn(&str, &str) -> bool) {
    println!("{table}");
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(file);
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(path, table).unwrap_or_else(|error| panic!("{file}: {error}"));
        return;
    }
    let snapshot = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{file}: {error}"));
    assert_eq!(snapshot.lines().count(), table.lines().count(), "{file} has other rows; RENEW=1 writes it anew");
    for (found, kept) in table.lines().zip(snapshot.lines()) {
        assert!(near(found, kept), "no longer `{kept}` but `{found}`; RENEW=1 writes {file} anew");
    }
}

/// Whether two lines have the same name up to a column, and after it numbers that differ by at most a share of the kept number plus
/// an absolute amount. Lines without such numbers have to be equal.
#[must_use]
pub fn numbers_near(found: &str, kept: &str, column: usize, relative: f64, absolute: f64) -> bool {
    let parsed = |line: &str| -> Option<(String, Vec<f64>)> {
        let (name, numbers) = line.split_at_checked(column)?;
        let numbers = numbers.split_whitespace().map(|number| number.parse().ok()).collect::<Option<Vec<f64>>>()?;
        Some((name.trim().to_owned(), numbers))
    };
    match (parsed(found), parsed(kept)) {
        (Some((name, found)), Some((kept_name, kept))) => {
            let near = |(found, kept): (&f64, &f64)| (found - kept).abs() <= relative * kept + absolute;
            name == kept_name && found.len() == kept.len() && found.iter().zip(&kept).all(near)
        }
        _ => found == kept,
    }
}
