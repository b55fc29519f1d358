//! What has changed since a machine file was written, or since recordings were made: the effects that a file holds may have become more or less.

use std::collections::BTreeSet;

use identification::fit::{Free, Freedom};
use machine_file::MachineFile;
use model_core::machine::{Machine, Parameter};

use crate::catalogue::{CATALOGUE, Hypothesis, covered_by};
use crate::diagnose::base_parameters;
use crate::outcome::Diagnosis;

/// The effects that a machine file holds, beyond what is a tolerance in it.
pub(crate) fn held(file: &MachineFile) -> Vec<&'static Hypothesis> {
    let base_parameters = base_parameters(file);
    CATALOGUE.iter().copied().filter(|effect| effect.is_on(&file.machine, &base_parameters)).collect()
}

/// Whether an effect may be found beside those that are on: none of them, but where it may have changed. What has become more of it is not given to
/// another effect of its kind.
pub(crate) fn may_be_found(effect: &Hypothesis, on: &[&Hypothesis], changeable: &[&Hypothesis]) -> bool {
    let is_it = |other: &&Hypothesis| other.name == effect.name;
    let is_of_its_kind = |other: &&Hypothesis| other.plainest() == effect.plainest();
    if on.iter().any(is_it) { changeable.iter().any(is_it) } else { !changeable.iter().any(is_of_its_kind) }
}

/// An amount of an effect that a machine file holds is known to this share of itself: what differs by less, from one recording of a drive to another or by
/// what else a fit leaves open, has not changed. Source: half of what a strength may be off by, chosen.
const AMOUNT_KNOWN: f64 = 0.1;

/// The base parameters with the amounts that may have changed in the place of their tolerances.
pub(crate) fn with_changes(
    mut free: Vec<Free>,
    machine: &Machine<f64>,
    changeable: &[&'static Hypothesis],
) -> Vec<Free> {
    let amounts = changeable.iter().flat_map(|effect| effect.effect_parameters()).filter(|own| own.is_amount());
    for amount in amounts {
        let (parameter, value) = (amount.parameter, machine.get(amount.parameter));
        if value == 0.0 {
            continue;
        }
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

/// From one time to another a value of a drive is the same within this share of itself. Source: chosen; a valve's zero and gain drift by less than a
/// per cent between services.
const SAME_WITHIN: f64 = 0.01;

impl Diagnosis {
    /// The machine file after the diagnosis: refitted, with the accepted effects. What has become a finding is no tolerance any more: another fit would
    /// hold it within.
    #[must_use]
    pub fn machine_file(&self, before: &MachineFile) -> MachineFile {
        let mut after = before.clone();
        after.machine = self.machine_after;
        after.start_at(self.level_at_rest);
        let of_effects = || self.findings.iter().flat_map(|finding| &finding.parameters);
        let found: BTreeSet<Parameter> = of_effects().map(|estimate| estimate.parameter).collect();
        after.tolerance.retain(|parameter, _| !found.contains(parameter));
        after.given.extend(self.refitted.iter().chain(of_effects()).map(|estimate| estimate.parameter));
        after.effects.extend(self.unnamed.as_ref().map(|_| "unnamed"));
        after.effects.extend(self.findings.iter().map(|finding| finding.effect.name));
        after
    }

    /// The same as what is known beforehand at another time: values that these recordings determine are known as well as that, and not only as well as
    /// a data sheet says.
    #[must_use]
    pub fn as_known_later(&self, before: &MachineFile) -> MachineFile {
        let mut after = self.machine_file(before);
        after.has_sigma_table = true;
        for free in base_parameters(before).iter().filter(|free| free.tolerance().is_none()) {
            let sheet = free.width(free.nominal());
            let estimate = self.refitted.iter().find(|estimate| estimate.parameter == free.parameter);
            let determined = estimate.filter(|one| one.std.is_finite() && !one.at_bound);
            let known = determined.filter(|_| !OF_THE_DAY.contains(&free.parameter));
            let sigma = known.map_or(sheet, |one| one.std.hypot(SAME_WITHIN * one.value).min(sheet));
            after.sigma.insert(free.parameter, sigma);
        }
        after
    }
}
