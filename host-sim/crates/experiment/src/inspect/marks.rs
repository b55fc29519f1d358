//! Where a channel is suspicious: stretches of time, to be marked in a chart.

use simulation::sensor_fault::{FailureKind, Failures};

/// What is suspicious.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkKind {
    /// One to three readings that no working sensor gives.
    Spike,
    /// The sensor jumped away, repeated one reading, and jumped back.
    Dropout,
    /// The sensor repeated one reading.
    Stuck,
    /// The sensor is at an end of its range.
    RangeEnd,
}

impl MarkKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Spike, Self::Dropout, Self::Stuck, Self::RangeEnd];

    /// Its name in documents.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            MarkKind::Spike => "spike",
            MarkKind::Dropout => "dropout",
            MarkKind::Stuck => "stuck",
            MarkKind::RangeEnd => "range-end",
        }
    }
}

/// A stretch of time in which a channel is suspicious.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// What is suspicious.
    pub kind: MarkKind,
    /// Time of its first row, s.
    pub from_s: f64,
    /// Time of its last row, s.
    pub to_s: f64,
    /// What the sensor reads, SI; of a spike the reading of its first row.
    pub reading: f64,
}

/// The marks of one channel, by kind and in the order of time.
pub(super) fn marks(time_s: &[f64], values: &[f64], failures: &Failures) -> Vec<Mark> {
    let mark =
        |kind, (from, last): (usize, usize), reading| Mark { kind, from_s: time_s[from], to_s: time_s[last], reading };
    let spikes = runs(&failures.spikes).into_iter().map(|rows| mark(MarkKind::Spike, rows, values[rows.0]));
    let stretches = failures.stretches.iter().map(|stretch| {
        let kind = match stretch.kind {
            FailureKind::Dropout => MarkKind::Dropout,
            FailureKind::Stuck => MarkKind::Stuck,
        };
        mark(kind, (stretch.from, stretch.to - 1), stretch.reading)
    });
    let ends = failures
        .ends
        .iter()
        .flat_map(|end| runs(&end.rows).into_iter().map(move |rows| mark(MarkKind::RangeEnd, rows, end.reading)));
    let mut all: Vec<Mark> = spikes.chain(stretches).chain(ends).collect();
    let order = |kind: MarkKind| MarkKind::ALL.iter().position(|known| *known == kind);
    all.sort_by(|a, b| order(a.kind).cmp(&order(b.kind)).then(a.from_s.total_cmp(&b.from_s)));
    all
}

/// First and last row of each run of rows that are set.
fn runs(rows: &[bool]) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize)> = Vec::new();
    for row in (0..rows.len()).filter(|row| rows[*row]) {
        match found.last_mut() {
            Some((_, last)) if *last + 1 == row => *last = row,
            _ => found.push((row, row)),
        }
    }
    found
}

/// Stretches without rows, (from, to) in s: intervals of more than one and a half usual ones.
pub(super) fn gaps(time_s: &[f64], interval_s: f64) -> Vec<(f64, f64)> {
    const LOST: f64 = 1.5;
    let is_gap = |pair: &&[f64]| pair[1] - pair[0] > LOST * interval_s;
    time_s.windows(2).filter(is_gap).map(|pair| (pair[0], pair[1])).collect()
}

#[cfg(test)]
mod tests {
    use recording::Signal;

    use super::*;

    #[test]
    fn a_spike_a_stuck_sensor_and_a_gap_are_marked_where_they_are() {
        let mut time_s: Vec<f64> = (0..2000).map(|row| f64::from(row) * 1e-3).collect();
        let mut values: Vec<f64> = time_s.iter().map(|time| 0.1 + 0.02 * (7.0 * time).sin()).collect();
        values[300] = 0.9;
        values[900..1100].fill(0.3);
        let failures = Failures::of(Signal::Position, &time_s, &values);
        let found = marks(&time_s, &values, &failures);
        let kinds: Vec<MarkKind> = found.iter().map(|mark| mark.kind).collect();
        assert_eq!(kinds, [MarkKind::Spike, MarkKind::Dropout], "{found:?}");
        assert!((found[0].from_s - 0.3).abs() < 1e-9 && (found[0].reading - 0.9).abs() < 1e-9, "{found:?}");
        assert!((found[1].from_s - 0.9).abs() < 1e-9 && (found[1].to_s - 1.099).abs() < 1e-9, "{found:?}");
        time_s.drain(500..510);
        let gap = gaps(&time_s, 1e-3);
        assert!(gap.len() == 1 && (gap[0].0 - 0.499).abs() < 1e-9 && (gap[0].1 - 0.51).abs() < 1e-9, "{gap:?}");
    }
}
