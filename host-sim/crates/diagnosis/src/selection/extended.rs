//! Where an extension of an effect that was found could start.

use identification::parallel;

use identification::fit::{Fit, Sensitivity};
use model_core::machine::MachineError;

use super::screen::{Lead, Values, combined};
use crate::catalogue::{EffectParameter, Hypothesis, Kind, Scene};

/// The most promising start of every form of an extension from a solution with the plainer effect: the value of the plainer effect is taken over, and
/// for the other parameters several values are tried.
pub fn extended(
    scene: &Scene<'_>,
    fit: &Fit,
    sensitivity: &Sensitivity<'_>,
    effect: &'static Hypothesis,
) -> Result<Vec<Lead>, MachineError> {
    let Some(extension) = effect.extends else { return Ok(Vec::new()) };
    let given = fit.machine.get(extension.given);
    // What the plainer effect was before stays its own.
    if scene.held.iter().any(|held| held.name == extension.plain) {
        return Ok(Vec::new());
    }
    let mut found = Vec::new();
    let taken = |effect_parameter: &&EffectParameter| extension.taken.contains(&effect_parameter.parameter);
    // A form that takes nothing over from the plainer effect is no extension of it.
    for form in effect.forms_in(scene).filter(|form| form.iter().any(|effect_parameter| taken(&effect_parameter))) {
        let start: Values = std::iter::once((extension.given, 0.0))
            .chain(form.iter().filter(taken).map(|effect_parameter| (effect_parameter.parameter, given)))
            .collect();
        let tries = form.iter().filter(|effect_parameter| !taken(effect_parameter)).map(|effect_parameter| {
            let (low, high) = effect_parameter.range(scene);
            let known = fit.free.iter().any(|free| free.parameter == effect_parameter.parameter);
            let fitted = fit.machine.get(effect_parameter.parameter);
            let values = match effect_parameter.kind {
                // A parameter that both have keeps the value of the plainer effect's refit.
                _ if known && (low..=high).contains(&fitted) => vec![fitted],
                Kind::Amount(_) | Kind::Firm(_) | Kind::Jump(_) => vec![0.1 * given, 0.5 * given, given],
                Kind::Signed(_) => vec![-0.5 * given, 0.05 * given, 0.5 * given],
                Kind::Shape(..) | Kind::Place(..) | Kind::Floor(..) | Kind::Setting(..) => {
                    effect_parameter.tries(scene)
                }
            };
            (effect_parameter.parameter, values)
        });
        let at = |values| Lead::at(sensitivity, fit, effect, form, values);
        let leads: Vec<Lead> = parallel::try_each(combined(start, tries), at)?;
        found.extend(leads.into_iter().min_by(|a, b| a.loss.total_cmp(&b.loss)));
    }
    Ok(found)
}
