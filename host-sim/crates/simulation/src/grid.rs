//! The core's tick grid over a recording.

use model_core::machine::Tick;
use recording::{Recording, median_interval};

use crate::error::SimulateError;

/// Most ticks of one simulation, or of a part of one: 14 hours at 1 kHz.
const MAX_TICKS: usize = 50_000_000;

/// Where the grid of a recording begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Origin {
    /// Time of point 0, s.
    pub(crate) time_s: f64,
    /// The point at which a part of a recording begins; what is before it was simulated with the part before.
    pub(crate) point: usize,
}

impl Origin {
    /// For a whole recording: its first row.
    pub(crate) fn of(recording: &Recording) -> Self {
        Self { time_s: recording.time_s()[0], point: 0 }
    }
}

/// The core's grid over a recording.
pub(crate) struct Grid<'a> {
    time_s: &'a [f64],
    tick_s: f64,
    origin: Origin,
    pub(crate) ticks: usize,
    /// For each row, counted from the point where the recording begins; for an earlier row, that point.
    pub(crate) rows: Vec<(usize, f64)>,
}

impl<'a> Grid<'a> {
    pub(crate) fn new(recording: &'a Recording, tick: Tick, origin: Origin) -> Result<Self, SimulateError> {
        let time_s = recording.time_s();
        let tick_s = tick.seconds();
        let duration_s = time_s[time_s.len() - 1] - origin.time_s - origin.point as f64 * tick_s;
        if duration_s / tick_s > MAX_TICKS as f64 {
            let recording = recording.name().to_owned();
            return Err(SimulateError::TooLong { recording, duration_s, tick_s, limit: MAX_TICKS });
        }
        let rows: Vec<(usize, f64)> = time_s
            .iter()
            .map(|time| {
                let at = (time - origin.time_s) / tick_s;
                // Times are written with a few digits: within a thousandth of a tick a row counts as on the grid.
                let nearest = at.round();
                let (point, share) =
                    if (at - nearest).abs() < 1e-3 { (nearest, 0.0) } else { (at.floor(), at - at.floor()) };
                let since = point - origin.point as f64;
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "0..MAX_TICKS by the check above"
                )]
                if since < 0.0 { (0, 0.0) } else { (since as usize, share) }
            })
            .collect();
        let ticks = rows.last().map_or(0, |(point, share)| point + usize::from(*share > 0.0));
        Ok(Self { time_s, tick_s, origin, ticks, rows })
    }

    /// For each tick, the last recorded value at or before its start.
    pub(crate) fn held(&self, values: &[f64]) -> Vec<f64> {
        let mut row = 0;
        (0..self.ticks)
            .map(|tick| {
                while self
                    .rows
                    .get(row + 1)
                    .is_some_and(|(point, share)| *point < tick || (*point == tick && *share == 0.0))
                {
                    row += 1;
                }
                values[row]
            })
            .collect()
    }

    /// At each grid point, the recorded values, linear in between.
    pub(crate) fn points(&self, values: &[f64]) -> Vec<f64> {
        let time = |point: usize| self.origin.time_s + (self.origin.point + point) as f64 * self.tick_s;
        between_rows(self.time_s, values, (0..=self.ticks).map(time))
    }
}

/// Whether so few rows were recorded that the fast half of a drive does not show: below 50 Hz.
#[must_use]
pub fn is_sparse(time_s: &[f64]) -> bool {
    /// 50 Hz by a clock that is a hundredth slow: a tenth of it, 2 ms, is the coarsest tick of the core.
    const SPARSE_FROM_S: f64 = 1.01 / 50.0;
    let intervals = time_s.len().saturating_sub(1).max(1) as f64;
    let mean_is =
        time_s.last().zip(time_s.first()).is_some_and(|(last, first)| (last - first) / intervals > SPARSE_FROM_S);
    // A gap makes no row rarer.
    mean_is && median_interval(time_s) > SPARSE_FROM_S
}

/// A series with one value for each row, at other times in their order: linear between rows, held before the first and after the last.
pub fn between_rows(row_s: &[f64], values: &[f64], times_s: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut row = 0;
    times_s
        .map(|time| {
            while row + 2 < row_s.len() && row_s[row + 1] <= time {
                row += 1;
            }
            let share = ((time - row_s[row]) / (row_s[row + 1] - row_s[row])).clamp(0.0, 1.0);
            // Exactly the recorded value where a row is at that time.
            let share = if (share - share.round()).abs() < 1e-6 { share.round() } else { share };
            if share >= 1.0 { values[row + 1] } else { values[row] + share * (values[row + 1] - values[row]) }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_sparse_below_50_hz_and_not_at_it() {
        let every = |row_s: f64| is_sparse(&(0..1000).map(|row| f64::from(row) * row_s).collect::<Vec<_>>());
        assert!(!every(1e-3) && !every(0.02) && !every(0.020_01));
        assert!(every(0.0205) && every(0.053));
        assert!(!is_sparse(&[]) && !is_sparse(&[1.0]));
        // A pause between two quick stretches makes no row rarer.
        let pause = (0..2000).map(|row| 1e-3 * f64::from(row) + if row < 1000 { 0.0 } else { 300.0 });
        assert!(!is_sparse(&pause.collect::<Vec<_>>()));
    }

    #[test]
    fn rows_are_joined_by_straight_lines() {
        let rows: Vec<f64> = (0..600).map(|row| 2.0 * f64::from(row)).collect();
        let row_s: Vec<f64> = (0..600).map(|row| 1e-3 * f64::from(row)).collect();
        let points = between_rows(&row_s, &rows, row_s.iter().copied());
        assert_eq!(points.len(), rows.len());
        assert!(points.iter().enumerate().all(|(point, value)| (value - 2.0 * point as f64).abs() < 1e-9));
        // Between rows, before the first and after the last.
        let off = between_rows(&row_s, &rows, [-1.0, 0.25e-3, 10.75e-3, 5.0].into_iter());
        assert!(off.iter().zip([0.0, 0.5, 21.5, 1198.0]).all(|(found, true_value)| (found - true_value).abs() < 1e-9));
    }
}
