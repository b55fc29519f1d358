//! One round of the search: candidate models are ranked, the best are refitted to the end, and superfluous effects are removed.

use identification::parallel;

use identification::fit::FitError;

use super::candidate::{Candidate, Chosen, Question};
use super::decision_rule::{
    LEFT_BY_EQUATIONS, LIKELIER_BY, LIKELIER_THAN_NONE, RIVAL_WITHIN, RIVAL_WITHIN_SHARE, UNEARNED_BEHIND,
};
use super::likelihood::{accepts, is_earned, misfit_above_noise, prefer_plain, prefer_sensor, ranked};
use super::outcome::Trial;
use super::search::{is_hopeful, least_above};
use crate::catalogue::Hypothesis;

/// Candidate models of a round that are refitted to the end.
const FINISHED: usize = 4;
/// Candidate models from which the next round starts.
pub(super) const BEAM: usize = 2;

/// Whether it is likelier than no effect by more than chance, and no other candidate model of a round is likelier than this one by more than that. This
/// one counts with its gain in that round or its gain `now`, whichever is larger. An extension and its plainer effect count as the same, unless the plainer
/// one, which was not accepted, is far likelier: then the extension stands in for something else.
pub(crate) fn is_likeliest(candidate: &Candidate, now: Option<f64>, round: &[Trial]) -> bool {
    let plainest = |effects: &mut dyn Iterator<Item = &'static Hypothesis>| {
        let mut names: Vec<&str> = effects.map(Hypothesis::plainest).collect();
        names.sort_unstable();
        names
    };
    let of_candidate = plainest(&mut candidate.effects.iter().map(|chosen| chosen.effect));
    let (same, others): (Vec<&Trial>, Vec<&Trial>) =
        round.iter().partition(|trial| plainest(&mut trial.effects.iter().copied()) == of_candidate);
    let nets = |trials: Vec<&Trial>| trials.into_iter().map(|trial| trial.net).fold(f64::NEG_INFINITY, f64::max);
    let (itself, alike): (Vec<&Trial>, Vec<&Trial>) = same.iter().copied().partition(|trial| trial.is_of(candidate));
    let is_plainer = |trial: &&Trial| trial.effects.iter().all(|own| own.extends.is_none() || candidate.has(own));
    let itself = now.into_iter().fold(nets(itself), f64::max);
    let plainer = nets(alike.into_iter().filter(is_plainer).collect());
    let own = now.into_iter().fold(nets(same), f64::max);
    // What gains by left-out recordings alone may only spoil the model without it.
    own > LIKELIER_THAN_NONE && own > nets(others) - LIKELIER_BY && itself >= plainer - (LIKELIER_BY + UNEARNED_BEHIND)
}

/// Enters a candidate model into the round of its size, unless a better fit of the same effects is already there.
pub(crate) fn enter(question: &Question<'_>, base: &Candidate, rounds: &mut [Vec<Trial>], candidate: &Candidate) {
    let Some(round) = rounds.get_mut(candidate.effects.len() - 1) else { return };
    for (candidate, net) in ranked(question, base, vec![candidate.clone()]) {
        let is_better = |trial: &Trial| trial.is_of(&candidate) && trial.net >= net;
        if !round.iter().any(is_better) {
            round.retain(|trial| !trial.is_of(&candidate));
            round.push(trial(&candidate, net));
        }
    }
    round.sort_by(|a, b| b.net.total_cmp(&a.net));
}

/// A candidate model without the effects that the others make superfluous; effects whose plainest name is in `stay` are kept. `None` where the
/// reduced model is not worth its effect parameters over the base.
pub(crate) fn reduced(
    question: &Question<'_>,
    base: &Candidate,
    full: Candidate,
    stay: &[&str],
) -> Result<Option<Candidate>, FitError> {
    let (mut rest, mut is_accepted) = (unrefined(question, full)?, true);
    while rest.effects.len() > 1 {
        let without = |index: usize| -> Result<Option<(bool, Candidate)>, FitError> {
            let without = rest.without(question, index)?;
            if !without.is_plausible(question) || accepts(question, base, &without, &rest)? {
                return Ok(None);
            }
            Ok(Some((accepts(question, base, base, &without)?, without)))
        };
        let may_go = |&index: &usize| !stay.contains(&rest.effects[index].effect.plainest());
        let indices: Vec<usize> = (0..rest.effects.len()).filter(may_go).collect();
        let fewer: Vec<Option<(bool, Candidate)>> = parallel::try_each(indices, without)?;
        // Of two effects that make each other superfluous, the one that is acceptable stays, otherwise the one with the smaller loss.
        let best = fewer
            .into_iter()
            .flatten()
            .min_by(|(one, a), (other, b)| other.cmp(one).then_with(|| a.fit.loss.total_cmp(&b.fit.loss)));
        let Some(best) = best else { break };
        (is_accepted, rest) = best;
    }
    Ok(is_accepted.then_some(rest))
}

/// A candidate model in which each refined form goes back to its plain form, if it no longer explains most of the plain form's misfit now that other
/// effects are beside it.
fn unrefined(question: &Question<'_>, mut candidate: Candidate) -> Result<Candidate, FitError> {
    if candidate.effects.len() < 2 {
        return Ok(candidate);
    }
    for index in 0..candidate.effects.len() {
        let Chosen { effect, form } = candidate.effects[index];
        for form in effect.plain_of(form) {
            let plain = candidate.instead(question, index, Chosen { effect, form }, &[])?;
            if plain.is_possible(question.scene) && !is_earned(&plain, &candidate) {
                candidate = plain;
                break;
            }
        }
    }
    Ok(candidate)
}

/// Whether nothing is left that a further effect could explain: the base parameters of the best candidate model are at their nominal values within
/// the priors, and its misfit is `near` the noise, or too small to be distinguished from the error of its own form.
pub(crate) fn explains_enough(question: &Question<'_>, base: &Candidate, best: &Candidate, near: f64) -> bool {
    let fits = || {
        best.worst_over_noise(question) < near
            || misfit_above_noise(&best.residuals) < LEFT_BY_EQUATIONS * misfit_above_noise(&base.residuals)
    };
    !best.is_pulled(question) && fits()
}

/// Candidate models of a round that are nearly as likely as a given one: less likely by no more than chance, or by no more than the error of its form
/// may gain. `None` where the given one is not in the round.
pub(super) fn rivals(candidate: &Candidate, ranked: Vec<(Candidate, f64)>) -> Option<Vec<Candidate>> {
    let names = candidate.names();
    let net = ranked.iter().find(|(other, _)| other.names() == names).map(|(_, net)| *net)?;
    let is_near = |other: &(Candidate, f64)| {
        other.1 >= net - RIVAL_WITHIN.max(RIVAL_WITHIN_SHARE * net) && other.0.names() != names
    };
    Some(candidates(ranked.into_iter().filter(is_near).take(FINISHED - 1).collect()))
}

/// Possible candidate models, ranked, the best of them refitted to the end.
pub(crate) fn finished(
    question: &Question<'_>,
    base: &Candidate,
    found: Vec<Candidate>,
) -> Result<Vec<(Candidate, f64)>, FitError> {
    let can_be = |candidate: &Candidate| candidate.is_possible(question.scene);
    let only_possible = |found: Vec<Candidate>| -> Vec<Candidate> { found.into_iter().filter(can_be).collect() };
    let (possible, astray): (Vec<Candidate>, Vec<Candidate>) = found.into_iter().partition(can_be);
    let mut rough = candidates(ranked(question, base, possible));
    let least = least_above(&rough);
    let leading = rough.iter().take_while(|candidate| is_hopeful(candidate, least)).count();
    let rest = rough.split_off(leading.min(FINISHED).max(BEAM.min(rough.len())));
    // A candidate model that left the possible range may return to it when it is refitted; the best such one is kept if all possible ones are
    // hopeless beside it.
    let astray = astray.into_iter().min_by(|a, b| a.fit.loss.total_cmp(&b.fit.loss));
    let beside_it = |least: f64| rough.iter().all(|candidate| !is_hopeful(candidate, least));
    let astray = astray.filter(|one| beside_it(misfit_above_noise(&one.residuals)));
    rough.extend(astray);
    let mut all = only_possible(to_the_end(question, rough)?);
    all.extend(rest);
    let mut simplified: Vec<Vec<&str>> = Vec::new();
    loop {
        let mut ranked = ranked(question, base, all);
        prefer_plain(base, &mut ranked);
        if question.has_tolerances() {
            prefer_sensor(&mut ranked);
        }
        // A candidate model that moves up only now is refitted to the end before it may be chosen.
        if !ranked.iter().take(BEAM).all(|(candidate, _)| candidate.is_finished) {
            let mut first = candidates(ranked);
            let rest = first.split_off(BEAM.min(first.len()));
            all = only_possible(to_the_end(question, first)?);
            all.extend(rest);
            continue;
        }
        // Nor is an extension chosen before the plainer effect was refitted from the extension's solution.
        let Some((best, _)) = ranked.first().filter(|(best, _)| !simplified.contains(&best.names())) else {
            return Ok(ranked);
        };
        simplified.push(best.names());
        let Some(plain) = best.with_plain(question)? else { return Ok(ranked) };
        all = candidates(ranked).into_iter().chain(only_possible(vec![plain])).collect();
    }
}

/// Ranked candidate models in their order.
pub(crate) fn candidates(ranked: Vec<(Candidate, f64)>) -> Vec<Candidate> {
    ranked.into_iter().map(|(candidate, _)| candidate).collect()
}

/// The candidate models in their order, each refitted to the end.
pub(super) fn to_the_end(question: &Question<'_>, candidates: Vec<Candidate>) -> Result<Vec<Candidate>, FitError> {
    let finished =
        |candidate: Candidate| if candidate.is_finished { Ok(candidate) } else { candidate.finished(question) };
    parallel::try_each(candidates, finished)
}

pub(crate) fn trials<'a>(ranked: impl IntoIterator<Item = &'a (Candidate, f64)>) -> Vec<Trial> {
    ranked.into_iter().map(|(candidate, net)| trial(candidate, *net)).collect()
}

pub(crate) fn trial(candidate: &Candidate, net: f64) -> Trial {
    let effects: Vec<_> = candidate.effects.iter().map(|chosen| chosen.effect).collect();
    Trial { effect: effects[effects.len() - 1], effects, net, machine: candidate.fit.machine }
}

#[cfg(test)]
mod tests;
