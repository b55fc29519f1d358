//! Misfit ranking: where even the best candidate model does not reach the noise, candidate models are compared with the noise inflated to its misfit.
//!
//! An effect follows its textbook form within some per cent, and errors of the valve's effects accumulate in the motion of the rod. With the sensors'
//! noise, every refit pulls the base parameters far from their nominal values to make up for that, whichever candidate model it is; the priors, which
//! count once, then judge the models by these parameters. With noise of every channel as large and as correlated as the best model's residual, the
//! parameters stay where they can be, and the differences between the models decide.

use identification::parallel;

use identification::experiment::Prepared;
use identification::fit::FitError;
use identification::fit::residuals::samples_by_blocks;

use super::candidate::{Candidate, Question};
use super::decision_rule::{MISFIT_RANKING_FROM, MISFIT_REFIT_STAYS};
use super::inflated_noise::as_far_as;
use super::likelihood::{misfit_above_noise, prefer_plain, ranked_by};

/// Ranks finished candidate models, and one `beside` that the whole model may have dropped, by refits with the noise inflated to the best one's
/// misfit. A candidate model that is far off, or whose base parameters were pulled from their nominal values, keeps this refit from here on; any
/// other stays as it was. All stay as they are where the best is at its noise, or where there is nothing to compare or to pull back.
pub(crate) fn ranked_by_misfit(
    question: &Question<'_>,
    base: &Candidate,
    finished: Vec<(Candidate, f64)>,
    beside: Option<Candidate>,
) -> Result<Vec<(Candidate, f64)>, FitError> {
    let candidates = finished.iter().map(|(candidate, _)| candidate);
    let best = candidates.min_by(|a, b| misfit_above_noise(&a.residuals).total_cmp(&misfit_above_noise(&b.residuals)));
    let Some(best) = best.filter(|best| best.worst_over_noise(question) > MISFIT_RANKING_FROM) else {
        return Ok(finished);
    };
    let possible = |candidate: &Candidate| candidate.is_possible(question.scene);
    let beside =
        beside.filter(|one| possible(one) && finished.iter().all(|(candidate, _)| candidate.names() != one.names()));
    let before: Vec<Candidate> = finished.iter().map(|(candidate, _)| candidate.clone()).chain(beside).collect();
    let stays = |candidate: &Candidate| {
        !candidate.is_pulled(question) && candidate.worst_over_noise(question) <= MISFIT_REFIT_STAYS
    };
    if matches!(before.as_slice(), [only] if stays(only)) {
        return Ok(finished);
    }
    let training = as_far_as(question, best)?;
    let training: Vec<&Prepared> = training.iter().collect();
    let less = Question { training: &training, ..*question };
    let refits: Vec<Candidate> = parallel::try_each(&before, |candidate| candidate.refitted_to(question, &less))?;
    let refits: Vec<Candidate> = refits.into_iter().filter(possible).collect();
    if refits.is_empty() {
        return Ok(finished);
    }
    let mut again = ranked_by(question, base, refits, samples_by_blocks);
    prefer_plain(base, &mut again);
    for (candidate, _) in &mut again {
        if let Some(as_it_was) = before.iter().find(|one| one.names() == candidate.names() && stays(one)) {
            *candidate = as_it_was.clone();
        }
    }
    Ok(again)
}
