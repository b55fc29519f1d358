//! What stands beside a finding: the position's evidence for jumps, the test against its rival, correlated parameters; and a table without a name.

use diagnosis::Finding;
use diagnosis::correction_table::Unnamed;
use diagnosis::selection::JumpsFound;
use experiment::discriminate::{Distance, Separation};
use identification::fit::Correlation;
use recording::display_unit::{in_si, significant};
use simulation::signal::noise::extent;

/// The jumps of a spool that no sensor measures.
#[must_use]
pub fn jumps(told: JumpsFound) -> String {
    let kept = significant(100.0 * told.kept_alone, 2);
    let whose = if told.is_alone() { "as one does" } else { "more than one does, so a hysteresis stands beside it" };
    format!(
        "the spool is not measured, but the position's residual repeats every {} % of spool travel, as jumps of this length leave it (log-likelihood {} more than without jumps); a stiction alone would keep {kept} % of its band, {whose}",
        significant(100.0 * told.jump_spacing.length, 2),
        significant(told.jump_spacing.evidence, 2)
    )
}

/// An alternative that is at least as probable is told with a finding: once in twenty times it is the true one.
const TOLD_FROM: f64 = 0.05;

/// What is claimed: an effect, or where the recordings do not tell it from others, all of them, by the name of their family where they have one. What
/// extends the same plain effect is no other: the plainer one is preferred.
#[must_use]
pub fn claimed(finding: &Finding) -> String {
    let others = finding
        .alternatives
        .iter()
        .filter(|(other, probability)| *probability >= TOLD_FROM && other.plainest() != finding.effect.plainest());
    let names: Vec<&str> = std::iter::once(finding.effect.name).chain(others.map(|(other, _)| other.name)).collect();
    if names.len() == 1 {
        return names.concat();
    }
    let which = match names.len() {
        2 => "which of the two",
        3 => "which of the three",
        _ => "which of these",
    };
    let either = names.join(" or ");
    match family(&names) {
        Some(family) => format!("{family} ({either}; {which} cannot be told)"),
        None => format!("{either} ({which} cannot be told)"),
    }
}

/// The word for a family of effects that all of these belong to.
fn family(names: &[&str]) -> Option<&'static str> {
    const FAMILIES: [(&str, &[&str]); 2] = [
        ("a leak", &["internal-leakage", "external-leakage", "valve-leakage", "pump-slip"]),
        (
            "dry friction",
            &[
                "coulomb-friction",
                "stribeck-friction",
                "presliding",
                "friction-asymmetry",
                "position-dependent-friction",
                "pressure-dependent-friction",
            ],
        ),
    ];
    FAMILIES.iter().find(|(_, members)| names.iter().all(|name| members.contains(name))).map(|(family, _)| *family)
}

/// A correction table for what no effect accounts for.
#[must_use]
pub fn correction_table(table: &Unnamed) -> String {
    let states: Vec<_> = table.over.iter().map(|axis| axis.state.name()).collect();
    let (low, high) = extent(table.values.iter().map(|estimate| estimate.value));
    let unit = if table.quantity.unit() == "1" { String::new() } else { format!(" {}", table.quantity.unit()) };
    format!(
        "without a name: a table of {} over {}, from {} to {}{unit}, follows {} of {} held-out recordings better",
        table.quantity.name(),
        states.join(" and "),
        in_si(low, 4),
        in_si(high, 4),
        table.confirmation.improved,
        table.confirmation.recordings
    )
}

/// The test that distinguishes an effect from its rival, without their names.
#[must_use]
pub fn advice(separation: &Separation) -> String {
    let apart = |best: &Distance| {
        let times = significant(best.over_noise, 2);
        format!("{}: the two models differ by {times} times the noise in {}", best.test, best.signal)
    };
    match (separation.tests.first(), &separation.sensor) {
        (Some(best), _) if separation.is_separated() => apart(best),
        (_, Some((sensor, best))) if best.tells() => format!("{}, with {sensor} recorded too", apart(best)),
        (Some(best), _) => format!("no standard test distinguishes them at this noise; best: {}", apart(best)),
        (None, _) => "no standard test runs on this drive".to_owned(),
    }
}

/// Two correlated parameters, with their coefficient.
#[must_use]
pub fn correlation(pair: &Correlation) -> String {
    let (one, other) = (pair.one.description().key, pair.other.description().key);
    let (size, sign) = (pair.coefficient.abs(), if pair.coefficient < 0.0 { "−" } else { "" });
    // Near 1, the difference from 1 matters.
    let decimals = if size < 0.9995 { 3 } else { 5 };
    format!("{one} and {other}: {sign}{size:.decimals$}")
}

#[cfg(test)]
mod tests {
    use diagnosis::catalogue::{CATALOGUE, Hypothesis};
    use diagnosis::selection::JumpSpacing;
    use model_core::machine::Parameter;
    use recording::Signal;

    use super::*;

    #[test]
    fn the_test_that_distinguishes_two_effects_is_advised_with_the_sensor_that_it_takes() {
        let distance = |test, over_noise| Distance {
            test,
            how: String::new(),
            duration_s: 10.0,
            signal: Signal::PressureA,
            over_noise,
            per_20_s: over_noise,
        };
        let told = |tests: &[Distance], sensor| {
            let (effect, rival) = ("internal-leakage", "external-leakage");
            advice(&Separation { effect, rival, confidence: 0.1, tests: tests.to_vec(), sensor })
        };
        assert_eq!(
            told(&[distance("ramps", 40.0)], None),
            "ramps: the two models differ by 40 times the noise in pressure_a"
        );
        let sensor = Some((Signal::PressureB, distance("hold", 40.0)));
        assert!(told(&[distance("ramps", 0.0)], sensor).ends_with(", with pressure_b recorded too"));
        assert!(
            told(&[distance("ramps", 0.0)], None)
                .starts_with("no standard test distinguishes them at this noise; best: ramps")
        );
        assert_eq!(told(&[], None), "no standard test runs on this drive");
    }

    #[test]
    fn what_the_position_says_is_told_with_what_it_leaves_open() {
        let told =
            |kept_alone| jumps(JumpsFound { jump_spacing: JumpSpacing { length: 0.0075, evidence: 16.1 }, kept_alone });
        assert!(
            told(0.2).contains("every 0.75 % of spool travel")
                && told(0.2).ends_with("keep 20 % of its band, as one does")
        );
        assert!(told(0.55).ends_with("keep 55 % of its band, more than one does, so a hysteresis stands beside it"));
    }

    #[test]
    fn a_correlation_near_one_shows_how_near() {
        let pair =
            |coefficient| Correlation { one: Parameter::ValveGain, other: Parameter::FlowCoefficient, coefficient };
        assert_eq!(correlation(&pair(-0.99)), "valve.gain_per_v and valve.flow_coefficient: −0.990");
        assert!(correlation(&pair(0.999_87)).ends_with(": 0.99987"));
    }

    fn effect(name: &str) -> &'static Hypothesis {
        CATALOGUE.iter().find(|effect| effect.name == name).unwrap()
    }

    fn found(name: &str, others: &[(&str, f64)]) -> String {
        let alternatives = others.iter().map(|(other, probability)| (effect(other), *probability)).collect();
        let (confidence, parameters) = (0.5, Vec::new());
        claimed(&Finding {
            effect: effect(name),
            confidence,
            parameters,
            before: Vec::new(),
            alternatives,
            jumps: None,
        })
    }

    #[test]
    fn what_cannot_be_told_apart_is_claimed_together() {
        assert_eq!(found("internal-leakage", &[("external-leakage", 0.01)]), "internal-leakage");
        assert_eq!(
            found("internal-leakage", &[("external-leakage", 0.3), ("valve-leakage", 0.2)]),
            "a leak (internal-leakage or external-leakage or valve-leakage; which of the three cannot be told)"
        );
        assert_eq!(found("coulomb-friction", &[("stribeck-friction", 0.3)]), "coulomb-friction");
        assert_eq!(
            found("sensor-offset", &[("dead-zone-asymmetry", 0.4)]),
            "sensor-offset or dead-zone-asymmetry (which of the two cannot be told)"
        );
        assert_eq!(
            found("end-stop", &[("valve-leakage", 0.2), ("null-drift", 0.2), ("flow-force", 0.2)]),
            "end-stop or valve-leakage or null-drift or flow-force (which of these cannot be told)"
        );
    }
}
