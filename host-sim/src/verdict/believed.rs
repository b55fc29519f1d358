//! Sets compared where none follows the recordings down to their noise: those are believed only as far as the best set follows them.
//!
//! An effect follows its textbook form within some per cent, and what the valve's misses adds up in all that the rod does. Taken at their
//! noise, recordings bend the ordinary parameters without end to make up for that, whichever set is refitted; the priors, which count once,
//! then judge the sets by what was bent. With the noise of every channel what the best set leaves, and as correlated, the parameters
//! stay where they can be, and what the sets differ in decides.

use rayon::prelude::*;

use super::likelihood::prefer_plain;
use super::{AT_NOISE, excess};
use crate::candidate::{Candidate, Question};
use crate::fit::FitError;
use crate::prepare::Prepared;
use crate::tempered;

/// Ranked sets, and one `beside` that was not ranked, refitted to recordings that are believed as far as the best of them follows those, and
/// ranked by that. As they are, where that is down to the noise.
pub(super) fn believed(
    question: &Question<'_>,
    base: &Candidate,
    ranked: Vec<(Candidate, f64)>,
    beside: Option<Candidate>,
) -> Result<Vec<(Candidate, f64)>, FitError> {
    let sets = ranked.iter().map(|(set, _)| set);
    let best = sets.min_by(|a, b| excess(&a.residuals).total_cmp(&excess(&b.residuals)));
    let Some(best) = best.filter(|best| best.worst_over_noise(question) > AT_NOISE) else { return Ok(ranked) };
    let (training, samples) = tempered::believed(question, best)?;
    let training: Vec<&Prepared> = training.iter().collect();
    let less = Question { training: &training, ..*question };
    let again = |set: Candidate| -> Result<(Candidate, f64), FitError> {
        let (set, loss) = set.believing(question, &less)?;
        let net = -loss - 0.5 * set.strengths() as f64 * samples.max(2.0).ln();
        Ok((set, net))
    };
    let first = |ranked: &[(Candidate, f64)]| ranked.first().map_or(0.0, |(_, net)| *net);
    let gained = first(&ranked);
    let beside = beside.filter(|one| ranked.iter().all(|(set, _)| set.names() != one.names()));
    let sets: Vec<Candidate> = ranked.into_iter().map(|(set, _)| set).chain(beside).collect();
    let mut ranked: Vec<(Candidate, f64)> = sets.into_par_iter().map(again).collect::<Result<_, _>>()?;
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    // What the best one gains over the base is told by the recordings as they are: believed less, the base would gain by that alone.
    let shift = gained - first(&ranked);
    for (_, net) in &mut ranked {
        *net += shift;
    }
    prefer_plain(base, &mut ranked);
    Ok(ranked)
}
