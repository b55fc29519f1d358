//! Which effects are worth a refit: each is tried at a few points of its usual range. What it would gain once all free values are refitted is
//! computed from the Jacobian of the residuals: one simulation per point instead of a fit.

use identification::parallel;

use identification::fit::{Change, Fit, Free, Sensitivity, Settled, Simulated};
use model_core::machine::{Machine, MachineError, Parameter};

use crate::catalogue::{EffectParameter, Form, Hypothesis, Kind, Scene};

/// A form of an effect at the point of its range with the largest predicted gain.
#[derive(Clone, Debug)]
pub struct Lead {
    /// The effect.
    pub effect: &'static Hypothesis,
    /// The form.
    pub form: Form,
    /// Value of every effect parameter, SI.
    pub values: Values,
    /// Half the sum of squares that it would gain.
    pub gain: f64,
    /// Half the sum of squares that it would leave.
    pub loss: f64,
    /// Coordinates after the refit of all values that were free before: parameters, then each recording's initial state.
    pub settled: Vec<f64>,
}

impl Lead {
    /// A form with these effect parameters.
    pub(crate) fn at(
        sensitivity: &Sensitivity<'_>,
        fit: &Fit,
        effect: &'static Hypothesis,
        form: Form,
        values: Values,
    ) -> Result<Self, MachineError> {
        let there = sensitivity.simulated(&with(&fit.machine, &values))?;
        let Settled { gain, loss, coordinates } = sensitivity.settle(&sensitivity.change(&there));
        Ok(Self { effect, form, values, gain, loss, settled: coordinates })
    }

    /// Whether both are the same form of the same effect.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.effect.name == other.effect.name && self.form.as_ptr() == other.form.as_ptr()
    }
}

/// Effect parameters with their values, SI.
pub type Values = Vec<(Parameter, f64)>;

/// A point whose predicted gain is less than this share of the largest is not evaluated further.
const WORTHWHILE: f64 = 0.02;
/// A point that really gains more than this share of what its derivatives predict is taken; otherwise a shorter step is tried too.
const NEARLY_LINEAR: f64 = 0.5;
/// Most points that are evaluated further.
const MOST_TRIED: usize = 18;

/// Predicted gain of a point of a form's shapes along the directions of its amounts.
#[derive(Debug)]
struct PredictedGain {
    /// Which form.
    form: usize,
    shape: Values,
    /// Value of each amount, in its unit.
    shares: Vec<f64>,
    gain: f64,
}

/// The effect parameters that say how much of the effect there is.
pub fn amounts(form: Form) -> impl Iterator<Item = &'static EffectParameter> {
    form.iter().filter(|effect_parameter| effect_parameter.is_amount())
}

/// What there is of an amount already: by its tolerance, or because it may have changed from there; 0 of any other.
fn taken_up(fit: &Fit, amount: &EffectParameter) -> f64 {
    fit.machine.get(amount.parameter)
}

/// Simulation with each amount a unit beyond its tolerance and the others as they are.
fn directions(
    fit: &Fit,
    sensitivity: &Sensitivity<'_>,
    form: Form,
    shape: &[(Parameter, f64)],
    units: &[f64],
) -> Result<Vec<Simulated>, MachineError> {
    let values = amounts(form)
        .zip(units)
        .map(|(amount, unit)| [shape, &[(amount.parameter, taken_up(fit, amount) + *unit)]].concat());
    values.map(|values| sensitivity.simulated(&with(&fit.machine, &values))).collect()
}

/// The value of each amount, in its unit, that lowers the loss most, from the direction in which it moves the residuals; and the gain.
fn directed(scene: &Scene<'_>, sensitivity: &Sensitivity<'_>, form: Form, directions: &[Simulated]) -> (Vec<f64>, f64) {
    let only_grows = |amount: &EffectParameter| !matches!(amount.kind, Kind::Signed(_)) && scene.before(amount) == 0.0;
    let positive: Vec<bool> = amounts(form).map(only_grows).collect();
    let changes: Vec<Change> = directions.iter().map(|direction| sensitivity.change(direction)).collect();
    sensitivity.amounts(&changes, &positive)
}

/// The best point of every form, the most promising first, for each of several weightings of the same recordings. Forms without a predicted gain are
/// left out.
pub fn screen(
    scene: &Scene<'_>,
    fit: &Fit,
    weighings: &[Sensitivity<'_>],
    hypotheses: &[&'static Hypothesis],
) -> Result<Vec<Vec<Lead>>, MachineError> {
    let Some(any) = weighings.first() else { return Ok(Vec::new()) };
    let forms: Vec<(&'static Hypothesis, Form)> =
        hypotheses.iter().flat_map(|effect| effect.forms_in(scene).map(move |form| (*effect, form))).collect();
    let points: Vec<(usize, Values)> = forms
        .iter()
        .enumerate()
        .flat_map(|(index, (_, form))| shapes(scene, form).into_iter().map(move |shape| (index, shape)))
        .collect();
    // Predicted gain of each point along its directions, for each weighting.
    let predicted_gain: Vec<Vec<PredictedGain>> = parallel::each(points, |(index, shape)| {
        let form = forms[index].1;
        let units: Vec<f64> = amounts(form).map(|effect_parameter| effect_parameter.unit(scene)).collect();
        // A point that is no valid drive has no predicted gain.
        let directions = directions(fit, any, form, &shape, &units).ok();
        let predicted = |sensitivity| {
            // Without an amount there is no direction: the gain is that of the point itself.
            if units.is_empty() {
                let lead = Lead::at(sensitivity, fit, forms[index].0, form, shape.clone());
                let gain = lead.map_or(0.0, |lead| lead.gain);
                return PredictedGain { form: index, shape: shape.clone(), shares: Vec::new(), gain };
            }
            let predicted_gain = directions.as_ref().map(|directions| directed(scene, sensitivity, form, directions));
            let (shares, gain) = predicted_gain.unwrap_or_default();
            PredictedGain { form: index, shape: shape.clone(), shares, gain }
        };
        weighings.iter().map(predicted).collect()
    });
    let by = |(which, sensitivity): (usize, &Sensitivity<'_>)| {
        best(scene, fit, sensitivity, &forms, predicted_gain.iter().map(|each| &each[which]).collect())
    };
    Ok(weighings.iter().enumerate().map(by).collect())
}

/// Whether an amount is beyond what the drive has within its tolerance anyway: less is no effect.
fn is_beyond_tolerance(scene: &Scene<'_>, free: &[Free], form: Form, values: &[(Parameter, f64)]) -> bool {
    let is_beyond = |amount: &EffectParameter| {
        let value = values.iter().find(|(parameter, _)| *parameter == amount.parameter);
        value.is_some_and(|(_, value)| scene.is_beyond(free, amount, *value))
    };
    let mut amounts = amounts(form).peekable();
    amounts.peek().is_none() || amounts.any(is_beyond)
}

/// The best of the promising points of every form, by simulation at the point itself.
fn best(
    scene: &Scene<'_>,
    fit: &Fit,
    sensitivity: &Sensitivity<'_>,
    forms: &[(&'static Hypothesis, Form)],
    predicted_gain: Vec<&PredictedGain>,
) -> Vec<Lead> {
    let is_beyond = |predicted: &&PredictedGain| {
        let form = forms[predicted.form].1;
        let amounts = amounts(form).zip(&predicted.shares);
        let values: Values = amounts
            .map(|(amount, share)| (amount.parameter, taken_up(fit, amount) + share * amount.unit(scene)))
            .collect();
        is_beyond_tolerance(scene, &fit.free, form, &values)
    };
    let predicted_gain: Vec<&PredictedGain> = predicted_gain.into_iter().filter(is_beyond).collect();
    let mut gains: Vec<f64> = predicted_gain.iter().map(|predicted| predicted.gain).collect();
    gains.sort_by(|a, b| b.total_cmp(a));
    let least = gains.first().map_or(0.0, |most| WORTHWHILE * most).max(gains.get(MOST_TRIED).copied().unwrap_or(0.0));
    let worthwhile = predicted_gain.into_iter().filter(|predicted| predicted.gain >= least);
    let leads: Vec<(usize, Option<Lead>)> = parallel::each(worthwhile, |predicted| {
        let (effect, form) = forms[predicted.form];
        // A point that is no valid drive is no lead.
        (predicted.form, lead(scene, fit, sensitivity, effect, form, predicted).ok().flatten())
    });
    let changed = parallel::each(points_of_change(scene, fit, forms), |(index, values)| {
        let (effect, form) = forms[index];
        let lead = Lead::at(sensitivity, fit, effect, form, values).ok();
        (index, lead.filter(|lead| lead.gain > 0.0))
    });
    let mut best: Vec<Option<Lead>> = vec![None; forms.len()];
    for (index, lead) in leads.into_iter().chain(changed) {
        if let Some(lead) = lead
            && is_beyond_tolerance(scene, &fit.free, lead.form, &lead.values)
            && best[index].as_ref().is_none_or(|known| known.gain < lead.gain)
        {
            best[index] = Some(lead);
        }
    }
    let mut found: Vec<Lead> = best.into_iter().flatten().collect();
    found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    found
}

/// Of each form of an effect that may have changed, points with more or less of one of its amounts, however small a change the derivatives predict: the base
/// parameters make up for much of a change, and a slope there says little of what is far away.
fn points_of_change(scene: &Scene<'_>, fit: &Fit, forms: &[(&'static Hypothesis, Form)]) -> Vec<(usize, Values)> {
    /// How much there is of what there was.
    const TRIED: [f64; 4] = [0.4, 0.7, 1.5, 2.5];
    let of_form = |(index, (_, form)): (usize, &(&'static Hypothesis, Form))| {
        let now: Values = amounts(form).map(|amount| (amount.parameter, taken_up(fit, amount))).collect();
        let may_change = amounts(form).enumerate().filter(|(_, amount)| scene.before(amount) != 0.0);
        let shape = shapes(scene, form).into_iter().next().unwrap_or_default();
        let points = may_change.flat_map(|(slot, amount)| TRIED.map(|ratio| (slot, ratio * scene.before(amount))));
        let with = |(slot, value): (usize, f64)| {
            let mut values = [shape.as_slice(), &now].concat();
            values[shape.len() + slot].1 = value;
            (index, values)
        };
        points.map(with).collect::<Vec<_>>()
    };
    forms.iter().enumerate().flat_map(of_form).collect()
}

/// Every combination of the shapes' points; of an effect that may have changed, the shapes that it has. A rigid friction has no stiffness.
pub fn shapes(scene: &Scene<'_>, form: Form) -> Vec<Values> {
    let tries = |shape: &EffectParameter| {
        let there = match shape.kind {
            _ if !scene.holds(form) => None,
            Kind::Shape(..) => scene.shape_then(shape),
            _ => Some(scene.machine.get(shape.parameter)),
        };
        there.map_or_else(|| shape.tries(scene), |there| vec![there])
    };
    let shapes = form.iter().filter(|effect_parameter| !effect_parameter.is_amount());
    combined(Vec::new(), shapes.map(|shape| (shape.parameter, tries(shape))))
}

/// The `given` values with every combination of the values to try.
pub fn combined(given: Values, tries: impl Iterator<Item = (Parameter, Vec<f64>)>) -> Vec<Values> {
    tries.fold(vec![given], |points, (parameter, values)| {
        points
            .iter()
            .flat_map(|point| values.iter().map(|value| [point.as_slice(), &[(parameter, *value)]].concat()))
            .collect()
    })
}

/// The machine with other values, each held within its range.
pub fn with(machine: &Machine<f64>, values: &[(Parameter, f64)]) -> Machine<f64> {
    let mut machine = *machine;
    for &(parameter, value) in values {
        let description = parameter.description();
        machine.set(parameter, value.clamp(description.min, description.max));
    }
    machine
}

/// An amount this far beyond what there is already; of what may only become less, some is left.
fn moved(scene: &Scene<'_>, amount: &EffectParameter, there: f64, beyond: f64) -> f64 {
    /// A step in the logarithm is not a step to nothing.
    const LEFT: f64 = 0.05;
    let may_vanish = scene.before(amount) > 0.0 && !matches!(amount.kind, Kind::Signed(_));
    if may_vanish { (there + beyond).max(LEFT * there) } else { there + beyond }
}

fn lead(
    scene: &Scene<'_>,
    fit: &Fit,
    sensitivity: &Sensitivity<'_>,
    effect: &'static Hypothesis,
    form: Form,
    predicted: &PredictedGain,
) -> Result<Option<Lead>, MachineError> {
    let lead_at = |values: Values| Lead::at(sensitivity, fit, effect, form, values);
    if form.iter().all(|effect_parameter| matches!(effect_parameter.kind, Kind::Jump(_))) {
        return jump(scene, form, lead_at).map(Some);
    }
    let mut units: Vec<f64> = amounts(form).map(|effect_parameter| effect_parameter.unit(scene)).collect();
    if units.is_empty() {
        return lead_at(predicted.shape.clone()).map(|lead| (lead.gain > 0.0).then_some(lead));
    }
    let (mut shares, mut predicted_gain) = (predicted.shares.clone(), predicted.gain);
    let mut best: Option<Lead> = None;
    // The second pass starts from the result of the first: a large amount has another direction than a small one.
    for last in [false, true] {
        if predicted_gain <= 0.0 || shares.iter().all(|share| *share == 0.0) {
            break;
        }
        for step in [1.0, 0.4] {
            let values: Values = amounts(form)
                .zip(shares.iter().zip(&units))
                .filter(|(_, (share, _))| **share != 0.0)
                .map(|(effect_parameter, (share, unit))| {
                    let beyond = step * share.clamp(-30.0, 30.0) * unit;
                    (
                        effect_parameter.parameter,
                        moved(scene, effect_parameter, taken_up(fit, effect_parameter), beyond),
                    )
                })
                .collect();
            let lead = lead_at([predicted.shape.as_slice(), &values].concat())?;
            let enough = lead.gain > NEARLY_LINEAR * predicted_gain;
            if best.as_ref().is_none_or(|known| known.gain < lead.gain) {
                best = Some(lead);
            }
            if enough {
                break;
            }
        }
        let near = shares.iter().all(|share| *share == 0.0 || (0.6..1.6).contains(&share.abs()));
        if near || last {
            break;
        }
        for (unit, share) in units.iter_mut().zip(&shares) {
            if *share != 0.0 {
                *unit *= share.abs().clamp(0.02, 30.0);
            }
        }
        (shares, predicted_gain) =
            directed(scene, sensitivity, form, &directions(fit, sensitivity, form, &predicted.shape, &units)?);
    }
    Ok(best.filter(|lead| lead.gain > 0.0).map(|mut lead| {
        // An effect parameter that is 0 at this point starts at a small value.
        for (effect_parameter, unit) in amounts(form).zip(&units) {
            if lead.values.iter().all(|(parameter, _)| *parameter != effect_parameter.parameter) {
                lead.values.push((effect_parameter.parameter, taken_up(fit, effect_parameter) + 0.03 * unit));
            }
        }
        lead
    }))
}

/// The best values of effect parameters with which residuals change in jumps: there is no usable derivative, so points of the ranges are tried and
/// then narrowed down, one effect parameter at a time.
fn jump(
    scene: &Scene<'_>,
    form: Form,
    lead_at: impl Fn(Values) -> Result<Lead, MachineError> + Sync,
) -> Result<Lead, MachineError> {
    /// Points of the first effect parameter's range, and of each further one's.
    const POINTS: [usize; 2] = [12, 4];
    let grid = |effect_parameter: &EffectParameter, points: usize| -> Vec<f64> {
        let (low, high) = effect_parameter.range(scene);
        (0..points).map(|index| low * libm::pow(high / low, (index as f64 + 0.5) / points as f64)).collect()
    };
    let tries = form
        .iter()
        .enumerate()
        .map(|(index, effect_parameter)| (effect_parameter.parameter, grid(effect_parameter, POINTS[index.min(1)])));
    let leads: Vec<Lead> = parallel::try_each(combined(Vec::new(), tries), &lead_at)?;
    let mut best: Option<Lead> = None;
    for lead in leads {
        if best.as_ref().is_none_or(|known| known.gain < lead.gain) {
            best = Some(lead);
        }
    }
    let Some(mut best) = best else { return lead_at(Vec::new()) };
    let mut width = 0.25;
    while width > 0.02 {
        let mut moved = false;
        for index in 0..form.len() {
            for factor in [1.0 - width, 1.0 + width] {
                let mut values = best.values.clone();
                let (parameter, value) = values[index];
                values[index].1 = (value * factor).min(parameter.description().max);
                let lead = lead_at(values)?;
                if lead.gain > best.gain {
                    (best, moved) = (lead, true);
                }
            }
        }
        if !moved {
            width *= 0.5;
        }
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use identification::fit::Freedom;
    use test_press::press;

    use super::*;
    use crate::catalogue::CATALOGUE;
    use crate::test_scene::scene;

    #[test]
    fn what_good_seals_have_anyway_is_no_lead_whichever_law_describes_it() {
        let free =
            [Free { parameter: Parameter::StribeckForce, freedom: Freedom::Within { most: 400.0, is_signed: false } }];
        let machine = press(&[]);
        let scene = scene(&machine, &[]);
        let coulomb = CATALOGUE.iter().find(|effect| effect.name == "coulomb-friction").unwrap();
        let is_lead = |free: &[Free], force_n| {
            is_beyond_tolerance(&scene, free, coulomb.forms[0], &[(Parameter::CoulombFriction, force_n)])
        };
        assert!(!is_lead(&free, 300.0) && is_lead(&free, 500.0) && is_lead(&[], 1.0));
    }
}
