//! Candidate models with one more effect: those worth a refit are refitted roughly.

use identification::parallel;

use identification::fit::FitError;

use super::candidate::{Candidate, Chosen, Question, Reference};
use super::decision_rule::PREDICTED_GAIN;
use super::inflated_noise::InflatedNoise;
use super::likelihood::{is_earned, misfit_above_noise};
use super::screen::Lead;
use crate::catalogue::Hypothesis;

/// An effect whose predicted gain is less than this share of the best one's is not refitted.
const PROMISING: f64 = 0.05;
/// Another form of an effect is refitted as well if its predicted gain is more than this share of that of its best form.
const NEAR_ITS_BEST_FORM: f64 = 0.8;

/// Every candidate model of the beam with one more effect, at most `most` effects from each reference, in their promising forms.
///
/// Where a candidate model has no effect yet and its base parameters are pulled from their nominal values by what is missing, the model with inflated
/// noise is a reference as well. Extensions of an effect start from its refit.
pub(super) fn widened(
    question: &Question<'_>,
    inflated: &InflatedNoise,
    beam: &[Candidate],
    most: usize,
    done: &(impl Fn(&str) + Sync),
) -> Result<Vec<Candidate>, FitError> {
    let of_candidate = |from: &Candidate| -> Result<Vec<Candidate>, FitError> {
        let open = open_to(question, from);
        let mut found = added(question, inflated, from, &open, most, done)?;
        found.extend(extensions(question, from, &open, &found, done)?);
        Ok(found)
    };
    of_each(beam, of_candidate)
}

/// Refits of a candidate model with one more effect, from its own solution and, where that is pulled from the nominal values, from the model with
/// inflated noise.
///
/// The leads of the model with inflated noise are those of its correlated residuals, then those that only independent residuals give. From both
/// models a form mostly ends at the same solution, so the leads of correlated residuals are refitted from the model with inflated noise, and from the
/// other one only if they come near the best.
fn added(
    question: &Question<'_>,
    inflated: &InflatedNoise,
    from: &Candidate,
    open: &[&'static Hypothesis],
    most: usize,
    done: &(impl Fn(&str) + Sync),
) -> Result<Vec<Candidate>, FitError> {
    let refit = |leads: &[Lead], reference: &Reference<'_>| refit_each(leads, done, |lead| reference.with(lead));
    let loosened = loosened(question, from, open);
    let reference = Reference::new(question, from)?;
    let presses = |lead: &Lead| from.presses(question, lead.effect, lead.form);
    let is_astray = from.effects.is_empty() && from.is_pulled(question);
    // Where much is free, what pulls the base parameters leads them to where no effect looks like itself.
    let own = if is_astray && question.has_tolerances() {
        Vec::new()
    } else {
        promising(reference.leads(open)?, most, PREDICTED_GAIN, presses)
    };
    if !is_astray {
        return refit(&[own, loosened].concat(), &reference);
    }
    let own = [own, loosened].concat();
    let beside = Reference::new(question, &inflated.base)?;
    let leads = beside.leads_by([&inflated.correlated, &inflated.independent], open)?;
    let [mut others, mut bending] = leads.map(|leads| promising(leads, most, 0.0, presses));
    let (again, own): (Vec<Lead>, Vec<Lead>) =
        own.into_iter().partition(|lead| others.iter().any(|other| other.is_like(lead)));
    bending.retain(|lead| others.iter().all(|known| !known.is_like(lead)));
    others.extend(bending);
    let (alone, both) = rayon::join(|| refit(&own, &reference), || refit(&others, &beside));
    let mut found = alone?;
    found.extend(both?);
    let least = least_above(found.iter().filter(|candidate| candidate.is_possible(question.scene)));
    let near = |lead: &Lead| found.iter().any(|known| known.newest_is_like(lead) && is_hopeful(known, least));
    let again: Vec<Lead> = again.into_iter().filter(near).collect();
    found.extend(refit(&again, &reference)?);
    Ok(found)
}

/// Effects that may have changed and of which a candidate model has used up what is known, each from where that model ended: a refit that begins far from
/// there may end above it.
fn loosened(question: &Question<'_>, from: &Candidate, open: &[&'static Hypothesis]) -> Vec<Lead> {
    let scene = question.scene;
    let pressed = |effect: &&'static Hypothesis| {
        let form = effect.forms_in(scene).find(|form| scene.holds(form) && from.uses_up(question, form))?;
        let values = form.iter().map(|own| (own.parameter, from.fit.machine.get(own.parameter))).collect();
        let (gain, loss, settled) = (0.0, from.fit.loss, from.fit.coordinates.clone());
        Some(Lead { effect, form, values, gain, loss, settled })
    };
    open.iter().filter_map(pressed).collect()
}

/// The refits of each, in their order.
pub(crate) fn of_each<T: Sync>(
    all: &[T],
    refits: impl Fn(&T) -> Result<Vec<Candidate>, FitError> + Sync + Send,
) -> Result<Vec<Candidate>, FitError> {
    let found: Vec<Vec<Candidate>> = parallel::try_each(all, refits)?;
    Ok(found.into_iter().flatten().collect())
}

/// A rough refit from each lead, in their order. `done` is called after each.
pub(crate) fn refit_each(
    leads: &[Lead],
    done: &(impl Fn(&str) + Sync),
    refit: impl Fn(&Lead) -> Result<Candidate, FitError> + Sync,
) -> Result<Vec<Candidate>, FitError> {
    let told = |lead: &Lead| {
        let candidate = refit(lead);
        done(lead.effect.name);
        candidate
    };
    parallel::try_each(leads, told)
}

/// Effects that may be added: neither there already, nor an extension of one that is.
pub(crate) fn open_to(question: &Question<'_>, from: &Candidate) -> Vec<&'static Hypothesis> {
    let open =
        |hypothesis: &&Hypothesis| from.effects.iter().all(|chosen| chosen.effect.plainest() != hypothesis.plainest());
    question.hypotheses.iter().copied().filter(open).collect()
}

/// The leads of the most promising effects, each with a predicted gain above the `least`. That is what chance gives, but 0 for the model with
/// inflated noise, where the whole misfit counts as noise. What `presses` against the end of its tolerance is promising too, whatever is predicted from
/// there.
fn promising(mut leads: Vec<Lead>, most: usize, least: f64, presses: impl Fn(&Lead) -> bool) -> Vec<Lead> {
    leads.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let best = leads.first().map_or(0.0, |lead| lead.gain);
    let mut kept: Vec<(&str, *const _, f64)> = Vec::new();
    let mut names: Vec<&str> = Vec::new();
    leads.retain(|lead| {
        let (name, form) = (lead.effect.name, lead.form.as_ptr());
        if !names.contains(&name) {
            names.push(name);
        }
        let rank = names.iter().position(|known| *known == name);
        let mut same = kept.iter().filter(|(known, ..)| *known == name);
        // Another form of the same effect has to come near the best one.
        let another = same.clone().all(|(.., predicted_gain)| lead.gain > NEAR_ITS_BEST_FORM * predicted_gain);
        let keep = same.all(|(_, known, _)| *known != form)
            && lead.gain > least
            && (presses(lead) || another && lead.gain > PROMISING * best && rank.is_some_and(|rank| rank < most));
        if keep {
            kept.push((name, form, lead.gain));
        }
        keep
    });
    leads
}

/// A candidate model with this many times the misfit above noise of the best one is not worth another refit.
const HOPELESS: f64 = 10.0;
/// Misfit above noise that chance leaves for each effect parameter: its loss varies by about two.
const BY_CHANCE: f64 = 2.0;

/// The least misfit above noise of any of these.
pub(crate) fn least_above<'c>(found: impl IntoIterator<Item = &'c Candidate>) -> f64 {
    found.into_iter().map(|candidate| misfit_above_noise(&candidate.residuals)).fold(f64::INFINITY, f64::min)
}

/// Whether a candidate model may come near the best one, whose misfit above noise is the `least`.
pub(crate) fn is_hopeful(candidate: &Candidate, least: f64) -> bool {
    misfit_above_noise(&candidate.residuals) < HOPELESS * least.max(BY_CHANCE * candidate.effect_parameters() as f64)
}

/// Refits of the extensions of refitted effects, from the best refit of each form; an extension that was refitted itself is only refitted again where
/// its predicted loss is lower.
fn extensions(
    question: &Question<'_>,
    from: &Candidate,
    open: &[&'static Hypothesis],
    plainer: &[Candidate],
    done: &(impl Fn(&str) + Sync),
) -> Result<Vec<Candidate>, FitError> {
    let of_plain = |plain: &Candidate| -> Result<Vec<Candidate>, FitError> {
        let Some(newest) = plain.effects.last() else { return Ok(Vec::new()) };
        let better = |other: &Candidate| other.newest() == plain.newest() && other.fit.loss < plain.fit.loss;
        if plain.fit.loss >= from.fit.loss || plainer.iter().any(better) {
            return Ok(Vec::new());
        }
        let known = |lead: &Lead| plainer.iter().any(|known| known.newest_is_like(lead) && known.fit.loss <= lead.loss);
        in_its_place(question, plain, newest, open, &known, done)
    };
    of_each(plainer, of_plain)
}

/// A candidate model with each refined form of one of its effects in the place of the plain form, refitted to the end. A refined form can follow much
/// that has another cause: it is only kept where it explains most of the misfit.
pub(super) fn refined(
    question: &Question<'_>,
    candidate: &Candidate,
    done: &(impl Fn(&str) + Sync),
) -> Result<Vec<Candidate>, FitError> {
    let finer = |(index, plain): (usize, &Chosen)| {
        let (effect, question) = (plain.effect, *question);
        let forms = effect.refined_from(plain.form);
        forms.map(move |form| {
            done(effect.name);
            candidate.instead(&question, index, Chosen { effect, form }, &[])?.unstuck(&question)
        })
    };
    let mut found: Vec<Candidate> = candidate.effects.iter().enumerate().flat_map(finer).collect::<Result<_, _>>()?;
    found.retain(|finer| is_earned(candidate, finer));
    Ok(found)
}

/// Refits of a candidate model with extensions in the place of an effect that it had before its newest one: beside the newest effect their additional
/// gain becomes visible.
pub(super) fn enriched(
    question: &Question<'_>,
    candidate: &Candidate,
    done: &(impl Fn(&str) + Sync),
) -> Result<Vec<Candidate>, FitError> {
    let Some((_, older)) = candidate.effects.split_last() else { return Ok(Vec::new()) };
    let of_one = |plain: &Chosen| in_its_place(question, candidate, plain, question.hypotheses, &|_| false, done);
    of_each(older, of_one)
}

/// Refits of a candidate model with each extension of one of its effects in the place of that effect; known leads are left out.
fn in_its_place(
    question: &Question<'_>,
    candidate: &Candidate,
    plain: &Chosen,
    open: &[&'static Hypothesis],
    known: &impl Fn(&Lead) -> bool,
    done: &(impl Fn(&str) + Sync),
) -> Result<Vec<Candidate>, FitError> {
    let extends = |effect: &&Hypothesis| effect.extends.is_some_and(|extension| extension.plain == plain.effect.name);
    let richer: Vec<&'static Hypothesis> = open.iter().copied().filter(extends).collect();
    if richer.is_empty() {
        return Ok(Vec::new());
    }
    let reference = Reference::new(question, candidate)?;
    let mut leads = reference.extensions(plain, &richer)?;
    leads.retain(|lead| !known(lead));
    refit_each(&leads, done, |lead| reference.with_extension(lead))
}

#[cfg(test)]
pub(crate) mod tests;
