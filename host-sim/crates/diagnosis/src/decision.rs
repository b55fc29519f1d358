//! Which effects of a selection are accepted once the held-out recordings are opened, and how well their values are known.

use identification::experiment::Prepared;
use identification::fit::{Estimate, FitError};
use model_core::machine::Parameter;

use crate::agreement::far_values;
use crate::catalogue::Hypothesis;
use crate::finding::{Finding, finding};
use crate::selection::veto::stands_on_own_sides;
use crate::selection::{Candidate, Chosen, Confirmation, Question, Selection, confirm};
use crate::since::is_told_by_any_day;

/// What is accepted.
pub(crate) struct Decision {
    pub(crate) findings: Vec<Finding>,
    pub(crate) not_confirmed: Vec<&'static Hypothesis>,
    /// Effects that may have changed and that only act otherwise than then.
    pub(crate) otherwise: Vec<&'static Hypothesis>,
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
        Ok(Self { findings: Vec::new(), not_confirmed, otherwise: Vec::new(), confirmation, after, estimates })
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
    // That there is more or less of what was there is no choice among many: held-out recordings that do not work where it shows need not fall as far.
    let is_there = |chosen: &Chosen| question.scene.held.iter().any(|held| held.name == chosen.effect.name);
    let only_changes = || chosen.effects.iter().all(is_there) && confirmation.gains();
    let stands = held.is_empty()
        || confirmation.confirms()
        || only_changes()
        || stands_on_own_sides(question, selection, &confirmation, held)?;
    if !stands {
        vetoed.extend(chosen.effects.iter().map(|chosen| chosen.effect));
        return Decision::without(question, selection, vetoed, Some(confirmation));
    }
    let confirmation = (!held.is_empty()).then_some(confirmation);
    let trades = chosen.effects.iter().filter(|one| chosen.trades(question, one.form));
    let otherwise: Vec<&Hypothesis> = trades.map(|one| one.effect).collect();
    if !otherwise.is_empty() {
        let without = Decision::without(question, selection, vetoed, confirmation)?;
        return Ok(Decision { otherwise, ..without });
    }
    let estimates = estimates(question, selection)?;
    if is_there_anyway(question, chosen) || makes_up(question, chosen, &estimates) {
        return Decision::without(question, selection, vetoed, confirmation);
    }
    let mut findings: Vec<Finding> =
        chosen.effects.iter().map(|chosen| finding(chosen, question.scene, selection, &estimates, &vetoed)).collect();
    findings.sort_by(|a, b| b.confidence.total_cmp(&a.confidence));
    Ok(Decision {
        findings,
        not_confirmed: vetoed,
        otherwise: Vec::new(),
        confirmation,
        after: chosen.clone(),
        estimates,
    })
}

/// Whether an effect of a candidate model is one that the base model has: volumes that follow the piston. More of it stands in for something else; it takes
/// part in the search, so that nothing less likely is named in its place.
fn is_there_anyway(question: &Question<'_>, chosen: &Candidate) -> bool {
    let follows = question.scene.machine.get(Parameter::VolumeFollows) > 0.0;
    follows && chosen.effects.iter().any(|chosen| chosen.has(Parameter::VolumeShare))
}

/// Whether the effects of a candidate model make up for something else: it still misses more than noise although a base value is one that no such drive
/// has. Where the machine file tells the values of this very drive, such a value is enough, and so is one of the oil and of the day, its viscosity apart,
/// that no day explains.
fn makes_up(question: &Question<'_>, chosen: &Candidate, estimates: &[Estimate]) -> bool {
    let far = far_values(question.scene.machine, question.base_parameters, estimates);
    let is_impossible = far.iter().any(|far| far.is_impossible);
    let is_of_no_day = || far.iter().any(|far| is_told_by_any_day(far.parameter));
    if question.scene.asks_since {
        return is_impossible || is_of_no_day();
    }
    is_impossible && chosen.misses_by_more_than_noise(question)
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

#[cfg(test)]
mod tests {
    use identification::fit::Free;

    use super::*;
    use crate::catalogue::{CATALOGUE, Scene};
    use crate::selection::search::tests::with_press;

    /// A bulk modulus that no oil has counts against a model that misses more than noise, and not against one that follows.
    #[test]
    fn a_model_that_follows_only_in_part_and_only_with_an_impossible_value_names_nothing() {
        let asked = |unknown: &[(Parameter, f64)], value: f64, asks_since: bool| {
            let mut bends = None;
            with_press(unknown, |question| {
                let before = question.scene.machine.get(Parameter::BulkModulus);
                let free = [Free::around(Parameter::BulkModulus, before, 0.3 * before)];
                let base = Candidate::rough(question, None).unwrap();
                let estimate = Estimate { parameter: Parameter::BulkModulus, before, value, std: 1e5, at_bound: false };
                let scene = Scene { asks_since, ..*question.scene };
                let question = Question { base_parameters: &free, scene: &scene, ..*question };
                bends = Some(makes_up(&question, &base, &[estimate]));
            });
            bends.unwrap()
        };
        let rubs = [(Parameter::CoulombFriction, 300.0)];
        assert!(asked(&rubs, 7e7, false));
        assert!(!asked(&rubs, 1.1e9, false));
        assert!(!asked(&[], 7e7, false));
        // Of a drive whose values are known, it counts against any model; so does a stiffness that no day explains.
        assert!(asked(&[], 7e7, true) && asked(&[], 3e9, true));
        assert!(!asked(&[], 3e9, false) && !asked(&[], 1.1e9, true));
    }

    /// Volumes that change by the geometry are there in a machine file that says so, and a finding in one that says constant.
    #[test]
    fn volumes_that_follow_the_piston_are_no_finding_where_the_machine_file_has_them() {
        let effect = CATALOGUE.iter().find(|effect| effect.name == "position-dependent-volume").unwrap();
        let is_there = |follows: f64| {
            let mut is_there = None;
            with_press(&[], |question| {
                let machine = question.scene.machine.with(&[(Parameter::VolumeFollows, follows)]);
                let scene = Scene { machine: &machine, ..question.scene.clone() };
                let question = Question { scene: &scene, ..*question };
                let mut candidate = Candidate::rough(&question, None).unwrap();
                candidate.effects.push(Chosen { effect, form: effect.forms[0] });
                is_there = Some(is_there_anyway(&question, &candidate));
            });
            is_there.unwrap()
        };
        assert!(is_there(1.0) && !is_there(0.0));
    }
}
