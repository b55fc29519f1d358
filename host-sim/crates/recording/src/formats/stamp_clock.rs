//! The times of rows that share coarse time stamps: one even clock through all stamps that fit one, else even within each stamp.

use super::coarse_stamps::LEAST_STAMPS;

/// By rounding, whichever way, stamps lie within one of their steps about their clock, and a little for the clock's own error.
const ROUNDED: f64 = 1.02;
/// With jitter they lie within this many steps about it.
const JITTERED: f64 = 1.5;

/// Stamps as they usually are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Usual {
    /// From one stamp to the next, s.
    pub(crate) step_s: f64,
    /// From one row to the next, s.
    pub(crate) interval_s: f64,
}

/// A stamp and its rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stamp {
    /// What it says, s.
    at_s: f64,
    /// Its first row.
    first: usize,
    /// The number of its rows.
    pub(crate) rows: usize,
    /// The stamp after it, s.
    next_s: Option<f64>,
}

impl Stamp {
    /// Those of rows whose times are stamps; `next_s` is the stamp after them, if one is known.
    pub(crate) fn all_of(times_s: &[f64], next_s: Option<f64>) -> Vec<Self> {
        let mut stamps: Vec<Self> = Vec::new();
        let mut first = 0;
        for rows in times_s.chunk_by(|a, b| a.to_bits() == b.to_bits()) {
            if let Some(before) = stamps.last_mut() {
                before.next_s = Some(rows[0]);
            }
            stamps.push(Self { at_s: rows[0], first, rows: rows.len(), next_s });
            first += rows.len();
        }
        stamps
    }

    /// To the stamp after it, s; the usual step where none is known.
    fn step_s(&self, usual: Usual) -> f64 {
        self.next_s.map_or(usual.step_s, |next_s| next_s - self.at_s)
    }

    /// Times of its rows, spread evenly within it: those of a recording's first stamp at its end, those of the last at its start.
    pub(crate) fn spread(&self, usual: Usual, is_first: bool) -> Even {
        let slot_s = self.step_s(usual).min(usual.step_s);
        let rows = self.rows as f64;
        let interval_s = usual.interval_s.min(slot_s / rows);
        // A full stamp begins with its own time.
        let free_s = slot_s - rows * interval_s;
        let begins_s = match self.next_s {
            None => 0.0,
            Some(_) if is_first => free_s,
            Some(_) => 0.5 * free_s,
        };
        Even { from_s: self.at_s, begins_s, interval_s, first: self.first, rows: self.rows }
    }
}

/// Rows at an even interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Even {
    /// The stamp of the first row, s.
    from_s: f64,
    /// From there to the first row, s.
    begins_s: f64,
    /// From one row to the next, s.
    pub(crate) interval_s: f64,
    /// The first row.
    first: usize,
    /// The number of rows.
    pub(crate) rows: usize,
}

impl Even {
    /// The clock of as many of these stamps from the first on as fit one, and their number. What is allowed to jitter would draw in stamps from
    /// beyond the end of a stretch: it is not allowed where a stretch ends and most of it is without jitter.
    pub(crate) fn longest(stamps: &[Stamp], usual: Usual) -> Option<(usize, Self)> {
        let within = |steps: f64| Self::longest_within(steps * usual.step_s, stamps, usual);
        let jittered = within(JITTERED)?;
        within(ROUNDED).filter(|rounded| jittered.0 < stamps.len() && 2 * rounded.0 > jittered.0).or(Some(jittered))
    }

    fn longest_within(most_s: f64, stamps: &[Stamp], usual: Usual) -> Option<(usize, Self)> {
        let through = |count: usize| Self::through(stamps.get(..count)?, most_s, usual);
        let mut clock = through(LEAST_STAMPS)?;
        let (mut fit, mut beyond) = (LEAST_STAMPS, 2 * LEAST_STAMPS);
        while let Some(longer) = through(beyond.min(stamps.len())).filter(|_| fit < stamps.len()) {
            (clock, fit, beyond) = (longer, beyond.min(stamps.len()), 2 * beyond);
        }
        while fit + 1 < beyond {
            let middle = fit.midpoint(beyond);
            match through(middle) {
                Some(longer) => (clock, fit) = (longer, middle),
                None => beyond = middle,
            }
        }
        Some((fit, clock))
    }

    /// The clock of all these stamps, if they lie within so much about it. Its interval is the least-squares slope of the stamps over the middle
    /// row of each, but of the first and the last, which may lack rows. It runs as early as it can with no row before its stamp. Where jitter
    /// then leaves rows after their stamp's end, it is off by the same either way.
    fn through(stamps: &[Stamp], most_s: f64, usual: Usual) -> Option<Self> {
        let (start, end) = (stamps.first()?, stamps.last()?);
        if stamps.len() < LEAST_STAMPS {
            return None;
        }
        let since = |stamp: &Stamp| (stamp.at_s - start.at_s, (stamp.first - start.first) as f64);
        let inner = &stamps[1..stamps.len() - 1];
        let points = || {
            inner.iter().map(|stamp| {
                let (at_s, first) = since(stamp);
                (first + 0.5 * (stamp.rows as f64 - 1.0), at_s)
            })
        };
        let count = inner.len() as f64;
        let (row, at_s) = points().fold((0.0, 0.0), |sum, point| (sum.0 + point.0 / count, sum.1 + point.1 / count));
        let (of_rows, of_both) = points().fold((0.0, 0.0), |sum, point| {
            let by = point.0 - row;
            (sum.0 + by * by, sum.1 + by * (point.1 - at_s))
        });
        let interval_s = of_both / of_rows;
        let (mut latest_s, mut earliest_s) = (f64::NEG_INFINITY, f64::INFINITY);
        for stamp in stamps {
            let (at_s, first) = since(stamp);
            latest_s = latest_s.max(at_s - first * interval_s);
            earliest_s = earliest_s.min(at_s - (first + stamp.rows as f64 - 1.0) * interval_s);
        }
        (interval_s > 0.0 && latest_s - earliest_s <= most_s).then(|| Self {
            from_s: start.at_s,
            begins_s: latest_s.min(0.5 * (latest_s + earliest_s + usual.step_s)),
            interval_s,
            first: start.first,
            rows: end.first + end.rows - start.first,
        })
    }

    /// Writes its times into those of all rows, each after `last_s`, the time of the row before it.
    pub(crate) fn write(&self, times_s: &mut [f64], last_s: &mut f64) {
        for (index, time_s) in times_s[self.first..][..self.rows].iter_mut().enumerate() {
            let even_s = self.from_s + self.begins_s + index as f64 * self.interval_s;
            // By jitter rows from before a pause can reach beyond it.
            *time_s = even_s.max(*last_s + 0.5 * self.interval_s);
            *last_s = *time_s;
        }
    }
}
