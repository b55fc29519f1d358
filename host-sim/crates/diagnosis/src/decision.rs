//! Which effects of a selection are accepted once the held-out recordings are opened, and how well their values are known.

use identification::experiment::Prepared;
use identification::fit::{Estimate, FitError};
use model_core::machine::Parameter;

use crate::catalogue::Hypothesis;
use crate::finding::{Finding, finding};
use crate::selection::veto::stands_on_own_sides;
use crate::selection::{Candidate, Confirmation, Question, Selection, confirm};

/// What is accepted.
pub(crate) struct Decision {
    pub(crate) findings: Vec<Finding>,
    pub(crate) not_confirmed: Vec<&'static Hypothesis>,
    /// What the held-out recordings said; `None` if there was no choice to confirm.
    pub(crate) confirmation: Option<Confirmation>,
    /// The model with what is accepted.
    pub(crate) after: Candidate,
    /// Every value that was fitted in it.
    pub(crate) estimates: Vec<Estimate>,
}

impl Decision {
    /// The decision that accepts nothing.
    fn without(
        question: &Question<'_>,
        selection: &Selection,
        not_confirmed: Vec<&'static Hypothesis>,
        confirmation: Option<Confirmation>,
    ) -> Result<Self, FitError> {
        let after = selection.base.clone();
        let estimates = after.estimates(question)?;
        Ok(Self { findings: Vec::new(), not_confirmed, confirmation, after, estimates })
    }
}

/// Opens the held-out recordings for the chosen candidate model: they confirm or veto each of its effects beside the others, and then
/// the model as a whole.
pub(crate) fn decide(
    question: &Question<'_>,
    selection: &mut Selection,
    held: &[&Prepared],
) -> Result<Decision, FitError> {
    let mut vetoed = selection.refused(question, held)?;
    let chosen = &selection.chosen;
    if chosen.effects.is_empty() {
        return Decision::without(question, selection, vetoed, None);
    }
    let confirmation = confirm(&selection.base, chosen, question.training, held)?;
    let stands =
        held.is_empty() || confirmation.confirms() || stands_on_own_sides(question, selection, &confirmation, held)?;
    if !stands {
        vetoed.extend(chosen.effects.iter().map(|chosen| chosen.effect));
        return Decision::without(question, selection, vetoed, Some(confirmation));
    }
    let estimates = estimates(question, selection)?;
    let mut findings: Vec<Finding> =
        chosen.effects.iter().map(|chosen| finding(chosen, selection, &estimates, &vetoed)).collect();
    findings.sort_by(|a, b| b.confidence.total_cmp(&a.confidence));
    let confirmation = (!held.is_empty()).then_some(confirmation);
    Ok(Decision { findings, not_confirmed: vetoed, confirmation, after: chosen.clone(), estimates })
}

/// Estimates of the chosen candidate model. Free runs do not show when a spool jumps. So the stiction parameters have no standard deviation where
/// no sensor sees the spool (only its jump spacing says how well they are known), and none where the spool hardly jumps.
fn estimates(question: &Question<'_>, selection: &Selection) -> Result<Vec<Estimate>, FitError> {
    let mut estimates = selection.chosen.estimates(question)?;
    let is_untold = selection.jumps.is_some() || selection.chosen.hardly_jumps();
    let is_of = |parameter| matches!(parameter, Parameter::StictionBand | Parameter::StictionKept);
    for estimate in estimates.iter_mut().filter(|one| is_untold && is_of(one.parameter)) {
        estimate.std = f64::NAN;
    }
    Ok(estimates)
}
