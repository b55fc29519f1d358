//! The static characteristic: width of its loop, null, edges of the dead zone, gain and where the gain falls.

use serde::Serialize;

use simulation::signal::noise::extent;

use super::branch::Branch;
use super::indications::SURE;
use super::line::FittedLine;

/// The loop between rising and falling input.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Hysteresis {
    /// Horizontal distance of the branches, input unit: median over levels of the output, positive where the output lags.
    pub width: f64,
    /// Scatter of the width over the levels (1.4826 × median absolute deviation), input unit.
    pub std: f64,
    /// Standard error of `width`, from what eight blocks of neighbouring levels differ by (levels next to each other are not independent) and from the
    /// distance of the rows.
    pub std_error: f64,
    /// Number of levels at which it was read.
    pub levels: usize,
    /// Distance of the branches' nulls.
    pub at_null: Option<f64>,
    /// `width` over the span of the input.
    pub share_of_span: f64,
}

/// Where the output is zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Null {
    /// Mean of the branches, input unit.
    pub input: f64,
    /// Null of the rising branches.
    pub rising: Option<f64>,
    /// Null of the falling branches.
    pub falling: Option<f64>,
}

/// Where one sign of the output begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Edge {
    /// Where a line through small outputs (5–40 % of the largest) meets zero, input unit.
    pub extrapolated: f64,
    /// Last input at rest and first input with an output above a thousandth of the largest, where there are rows at rest.
    pub begins_between: Option<(f64, f64)>,
    /// Slope of the line: the gain there.
    pub gain: f64,
}

/// The gain in one interval of the input.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LocalGain {
    /// From this input.
    pub from: f64,
    /// To this one.
    pub to: f64,
    /// Rise of the output over rise of the input.
    pub gain: f64,
    /// Standard error of `gain`; 0 between two rows of a table.
    pub std_error: f64,
    /// Mean output in the interval.
    pub output: f64,
}

/// From here on to the end of the sweep the gain is less than a share of the gain at small outputs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Saturation {
    /// Share of the gain at small outputs.
    pub share: f64,
    /// From this input on.
    pub from: f64,
    /// Whether the gain has fallen at the upper end of the sweep.
    pub upper: bool,
}

/// Rows of a sweep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sweep<'a> {
    pub(crate) input: &'a [f64],
    pub(crate) output: &'a [f64],
    pub(crate) branches: &'a [Branch],
}

/// Share of the largest output within which a line is fitted to find the edge of the dead zone.
pub(crate) const SMALL: std::ops::Range<f64> = 0.05..0.4;
/// Output below this share of the largest counts as none.
const REST: f64 = 1e-3;

impl Sweep<'_> {
    fn largest(&self, sign: f64) -> f64 {
        self.output.iter().map(|value| sign * value).fold(0.0, f64::max)
    }

    /// The line through small outputs of one sign, over some rows.
    fn edge_line(&self, points: &[(f64, f64)], sign: f64) -> Option<FittedLine> {
        let largest = self.largest(sign);
        // A sign whose output stays so small is noise or leakage.
        if largest < 0.05 * self.largest(-sign) {
            return None;
        }
        let mut opened: Vec<(f64, f64)> =
            points.iter().copied().filter(|point| sign * point.1 / largest >= SMALL.start).collect();
        opened.sort_by(|a, b| (sign * a.1).total_cmp(&(sign * b.1)));
        // In a table with few rows, the three smallest outputs are used. Where no output is small, nothing is known of where it begins.
        let small = opened.iter().take_while(|point| sign * point.1 / largest < SMALL.end).count();
        opened.truncate(if small > 0 { small.max(3) } else { 0 });
        let line = FittedLine::robust(&opened).filter(|line| line.slope != 0.0)?;
        // A line is followed no further than it is long.
        let (from, to) = extent(opened.iter().map(|point| point.0));
        let zero = line.zero();
        (from - zero <= to - from && zero - to <= to - from).then_some(line)
    }

    fn null_of(&self, branch: &Branch) -> Option<f64> {
        let points = branch.points(self.input, self.output);
        let [above, below] = [1.0, -1.0].map(|sign| self.edge_line(&points, sign).map(FittedLine::zero));
        above.zip(below).map(|(above, below)| f64::midpoint(above, below))
    }

    /// Where the output is zero: midway between the edges of both signs, for each direction of the input.
    pub(crate) fn null(&self) -> Option<Null> {
        let mean = |rising: bool| {
            let nulls: Vec<f64> =
                self.branches.iter().filter(|branch| branch.rising == rising).filter_map(|b| self.null_of(b)).collect();
            (!nulls.is_empty()).then(|| nulls.iter().sum::<f64>() / nulls.len() as f64)
        };
        let (rising, falling) = (mean(true), mean(false));
        let input = match (rising, falling) {
            (Some(rising), Some(falling)) => f64::midpoint(rising, falling),
            (one, other) => one.or(other)?,
        };
        Some(Null { input, rising, falling })
    }

    /// Where an output of this sign begins.
    pub(crate) fn edge(&self, sign: f64) -> Option<Edge> {
        let each: Vec<FittedLine> = self
            .branches
            .iter()
            .filter_map(|branch| self.edge_line(&branch.points(self.input, self.output), sign))
            .collect();
        let count = each.len() as f64;
        let extrapolated = each.iter().map(|line| line.zero()).sum::<f64>() / count;
        let gain = each.iter().map(|line| line.slope).sum::<f64>() / count;
        (!each.is_empty()).then(|| Edge { extrapolated, begins_between: self.begins(sign, gain), gain })
    }

    /// The last input at rest and the first one that moves with this sign.
    fn begins(&self, sign: f64, gain: f64) -> Option<(f64, f64)> {
        let none = REST * self.largest(1.0).max(self.largest(-1.0));
        let outwards = sign * gain.signum();
        let rows = || self.input.iter().zip(self.output).map(|(input, output)| (outwards * input, sign * output));
        let at_rest: Vec<f64> = rows().filter(|row| row.1.abs() <= none).map(|row| row.0).collect();
        let rest = at_rest.iter().copied().fold(f64::MIN, f64::max);
        let first = rows().filter(|row| row.1 > none && row.0 > rest).map(|row| row.0).fold(f64::MAX, f64::min);
        (at_rest.len() > 1 && first < f64::MAX).then_some((outwards * rest, outwards * first))
    }

    /// The gain along the input, in intervals that hold several levels of a staircase of this step; at each turn the input
    /// moves by `play` before the output follows.
    pub(crate) fn gains(&self, gain: f64, step: Option<f64>, play: f64) -> Vec<LocalGain> {
        const DENSE: usize = 200;
        let (low, high) = extent(self.input);
        let (low, high) = if 4.0 * play < high - low { (low + play, high - play) } else { (low, high) };
        let rows_covered: usize = self.branches.iter().map(|branch| branch.rows.len()).sum();
        if rows_covered < DENSE {
            return self.gains_of_table(0.02 * (high - low));
        }
        let least = step.map_or(0.0, |step| 6.0 * step / gain.abs());
        let count = ((high - low) / least.max((high - low) / 20.0)).floor().max(2.0);
        let width = (high - low) / count;
        let mut found = Vec::new();
        let places = std::iter::successors(Some(0.0), |index| Some(index + 1.0)).take_while(|index| *index < count);
        for index in places {
            let from = low + width * index;
            let inside = |branch: &Branch| -> Vec<(f64, f64)> {
                let mut points = branch.points(self.input, self.output);
                points.retain(|point| (from..=from + width).contains(&point.0));
                points
            };
            let points: Vec<Vec<(f64, f64)>> = self.branches.iter().map(inside).filter(|p| p.len() > 4).collect();
            let lines: Vec<(FittedLine, f64)> = points
                .iter()
                .filter_map(|points| FittedLine::through(points).map(|line| (line, line.slope_error(points))))
                .collect();
            if lines.is_empty() {
                continue;
            }
            let branches = lines.len() as f64;
            let gain = lines.iter().map(|line| line.0.slope).sum::<f64>() / branches;
            let std_error = lines.iter().map(|line| line.1 * line.1).sum::<f64>().sqrt() / branches;
            let all = points.iter().flatten();
            let output = all.clone().map(|point| point.1).sum::<f64>() / all.count() as f64;
            found.push(LocalGain { from, to: from + width, gain, std_error, output });
        }
        found
    }

    /// The same for a table of few rows: the gain from row to row; rows closer than `least` are joined.
    fn gains_of_table(&self, least: f64) -> Vec<LocalGain> {
        let mut points: Vec<(f64, f64)> =
            self.branches.iter().flat_map(|branch| branch.points(self.input, self.output)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut found = Vec::new();
        let Some(mut from) = points.first().copied() else { return found };
        for &to in &points {
            if to.0 - from.0 > least {
                let gain = (to.1 - from.1) / (to.0 - from.0);
                let output = f64::midpoint(from.1, to.1);
                found.push(LocalGain { from: from.0, to: to.0, gain, std_error: 0.0, output });
                from = to;
            }
        }
        found
    }
}

/// Where, at either end of a sweep, the gain has surely fallen to a half and to a tenth.
pub(crate) fn saturation(gains: &[LocalGain], gain: f64) -> Vec<Saturation> {
    let largest = gains.iter().map(|local| local.output.abs()).fold(0.0, f64::max);
    let mut found = Vec::new();
    for share in [0.5, 0.1] {
        let surely = |local: &LocalGain| local.gain / gain + SURE * local.std_error / gain.abs() < share;
        let fallen = |local: &&LocalGain| surely(local) && local.output.abs() > 0.5 * largest;
        // A gain that is small everywhere has not fallen.
        if gains.iter().all(|local| fallen(&local)) {
            continue;
        }
        let upper = gains.iter().rev().take_while(fallen).last().map(|local| (local.from, true));
        let lower = gains.iter().take_while(fallen).last().map(|local| (local.to, false));
        found.extend([lower, upper].into_iter().flatten().map(|(from, upper)| Saturation { share, from, upper }));
    }
    found
}
