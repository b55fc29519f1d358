//! What kind of curve a recording shows, judged against its own scatter: only a monotone one has a gain, a null and a dead zone.

use serde::Serialize;

use simulation::signal::noise::extent;

use super::branch::Branch;
use super::course::{Course, Place};
use super::curve::{SMALL, Sweep};

/// The kind of a curve.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Shape {
    /// Nowhere turns back by more than its scatter.
    Monotone {
        /// Whether the output rises with the input.
        rising: bool,
    },
    /// Changes nowhere by more than its scatter.
    Constant {
        /// Mean output.
        mean: f64,
        /// Scatter of its rows.
        scatter: f64,
    },
    /// One maximum inside, and down to half of its height on either side.
    Peak(Extreme),
    /// One minimum inside, and up to half of its depth on either side.
    Valley(Extreme),
    /// Turns back, once or more often.
    TurnsBack {
        /// The places at which it turns, with both ends, on one branch: input and output.
        turns: Vec<(f64, f64)>,
        /// Whether small outputs (below 40 % of the largest) are passed once only: then null and dead zone are clear all the same.
        small_once: bool,
    },
    /// Its branches are of different kinds.
    BranchesDiffer,
}

/// A maximum or a minimum between two lower or two higher ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Extreme {
    /// Output there, mean of the branches.
    pub output: f64,
    /// Standard error of `output`: of the means, and of the branches about each other.
    pub std: f64,
    /// Input there, mean of the rising and the falling branches.
    pub input: f64,
    /// Input there on rising branches.
    pub rising: Option<f64>,
    /// Input there on falling branches.
    pub falling: Option<f64>,
    /// Output at the lower end of the input.
    pub lower_end: f64,
    /// Output at the upper end of the input.
    pub upper_end: f64,
    /// Width of the input within which the output is beyond half of its height over the mean of both ends.
    pub width_at_half_height: f64,
}

/// Most means along a branch, to tell its kind and to read its extreme.
const PLACES: usize = 40;
const FINE_PLACES: usize = 100;
/// A branch tells the kind of the curve if it covers this share of the input's span.
const WHOLE: f64 = 0.75;
/// Least change that counts, as a share of the output's span.
const LEAST: f64 = 1e-3;

impl Shape {
    /// Whether gain, null and dead zone can be read.
    #[must_use]
    pub fn has_edges(&self) -> bool {
        matches!(self, Shape::Monotone { .. } | Shape::TurnsBack { small_once: true, .. })
    }

    /// Whether the gain can be followed along the input.
    #[must_use]
    pub fn is_monotone(&self) -> bool {
        matches!(self, Shape::Monotone { .. })
    }

    /// The maximum or minimum inside.
    #[must_use]
    pub fn extreme(&self) -> Option<&Extreme> {
        match self {
            Shape::Peak(extreme) | Shape::Valley(extreme) => Some(extreme),
            _ => None,
        }
    }
}

/// What one branch shows.
struct Run {
    rising: bool,
    course: Course,
    fine: Course,
    turns: Vec<Place>,
}

impl Run {
    /// How often it turns, and whether it rises first.
    fn kind(&self) -> (usize, Option<bool>) {
        let first = self.turns.first().zip(self.turns.get(1));
        (self.turns.len().min(4), first.map(|(from, to)| from.output < to.output))
    }
}

/// Factors on the threshold of a turn. Branches repeat each other: where they are of different kinds, a turn that only one of them has is looked at more
/// strictly, since noise that lasts longer than the means reach makes turns.
const STRICTER: [f64; 3] = [1.0, 1.5, 2.0];

/// The kind of the curve. Behind each turn of the input, `play` of it is left out: there the branch leaves the other one.
pub(crate) fn shape(sweep: &Sweep<'_>, play: f64) -> Shape {
    let (low, high) = extent(sweep.output);
    let mut runs = runs(sweep, play);
    let mut alike = false;
    for times in STRICTER {
        for run in &mut runs {
            run.turns = run.course.turns(LEAST * (high - low), times);
        }
        alike = runs.windows(2).all(|pair| pair[0].kind() == pair[1].kind());
        if alike {
            break;
        }
    }
    let Some(first) = runs.first() else { return Shape::BranchesDiffer };
    if !alike {
        let all_turn_back = runs.iter().all(|run| run.turns.len() > 2);
        return if all_turn_back { turns_back(&runs) } else { Shape::BranchesDiffer };
    }
    match first.kind() {
        (0, _) => {
            let mean = sweep.output.iter().sum::<f64>() / sweep.output.len() as f64;
            Shape::Constant { mean, scatter: runs.iter().map(|run| run.course.scatter).fold(0.0, f64::max) }
        }
        (2, rising) => Shape::Monotone { rising: rising == Some(true) },
        (3, up) => {
            let up = up == Some(true);
            match extreme(&runs, up) {
                Some(found) if up => Shape::Peak(found),
                Some(found) => Shape::Valley(found),
                None => turns_back(&runs),
            }
        }
        _ => turns_back(&runs),
    }
}

fn runs(sweep: &Sweep<'_>, play: f64) -> Vec<Run> {
    let (low, high) = extent(sweep.input);
    let run = |branch: &Branch, first: bool| {
        let mut points = branch.points(sweep.input, sweep.output);
        let behind = if first { 0.0 } else { play.min(0.25 * (high - low)) };
        let turned = sweep.input[branch.rows.start];
        points.retain(|point| (point.0 - turned).abs() >= behind);
        let (course, fine) = (Course::of(&points, PLACES), Course::of(&points, FINE_PLACES));
        Run { rising: branch.rising, course, fine, turns: Vec::new() }
    };
    let covers = |branch: &Branch| {
        let inside = extent(&sweep.input[branch.rows.clone()]);
        inside.1 - inside.0 > WHOLE * (high - low)
    };
    let all = sweep.branches.iter().enumerate();
    all.filter(|(_, branch)| covers(branch)).map(|(index, branch)| run(branch, index == 0)).collect()
}

fn turns_back(runs: &[Run]) -> Shape {
    let turns: Vec<(f64, f64)> = runs[0].turns.iter().map(|place| (place.input, place.output)).collect();
    let largest = |sign: f64| turns.iter().map(|turn| sign * turn.1).fold(0.0, f64::max);
    // The way that the curve goes as a whole, and the stretches against it.
    let rises = |pair: &[Place]| pair[1].output > pair[0].output;
    let against = |run: &Run| {
        let whole = run.turns.windows(2).max_by(|a, b| f64::total_cmp(&height(a), &height(b))).is_some_and(rises);
        let back: Vec<(f64, f64)> = run
            .turns
            .windows(2)
            .filter(|pair| rises(pair) != whole)
            .map(|pair| (pair[0].output.min(pair[1].output), pair[0].output.max(pair[1].output)))
            .collect();
        back
    };
    let beyond_small = |&(low, high): &(f64, f64)| low > SMALL.end * largest(1.0) || high < -SMALL.end * largest(-1.0);
    let small_once = runs.iter().flat_map(against).all(|stretch| beyond_small(&stretch));
    Shape::TurnsBack { turns, small_once }
}

fn height(pair: &[Place]) -> f64 {
    (pair[1].output - pair[0].output).abs()
}

/// The extreme of branches that have one inside each; `None` if they do not come back to half of its height on both sides.
fn extreme(runs: &[Run], peak: bool) -> Option<Extreme> {
    let sign = if peak { 1.0 } else { -1.0 };
    let highest = |run: &Run| -> Option<Place> {
        run.fine.places.iter().copied().max_by(|a, b| (sign * a.output).total_cmp(&(sign * b.output)))
    };
    let tops: Vec<Place> = runs.iter().filter_map(highest).collect();
    let mean = |values: &[f64]| (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
    let end = |place: fn(&Course) -> Option<&Place>| {
        mean(&runs.iter().filter_map(|run| place(&run.fine)).map(|place| place.output).collect::<Vec<_>>())
    };
    let (lower_end, upper_end) = (end(|course| course.places.first())?, end(|course| course.places.last())?);
    let way = |rising: bool| {
        let inputs = runs.iter().zip(&tops).filter(|(run, _)| run.rising == rising).map(|(_, top)| top.input);
        mean(&inputs.collect::<Vec<_>>())
    };
    let (rising, falling) = (way(true), way(false));
    let input = rising.zip(falling).map(|(rising, falling)| f64::midpoint(rising, falling)).or(rising).or(falling)?;
    let output = mean(&tops.iter().map(|top| top.output).collect::<Vec<_>>())?;
    let half = f64::midpoint(output, f64::midpoint(lower_end, upper_end));
    let width = |(run, top): (&Run, &Place)| width_at(&run.fine, *top, half, sign);
    let widths: Vec<f64> = runs.iter().zip(&tops).map(width).collect::<Option<_>>()?;
    let width_at_half_height = mean(&widths)?;
    let count = tops.len() as f64;
    let between = tops.iter().map(|top| (top.output - output).powi(2)).sum::<f64>() / count / (count - 1.0).max(1.0);
    let within = tops.iter().map(|top| top.error * top.error).sum::<f64>() / (count * count);
    let std = (between + within).sqrt();
    Some(Extreme { output, std, input, rising, falling, lower_end, upper_end, width_at_half_height })
}

/// Width of the input beyond a level about the extreme; `None` if a side does not come back to it.
fn width_at(course: &Course, top: Place, level: f64, sign: f64) -> Option<f64> {
    let within = |place: &&Place| sign * (place.output - level) > 0.0;
    let below = course.places.iter().rev().filter(|place| place.input < top.input).find(|place| !within(place))?;
    let above = course.places.iter().filter(|place| place.input > top.input).find(|place| !within(place))?;
    let next = |from: &Place, step: f64| {
        let inner = course.places.iter().filter(|place| step * (place.input - from.input) > 0.0);
        let inner = inner.min_by(|a, b| (a.input - from.input).abs().total_cmp(&(b.input - from.input).abs()))?;
        let share = (level - from.output) / (inner.output - from.output);
        Some(from.input + share * (inner.input - from.input))
    };
    Some(next(above, -1.0)? - next(below, 1.0)?)
}
