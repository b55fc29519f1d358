//! A search in stages: each value in turn is held at the machine file's while the others settle, and then released.
//!
//! Where rows are sparse and little is measured, many values imitate each other: a search over all of them runs into the valley that is steepest at the
//! nominal values. With one of them held it comes to other valleys. The best end is taken, so that a further free value can only lower the loss of the
//! search that holds it.

use model_core::machine::Machine;

use super::{Fit, FitError, Free, From, StartState, coarse, fit};
use crate::experiment::Prepared;
use crate::parallel;

/// A search with a held value ends when the loss falls by less than this share in a step.
const ROUGHLY: f64 = 0.03;
/// Searches that are continued with all values released.
const RELEASED: usize = 4;

/// The best of a fit and of searches in stages, each of which holds one of its free values first. It takes about six times as long as the fit.
pub fn staged(
    machine: &Machine<f64>,
    free: &[Free],
    cases: &[&Prepared],
    first: Fit,
    precision: f64,
) -> Result<Fit, FitError> {
    if free.len() < 2 {
        return Ok(first);
    }
    let coarser = coarse(cases, machine, &vec![StartState::default(); cases.len()])?;
    let coarser: Vec<&Prepared> = coarser.iter().collect();
    let holding = |held: usize| {
        let others: Vec<Free> =
            free.iter().enumerate().filter(|(index, _)| *index != held).map(|(_, free)| *free).collect();
        fit(machine, &others, &coarser, &From::default(), ROUGHLY)
    };
    let mut held = parallel::try_each(0..free.len(), holding)?;
    held.retain(|one| one.loss.is_finite());
    held.sort_by(|a, b| a.loss.total_cmp(&b.loss));
    held.truncate(RELEASED);
    let release = |one: &Fit| fit(machine, free, cases, &From { solution: Some(one), ..From::default() }, precision);
    let released = parallel::try_each(&held, release)?;
    Ok(released.into_iter().fold(first, |best, one| if one.loss < best.loss { one } else { best }))
}
