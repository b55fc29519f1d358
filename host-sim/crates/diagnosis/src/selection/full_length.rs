//! What was found on the first part of long recordings, held against the whole of them.
//!
//! Base and chosen set are refitted on the whole, which has to accept the set once more; what it makes superfluous goes, where what is
//! left was the likeliest of its size on the first part. What acts slowly does not show in a first part: where the whole is left above
//! its noise, the effects that act over time are tried on it.

use identification::fit::FitError;

use super::candidate::{Candidate, Question, Reference};
use super::decision_rule::{MOST_EFFECTS, SLOW_EFFECTS_FROM, WHOLE_REFITTED_BELOW};
use super::likelihood::{accepts, ranked};
use super::outcome::Selection;
use super::round::{explains_enough, is_likeliest, reduced, trials};
use super::screen::Lead;
use super::search::{open_to, refit_each};

/// The selection that the whole recordings make of what was `found` on their first part. `done` is told after each refit.
///
/// Few runs of a recording, whatever was tried before: what grows with its length is a dozen refits' steps.
pub fn lengthened(
    question: &Question<'_>,
    found: &Selection,
    done: &(impl Fn(&str) + Sync),
) -> Result<Selection, FitError> {
    let accepts_any = !found.chosen.effects.is_empty();
    let (base, chosen) = rayon::join(
        || base(question, &found.base),
        || accepts_any.then(|| found.chosen.finished(question)).transpose(),
    );
    let base = base?;
    done("the whole recordings");
    let mut selection = Selection {
        chosen: base.clone(),
        base,
        rounds: found.rounds.clone(),
        joined: found.joined.clone(),
        heard: None,
    };
    if let Some(chosen) = chosen?
        && chosen.is_plausible(question.scene)
        && accepts(question, &selection.base, &selection.base, &chosen)?
        && let Some(accepted) = reduced(question, &selection.base, chosen, &found.joined)?
        && found.makes_likeliest(&accepted)
    {
        selection.chosen = accepted;
    }
    if selection.chosen.effects.len() < MOST_EFFECTS
        && !explains_enough(question, &selection.base, &selection.chosen, SLOW_EFFECTS_FROM)
        && let Some((slow, others)) = slow(question, &selection.chosen, done)?
        && accepts(question, &selection.base, &selection.chosen, &slow)?
        && let Some(accepted) = reduced(question, &selection.base, slow.clone(), &found.joined)?
    {
        // It stands against what else the whole recordings were asked about.
        let mut of_its_size = others;
        of_its_size.extend([slow, selection.chosen, accepted.clone()]);
        of_its_size.retain(|set| set.effects.len() == accepted.effects.len());
        selection.rounds.truncate(accepted.effects.len() - 1);
        selection.rounds.push(trials(&ranked(question, &selection.base, of_its_size)));
        selection.chosen = accepted;
    }
    Ok(selection)
}

impl Selection {
    /// Whether an effect that is left of the chosen set was the likeliest of its size, where that was decided.
    fn makes_likeliest(&self, accepted: &Candidate) -> bool {
        let count = accepted.effects.len();
        count == self.chosen.effects.len()
            || self.rounds.get(count - 1).is_some_and(|round| is_likeliest(accepted, None, round))
    }
}

/// The machine file's model on the whole: to the end only where that is near, for what lacks an effect never quite arrives.
fn base(question: &Question<'_>, from: &Candidate) -> Result<Candidate, FitError> {
    let rough = Candidate::rough(question, Some(&from.fit))?;
    if rough.worst_over_noise(question) < WHOLE_REFITTED_BELOW { rough.finished(question) } else { Ok(rough) }
}

/// A set with the effect beside it that acts slowly and follows the whole recordings best, refitted, and those with each of the others.
fn slow(
    question: &Question<'_>,
    from: &Candidate,
    done: &(impl Fn(&str) + Sync),
) -> Result<Option<(Candidate, Vec<Candidate>)>, FitError> {
    let mut open = open_to(question, from);
    open.retain(|hypothesis| hypothesis.is_slow(question.scene));
    if open.is_empty() {
        return Ok(None);
    }
    let reference = Reference::new(question, from)?;
    let mut leads: Vec<Lead> = reference.leads(&open)?;
    let mut known: Vec<&str> = Vec::new();
    // The most promising first, so that the best form of each stays.
    leads.retain(|lead| {
        let new = !known.contains(&lead.effect.name);
        known.push(lead.effect.name);
        new
    });
    let mut others = refit_each(&leads, done, |lead| reference.with(lead))?;
    others.sort_by(|a, b| a.fit.loss.total_cmp(&b.fit.loss));
    if others.is_empty() {
        return Ok(None);
    }
    let best = others.remove(0).finished(question)?;
    others.retain(|candidate| candidate.is_possible(question.scene));
    Ok(best.is_plausible(question.scene).then_some((best, others)))
}
