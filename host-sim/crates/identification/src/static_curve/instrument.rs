//! What the instrument does to the output and the valve does not: a staircase, and jumps at certain readings.

use simulation::signal::noise::extent;

use super::branch::Branch;
use super::line::median;

/// The output has levels at equal distances and no values between.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Staircase {
    /// The distance of the levels, in the output's unit.
    pub step: f64,
    /// How many levels there are.
    pub levels: usize,
    /// Below this magnitude of the output there are values between the levels; 0 where the staircase is everywhere.
    pub from_magnitude: f64,
}

/// A jump of the output at the same reading on the way up and on the way down, and at no other reading.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Jump {
    /// Lowest and highest reading of it.
    pub output: (f64, f64),
    /// The input there, mean of the branches.
    pub input: f64,
}

/// Smallest distance of levels that counts, as a share of the output's span.
const LEAST_STEP: f64 = 5e-3;
/// Distances of levels count as equal within this share.
const EQUAL: f64 = 0.05;
const LEAST_LEVELS: usize = 6;
/// Fewest rows per level: rows of a table at equal inputs are no staircase.
const ROWS_A_LEVEL: usize = 3;

/// The staircase in the output, if it has one.
#[must_use]
pub fn staircase(output: &[f64]) -> Option<Staircase> {
    let (low, high) = extent(output);
    let mut levels = output.to_vec();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let steps: Vec<(f64, f64)> = levels
        .windows(2)
        .filter(|pair| pair[1] - pair[0] > LEAST_STEP * (high - low))
        .map(|pair| (pair[0], pair[1]))
        .collect();
    let step = median(steps.iter().map(|(from, to)| to - from).collect());
    let equal: Vec<&(f64, f64)> = steps.iter().filter(|(from, to)| (to - from - step).abs() < EQUAL * step).collect();
    let (nearest, furthest) = extent(equal.iter().flat_map(|(from, to)| [from.abs(), to.abs()]));
    let from_magnitude = if nearest > 2.0 * step { nearest } else { 0.0 };
    let rows = output.iter().filter(|value| (from_magnitude..=furthest).contains(&value.abs())).count();
    let regular = equal.len() >= LEAST_LEVELS && 3 * equal.len() > 2 * steps.len();
    (regular && rows >= ROWS_A_LEVEL * equal.len()).then_some(Staircase {
        step,
        levels: equal.len() + 1,
        from_magnitude,
    })
}

/// Number of steps into which the output's span is divided to look for jumps.
const GRID: usize = 100;
/// At a jump, the output needs less than this share of the input that the same rise needs elsewhere.
const SHORT: f64 = 0.7;

/// Jumps outside the staircase that every branch makes at the same reading.
///
/// With a smooth gain, no interval of the output is crossed twice as fast as usual. So the gain has to be nearly constant
/// elsewhere; where it is not, nothing is found.
#[must_use]
pub fn jumps(input: &[f64], output: &[f64], branches: &[Branch], staircase: Option<Staircase>) -> Vec<Jump> {
    let (low, high) = extent(output);
    let fine = staircase.map_or(f64::INFINITY, |staircase| staircase.from_magnitude - staircase.step);
    let level = |index: usize| low + (high - low) * index as f64 / GRID as f64;
    let crossings: Vec<Vec<Option<f64>>> = branches
        .iter()
        .map(|branch| (0..=GRID).map(|index| branch.crossing(input, output, level(index))).collect())
        .collect();
    let in_all = |index: usize| -> Option<Vec<(f64, f64)>> {
        let both = |branch: &Vec<Option<f64>>| branch[index].zip(branch[index + 1]);
        (level(index).abs().max(level(index + 1).abs()) < fine).then(|| crossings.iter().map(both).collect())?
    };
    let taken = |pairs: &[(f64, f64)]| pairs.iter().map(|(from, to)| (to - from).abs()).collect::<Vec<f64>>();
    let all: Vec<(usize, Vec<(f64, f64)>)> =
        (0..GRID).filter_map(|index| in_all(index).map(|pairs| (index, pairs))).collect();
    let usual = median(all.iter().flat_map(|(_, pairs)| taken(pairs)).collect());
    let spread = median(all.iter().flat_map(|(_, pairs)| taken(pairs)).map(|width| (width - usual).abs()).collect());
    if branches.len() < 2 || all.len() < 10 || spread > 0.3 * usual {
        return Vec::new();
    }
    let mut found: Vec<(usize, Jump)> = Vec::new();
    for (index, pairs) in &all {
        if taken(pairs).iter().any(|width| *width > SHORT * usual) {
            continue;
        }
        let at = pairs.iter().map(|(from, to)| f64::midpoint(*from, *to)).sum::<f64>() / pairs.len() as f64;
        match found.last_mut() {
            Some((last, jump)) if *last + 1 == *index => {
                (*last, jump.output.1, jump.input) = (*index, level(index + 1), f64::midpoint(jump.input, at));
            }
            _ => found.push((*index, Jump { output: (level(*index), level(index + 1)), input: at })),
        }
    }
    found.into_iter().map(|(_, jump)| jump).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::static_curve::branch::branches;

    #[test]
    fn a_coarse_range_of_a_meter_is_a_staircase_and_a_table_is_none() {
        let coarse = |value: f64| if value.abs() > 4.0 { (value / 0.4).round() * 0.4 } else { value };
        let sweep: Vec<f64> = (0..2000).map(|row| coarse(0.01 * f64::from(row) - 10.0)).collect();
        let found = staircase(&sweep).unwrap();
        assert!((found.step - 0.4).abs() < 1e-9 && (found.from_magnitude - 4.0).abs() < 0.5, "{found:?}");
        assert_eq!(staircase(&(0..30).map(f64::from).collect::<Vec<_>>()), None);
        assert_eq!(staircase(&(0..2000).map(|row| f64::from(row).sqrt()).collect::<Vec<_>>()), None);
    }

    #[test]
    fn a_jump_at_one_reading_is_found_on_both_branches() {
        let input: Vec<f64> = (0..4000).map(|row| 10.0 - 0.01 * f64::from((row - 2000_i32).abs())).collect();
        let meter = |value: f64| value + if value > 3.0 { 0.5 } else { 0.0 };
        let output: Vec<f64> = input.iter().map(|value| meter(*value)).collect();
        let found = jumps(&input, &output, &branches(&input), None);
        assert!(found.len() == 1 && (found[0].input - 3.0).abs() < 0.1, "{found:?}");
        assert_eq!(jumps(&input, &input, &branches(&input), None), []);
    }
}
