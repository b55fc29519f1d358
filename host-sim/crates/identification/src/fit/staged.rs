//! A first search in stages: each value in turn is held at the machine file's while the others settle, and then released.
//!
//! Where rows are sparse and little is measured, many values imitate each other: a search over all of them runs into the valley that is steepest at the
//! nominal values. With one of them held it comes to other valleys. The best end is taken. So a further free value seldom makes a fit worse: the search
//! that holds it is the one that does not have it.

use model_core::machine::Machine;

use super::{Fit, FitError, Free, From, first_search, fit};
use crate::experiment::Prepared;
use crate::parallel;

/// A search ends for a first look when the loss falls by less than this share in a step.
const ROUGHLY: f64 = 0.03;
/// Searches with a held value of which that value is released.
const RELEASED: usize = 4;

/// The best of a search over all free values at once and of searches in stages, each of which holds one of them first. The best of these, after a first
/// look, goes on until the loss falls by less than `precision` in a step. It takes about four times as long as the first search.
pub fn staged(machine: &Machine<f64>, free: &[Free], cases: &[&Prepared], precision: f64) -> Result<Fit, FitError> {
    let first = first_search(machine, free, cases, precision)?;
    if free.len() < 2 {
        return Ok(first);
    }
    let holding = |held: usize| {
        let others: Vec<Free> =
            free.iter().enumerate().filter(|(index, _)| *index != held).map(|(_, free)| *free).collect();
        fit(machine, &others, cases, &From::default(), ROUGHLY)
    };
    let held = parallel::try_each(0..free.len(), holding)?;
    let from =
        |one: &Fit, precision| fit(machine, free, cases, &From { solution: Some(one), ..From::default() }, precision);
    let released = parallel::try_each(&best(held, RELEASED), |one| from(one, ROUGHLY))?;
    let ends = parallel::try_each(&best(released, 1), |one| from(one, precision))?;
    Ok(ends.into_iter().fold(first, |best, one| if one.loss < best.loss { one } else { best }))
}

/// So many of the fits, those with the least loss.
fn best(mut fits: Vec<Fit>, count: usize) -> Vec<Fit> {
    fits.retain(|one| one.loss.is_finite());
    fits.sort_by(|a, b| a.loss.total_cmp(&b.loss));
    fits.truncate(count);
    fits
}
