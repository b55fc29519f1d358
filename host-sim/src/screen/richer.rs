//! Where what is richer than an effect that was found could start: extensions of it, and its refined forms.

use model_core::machine::MachineError;
use rayon::prelude::*;

use super::{Lead, Values, combined};
use crate::fit::{Fit, Sensitivity};
use crate::hypothesis::{Form, Hypothesis, Kind, Scene, Strength};

/// The most promising start of every form of an extension from a solution with the plainer effect: what that had is taken over,
/// and the rest is tried.
pub fn extended(
    scene: &Scene<'_>,
    fit: &Fit,
    sensitivity: &Sensitivity<'_>,
    effect: &'static Hypothesis,
) -> Result<Vec<Lead>, MachineError> {
    let Some(extension) = effect.extends else { return Ok(Vec::new()) };
    let given = fit.machine.get(extension.given);
    let mut found = Vec::new();
    let taken = |strength: &&Strength| extension.taken.contains(&strength.parameter);
    // A form that takes nothing over from the plainer effect is no extension of it.
    for form in effect.forms_in(scene).filter(|form| form.iter().any(|strength| taken(&strength))) {
        let start: Values = std::iter::once((extension.given, 0.0))
            .chain(form.iter().filter(taken).map(|strength| (strength.parameter, given)))
            .collect();
        let tries = form.iter().filter(|strength| !taken(strength)).map(|strength| {
            let (low, high) = strength.range(scene);
            let known = fit.free.iter().any(|free| free.parameter == strength.parameter);
            let fitted = fit.machine.get(strength.parameter);
            let values = match strength.kind {
                // What both have, the plainer one's refit knows.
                _ if known && (low..=high).contains(&fitted) => vec![fitted],
                Kind::Amount(_) | Kind::Firm(_) | Kind::Jump(_) => vec![0.1 * given, 0.5 * given, given],
                Kind::Signed(_) => vec![-0.5 * given, 0.05 * given, 0.5 * given],
                Kind::Shape(..) | Kind::Place(..) => strength.tries(scene),
            };
            (strength.parameter, values)
        });
        found.extend(best_of(sensitivity, fit, (effect, form), combined(start, tries))?);
    }
    Ok(found)
}

/// The same of a refined form of an effect, from a solution with it in the plain one.
pub fn refining(
    scene: &Scene<'_>,
    fit: &Fit,
    sensitivity: &Sensitivity<'_>,
    effect: &'static Hypothesis,
    [plain, refined]: [Form; 2],
) -> Result<Option<Lead>, MachineError> {
    let start: Values =
        plain.iter().map(|strength| (strength.parameter, fit.machine.get(strength.parameter))).collect();
    let more = |strength: &&Strength| plain.iter().all(|known| known.parameter != strength.parameter);
    let tries = refined.iter().filter(more).map(|strength| {
        let little = 0.1 * strength.unit(scene);
        let values = match strength.kind {
            Kind::Amount(_) | Kind::Firm(_) | Kind::Jump(_) => vec![little],
            Kind::Signed(_) => vec![-little, little],
            Kind::Shape(..) | Kind::Place(..) => strength.tries(scene),
        };
        (strength.parameter, values)
    });
    best_of(sensitivity, fit, (effect, refined), combined(start, tries))
}

/// The lead of an effect with the least loss, of these values.
fn best_of(
    sensitivity: &Sensitivity<'_>,
    fit: &Fit,
    (effect, form): (&'static Hypothesis, Form),
    all: Vec<Values>,
) -> Result<Option<Lead>, MachineError> {
    let at = |values| Lead::at(sensitivity, fit, effect, form, values);
    let leads: Vec<Lead> = all.into_par_iter().map(at).collect::<Result<_, MachineError>>()?;
    Ok(leads.into_iter().min_by(|a, b| a.loss.total_cmp(&b.loss)))
}
