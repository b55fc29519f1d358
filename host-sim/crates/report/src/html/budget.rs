//! How much of the recordings is put into one page, drawings and numbers together, so that it can be sent by mail.

use diagnosis::{Diagnosis, Shown};

/// Approximate number of bytes for everything that is drawn over time, in a page of 3 MB.
const BYTES: f64 = 2_100_000.0;
/// Share of it for the drawings; the numbers for the script take the other part.
const OF_DRAWINGS: f64 = 0.4;
/// Bytes of a panel's frame, grid, labels and headings.
const PER_PANEL: f64 = 6_000.0;
/// Bytes of a point of a drawing.
const PER_POINT: f64 = 11.0;
/// Bytes of a number for the script, and of the time of a thinned row.
const PER_NUMBER: f64 = 4.5;
/// Fewest and most points of a drawn trace.
const POINTS: (f64, f64) = (150.0, 700.0);
/// Fewest rows for the script.
const LEAST_ROWS: f64 = 300.0;
/// Panels at the top of the page and beside the localisation.
const BESIDE: f64 = 5.0;

/// What every recording may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Budget {
    /// Recordings that are drawn, in the order of [`Budget::drawn`].
    pub(crate) recordings: usize,
    /// Points of a drawn trace.
    pub(crate) points: usize,
    /// Rows of a panel for the script.
    pub(crate) rows: usize,
}

impl Budget {
    /// The budget for all recordings that are shown.
    pub(crate) fn of(diagnosis: &Diagnosis) -> Self {
        let panels = diagnosis.shown.iter().map(|shown| shown.prepared.channels.len()).max().unwrap_or(1);
        Self::shared(diagnosis.shown.len(), panels, if diagnosis.changes() { 2 } else { 1 })
    }

    /// The budget for this number of recordings and panels, each with what was recorded and this number of simulations with their residuals.
    pub(crate) fn shared(recordings: usize, panels: usize, simulations: usize) -> Self {
        let (series, traces) = (1.0 + simulations as f64, 1.0 + 2.0 * simulations as f64);
        let per_panel =
            |points: f64, rows: f64| PER_PANEL + PER_POINT * traces * points + PER_NUMBER * (series + 0.5) * rows;
        let most = BYTES / per_panel(POINTS.0, LEAST_ROWS) - BESIDE;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
        let fitting = (most / panels.max(1) as f64).max(1.0) as usize;
        let recordings = recordings.min(fitting);
        let all = (recordings * panels) as f64 + BESIDE;
        let left = BYTES / all - PER_PANEL;
        let points = (OF_DRAWINGS * left / (PER_POINT * traces)).clamp(POINTS.0, POINTS.1);
        let rows = ((left - PER_POINT * traces * points) / (PER_NUMBER * (series + 0.5))).max(LEAST_ROWS);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded above and below")]
        Self { recordings, points: points as usize, rows: rows as usize }
    }

    /// Whether a recording is drawn: the held-out ones first, then those trained on.
    pub(crate) fn draws(&self, all: &[Shown], shown: &Shown) -> bool {
        let first = |held_out: bool| all.iter().filter(move |other| other.held_out == held_out);
        first(true).chain(first(false)).take(self.recordings).any(|drawn| std::ptr::eq(drawn, shown))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::data::{for_page, time};
    use crate::plot::{Panel, Style, Trace, svg};

    /// Bytes of the drawings and numbers of this number of recordings of four noisy signals, four seconds at 1 kHz.
    fn bytes(budget: Budget) -> usize {
        let time_s: Vec<f64> = (0..4000).map(|row| f64::from(row) * 1e-3).collect();
        let mut seed = 11_u64;
        let mut noisy = || -> Vec<f64> {
            time_s
                .iter()
                .map(|time| {
                    seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    40.0 * (3.0 * time).sin() + (seed >> 40) as f64 / f64::from(1_u32 << 24)
                })
                .collect()
        };
        let panel = Panel::new("Pressure A", "bar", time_s.clone())
            .trace(Trace::new("recorded", noisy(), Style::Recorded))
            .trace(Trace::new("before", noisy(), Style::Before))
            .trace(Trace::new("after", noisy(), Style::After));
        let panel = Panel { points: Some(budget.points), ..panel.residuals() };
        let panels = vec![panel; 4];
        budget.recordings * (svg("", "", &panels).len() + for_page(&time(&panels, budget.rows)).len())
    }

    #[test]
    fn six_recordings_twenty_and_a_hundred_leave_a_page_below_three_megabytes() {
        // The other parts of a page: the library, tables, and pictures of effects, states and correlations.
        let rest = 60_000 + 500_000;
        for recordings in [1, 6, 20, 100] {
            let budget = Budget::shared(recordings, 4, 2);
            let bytes = bytes(budget) * (4 * recordings + 5) / (4 * recordings);
            println!("{recordings} recordings, {budget:?}: {bytes} bytes");
            assert!(bytes + rest < 3_000_000, "{recordings} recordings, {budget:?}: {bytes} bytes");
        }
    }

    #[test]
    fn few_recordings_are_shown_in_full_and_many_in_part() {
        let few = Budget::shared(6, 4, 2);
        assert!(few.recordings == 6 && few.points > 400 && few.rows > 2500, "{few:?}");
        let many = Budget::shared(20, 4, 2);
        assert!(many.recordings == 20 && many.rows >= 300 && many.rows < few.rows, "{many:?}");
        let crowd = Budget::shared(500, 6, 2);
        assert!(crowd.recordings < 60 && crowd.recordings > 10, "{crowd:?}");
        for budget in [few, many, crowd] {
            let panels = budget.recordings as f64 * if budget == crowd { 6.0 } else { 4.0 };
            let bytes = panels * (PER_PANEL + 55.0 * budget.points as f64 + 15.75 * budget.rows as f64);
            assert!(bytes < BYTES, "{budget:?}: {bytes}");
        }
    }
}
