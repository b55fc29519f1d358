//! What has changed since a machine file was written, or since recordings were made: the effects that a file holds may have become more or less.

use identification::experiment::Prepared;
use identification::fit::{Estimate, Free, Freedom};
use machine_file::MachineFile;
use model_core::machine::{Machine, Parameter};

use crate::before_after::Shown;
use crate::catalogue::{AMOUNT_KNOWN, CATALOGUE, EffectParameter, Hypothesis, covered_by, tolerance};
use crate::outcome::Diagnosis;

/// The effects that a machine file holds, beyond what is a tolerance by its `sheet` of base parameters.
pub(crate) fn held(file: &MachineFile, sheet: &[Free]) -> Vec<&'static Hypothesis> {
    CATALOGUE.iter().copied().filter(|effect| effect.is_on(&file.machine, sheet)).collect()
}

/// Whether an effect may be found beside those that are on: none of them, but where it may have changed. What has become more of it is not given to
/// another effect of its kind. A floor of the pressures has no amount that could change.
pub(crate) fn may_be_found(
    effect: &Hypothesis,
    on: &[&Hypothesis],
    held: &[&Hypothesis],
    changeable: &[&EffectParameter],
) -> bool {
    let is_it = |other: &&Hypothesis| other.name == effect.name;
    let is_of_its_kind = |other: &&Hypothesis| other.plainest() == effect.plainest();
    let can_change = || effect.amounts().any(|own| changeable.iter().any(|amount| amount.parameter == own.parameter));
    if on.iter().any(is_it) { held.iter().any(is_it) && can_change() } else { !held.iter().any(is_of_its_kind) }
}

/// What a diagnosis lets move in the model without effects, and what may have changed.
pub(crate) struct Moves {
    /// The effects that may have changed.
    pub(crate) held: Vec<&'static Hypothesis>,
    /// Their amounts.
    pub(crate) changeable: Vec<&'static EffectParameter>,
    /// The base parameters.
    pub(crate) free: Vec<Free>,
    /// That of them by which the oil's temperature acts, where it is no effect.
    of_oil: Option<Free>,
}

impl Moves {
    /// By a `sheet` of base parameters; where it is asked what has changed since, with the effects that the file holds.
    pub(crate) fn of(
        file: &MachineFile,
        sheet: &[Free],
        since: Option<&[&'static Hypothesis]>,
        cases: &[Prepared],
    ) -> Self {
        let Some(held) = since else {
            return Self { held: Vec::new(), changeable: Vec::new(), free: sheet.to_vec(), of_oil: None };
        };
        let changeable = changeable(&file.machine, sheet, held);
        let of_oil = of_oil(file, cases);
        let fitted = since_then(sheet, (file, cases), held, &changeable);
        Self { held: held.to_vec(), changeable, free: fitted.into_iter().chain(of_oil).collect(), of_oil }
    }

    /// What moves, with the amounts that may have changed free to become much less or more: what there is of them is asked, not whether it is as before.
    pub(crate) fn asking_amounts(&self) -> Vec<Free> {
        /// Standard deviation of a magnitude's logarithm: from a ninth to nine times as much is within two.
        const SPREAD: f64 = 1.1;
        let asked = |free: &Free| {
            let amount = self.changeable.iter().find(|amount| amount.parameter == free.parameter)?;
            let then = free.nominal();
            let freedom = if amount.is_signed() {
                Freedom::Around { nominal: then, sigma: then.abs() }
            } else {
                Freedom::Logarithm { centre: then, spread: SPREAD, vanishes: false }
            };
            Some(Free { freedom, ..*free })
        };
        self.free.iter().map(|free| asked(free).unwrap_or(*free)).collect()
    }

    /// Whether an effect is part of the model already, and none beside it.
    pub(crate) fn has_in_model(&self, effect: &Hypothesis) -> bool {
        self.of_oil.is_some_and(|free| effect.amounts().any(|own| own.parameter == free.parameter))
    }

    /// The effects that may have changed and of which these recordings do not tell it: no form of theirs can be tried, or a change by half of any of their
    /// amounts would be chance. `estimates` are those of the base parameters; those of what is found are not among them.
    pub(crate) fn untested(
        &self,
        hypotheses: &[&'static Hypothesis],
        estimates: &[Estimate],
    ) -> Vec<&'static Hypothesis> {
        let is_told = |amount: &&EffectParameter| {
            let free = self.free.iter().find(|free| free.parameter == amount.parameter);
            let estimate = estimates.iter().find(|estimate| estimate.parameter == amount.parameter);
            // What jumps is searched over its whole range.
            free.zip(estimate).is_none_or(|(free, estimate)| shows(free, estimate))
        };
        let is_tested = |effect: &Hypothesis| {
            let own = |amount: &&&EffectParameter| effect.amounts().any(|own| own.parameter == amount.parameter);
            hypotheses.iter().any(|known| known.name == effect.name) && self.changeable.iter().filter(own).any(is_told)
        };
        self.held.iter().copied().filter(|effect| !is_tested(effect)).collect()
    }
}

/// The amounts of effects that may have changed: those of which the machine file holds more than a tolerance. One that several forms share comes once.
fn changeable(machine: &Machine<f64>, sheet: &[Free], held: &[&'static Hypothesis]) -> Vec<&'static EffectParameter> {
    let mut found: Vec<&EffectParameter> = Vec::new();
    for amount in held.iter().flat_map(|effect| effect.amounts()) {
        let is_known = found.iter().any(|known| known.parameter == amount.parameter);
        if !is_known && machine.get(amount.parameter).abs() > tolerance(sheet, amount.parameter) {
            found.push(amount);
        }
    }
    found
}

/// The base parameters once they were fitted, with the amounts that may have changed in the place of what else the file says of them and of their
/// tolerances.
fn since_then(
    sheet: &[Free],
    (file, cases): (&MachineFile, &[Prepared]),
    held: &[&Hypothesis],
    changeable: &[&EffectParameter],
) -> Vec<Free> {
    let knows_oil = knows_oil(file, cases);
    let is_of_the_day = |free: &Free| {
        let moves_along = |(parameter, along): &(Parameter, &[Parameter])| {
            *parameter == free.parameter && changeable.iter().any(|amount| along.contains(&amount.parameter))
        };
        if OF_THE_COMMAND.contains(&free.parameter) || MOVES_ALONG.iter().any(moves_along) {
            return true;
        }
        let acts_like = |names: &[&str]| held.iter().any(|effect| names.contains(&effect.name));
        let is_oils = knows_oil && free.parameter == Parameter::ViscousFriction;
        !is_oils && OF_THE_DAY.iter().any(|(parameter, alike)| *parameter == free.parameter && !acts_like(alike))
    };
    let mut free: Vec<Free> =
        sheet.iter().map(|free| if is_of_the_day(free) { *free } else { once_fitted(*free, file) }).collect();
    for amount in changeable {
        let (parameter, value) = (amount.parameter, file.machine.get(amount.parameter));
        let covers = |free: &Free| free.tolerance().is_some() && free.parameter == covered_by(parameter);
        free.retain(|free| free.parameter != parameter && !covers(free));
        if !amount.is_jump() {
            let most = AMOUNT_KNOWN * value.abs();
            free.push(Free { parameter, freedom: Freedom::Near { nominal: value, most, within: None } });
        }
    }
    free
}

/// What is of the oil and of the day, not of the drive: it may be different at another time, however well it was known. Where an effect that acts like it
/// may have changed, it is known as the rest is: it would take up the change. So is viscous friction where the oil's temperature is known at both times.
const OF_THE_DAY: [(Parameter, &[&str]); 5] = [
    (Parameter::BulkModulus, &["entrained-air", "hose-compliance"]),
    (Parameter::ViscousFriction, &[]),
    (Parameter::TankPressure, &["tank-back-pressure"]),
    (Parameter::LoadForce, &["position-dependent-load", "friction-asymmetry"]),
    (Parameter::AirShare, &["hose-compliance"]),
];

/// Whether a value is one of the oil and of the day, and yet so known that no day makes it much different: cold oil has several times the viscosity.
pub(crate) fn is_told_by_any_day(parameter: Parameter) -> bool {
    parameter != Parameter::ViscousFriction && OF_THE_DAY.iter().any(|(of_the_day, _)| *of_the_day == parameter)
}

/// What depends on how a drive is moved, and is open again with other commands: the dead time stands for how a spool of higher order begins to move.
const OF_THE_COMMAND: [Parameter; 1] = [Parameter::TransportDelay];

/// A base parameter that another time leaves as open as a data sheet does, where one of these amounts may have changed: an edge that wears changes the mean
/// overlap as it changes the difference between the overlaps, which a spool's sensor reads as an offset.
const MOVES_ALONG: [(Parameter, &[Parameter]); 1] =
    [(Parameter::DeadZone, &[Parameter::DeadZoneDifference, Parameter::SpoolOffset])];

/// What is set by hand: known once it was fitted, but not bounded.
const SET_BY_HAND: [Parameter; 1] = [Parameter::SupplyPressure];

/// So many times as well as a data sheet says a value is known once it was fitted. Where a fit leaves a combination of values open, it is the same at
/// another time.
pub(crate) const KNOWN_TIMES: f64 = 5.0;

/// Standard deviations that a value of the drive itself stays within. A prior without an end gives way to recordings that press hard enough, and a leak that
/// has doubled is then a valve that no drive has.
const BOUNDED_BY: f64 = 2.0;

/// A base parameter as it is known once it was fitted. Of a tolerance a part is left around what the file holds within it; of one that was never fitted, all.
fn once_fitted(free: Free, file: &MachineFile) -> Free {
    /// Of what exceeds a least value, the share that a bound comes to it at most.
    const KEPT: f64 = 0.9;
    let bounded = |nominal: f64, most: f64| Freedom::Near { nominal, most, within: None };
    let freedom = match free.freedom {
        Freedom::Around { nominal, sigma } if SET_BY_HAND.contains(&free.parameter) => {
            Freedom::Around { nominal, sigma: sigma / KNOWN_TIMES }
        }
        Freedom::Around { nominal, sigma } => bounded(nominal, BOUNDED_BY * sigma / KNOWN_TIMES),
        Freedom::Roughly { least, nominal, spread } => {
            bounded(nominal, (nominal - least) * (BOUNDED_BY * spread / KNOWN_TIMES).min(KEPT))
        }
        Freedom::Within { most, is_signed } if file.given.contains(&free.parameter) => {
            let (parameter, half) = (free.parameter, if is_signed { most } else { 0.5 * most });
            let then = file.machine.get(parameter);
            return Free::part_of_tolerance(parameter, most, is_signed, then, half / KNOWN_TIMES);
        }
        other => other,
    };
    Free { freedom, ..free }
}

/// Times its standard deviation by the recordings that a change has to exceed to show. Source: once in 400 by chance.
const SHOWS_FROM: f64 = 3.0;

/// Whether the recordings would show a change by half of an amount.
fn shows(free: &Free, estimate: &Estimate) -> bool {
    let Freedom::Near { nominal, most, .. } = free.freedom else { return true };
    // What has moved, the recordings have moved.
    (estimate.value - nominal).abs() > 0.5 * most || SHOWS_FROM * alone(free, estimate, nominal) < 0.5 * nominal.abs()
}

/// The standard deviation that recordings tell by themselves, at a value: what is left of the estimate's precision without that of its prior.
fn alone(free: &Free, estimate: &Estimate, at: f64) -> f64 {
    let deviation = estimate.std / free.width(estimate.value);
    deviation / (1.0 - deviation * deviation).max(0.0).sqrt() * free.width(at)
}

/// Whether there is as much of an effect as then, as near as that is known, and a change by half of it would have shown.
pub(crate) fn is_as_before(estimate: &Estimate, then: f64) -> bool {
    (estimate.value - then).abs() <= AMOUNT_KNOWN * then.abs() && SHOWS_FROM * estimate.std < 0.5 * then.abs()
}

/// Of fitted values, the amounts of effects that the recordings tell: by a third of themselves, or of what may be within the drawing.
pub(crate) fn strengths(free: &[Free], estimates: &[Estimate]) -> Vec<Estimate> {
    let is_told = |estimate: &&Estimate| {
        let free = free.iter().find(|free| free.parameter == estimate.parameter);
        free.filter(|_| estimate.parameter.effect().is_some()).is_some_and(|free| {
            let scale = estimate.value.abs().max(0.5 * free.tolerance().unwrap_or(0.0));
            SHOWS_FROM * alone(free, estimate, estimate.value) < scale
        })
    };
    estimates.iter().filter(is_told).copied().collect()
}

/// Oil of another temperature than then, where both are known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OtherOil {
    /// Mean temperature then, °C.
    pub then_c: f64,
    /// Mean recorded temperature, °C.
    pub now_c: f64,
    /// Its viscosity, as a share of that of then.
    pub viscosity: f64,
}

impl OtherOil {
    /// Whether it is different enough to be told: by more than an amount is known.
    #[must_use]
    pub fn is_told(&self) -> bool {
        (self.viscosity - 1.0).abs() > AMOUNT_KNOWN
    }
}

/// What the temperature of the oil changes, where it is recorded and the machine file says at which one its values hold: its law is known by the oil's
/// kind, and a drive that is only warmer has not changed.
fn of_oil(file: &MachineFile, cases: &[Prepared]) -> Option<Free> {
    /// Relative loss of viscosity per kelvin of mineral oil, as `oil-temperature` has it: two standard deviations either way.
    const USUAL_PER_K: (f64, f64) = (0.02, 0.06);
    let parameter = Parameter::ViscosityLossPerKelvin;
    let is_on = file.machine.get(parameter) > 0.0;
    let (low, high) = USUAL_PER_K;
    let freedom =
        Freedom::Logarithm { centre: (low * high).sqrt(), spread: 0.25 * libm::log(high / low), vanishes: false };
    (!is_on && knows_oil(file, cases)).then_some(Free { parameter, freedom })
}

/// Whether the oil's temperature is known at both times.
fn knows_oil(file: &MachineFile, cases: &[Prepared]) -> bool {
    file.given.contains(&Parameter::ReferenceTemperature) && mean_oil_c(cases).is_some()
}

/// Mean temperature of the oil in the recordings that have it, °C.
fn mean_oil_c<'a>(cases: impl IntoIterator<Item = &'a Prepared>) -> Option<f64> {
    let recorded: Vec<f64> = cases.into_iter().filter_map(|case| case.stimulus.mean_oil_c()).collect();
    (!recorded.is_empty()).then(|| recorded.iter().sum::<f64>() / recorded.len() as f64)
}

/// The training recordings.
fn trained(shown: &[Shown]) -> impl Iterator<Item = &Prepared> {
    shown.iter().filter(|shown| !shown.held_out).map(|shown| &shown.prepared)
}

/// Oil of another temperature than then, where the machine after a diagnosis has its law.
pub(crate) fn other_oil(file: &MachineFile, shown: &[Shown], after: &Machine<f64>) -> Option<OtherOil> {
    let (now_c, loss) = (mean_oil_c(trained(shown))?, after.get(Parameter::ViscosityLossPerKelvin));
    let then = Parameter::ReferenceTemperature;
    let then_c = (loss > 0.0 && file.given.contains(&then)).then(|| file.machine.get(then))?;
    let viscosity = libm::exp(-loss * (now_c - after.get(then))).clamp(0.125, 8.0);
    Some(OtherOil { then_c, now_c, viscosity })
}

impl Diagnosis {
    /// The machine file after the diagnosis: refitted, with the accepted effects. What has become a finding is no tolerance any more: another fit would
    /// hold it within.
    #[must_use]
    pub fn machine_file(&self, before: &MachineFile) -> MachineFile {
        let mut after = before.clone();
        after.machine = self.machine_after;
        // The band was that of other values.
        after.band = None;
        after.start_at(self.level_at_rest);
        let of_effects =
            || self.findings.iter().flat_map(|finding| &finding.parameters).map(|estimate| estimate.parameter);
        after.given.extend(self.refitted.iter().map(|estimate| estimate.parameter).chain(of_effects()));
        for parameter in of_effects().flat_map(|parameter| [parameter, covered_by(parameter)]) {
            after.tolerance.remove(&parameter);
        }
        // What a file holds is for the oil that it was fitted to.
        let oil_c = mean_oil_c(trained(&self.shown));
        if let Some(oil_c) = oil_c.filter(|_| after.machine.get(Parameter::ViscosityLossPerKelvin) == 0.0) {
            after.machine.set(Parameter::ReferenceTemperature, oil_c);
            after.given.insert(Parameter::ReferenceTemperature);
        }
        after.effects.extend(self.unnamed.as_ref().map(|_| "unnamed"));
        after.effects.extend(self.findings.iter().map(|finding| finding.effect.name));
        after
    }
}

#[cfg(test)]
mod tests;
