//! Sets with one more effect: what is worth a refit, refitted roughly.

use rayon::prelude::*;

use crate::candidate::{Candidate, Question};
use crate::fit::{CHANCE, FitError};
use crate::hypothesis::Hypothesis;
use crate::prepare::Prepared;
use crate::screen::Lead;
use crate::tempered::Tempered;

/// An effect that promises less than this share of what the best does is not refitted.
const PROMISING: f64 = 0.05;

/// Every set of the beam with one more effect, at most `most` effects from each reference, in their promising forms.
///
/// Where nothing is in a set yet and what is missing has bent the ordinary parameters, the tempered model is a reference as
/// well. Extensions of an effect start from its refit.
pub fn widened(
    question: &Question<'_>,
    tempered: &Tempered,
    beam: &[Candidate],
    most: usize,
    done: &(impl Fn(&str) + Sync),
) -> Result<Vec<Candidate>, FitError> {
    let mut found = Vec::new();
    for from in beam {
        let open = open_to(question, from);
        let mut leads: Vec<(Lead, &Candidate)> = Vec::new();
        let own = from.leads(question, &open)?.into_iter().map(|lead| (lead, from)).collect();
        leads.extend(promising(own, from.fit.loss, most, CHANCE));
        if from.effects.is_empty() && from.is_bent(question) {
            let cases: Vec<&Prepared> = tempered.cases.iter().collect();
            let softer = Question { training: &cases, ..*question };
            let beside = tempered.base.leads(&softer, &open)?.into_iter().map(|lead| (lead, &tempered.base)).collect();
            leads.extend(promising(beside, tempered.base.fit.loss, most, 0.0));
        }
        let refitted = refit_each(&leads, done, |(lead, reference)| (lead, reference.with(question, lead)))?;
        let extended = extensions(question, from, &open, &refitted, done)?;
        found.extend(refitted);
        found.extend(extended);
    }
    Ok(found)
}

/// A rough refit from each lead, in their order. `done` is told after each.
pub(crate) fn refit_each<L: Sync>(
    leads: &[L],
    done: &(impl Fn(&str) + Sync),
    refit: impl Fn(&L) -> (&Lead, Result<Candidate, FitError>) + Sync,
) -> Result<Vec<Candidate>, FitError> {
    let told = |lead: &L| {
        let (lead, candidate) = refit(lead);
        done(lead.effect.name);
        candidate
    };
    leads.par_iter().map(told).collect()
}

/// Effects that may be added: neither there already, nor an extension of one that is.
pub(crate) fn open_to(question: &Question<'_>, from: &Candidate) -> Vec<&'static Hypothesis> {
    let open =
        |hypothesis: &&Hypothesis| from.effects.iter().all(|chosen| chosen.effect.plainest() != hypothesis.plainest());
    question.hypotheses.iter().copied().filter(open).collect()
}

/// The leads of the most promising effects, each of which promises more than the `least`: what chance gives, but beside the
/// tempered model nothing, for there a loss is no larger than chance would have it.
fn promising(mut leads: Vec<(Lead, &Candidate)>, loss: f64, most: usize, least: f64) -> Vec<(Lead, &Candidate)> {
    leads.sort_by(|a, b| a.0.loss.total_cmp(&b.0.loss));
    let best = leads.first().map_or(0.0, |(lead, _)| loss - lead.loss);
    let mut kept: Vec<(&str, *const _, f64)> = Vec::new();
    let mut names: Vec<&str> = Vec::new();
    leads.retain(|(lead, _)| {
        let (name, form) = (lead.effect.name, lead.form.as_ptr());
        if !names.contains(&name) {
            names.push(name);
        }
        let rank = names.iter().position(|known| *known == name);
        let mut same = kept.iter().filter(|(known, ..)| *known == name);
        // Another form of the same effect has to come near the best one.
        let another = same.clone().all(|(.., promised)| loss - lead.loss > 0.8 * promised);
        let keep = same.all(|(_, known, _)| *known != form)
            && another
            && loss - lead.loss > least.max(PROMISING * best)
            && rank.is_some_and(|rank| rank < most);
        if keep {
            kept.push((name, form, loss - lead.loss));
        }
        keep
    });
    leads
}

/// Refits of the extensions of effects that were refitted.
fn extensions(
    question: &Question<'_>,
    from: &Candidate,
    open: &[&'static Hypothesis],
    plainer: &[Candidate],
    done: &(impl Fn(&str) + Sync),
) -> Result<Vec<Candidate>, FitError> {
    let mut found = Vec::new();
    for plain in plainer {
        let Some(newest) = plain.effects.last() else { continue };
        let richer: Vec<&'static Hypothesis> = open
            .iter()
            .copied()
            .filter(|effect| effect.extends.is_some_and(|extension| extension.plain == newest.effect.name))
            .collect();
        if richer.is_empty() || plain.fit.loss >= from.fit.loss {
            continue;
        }
        let leads = plain.extensions(question, &richer)?;
        found.extend(refit_each(&leads, done, |lead| (lead, plain.with_extension(question, lead)))?);
    }
    Ok(found)
}
