//! The loop between the way up and the way down: its width at the same output, on each flank of the curve.

use simulation::signal::noise::extent;

use super::branch::Branch;
use super::curve::{Hysteresis, Null, Sweep};
use super::indications::SURE;
use super::line::{median, median_and_std};
use super::shape::{Extreme, Shape};

/// Levels of the output at which the loop is read.
const LEVELS: u32 = 200;
/// Fewest levels at which both ways have to be seen.
const LEAST_LEVELS: usize = 10;
/// Blocks of neighbouring levels that the standard error is taken from.
const BLOCKS: usize = 8;

/// The two ways along one flank.
struct Flank {
    up: Branch,
    down: Branch,
}

impl Sweep<'_> {
    /// Input by which the output may stay behind where the input turns: the loop, as far as it is known.
    pub(crate) fn play(&self) -> f64 {
        self.hysteresis(None).map_or(0.0, |found| found.width.abs() + SURE * found.std_error)
    }

    /// The loop between each branch and the next, where every level is passed once.
    pub(crate) fn hysteresis(&self, null: Option<Null>) -> Option<Hysteresis> {
        self.loop_between(&self.pairs(), extent(self.output), null)
    }

    /// The loop on both flanks of a maximum or a minimum; elsewhere as of a monotone curve, and none of a curve that turns back otherwise.
    pub(crate) fn loop_of(&self, shape: &Shape, null: Option<Null>) -> Option<Hysteresis> {
        match shape {
            Shape::Monotone { .. } | Shape::TurnsBack { small_once: true, .. } => self.hysteresis(null),
            Shape::Peak(extreme) | Shape::Valley(extreme) => {
                self.loop_between(&self.flanks(extreme), levels_of(extreme), None)
            }
            _ => None,
        }
    }

    /// Input that the steeper flank takes from a quarter to three quarters of its height: a loop that is narrower lies within the flank.
    pub(crate) fn flank(&self, shape: &Shape) -> Option<f64> {
        let (pairs, (low, high)) = match shape.extreme() {
            Some(extreme) => (self.flanks(extreme), levels_of(extreme)),
            None => (self.pairs(), extent(self.output)),
        };
        let at = |share: f64| low + share * (high - low);
        let length = |branch: &Branch| {
            let crossing = |level| branch.crossing(self.input, self.output, level);
            crossing(at(0.75)).zip(crossing(at(0.25))).map(|(upper, lower)| (upper - lower).abs())
        };
        let lengths: Vec<f64> =
            pairs.iter().flat_map(|flank| [length(&flank.up), length(&flank.down)]).flatten().collect();
        lengths.into_iter().reduce(f64::min)
    }

    fn pairs(&self) -> Vec<Flank> {
        let pair = |pair: &[Branch]| {
            let (up, down) = if pair[0].rising { (&pair[0], &pair[1]) } else { (&pair[1], &pair[0]) };
            Flank { up: up.clone(), down: down.clone() }
        };
        self.branches.windows(2).map(pair).collect()
    }

    /// Each branch divided at its extreme.
    fn flanks(&self, extreme: &Extreme) -> Vec<Flank> {
        let divided = |branch: &Branch| -> Option<[Branch; 2]> {
            let top = if branch.rising { extreme.rising? } else { extreme.falling? };
            let passed = |row: &usize| (self.input[*row] >= top) == branch.rising;
            let at = branch.rows.clone().find(passed)?;
            let part = |rows| Branch { rows, rising: branch.rising };
            let (before, after) = (part(branch.rows.start..at), part(at..branch.rows.end));
            let long = before.rows.len() > 1 && after.rows.len() > 1;
            long.then_some(if branch.rising { [before, after] } else { [after, before] })
        };
        let both = |flank: Flank| divided(&flank.up).zip(divided(&flank.down));
        let flanks = self.pairs().into_iter().filter_map(both).flat_map(|(up, down)| {
            let [lower_up, upper_up] = up;
            let [lower_down, upper_down] = down;
            [Flank { up: lower_up, down: lower_down }, Flank { up: upper_up, down: upper_down }]
        });
        flanks.collect()
    }

    fn loop_between(&self, flanks: &[Flank], (low, high): (f64, f64), null: Option<Null>) -> Option<Hysteresis> {
        let mut widths = Vec::new();
        for flank in flanks {
            for index in 1..LEVELS {
                let level = low + (high - low) * f64::from(index) / f64::from(LEVELS);
                let crossing = |branch: &Branch| branch.crossing(self.input, self.output, level);
                widths.extend(crossing(&flank.up).zip(crossing(&flank.down)).map(|(up, down)| up - down));
            }
        }
        if widths.len() < LEAST_LEVELS {
            return None;
        }
        let (width, std) = median_and_std(&widths);
        let blocks: Vec<f64> =
            widths.chunks(widths.len().div_ceil(BLOCKS)).map(|block| median(block.to_vec())).collect();
        let count = blocks.len() as f64;
        let mean = blocks.iter().sum::<f64>() / count;
        let variance = blocks.iter().map(|block| (block - mean).powi(2)).sum::<f64>() / (count - 1.0);
        // A crossing lies anywhere between two rows, on all levels alike: evenly spread on either branch.
        let rows = self.branches.iter().map(|branch| branch.rows.len()).max().unwrap_or(0).max(2) as f64;
        let (from, to) = extent(self.input);
        let at_null = null.and_then(|null| null.rising.zip(null.falling)).map(|(rising, falling)| rising - falling);
        Some(Hysteresis {
            width,
            std,
            std_error: libm::hypot((variance / count).sqrt(), (to - from) / (rows - 1.0) / 6_f64.sqrt()),
            levels: widths.len(),
            at_null,
            share_of_span: width / (to - from),
        })
    }
}

/// The levels that both flanks pass: from the higher end to the maximum.
fn levels_of(extreme: &Extreme) -> (f64, f64) {
    let peak = extreme.output > f64::midpoint(extreme.lower_end, extreme.upper_end);
    let ends = (extreme.lower_end, extreme.upper_end);
    if peak { (ends.0.max(ends.1), extreme.output) } else { (extreme.output, ends.0.min(ends.1)) }
}
