//! The table of tracking errors, a snapshot beside this file.

use std::fmt;

use system_tests::snapshot;

/// A machine, and how well its controllers follow: root of the mean square of the true distance to the set point.
#[derive(Clone, Debug)]
pub(crate) struct TableLine {
    /// Counts of the encoder, and what the controllers do not know.
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

/// Where the numbers begin in a row, and where the last one begins.
const COLUMN: usize = 28;
const SHARE: usize = 74;
/// Largest change of an entry against the snapshot: another processor's libm can move a controller to the next encoder step.
const RELATIVE: f64 = 0.15;
/// Added to it, mm.
const ABSOLUTE_MM: f64 = 0.004;

impl TableLine {
    /// Error of model-following control over that of the better PI controller.
    pub(crate) fn share(&self) -> f64 {
        self.following_mm / self.plain_mm.min(self.jumping_mm)
    }

    fn numbers(&self) -> [f64; 4] {
        [self.following_mm, self.following_worst_mm, self.plain_mm, self.jumping_mm]
    }
}

impl fmt::Display for TableLine {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let [following, worst, plain, jumping] = self.numbers();
        let (name, share) = (&self.name, self.share());
        write!(formatter, "{name:<COLUMN$} {following:>9.3} {worst:>8.3} {plain:>9.3} {jumping:>16.3} {share:>22.2}")
    }
}

/// Prints the table and compares it with the snapshot, or renews the snapshot.
///
/// # Panics
/// They differ.
pub(crate) fn compare(lines: &[TableLine]) {
    let body: Vec<String> = lines.iter().map(TableLine::to_string).collect();
    // The share follows from the errors before it.
    let errors = |line: &str| line.get(..SHARE).unwrap_or(line).to_owned();
    snapshot::compare("closed_loop/table.txt", &format!("{HEAD}{}\n", body.join("\n")), |found, kept| {
        snapshot::numbers_near(&errors(found), &errors(kept), COLUMN, RELATIVE, ABSOLUTE_MM)
    });
}
