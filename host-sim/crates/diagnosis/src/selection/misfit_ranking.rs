//! Sets compared where even the best one does not follow the recordings down to their noise: those are believed only as far as it does.
//!
//! An effect follows its textbook form within some per cent, and what the valve's misses adds up in all that the rod does. Taken at their
//! noise, recordings bend the base parameters without end to make up for that, whichever set is refitted; the priors, which count once,
//! then judge the sets by what was bent. With the noise of every channel what the best set leaves, and as correlated, the parameters
//! stay where they can be, and what the sets differ in decides.

use identification::parallel;

use identification::experiment::Prepared;
use identification::fit::FitError;
use identification::fit::residuals::samples_by_blocks;

use super::candidate::{Candidate, Question};
use super::decision_rule::{MISFIT_RANKING_FROM, MISFIT_REFIT_STAYS};
use super::inflated_noise::as_far_as;
use super::likelihood::{misfit_above_noise, prefer_plain, ranked_by};

/// Finished sets, ranked, and one `beside` that the chain may have had no use for, ranked by refits to recordings that are believed as far as
/// the best of them follows those. A set that is far off, or whose base parameters were bent, is so refitted from here on; any other stays as it was.
/// All as they are, where the best is at its noise, or where there is nothing to compare or to straighten.
pub(crate) fn believed(
    question: &Question<'_>,
    base: &Candidate,
    finished: Vec<(Candidate, f64)>,
    beside: Option<Candidate>,
) -> Result<Vec<(Candidate, f64)>, FitError> {
    let sets = finished.iter().map(|(set, _)| set);
    let best = sets.min_by(|a, b| misfit_above_noise(&a.residuals).total_cmp(&misfit_above_noise(&b.residuals)));
    let Some(best) = best.filter(|best| best.worst_over_noise(question) > MISFIT_RANKING_FROM) else {
        return Ok(finished);
    };
    let possible = |set: &Candidate| set.is_possible(question.scene);
    let beside = beside.filter(|one| possible(one) && finished.iter().all(|(set, _)| set.names() != one.names()));
    let before: Vec<Candidate> = finished.iter().map(|(set, _)| set.clone()).chain(beside).collect();
    let stays = |set: &Candidate| !set.is_pulled(question) && set.worst_over_noise(question) <= MISFIT_REFIT_STAYS;
    if matches!(before.as_slice(), [only] if stays(only)) {
        return Ok(finished);
    }
    let training = as_far_as(question, best)?;
    let training: Vec<&Prepared> = training.iter().collect();
    let less = Question { training: &training, ..*question };
    let refits: Vec<Candidate> = parallel::try_each(&before, |set| set.refitted_to(question, &less))?;
    let refits: Vec<Candidate> = refits.into_iter().filter(possible).collect();
    if refits.is_empty() {
        return Ok(finished);
    }
    let mut again = ranked_by(question, base, refits, samples_by_blocks);
    prefer_plain(base, &mut again);
    for (set, _) in &mut again {
        if let Some(as_it_was) = before.iter().find(|one| one.names() == set.names() && stays(one)) {
            *set = as_it_was.clone();
        }
    }
    Ok(again)
}
