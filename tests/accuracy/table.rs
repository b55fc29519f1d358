//! The table of the errors found, a snapshot beside this file.

use std::fmt;

use system_tests::simulate::{Distance, Row, distance};
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
    /// Single precision against the oracle.
    pub(crate) single: Distance,
    /// Single precision against f64.
    pub(crate) single_rounding: Distance,
}

/// The distances of a line: f64, fixed point and single precision against the truth, fixed point and single precision against f64.
pub(crate) fn five(truth: &[Row], real: &[Row], fixed: &[Row], single: &[Row]) -> [Distance; 5] {
    let of = |run: &[Row]| distance(run, truth);
    [of(real), of(fixed), of(single), distance(fixed, real), distance(single, real)]
}

const HEAD: &str = "\
Largest error over all ticks at 1 kHz against the oracle at 1e-10: position in % of stroke, either pressure in % of supply.
drive    signal               f64 position  pressure   fixed position  pressure   fixed-f64 position  pressure   f32 position  pressure   f32-f64 position  pressure
";

/// Where the numbers begin in a row.
const COLUMN: usize = 30;
/// Largest change of an entry against the snapshot: another processor's libm, another release of the oracle's solver.
const RELATIVE: f64 = 0.05;
/// Added to it: the last digit of the table, %.
const LAST_DIGIT: f64 = 1.1e-6;

impl TableLine {
    /// A line with the distances of [`five`].
    pub(crate) fn of(drive: &str, signal: String, found: [Distance; 5]) -> Self {
        let [real, fixed, single, rounding, single_rounding] = found;
        Self { drive: drive.to_owned(), signal, real, fixed, rounding, single, single_rounding }
    }

    /// Compares the line with what is allowed against the oracle, and between fixed point or single precision and f64.
    ///
    /// # Panics
    /// It exceeds a limit.
    pub(crate) fn check(&self, allowed: Tolerance, rounding: Tolerance) {
        assert!(allowed.holds(self.real), "f64 misses {allowed:?}: {self}");
        assert!(allowed.holds(self.fixed), "fixed point misses {allowed:?}: {self}");
        assert!(rounding.holds(self.rounding), "fixed point and f64 part by more than {rounding:?}: {self}");
        assert!(allowed.holds(self.single), "single precision misses {allowed:?}: {self}");
        let near = rounding.holds(self.single_rounding);
        assert!(near, "single precision and f64 part by more than {rounding:?}: {self}");
    }
}

impl fmt::Display for TableLine {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let Self { drive, signal, real, fixed, rounding, single, single_rounding } = self;
        write!(formatter, "{drive:<8} {signal:<20}")?;
        for (found, wide) in [(real, 13), (fixed, 16), (rounding, 20), (single, 14), (single_rounding, 18)] {
            let (position, pressure) = (100.0 * found.position, 100.0 * found.pressure);
            write!(formatter, " {position:>wide$.6} {pressure:>9.6}")?;
        }
        Ok(())
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
