//! What was found on the first part of long recordings, checked on the whole recordings.
//!
//! Base and chosen candidate model are refitted on the whole recordings, which have to accept the model once more. Effects that are superfluous there
//! are removed, if the reduced model was the likeliest of its size on the first part. Slow effects are not visible in a first part: where the misfit
//! of the whole is above the noise, the effects that act over time are tried on the whole.

use identification::fit::FitError;

use super::candidate::{Candidate, Question, Reference};
use super::decision_rule::{MOST_EFFECTS, SLOW_EFFECTS_FROM, WHOLE_REFITTED_BELOW};
use super::likelihood::{accepts, ranked};
use super::outcome::Selection;
use super::round::{explains_enough, is_likeliest, reduced, trials};
use super::screen::Lead;
use super::search::{open_to, refit_each};
use super::searched::{Clock, Stage};
use crate::catalogue::Hypothesis;

/// The selection on the whole recordings, from what was `found` on their first part. `done` is called after each refit.
///
/// It needs few runs of a recording, whatever was tried before: only the steps of a dozen refits grow with the length.
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
        inflated: found.inflated.clone(),
        base,
        rounds: found.rounds.clone(),
        joined: found.joined.clone(),
        jumps: None,
        searched: found.searched.clone(),
    };
    if let Some(chosen) = chosen?
        && chosen.is_plausible(question)
        && accepts(question, &selection.base, &selection.base, &chosen)?
        && let Some(accepted) = reduced(question, &selection.base, chosen, &found.joined)?
        && found.makes_likeliest(&accepted)
    {
        selection.chosen = accepted;
    }
    let open = if selection.chosen.effects.len() < MOST_EFFECTS
        && !explains_enough(question, &selection.base, &selection.chosen, SLOW_EFFECTS_FROM)
    {
        open_to(question, &selection.chosen).into_iter().filter(|effect| effect.is_slow(question.scene)).collect()
    } else {
        Vec::new()
    };
    let mut clock = Clock::of(question);
    if clock.effort().is_used_up() && !open.is_empty() {
        selection.searched.leave(Stage::Slow);
    } else if let Some((slow, others)) = slow(question, &selection.chosen, &open, done)?
        && accepts(question, &selection.base, &selection.chosen, &slow)?
        && let Some(accepted) = reduced(question, &selection.base, slow.clone(), &found.joined)?
    {
        // It is ranked against the other candidate models that were tried on the whole recordings.
        let mut of_its_size = others;
        of_its_size.extend([slow, selection.chosen, accepted.clone()]);
        of_its_size.retain(|candidate| candidate.effects.len() == accepted.effects.len());
        selection.rounds.truncate(accepted.effects.len() - 1);
        selection.rounds.push(trials(&ranked(question, &selection.base, of_its_size)));
        selection.chosen = accepted;
    }
    selection.searched.did(Stage::Slow, clock.lap_s());
    Ok(selection)
}

impl Selection {
    /// Whether the part of the chosen candidate model that is left was the likeliest of its size in its round of the search.
    fn makes_likeliest(&self, accepted: &Candidate) -> bool {
        let count = accepted.effects.len();
        count == self.chosen.effects.len()
            || self.rounds.get(count - 1).is_some_and(|round| is_likeliest(accepted, None, round))
    }
}

/// The machine file's model on the whole: refitted to the end only where it is near the noise, since a model that lacks an effect never quite
/// converges.
///
/// A part with few rows may have a valley that the whole has not: then the machine file's values are a second beginning.
fn base(question: &Question<'_>, from: &Candidate) -> Result<Candidate, FitError> {
    let mut rough = Candidate::rough(question, Some(&from.fit))?;
    if question.scene.is_sparse {
        let nominal = Candidate::rough(question, None)?;
        if nominal.fit.loss < rough.fit.loss {
            rough = nominal;
        }
    }
    if rough.worst_over_noise(question) < WHOLE_REFITTED_BELOW { rough.finished(question) } else { Ok(rough) }
}

/// The candidate model with one of these slow effects added that follows the whole recordings best, refitted to the end, and those with each of the other slow
/// effects.
fn slow(
    question: &Question<'_>,
    from: &Candidate,
    open: &[&'static Hypothesis],
    done: &(impl Fn(&str) + Sync),
) -> Result<Option<(Candidate, Vec<Candidate>)>, FitError> {
    if open.is_empty() {
        return Ok(None);
    }
    let reference = Reference::new(question, from)?;
    let mut leads: Vec<Lead> = reference.leads(open)?;
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
    Ok(best.is_plausible(question).then_some((best, others)))
}
