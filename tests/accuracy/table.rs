//! The table of the errors found, a snapshot beside this file.

use std::fmt;

use system_tests::simulate::Distance;
use system_tests::snapshot;

use crate::tolerances::Tolerance;

/// A drive on a signal.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TableLine {
    /// Which drive.
    pub(crate) drive: String,
    /// Which signal.
    pub(crate) signal: String,
    /// f64 against the oracle.
    pub(crate) real: Distance,
    /// Fixed point against the oracle.
    pub(crate) fixed: Distance,
    /// Fixed point against f64.
    pub(crate) rounding: Distance,
}

const HEAD: &str = "\
Largest error over all ticks at 1 kHz against the oracle at 1e-10: position in % of stroke, either pressure in % of supply.
drive    signal               f64 position  pressure   fixed position  pressure   fixed-f64 position  pressure
";

/// Where the numbers begin in a row.
const COLUMN: usize = 30;
/// Largest change of an entry against the snapshot: another processor's libm, another release of the oracle's solver.
const RELATIVE: f64 = 0.05;
/// Added to it: the last digit of the table, %.
const LAST_DIGIT: f64 = 1.1e-6;

impl TableLine {
    fn numbers(&self) -> [f64; 6] {
        let of = |found: Distance| [100.0 * found.position, 100.0 * found.pressure];
        let ([a, b], [c, d], [e, f]) = (of(self.real), of(self.fixed), of(self.rounding));
        [a, b, c, d, e, f]
    }

    /// Compares the line with what is allowed against the oracle, and between fixed point and f64.
    ///
    /// # Panics
    /// It exceeds a limit.
    pub(crate) fn check(&self, allowed: Tolerance, rounding: Tolerance) {
        assert!(allowed.holds(self.real), "f64 misses {allowed:?}: {self}");
        assert!(allowed.holds(self.fixed), "fixed point misses {allowed:?}: {self}");
        assert!(rounding.holds(self.rounding), "fixed point and f64 part by more than {rounding:?}: {self}");
    }
}

impl fmt::Display for TableLine {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let [a, b, c, d, e, f] = self.numbers();
        let (drive, signal) = (&self.drive, &self.signal);
        write!(formatter, "{drive:<8} {signal:<20} {a:>13.6} {b:>9.6} {c:>16.6} {d:>9.6} {e:>20.6} {f:>9.6}")
    }
}

/// Prints the table and compares it with the snapshot of this name, or renews the snapshot.
///
/// # Panics
/// They differ.
pub(crate) fn compare(name: &str, lines: &[TableLine]) {
    let body: Vec<String> = lines.iter().map(TableLine::to_string).collect();
    snapshot::compare(&format!("accuracy/{name}"), &format!("{HEAD}{}\n", body.join("\n")), |found, kept| {
        snapshot::numbers_near(found, kept, COLUMN, RELATIVE, LAST_DIGIT)
    });
}
