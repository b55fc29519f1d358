//! What has changed since a machine file was written, or since recordings were made: the effects that a file holds may have become more or less.

use identification::fit::{Free, Freedom};
use machine_file::MachineFile;
use model_core::machine::{Machine, Parameter};

use crate::catalogue::{CATALOGUE, EffectParameter, Hypothesis, covered_by, tolerance};
use crate::outcome::Diagnosis;

/// The effects that a machine file holds, beyond what is a tolerance by its `sheet` of base parameters.
pub(crate) fn held(file: &MachineFile, sheet: &[Free]) -> Vec<&'static Hypothesis> {
    CATALOGUE.iter().copied().filter(|effect| effect.is_on(&file.machine, sheet)).collect()
}

/// Whether an effect may be found beside those that are on: none of them, but where it may have changed. What has become more of it is not given to
/// another effect of its kind.
pub(crate) fn may_be_found(effect: &Hypothesis, on: &[&Hypothesis], held: &[&Hypothesis]) -> bool {
    let is_it = |other: &&Hypothesis| other.name == effect.name;
    let is_of_its_kind = |other: &&Hypothesis| other.plainest() == effect.plainest();
    if on.iter().any(is_it) { held.iter().any(is_it) } else { !held.iter().any(is_of_its_kind) }
}

/// An amount of an effect that a machine file holds is known to this share of itself: what differs by less, from one recording of a drive to another or by
/// what else a fit leaves open, has not changed. Source: half of what a strength may be off by, chosen.
const AMOUNT_KNOWN: f64 = 0.1;

/// The amounts of effects that may have changed: those of which the machine file holds more than a tolerance.
pub(crate) fn changeable(
    machine: &Machine<f64>,
    sheet: &[Free],
    held: &[&'static Hypothesis],
) -> Vec<&'static EffectParameter> {
    let amounts = held.iter().flat_map(|effect| effect.amounts());
    amounts.filter(|amount| machine.get(amount.parameter).abs() > tolerance(sheet, amount.parameter)).collect()
}

/// The base parameters once they were fitted, with the amounts that may have changed in the place of their tolerances.
pub(crate) fn since_then(sheet: &[Free], machine: &Machine<f64>, changeable: &[&EffectParameter]) -> Vec<Free> {
    let mut free: Vec<Free> = sheet.iter().copied().map(once_fitted).collect();
    for amount in changeable {
        let (parameter, value) = (amount.parameter, machine.get(amount.parameter));
        free.retain(|free| free.tolerance().is_none() || ![parameter, covered_by(parameter)].contains(&free.parameter));
        if !amount.is_jump() && free.iter().all(|free| free.parameter != parameter) {
            free.push(Free { parameter, freedom: Freedom::Near { nominal: value, most: AMOUNT_KNOWN * value.abs() } });
        }
    }
    free
}

/// What is of the oil and of the day, not of the drive: it may be different at another time, however well it was known.
const OF_THE_DAY: [Parameter; 4] =
    [Parameter::BulkModulus, Parameter::ViscousFriction, Parameter::TankPressure, Parameter::LoadForce];

/// So many times as well as a data sheet says a value is known once it was fitted. Where a fit leaves a combination of values open, it is the same at
/// another time.
const KNOWN_TIMES: f64 = 5.0;

/// A base parameter as it is known once it was fitted.
fn once_fitted(free: Free) -> Free {
    let freedom = match free.freedom {
        _ if OF_THE_DAY.contains(&free.parameter) => free.freedom,
        Freedom::Around { nominal, sigma } => Freedom::Around { nominal, sigma: sigma / KNOWN_TIMES },
        Freedom::Roughly { least, nominal, spread } => {
            Freedom::Roughly { least, nominal, spread: spread / KNOWN_TIMES }
        }
        other => other,
    };
    Free { freedom, ..free }
}

impl Diagnosis {
    /// The machine file after the diagnosis: refitted, with the accepted effects. What has become a finding is no tolerance any more: another fit would
    /// hold it within.
    #[must_use]
    pub fn machine_file(&self, before: &MachineFile) -> MachineFile {
        let mut after = before.clone();
        after.machine = self.machine_after;
        after.start_at(self.level_at_rest);
        let of_effects =
            || self.findings.iter().flat_map(|finding| &finding.parameters).map(|estimate| estimate.parameter);
        after.given.extend(self.refitted.iter().map(|estimate| estimate.parameter).chain(of_effects()));
        for parameter in of_effects().flat_map(|parameter| [parameter, covered_by(parameter)]) {
            after.tolerance.remove(&parameter);
        }
        after.effects.extend(self.unnamed.as_ref().map(|_| "unnamed"));
        after.effects.extend(self.findings.iter().map(|finding| finding.effect.name));
        after
    }
}
