//! Sweeps of the same thing at several rates: a loop that shrinks with the rate is a lag, one that stays is hysteresis.
//!
//! With a lag τ the output of either way is late by the rate of the input times τ: width = hysteresis + 2·τ·rate.

use serde::Serialize;

use super::Statics;
use super::indications::{Evidence, Indication};

/// What the rates of the sweeps are known from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RateFrom {
    /// The recordings' clocks.
    Clock,
    /// The periods that were given.
    Period,
    /// The numbers of rows, as if all sweeps had been sampled alike: times are in rows.
    Rows,
}

/// The loop of one sweep.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoopAtRate {
    /// Which of the sweeps, from 0.
    pub sweep: usize,
    /// Its recording.
    pub recording: String,
    /// Time of a way up and down, s (rows with [`RateFrom::Rows`]).
    pub period: f64,
    /// Rate of the input, its unit a second (a row).
    pub rate: f64,
    /// Width of the loop, input unit.
    pub width: f64,
    /// Standard error of `width`.
    pub std_error: f64,
    /// Whether the loop is narrower than the curve's flank: a wider one no longer grows in proportion to the rate.
    pub narrow: bool,
}

impl LoopAtRate {
    /// Whether the loop is wider than its scatter.
    #[must_use]
    pub fn is_loop(&self) -> bool {
        Estimate { value: self.width.abs(), std: self.std_error }.is_sure()
    }
}

/// A value and its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub std: f64,
}

impl Estimate {
    /// Whether it is above zero with the certainty of three standard deviations of a normal distribution.
    #[must_use]
    pub fn is_sure(&self) -> bool {
        self.value > SURE_OF_BLOCKS * self.std
    }
}

/// What the loops of several sweeps are due to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// It shrinks as the sweep gets slower, and nothing is sure to stay.
    Lag,
    /// It stays.
    Hysteresis,
    /// A part of it shrinks and a part of it stays.
    Both,
    /// No sweep has a loop beyond its scatter.
    NoLoop,
    /// The rates are equal, or the widths not certain enough.
    Undecided,
}

/// Several sweeps compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// What the rates are known from.
    pub rate_from: RateFrom,
    /// The sweeps' loops, slowest first.
    pub loops: Vec<LoopAtRate>,
    /// Sweeps without a loop to be read.
    pub without_loop: Vec<String>,
    /// Width at rate zero, input unit, from the loops narrower than the flank. Where the loop shrinks with the rate, two unknowns take three of them, so
    /// that one is left over to check the line; else two. `None` where there are fewer.
    pub hysteresis: Option<Estimate>,
    /// Lag, s (rows with [`RateFrom::Rows`]), from the same loops as `hysteresis`; without one from all loops, and then a rough figure.
    pub lag: Option<Estimate>,
    /// By how much the widest loop of a fast sweep exceeds that of the slowest.
    pub shrinks_by: Option<Estimate>,
    /// Mean square of what the loops that `lag` is taken from are off the line, in standard errors; `None` through two loops.
    pub misfit: Option<f64>,
    /// The cause of the loops.
    pub cause: Cause,
}

/// A standard error from eight blocks is uncertain itself: Student's t with 7 degrees of freedom exceeds this as seldom (0.13 %) as a normal
/// distribution exceeds 3.
const SURE_OF_BLOCKS: f64 = 4.53;
/// Rates that are closer than this are one rate.
const ONE_RATE: f64 = 1.05;

/// Compares the loops of sweeps, each with its period (s, or rows) and the length of its steeper flank.
#[must_use]
pub fn compare(sweeps: &[(&Statics, f64)], rate_from: RateFrom) -> Comparison {
    let read = |(sweep, (statics, period)): (usize, &(&Statics, f64))| {
        let loops = statics.hysteresis?;
        let rate = 2.0 * (statics.input.high - statics.input.low) / period;
        let flank = statics.flank.unwrap_or(f64::INFINITY);
        let (width, narrow) = (loops.width, loops.width.abs() < flank);
        let recording = statics.recording.clone();
        Some(LoopAtRate { sweep, recording, period: *period, rate, width, std_error: loops.std_error, narrow })
    };
    let mut loops: Vec<LoopAtRate> = sweeps.iter().enumerate().filter_map(read).collect();
    loops.sort_by(|a, b| a.rate.total_cmp(&b.rate));
    let without_loop = sweeps.iter().filter(|sweep| sweep.0.hysteresis.is_none());
    let without_loop = without_loop.map(|sweep| sweep.0.recording.clone()).collect();
    let narrow: Vec<&LoopAtRate> = loops.iter().filter(|one| one.narrow).collect();
    let shrinks_by = shrinks_by(&loops);
    let shrinks = shrinks_by.is_some_and(|by| by.is_sure());
    let split = line(&narrow).filter(|_| narrow.len() > if shrinks { 2 } else { 1 });
    let used = split.or_else(|| line(&loops.iter().collect::<Vec<_>>()));
    let mut found = Comparison {
        rate_from,
        hysteresis: split.map(|line| line.hysteresis),
        misfit: used.and_then(|line| line.misfit),
        lag: used.map(|line| line.lag),
        shrinks_by,
        cause: Cause::Undecided,
        without_loop,
        loops,
    };
    found.cause = found.cause();
    found
}

impl Comparison {
    /// The effects of the catalogue that the loops show: hysteresis where a part of the loop surely stays however slow the sweep. With rates that are
    /// only supposed, none.
    #[must_use]
    pub fn indications(&self) -> Vec<Indication> {
        let stays = matches!(self.cause, Cause::Hysteresis | Cause::Both) && self.rate_from != RateFrom::Rows;
        let evidence = |width: Estimate| Evidence::LoopStays {
            width: width.value,
            std: width.std,
            sweeps: self.loops.iter().filter(|one| one.narrow).count(),
        };
        let found = self.hysteresis.filter(|_| stays).map(evidence);
        found.map(|evidence| Indication { effect: "valve-hysteresis", evidence }).into_iter().collect()
    }

    fn cause(&self) -> Cause {
        let loops = &self.loops;
        if !loops.is_empty() && loops.iter().all(|one| !one.is_loop()) {
            return Cause::NoLoop;
        }
        let shrinks = self.shrinks_by.is_some_and(|by| by.is_sure());
        let stays = self.hysteresis.is_some_and(|width| width.is_sure());
        match (shrinks, stays) {
            (true, false) => Cause::Lag,
            (false, true) => Cause::Hysteresis,
            (true, true) => Cause::Both,
            (false, false) => Cause::Undecided,
        }
    }
}

/// The widest loop less the slowest one's, where their rates differ.
fn shrinks_by(loops: &[LoopAtRate]) -> Option<Estimate> {
    let slowest = loops.first()?;
    let faster = loops.iter().filter(|one| one.rate > ONE_RATE * slowest.rate);
    let by = |one: &LoopAtRate| Estimate {
        value: one.width - slowest.width,
        std: libm::hypot(one.std_error, slowest.std_error),
    };
    faster.map(by).max_by(|a, b| (a.value / a.std).total_cmp(&(b.value / b.std)))
}

#[derive(Clone, Copy)]
struct Line {
    hysteresis: Estimate,
    lag: Estimate,
    misfit: Option<f64>,
}

/// width = hysteresis + 2·lag·rate by weighted least squares. The standard errors grow with the misfit where the loops lie further off the line
/// than theirs.
fn line(loops: &[&LoopAtRate]) -> Option<Line> {
    let (slowest, fastest) = (loops.first()?, loops.last()?);
    if fastest.rate <= ONE_RATE * slowest.rate {
        return None;
    }
    // A loop without scatter, as computed ones have, is known to a millionth.
    let least = 1e-6 * loops.iter().map(|one| one.width.abs()).fold(f64::MIN_POSITIVE, f64::max);
    let weight = |one: &LoopAtRate| 1.0 / one.std_error.max(least).powi(2);
    let sum = |of: &dyn Fn(&LoopAtRate) -> f64| loops.iter().map(|one| weight(one) * of(one)).sum::<f64>();
    let all = sum(&|_| 1.0);
    let (rate, width) = (sum(&|one| one.rate) / all, sum(&|one| one.width) / all);
    let square = sum(&|one| (one.rate - rate).powi(2));
    let slope = sum(&|one| (one.rate - rate) * (one.width - width)) / square;
    let at_zero = width - slope * rate;
    let off = sum(&|one| (one.width - at_zero - slope * one.rate).powi(2));
    let misfit = (loops.len() > 2).then(|| off / (loops.len() - 2) as f64);
    let grown = misfit.unwrap_or(1.0).max(1.0);
    let hysteresis = Estimate { value: at_zero, std: (grown * (1.0 / all + rate * rate / square)).sqrt() };
    let lag = Estimate { value: slope / 2.0, std: (grown / square).sqrt() / 2.0 };
    Some(Line { hysteresis, lag, misfit })
}
