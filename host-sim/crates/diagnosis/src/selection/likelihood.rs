//! How much better one candidate model is than another: log-likelihoods in which each signal's noise level is unknown, ½·n·ln(loss) with n the
//! independent samples of its residual, less the penalty for the effect parameters, plus what the base parameters gain by coming back to their
//! nominal values.

use identification::fit::{Counts, FitError, Residuals, loss};

use super::candidate::{Candidate, Chosen, Question};
use super::decision_rule::{
    BEYOND_PENALTY, EXTENSION_EXPLAINS, EXTENSION_GAINS, FEW_RECORDINGS, FINER_FORM_TAKES, FURTHER_EXPLAINS,
    LEAST_EXPLAINED, LIKELIER_BY, MOST_REFITTED_WITHOUT, RECORDINGS_EXCUSED, RECORDINGS_GAIN, UNEARNED_BEHIND,
};
use crate::catalogue::{CATALOGUE, Subsystem};

/// Best first by log-likelihood gained over the base less penalty; only the best form of the same effects stays.
pub(crate) fn ranked(question: &Question<'_>, base: &Candidate, found: Vec<Candidate>) -> Vec<(Candidate, f64)> {
    ranked_by(question, base, found, question.counts())
}

/// The same with another way to count the independent samples of a series.
pub(crate) fn ranked_by(
    question: &Question<'_>,
    base: &Candidate,
    found: Vec<Candidate>,
    counts: Counts,
) -> Vec<(Candidate, f64)> {
    let Some(best) = found.iter().min_by(|a, b| a.fit.loss.total_cmp(&b.fit.loss)) else { return Vec::new() };
    // The independent samples of the best candidate model's residuals are used for all, so that all are compared alike.
    let samples: Vec<f64> = best.residuals.iter().flatten().map(|series| counts(series)).collect();
    let total: f64 = samples.iter().sum();
    let net = |candidate: &Candidate| {
        let series = base.residuals.iter().flatten().zip(candidate.residuals.iter().flatten());
        let gain: f64 = series
            .zip(&samples)
            .map(|((before, after), samples)| 0.5 * samples * libm::log(floored(before) / floored(after)))
            .sum();
        gain + straightened(question, base, candidate)
            - 0.5 * candidate.new_values(question) as f64 * libm::log(total.max(2.0))
    };
    let valued = |candidate: Candidate| {
        let net = net(&candidate);
        (candidate, net)
    };
    let mut ranked: Vec<(Candidate, f64)> = found.into_iter().map(valued).collect();
    // Candidate models that are equally likely stay in the catalogue's order.
    ranked.sort_by(|a, b| b.1.round().total_cmp(&a.1.round()).then_with(|| order(&a.0).cmp(&order(&b.0))));
    let mut seen: Vec<Vec<&str>> = Vec::new();
    ranked.retain(|(candidate, _)| {
        let names = candidate.names();
        let new = !seen.contains(&names);
        seen.push(names);
        new
    });
    ranked
}

/// Places of a candidate model's effects in the catalogue.
fn order(candidate: &Candidate) -> Vec<usize> {
    let place =
        |chosen: &Chosen| CATALOGUE.iter().position(|known| known.name == chosen.effect.name).unwrap_or(usize::MAX);
    candidate.effects.iter().map(place).collect()
}

/// Puts a candidate model with the plainer effect before the one with its extension, where the extension does not earn its additional parameters.
pub(crate) fn prefer_plain(base: &Candidate, ranked: &mut Vec<(Candidate, f64)>) {
    let Some((best, best_net)) = ranked.first() else { return };
    let most = misfit_above_noise(&base.residuals);
    let plainer = ranked.iter().position(|(candidate, net)| {
        let extended = best.effects.iter().any(|chosen| {
            chosen.effect.extends.is_some_and(|extension| {
                let others = best.effects.iter().filter(|other| other.effect.name != chosen.effect.name);
                let mut wanted: Vec<&str> = others.map(|other| other.effect.name).chain([extension.plain]).collect();
                wanted.sort_unstable();
                wanted == candidate.names()
            })
        });
        let (left, leaves) = (misfit_above_noise(&candidate.residuals), misfit_above_noise(&best.residuals));
        let earned = best_net - net > EXTENSION_GAINS
            && (left - leaves > EXTENSION_EXPLAINS * most || is_earned(candidate, best));
        extended && !earned
    });
    if let Some(index) = plainer {
        let plain = ranked.remove(index);
        // An extension that does not earn its place is ranked below the plainer effect, however well its own form fits.
        for (_, net) in ranked.iter_mut().take(index) {
            *net = net.min(plain.1 - UNEARNED_BEHIND);
        }
        ranked.insert(0, plain);
    }
}

/// Puts a candidate model with a sensor's fault before one with physics in its place, where the recordings do not tell the two apart: to look at a sensor
/// costs less than to open a valve. Asked of drives with tolerances: in those both are within a drawing first.
pub(crate) fn prefer_sensor(ranked: &mut [(Candidate, f64)]) {
    let Some((best, best_net)) = ranked.first() else { return };
    let senses = |chosen: &&Chosen| chosen.effect.subsystem == Subsystem::Sensing;
    let takes_its_place = |other: &Candidate| {
        let new: Vec<&Chosen> = other.effects.iter().filter(|chosen| !best.has(chosen.effect)).collect();
        let gone: Vec<&Chosen> = best.effects.iter().filter(|chosen| !other.has(chosen.effect)).collect();
        new.len() == 1 && gone.len() == 1 && new.iter().all(senses) && !gone.iter().any(senses)
    };
    let is_told = |net: f64| best_net - net > LIKELIER_BY;
    if let Some(index) = ranked.iter().position(|(other, net)| !is_told(*net) && takes_its_place(other)) {
        ranked[..=index].rotate_right(1);
    }
}

/// Whether a finer form explains enough of the plain form's misfit.
pub(crate) fn is_earned(plain: &Candidate, finer: &Candidate) -> bool {
    misfit_above_noise(&finer.residuals) < (1.0 - FINER_FORM_TAKES) * misfit_above_noise(&plain.residuals)
}

/// The loss of a series, but at least that of pure noise: nothing can be gained below it.
fn floored(series: &[f64]) -> f64 {
    let loss = loss(series);
    // A sensor that failed in every row speaks neither for a model nor against it.
    if loss.is_finite() { loss.max(series.len() as f64).max(1.0) } else { f64::INFINITY }
}

/// Log-likelihood gained on one signal.
pub(crate) fn gained(before: &[f64], after: &[f64], counts: Counts) -> f64 {
    gained_by(independent(before, after, counts), before, after)
}

fn gained_by(samples: f64, before: &[f64], after: &[f64]) -> f64 {
    0.5 * samples * libm::log(floored(before) / floored(after))
}

/// The independent samples of the residual that has fewer, so that the gain from one to the other is the loss in the opposite direction.
fn independent(before: &[f64], after: &[f64], counts: Counts) -> f64 {
    counts(before).min(counts(after))
}

/// Log-likelihood gained as the base parameters come back to their nominal values: a model that lacks an effect pulls them away.
pub(crate) fn straightened(question: &Question<'_>, without: &Candidate, with: &Candidate) -> f64 {
    without.pulled(question) - with.pulled(question)
}

/// The misfit above noise.
pub(crate) fn misfit_above_noise(residuals: &Residuals) -> f64 {
    residuals.iter().flatten().map(|series| above_noise(series)).sum()
}

/// The misfit above noise of a series.
pub(crate) fn above_noise(series: &[f64]) -> f64 {
    floored(series) - series.len() as f64
}

/// Whether `with` is worth its effect parameters over `without`.
pub(crate) fn accepts(
    question: &Question<'_>,
    base: &Candidate,
    without: &Candidate,
    with: &Candidate,
) -> Result<bool, FitError> {
    let (most, before, after) = (
        misfit_above_noise(&base.residuals),
        misfit_above_noise(&without.residuals),
        misfit_above_noise(&with.residuals),
    );
    // A base that follows by using up what an amount is known to leaves little to explain: what tells the change are the values that come back.
    let explains = after <= (1.0 - LEAST_EXPLAINED) * before || without.makes_up_for_change(question, with);
    let told = before - after >= FURTHER_EXPLAINS * most || (without.is_pulled(question) && !with.is_pulled(question));
    if !explains || (!without.effects.is_empty() && !told) {
        return Ok(false);
    }
    let counts = question.counts();
    let pays = |gained: &Gained| {
        let penalty =
            gained.cost(with.new_values(question).saturating_sub(without.new_values(question))) + BEYOND_PENALTY;
        // Parameters that come back may pay for the effect parameters, but the recordings themselves have to gain as well.
        gained.all > RECORDINGS_GAIN && gained.all + straightened(question, without, with) > penalty && gained.repeats
    };
    let gained = |without: &Residuals, with: &Residuals| {
        if question.is_whitened() {
            Gained::of_whitened(without, with, counts)
        } else {
            Gained::of(without, with, counts)
        }
    };
    if pays(&gained(&without.left_out(question)?, &with.left_out(question)?)) {
        return Ok(true);
    }
    // One step is inaccurate where much depends on the recording that was left out; with very many recordings little depends on each.
    if question.training.len() > MOST_REFITTED_WITHOUT {
        return Ok(false);
    }
    Ok(pays(&gained(&without.residuals, &with.residuals))
        && pays(&gained(&without.left_out_refitted(question)?, &with.left_out_refitted(question)?)))
}

/// What recordings gain by the residuals `after` over those `before`.
pub(crate) struct Gained {
    /// Log-likelihood gained on all of them.
    pub(crate) all: f64,
    /// Whether all of them but one gain: what happens once is a disturbance.
    pub(crate) repeats: bool,
    /// Independent samples.
    samples: f64,
}

impl Gained {
    pub(crate) fn of(before: &Residuals, after: &Residuals, counts: Counts) -> Self {
        Self::by(before, after, |before, after| independent(before, after, counts))
    }

    /// The same of whitened residuals: what lasts in them beyond a block is what a model lacks, so the better one counts their samples.
    /// Position and velocity gain by the same force, so both together count once.
    fn of_whitened(before: &Residuals, after: &Residuals, counts: Counts) -> Self {
        let channels = before.iter().map(Vec::len).max().unwrap_or(1).max(1) as f64;
        Self::by(before, after, |before, after| {
            counts(if loss(after) < loss(before) { after } else { before }) / channels
        })
    }

    fn by(before: &Residuals, after: &Residuals, independent: impl Fn(&[f64], &[f64]) -> f64) -> Self {
        let mut samples = 0.0;
        let mut on = |before: &[Vec<f64>], after: &[Vec<f64>]| -> f64 {
            let channels = before.iter().zip(after);
            let gains = channels.map(|(before, after)| {
                let independent = independent(before, after);
                samples += independent;
                gained_by(independent, before, after)
            });
            gains.sum()
        };
        let gains: Vec<f64> = before.iter().zip(after).map(|(before, after)| on(before, after)).collect();
        let improved = gains.iter().filter(|gain| **gain > 0.0).count();
        let needed = if gains.len() > FEW_RECORDINGS { gains.len() - RECORDINGS_EXCUSED } else { gains.len() };
        Self { all: gains.iter().sum(), repeats: improved >= needed, samples }
    }

    /// Penalty for this number of fitted values: half the logarithm of the samples for each.
    pub(crate) fn cost(&self, values: usize) -> f64 {
        0.5 * values as f64 * libm::log(f64::max(self.samples, 2.0))
    }
}
