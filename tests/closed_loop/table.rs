//! The table of tracking errors, a snapshot beside this file.

use std::fmt;
use std::path::PathBuf;

/// A machine, and how its controllers follow: root of the mean square of the true distance to the set point.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// Counts of the encoder, and what the controllers were not told.
    pub(crate) name: String,
    /// Model-following control.
    pub(crate) following_mm: f64,
    /// Its largest distance.
    pub(crate) following_worst_mm: f64,
    /// The PI controller.
    pub(crate) plain_mm: f64,
    /// The PI controller that jumps over the valve's overlap.
    pub(crate) jumping_mm: f64,
}

const HEAD: &str = "\
Distance of the rod to its set point, mm: root of the mean square (and largest).  Counts of the encoder a turn, and what is different.
counts  machine              following  largest        PI  PI over overlap  following / better PI
";

/// Largest change of an entry against the snapshot: another processor's libm turns a controller between two encoder steps otherwise.
const RELATIVE: f64 = 0.15;
/// And, mm.
const ABSOLUTE_MM: f64 = 0.004;

impl Line {
    /// Error of model-following control over that of the better PI controller.
    pub(crate) fn share(&self) -> f64 {
        self.following_mm / self.plain_mm.min(self.jumping_mm)
    }

    fn numbers(&self) -> [f64; 4] {
        [self.following_mm, self.following_worst_mm, self.plain_mm, self.jumping_mm]
    }

    fn parse(text: &str) -> Option<(String, [f64; 4])> {
        let (name, numbers) = text.split_at_checked(28)?;
        let numbers: Vec<f64> = numbers.split_whitespace().take(4).map_while(|number| number.parse().ok()).collect();
        Some((name.trim().to_owned(), numbers.try_into().ok()?))
    }
}

impl fmt::Display for Line {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let [following, worst, plain, jumping] = self.numbers();
        let (name, share) = (&self.name, self.share());
        write!(formatter, "{name:<28} {following:>9.3} {worst:>8.3} {plain:>9.3} {jumping:>16.3} {share:>22.2}")
    }
}

/// Prints the table and compares it with the snapshot, or renews that.
///
/// # Panics
/// They differ.
pub(crate) fn compare(lines: &[Line]) {
    let body: Vec<String> = lines.iter().map(Line::to_string).collect();
    let table = format!("{HEAD}{}\n", body.join("\n"));
    println!("{table}");
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("closed_loop/table.txt");
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(file, table).unwrap();
        return;
    }
    let snapshot = std::fs::read_to_string(file).unwrap();
    let wanted: Vec<_> = snapshot.lines().skip(HEAD.lines().count()).map(Line::parse).collect();
    assert_eq!(wanted.len(), lines.len(), "the snapshot has other rows; RENEW=1 writes it anew");
    for (line, wanted) in lines.iter().zip(wanted) {
        let (name, wanted) = wanted.expect("a row of the snapshot has a name and four numbers");
        assert_eq!(line.name.trim(), name, "the snapshot has other rows; RENEW=1 writes it anew");
        for (found, wanted) in line.numbers().into_iter().zip(wanted) {
            let near = (found - wanted).abs() <= RELATIVE * wanted + ABSOLUTE_MM;
            assert!(near, "{name}: {found} is no longer {wanted}; RENEW=1 writes the snapshot anew");
        }
    }
}
