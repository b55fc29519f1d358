//! Readings at an end of a sensor's range: what is beyond it reads as the end.
//!
//! A signal may stay at its highest or lowest value for other reasons: a rod rests against its stop, oil does not fall below the tank's
//! pressure. What gives the end of a range away is that the noise is missing there, although the sensor has some, or, in a sensor without
//! visible noise, that a pressure or force comes and goes at full slope. A spool's sensor ends at full travel. Some sensors end before their noise is
//! added: just inside the range it lifts a row or two beyond the end.

use recording::Signal;

use crate::signal::noise::{extent, median};

/// Readings at an end of a sensor's range.
#[derive(Clone, Debug, PartialEq)]
pub struct RangeEnd {
    /// What it reads there, SI.
    pub reading: f64,
    /// Which end it is.
    pub side: Side,
    /// Rows with this reading or beyond, and those between them where noise lifts it off for a moment.
    pub rows: Vec<bool>,
}

impl RangeEnd {
    /// Number of these rows.
    #[must_use]
    pub fn count(&self) -> usize {
        self.rows.iter().filter(|row| **row).count()
    }

    /// The same end in another recording of that sensor; `None` where its readings do not come so far, or go on beyond.
    #[must_use]
    pub fn in_other(&self, values: &[f64]) -> Option<Self> {
        let Self { reading, side, .. } = *self;
        let at_end = || joined(values.iter().map(|value| side.is_reached(reading, *value)).collect());
        side.is_end(reading, values).then(|| Self { reading, side, rows: at_end() })
    }
}

/// The two ends of a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The lowest reading.
    Low,
    /// The highest one.
    High,
}

impl Side {
    /// Whether a reading is at this end or beyond.
    pub(crate) fn is_reached(self, end: f64, reading: f64) -> bool {
        self.is_passed(end, reading) || reading.to_bits() == end.to_bits()
    }

    /// Whether a reading is beyond this end.
    fn is_passed(self, end: f64, reading: f64) -> bool {
        match self {
            Side::Low => reading < end,
            Side::High => reading > end,
        }
    }

    /// Whether a sensor that reads these values ends there: it comes so far, and hardly ever further.
    pub(crate) fn is_end(self, end: f64, values: &[f64]) -> bool {
        let count = |is: &dyn Fn(f64) -> bool| values.iter().filter(|value| is(**value)).count() as f64;
        let reached = count(&|value| self.is_reached(end, value));
        let is_there = values.iter().any(|value| value.to_bits() == end.to_bits());
        is_there && count(&|value| self.is_passed(end, value)) <= (MOST_BEYOND * reached).max(1.0)
    }

    /// The reading nearest to this end that is repeated, if that is where the values end: a row or two may be beyond it.
    fn repeated(self, values: &[f64]) -> Option<f64> {
        let runs = values.windows(LEAST_RUN).filter(|run| run.iter().all(|value| value.to_bits() == run[0].to_bits()));
        let outermost = |a: f64, b: f64| if self.is_passed(a, b) { b } else { a };
        runs.map(|run| run[0]).reduce(outermost).filter(|end| self.is_end(*end, values))
    }
}

/// Rows beyond an end, at most, as a share of those that reach it; one row may always be.
const MOST_BEYOND: f64 = 0.02;
/// Noise lifts a row so many standard deviations, or steps, beyond an end at most.
const BEYOND_NOISE: f64 = 6.0;
/// Fewest rows in a row that show a missing noise or a visit.
const LEAST_RUN: usize = 4;
/// Fewest rows at an end, as a share: with less a fit loses nothing by judging them.
const LEAST_SHARE: f64 = 0.005;
/// A sensor has visible noise where this is more than so many of its steps: at 0.6 steps it repeats a reading in 60 % of the rows at most …
const VISIBLE_STEPS: f64 = 0.6;
/// … and more than this share of the span: computed series have less.
const VISIBLE_SPAN: f64 = 3e-5;
/// The most often that such noise repeats a reading.
const REPEATS_MOST: f64 = 0.6;
/// Rows in which a sensor at rest is looked for, and the share of them that repeat the reading before.
const REST_ROWS: usize = 32;
const REST_REPEATS: f64 = 0.8;
/// A reading that repeats for so long is the end of the range if noise causes it less often than once in this many recordings.
const ONCE_IN: f64 = 1e5;
/// The highest reading is a step below full scale in two's complement: at 11 bits half of this.
const NEAR_FULL_SCALE: f64 = 1e-3;
/// Rows between two at the end that are as close as this are at the end but for noise.
const GAP_ROWS: usize = 8;
/// A smooth turn that keeps a reading for four rows is at most four steps off two rows later, by its parabola; twice that is a corner.
const CORNER_STEPS: f64 = 8.0;
/// Fewest visits with a corner at both ends, so that one event does not count as a range.
const LEAST_VISITS: usize = 3;
/// A pressure below this, Pa, is as low as oil in a tank line or a vacuum is: it may well rest there.
const TANK_PA: f64 = 2e5;

/// What a sensor reads at the ends of its range, with its noise and step; the highest reading first.
pub(crate) fn range_ends(signal: Signal, values: &[f64], step: f64) -> Vec<RangeEnd> {
    let (low, high) = extent(values);
    let may = |side: Side, end: f64| {
        // At 0 a drive rests: no velocity, no flow, the rod run in. Nor is a tank's pressure an end.
        end != 0.0 && !(side == Side::Low && is_pressure(signal) && end.abs() < TANK_PA)
    };
    let sides = [Side::High, Side::Low];
    let ends: Vec<(Side, f64)> = sides.into_iter().filter_map(|side| Some((side, side.repeated(values)?))).collect();
    if low >= high {
        return Vec::new();
    }
    let readings = Readings { signal, values, step, span: high - low, rests: rests_elsewhere(values, &ends) };
    let mut found: Vec<RangeEnd> = ends
        .iter()
        .filter(|(side, end)| may(*side, *end))
        .filter_map(|(side, end)| readings.at_end(*side, *end))
        .collect();
    for (side, end) in [(Side::High, high), (Side::Low, low)] {
        if found.iter().all(|known| known.side != side) {
            found.extend(readings.at_full_scale(side, end));
        }
    }
    found
}

fn is_pressure(signal: Signal) -> bool {
    matches!(signal, Signal::PressureA | Signal::PressureB | Signal::SupplyPressure | Signal::TankPressure)
}

/// What a sensor reads.
struct Readings<'a> {
    signal: Signal,
    values: &'a [f64],
    /// Its resolution.
    step: f64,
    /// Difference between its highest and lowest reading.
    span: f64,
    /// Whether it rests away from its ends as well.
    rests: bool,
}

impl Readings<'_> {
    /// The end of a spool's range, where a spool that overshoots passes it for so few rows that a missing noise shows nothing: its sensor is scaled to its
    /// travel, and ends there or a step before. What stays there for longer may be a spool at its stop.
    fn at_full_scale(&self, side: Side, end: f64) -> Option<RangeEnd> {
        let is_full = self.signal == Signal::Spool && (end.abs() - 1.0).abs() <= NEAR_FULL_SCALE;
        let rows: Vec<bool> = self.values.iter().map(|value| side.is_reached(end, *value)).collect();
        let longest = rows.chunk_by(|a, b| a == b).filter(|visit| visit[0]).map(<[bool]>::len).max();
        (is_full && longest.is_some_and(|rows| !self.is_rare(rows))).then_some(RangeEnd { reading: end, side, rows })
    }

    /// Whether visible noise hardly ever repeats a reading in so many rows.
    fn is_rare(&self, rows: usize) -> bool {
        let times = i32::try_from(rows - 1).unwrap_or(i32::MAX);
        REPEATS_MOST.powi(times) * self.values.len() as f64 * ONCE_IN < 1.0
    }

    /// The end of the range, if this reading is one.
    fn at_end(&self, side: Side, end: f64) -> Option<RangeEnd> {
        let Self { signal, values, step, span, rests } = *self;
        let is_there = |value: &f64| side.is_reached(end, *value);
        let count = values.iter().filter(|value| is_there(value)).count();
        if (count as f64) < LEAST_SHARE * values.len() as f64 || count < 2 * LEAST_RUN {
            return None;
        }
        let visits: Vec<(usize, usize)> = visits(values, is_there);
        let longest = visits.iter().map(|(from, to)| to - from).max()?;
        let noise = noise_beside(values, &visits);
        let is_noise =
            |value: &f64| !side.is_passed(end, *value) || (value - end).abs() <= BEYOND_NOISE * noise.max(step);
        if !values.iter().all(is_noise) {
            return None;
        }
        let is_silent = !rests && noise > (VISIBLE_STEPS * step).max(VISIBLE_SPAN * span) && self.is_rare(longest);
        let cuts = matches!(signal, Signal::PressureA | Signal::PressureB | Signal::Force);
        let has_corners = || {
            let off = |row: Option<usize>| row.and_then(|row| values.get(row)).map(|value| (value - end).abs());
            let corner = |row| off(row).is_none_or(|off| off > CORNER_STEPS * step.max(noise));
            let cornered = |(from, to): &&(usize, usize)| corner(from.checked_sub(2)) && corner(Some(to + 1));
            let cornered = visits.iter().filter(cornered).count();
            cuts && cornered >= LEAST_VISITS && 5 * cornered >= 4 * visits.len()
        };
        (is_silent || has_corners()).then(|| RangeEnd {
            reading: end,
            side,
            rows: joined(values.iter().map(is_there).collect()),
        })
    }
}

/// Runs of at least a few rows at an end.
fn visits(values: &[f64], is_there: impl Fn(&f64) -> bool) -> Vec<(usize, usize)> {
    let mut visits = Vec::new();
    let mut from = 0;
    for row in 0..=values.len() {
        if row == values.len() || !is_there(&values[row]) {
            if row - from >= LEAST_RUN {
                visits.push((from, row));
            }
            from = row + 1;
        }
    }
    visits
}

/// Standard deviation of white noise in the rows just before and after the visits: that of third differences, as of a whole signal, in the
/// median of the visits. A signal that comes smoothly, however fast, has little of it.
fn noise_beside(values: &[f64], visits: &[(usize, usize)]) -> f64 {
    const ROWS: usize = 8;
    let third = |w: &[f64]| ((w[3] - w[0]) - 3.0 * (w[2] - w[1])).powi(2) / 20.0;
    let of = |rows: &[f64]| {
        let squares: Vec<f64> = rows.windows(4).map(third).collect();
        (squares.len() > 2).then(|| squares.iter().sum::<f64>() / squares.len() as f64)
    };
    let mut found: Vec<f64> = visits
        .iter()
        .flat_map(|&(from, to)| {
            let (before, after) =
                (&values[from.saturating_sub(ROWS)..from], &values[to..(to + ROWS).min(values.len())]);
            [of(before), of(after)]
        })
        .flatten()
        .collect();
    median(&mut found).sqrt()
}

/// Whether it also repeats a reading for some time away from both ends, as a sensor at rest without visible noise does.
fn rests_elsewhere(values: &[f64], ends: &[(Side, f64)]) -> bool {
    let is_between = |value: f64| ends.iter().all(|(side, end)| !side.is_reached(*end, value));
    values.chunks_exact(REST_ROWS).any(|rows| {
        let repeats = |pair: &&[f64]| is_between(pair[0]) && pair[0].to_bits() == pair[1].to_bits();
        rows.windows(2).filter(repeats).count() as f64 > REST_REPEATS * REST_ROWS as f64
    })
}

/// Rows with those between two that are close.
fn joined(mut rows: Vec<bool>) -> Vec<bool> {
    let mut last = None;
    for row in 0..rows.len() {
        if !rows[row] {
            continue;
        }
        if let Some(last) = last.filter(|last| row - last <= GAP_ROWS) {
            rows[last..row].fill(true);
        }
        last = Some(row);
    }
    rows
}
