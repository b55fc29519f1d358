//! What has become of an effect that the machine file holds, and what is said where none has changed.

use diagnosis::agreement::sensor_of;
use diagnosis::catalogue::{Hypothesis, short_name};
use diagnosis::{Diagnosis, Finding, OtherOil, Verdict};
use identification::fit::Estimate;
use model_core::machine::{Machine, Parameter};
use recording::display_unit::{in_si, significant};

use crate::size::{Size, size};

/// What is found, for a headline: what has changed and how, where that was asked; else what is claimed.
#[must_use]
pub fn found(diagnosis: &Diagnosis, finding: &Finding) -> String {
    match change(&diagnosis.machine_after, finding) {
        Some(change) => change,
        None if diagnosis.since.is_some() => format!("{} is new", super::claimed(finding)),
        None => super::claimed(finding),
    }
}

/// How an effect has changed, by the amount that has changed most surely: `internal-leakage rose from 1.97e-12 to 3.94e-12 m3/s/Pa (0.83 l/min → 1.7
/// l/min …)`. Rising and falling are of the magnitude. `None` of an effect that was not there before.
#[must_use]
pub fn change(machine: &Machine<f64>, finding: &Finding) -> Option<String> {
    let (estimate, before) = most_changed(finding)?;
    let value = estimate.value;
    let verb = if value * before < 0.0 {
        "has turned round,"
    } else {
        match (value.abs() > before.abs(), before < 0.0) {
            (true, false) => "rose",
            (false, false) => "fell",
            (true, true) => "became larger,",
            (false, true) => "became smaller,",
        }
    };
    let whose = whose(finding.effect, estimate.parameter);
    let unit = estimate.parameter.description().unit;
    let sizes = size(machine, estimate.parameter, before).zip(size(machine, estimate.parameter, value));
    let sizes = sizes.map_or_else(String::new, |(then, now)| {
        let Size { amount, of, .. } = now;
        // What the sign stands for is told of both where it has turned round.
        let of_then = if value * before < 0.0 { then.of } else { String::new() };
        format!(" ({}{of_then} → {amount}{of})", then.amount)
    });
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    Some(format!("{whose} {verb} from {} to {}{unit}{sizes}", in_si(before, 3), in_si(value, 3)))
}

/// An effect, with the sensor or the name of the amount where it has several.
#[must_use]
pub fn whose(effect: &Hypothesis, parameter: Parameter) -> String {
    let has_others = effect.effect_parameters().any(|own| own.is_amount() && own.parameter != parameter);
    match sensor_of(parameter) {
        _ if !has_others => effect.name.to_owned(),
        Some(signal) => format!("{} of {signal}", effect.name),
        None => format!("{} of {}", short_name(parameter), effect.name),
    }
}

/// What is seen of an effect that acts otherwise than then.
pub const TRADED: &str =
    "one of its parameters fell and another rose, which the same drive at other flows or speeds does too";

/// The amount of a changed effect that has changed most surely, by its standard deviation, with what it was. Amounts without a standard deviation come after
/// those that have one, by their ratio.
#[must_use]
pub fn most_changed(finding: &Finding) -> Option<(&Estimate, f64)> {
    let amounts = finding.parameters.iter().filter_map(|estimate| {
        let before = finding.before.iter().find(|(parameter, _)| *parameter == estimate.parameter)?.1;
        Some((estimate, before))
    });
    let by = |(estimate, before): &(&Estimate, f64)| {
        let ratio = estimate.value / before;
        let ratio = if ratio > 0.0 { libm::log(ratio).abs() } else { f64::INFINITY };
        let deviations = (estimate.value - before).abs() / estimate.std;
        (if deviations.is_nan() { -1.0 } else { deviations }, ratio)
    };
    amounts.max_by(|one, other| {
        let (one, other) = (by(one), by(other));
        one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1))
    })
}

/// That nothing has changed, as far as these recordings tell it: `follows` is how the model of then follows them.
#[must_use]
pub fn unchanged(diagnosis: &Diagnosis, follows: &str) -> String {
    let far = diagnosis.far_values();
    let with_oil = diagnosis.other_oil.filter(OtherOil::is_told).map_or_else(String::new, |oil| {
        let by = significant((oil.now_c - oil.then_c).abs(), 2);
        format!(" with oil {by} K {},", if oil.now_c > oil.then_c { "warmer" } else { "colder" })
    });
    let model = format!("the model of then, refitted,{with_oil} {follows}");
    let untested = names(&diagnosis.untested);
    let doubtful = names(&diagnosis.doubtful_changes());
    if !doubtful.is_empty() {
        return format!(
            "it stays open whether {doubtful} has changed: the training recordings say so, and the held-out ones do not confirm it; {model}"
        );
    }
    if !diagnosis.otherwise.is_empty() {
        let otherwise = names(&diagnosis.otherwise);
        return format!("it stays open whether {otherwise} has changed: {TRADED}; {model}");
    }
    if let Some(first) = far.first() {
        let others = match far.len() {
            1 => String::new(),
            2 => ", and with another value far from then's".to_owned(),
            many => format!(", and with {} other values far from then's", many - 1),
        };
        let moved = super::moved(first);
        return format!("no effect is found to have changed, but a value has: {model}, only with {moved}{others}");
    }
    if untested.is_empty() {
        return format!("unchanged: {model}");
    }
    if diagnosis.since.as_ref().is_some_and(|held| held.len() == diagnosis.untested.len()) {
        return format!("it stays open whether {untested} has changed: these recordings cannot show it; {model}");
    }
    format!("unchanged as far as these recordings show: {model}; whether {untested} has changed they cannot show")
}

/// What the recordings of then leave doubtful, for the end of a headline.
#[must_use]
pub fn doubt_of_then(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.then {
        Some(Verdict::Unexplained) => {
            "; but then is unexplained: the model does not follow the recordings of then either, and what is missing then may be what is told of now"
        }
        _ => "",
    }
}

/// What is different with the oil since then.
#[must_use]
pub fn other_oil(oil: &OtherOil) -> String {
    format!(
        "{} °C in these recordings, {} °C then: {} % of the viscosity of then",
        significant(oil.now_c, 3),
        significant(oil.then_c, 3),
        significant(100.0 * oil.viscosity, 2)
    )
}

/// Effects in a list.
fn names(effects: &[&Hypothesis]) -> String {
    effects.iter().map(|effect| effect.name).collect::<Vec<_>>().join(" or ")
}

#[cfg(test)]
mod tests {
    use diagnosis::catalogue::CATALOGUE;
    use test_press::press;

    use super::*;

    /// What is said of an effect whose amounts were, are and are known to this.
    fn said(name: &str, amounts: &[(Parameter, f64, f64, f64)]) -> String {
        let estimate = |&(parameter, before, value, std): &(Parameter, f64, f64, f64)| Estimate {
            parameter,
            before,
            value,
            std,
            at_bound: false,
        };
        let finding = Finding {
            effect: CATALOGUE.iter().find(|effect| effect.name == name).unwrap(),
            confidence: 0.9,
            parameters: amounts.iter().map(estimate).collect(),
            before: amounts.iter().map(|&(parameter, before, ..)| (parameter, before)).collect(),
            alternatives: Vec::new(),
            jumps: None,
        };
        change(&press(&[]), &finding).unwrap()
    }

    #[test]
    fn of_several_amounts_the_one_is_told_that_has_changed_most_surely() {
        use Parameter as P;
        // A tenth part of nearly nothing is known to nothing.
        let told = said(
            "external-leakage",
            &[(P::ExternalLeakageA, 1e-12, 3e-12, 2e-12), (P::ExternalLeakageB, 2e-12, 3e-12, 1e-14)],
        );
        assert!(told.contains("_b_") && told.contains(" of external-leakage rose from 2.00e-12 to 3.00e-12"), "{told}");
        let told =
            said("spool-stiction", &[(P::StictionBand, 0.02, 0.03, f64::NAN), (P::StictionKept, 0.2, 0.19, f64::NAN)]);
        assert!(told.starts_with("band of spool-stiction rose"), "{told}");
    }

    #[test]
    fn what_is_negative_becomes_larger_or_smaller_by_its_magnitude_and_names_its_sensor() {
        use Parameter as P;
        let of = |before, value| said("sensor-offset", &[(P::PressureBOffset, before, value, 1e3)]);
        assert!(of(-2e5, -4e5).starts_with("sensor-offset of pressure_b became larger, from -2.00e5 to -4.00e5 Pa"));
        assert!(of(-4e5, -2e5).starts_with("sensor-offset of pressure_b became smaller, from"));
        assert!(of(2e5, 4e5).starts_with("sensor-offset of pressure_b rose from"));
        assert!(of(-2e5, 2e5).starts_with("sensor-offset of pressure_b has turned round, from"));
    }
}
