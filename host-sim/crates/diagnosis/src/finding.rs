//! An accepted effect, how sure it is, and what else it may be.

use identification::fit::Estimate;
use model_core::machine::Parameter;

use crate::catalogue::{Hypothesis, Scene};
use crate::selection::decision_rule::{ALTERNATIVE_FROM, MOST_CONFIDENT};
use crate::selection::{Chosen, JumpsFound, Selection, Trial};

/// One accepted effect.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The effect.
    pub effect: &'static Hypothesis,
    /// Probability among the candidate models of its size that were refitted, and the base model.
    pub confidence: f64,
    /// Its fitted parameters.
    pub parameters: Vec<Estimate>,
    /// Of an effect that the machine file holds: how much there was of it.
    pub before: Vec<(Parameter, f64)>,
    /// What may stand in its place beside the other accepted effects, with the probability of those candidate models.
    pub alternatives: Vec<(&'static Hypothesis, f64)>,
    /// The jumps that the position shows, for a stiction that no free run can determine.
    pub jumps: Option<JumpsFound>,
}

/// A finding with its probability among the candidate models that were refitted in the same round, without those that hold a vetoed
/// effect.
pub(crate) fn finding(
    chosen: &Chosen,
    scene: &Scene<'_>,
    selection: &Selection,
    estimates: &[Estimate],
    vetoed: &[&'static Hypothesis],
) -> Finding {
    let all = &selection.chosen.effects;
    let round = selection.rounds.get(all.len() - 1).into_iter().flatten();
    let candidates: Vec<&Trial> = round.filter(|candidate| !candidate.has_any(vetoed)).collect();
    let Odds { confidence, alternatives } = odds(chosen.effect, all, &candidates);
    let parameters = chosen
        .form
        .iter()
        .filter_map(|effect_parameter| {
            estimates.iter().find(|estimate| estimate.parameter == effect_parameter.parameter).copied()
        })
        .collect();
    let before = chosen.form.iter().map(|own| (own.parameter, scene.before(own))).filter(|(_, before)| *before != 0.0);
    Finding {
        effect: chosen.effect,
        confidence: confidence.min(MOST_CONFIDENT),
        before: before.collect(),
        parameters,
        alternatives,
        jumps: selection.jumps.as_ref().filter(|_| chosen.has(Parameter::StictionBand)).map(|jumps| jumps.found),
    }
}

/// How probable one of the chosen effects is, and each that may stand in its place.
struct Odds {
    confidence: f64,
    alternatives: Vec<(&'static Hypothesis, f64)>,
}

/// The odds by what candidate models gain. One that differs in another effect as well says nothing about this one's alternatives.
fn odds(effect: &'static Hypothesis, chosen: &[Chosen], candidates: &[&Trial]) -> Odds {
    let largest = candidates.iter().map(|candidate| candidate.net).fold(0.0, f64::max);
    let weight = |candidate: &Trial| libm::exp(candidate.net - largest);
    // No effect at all stands against them with a net gain of 0.
    let total: f64 = candidates.iter().map(|candidate| weight(candidate)).sum::<f64>() + libm::exp(-largest);
    let with = candidates.iter().filter(|candidate| candidate.has_any(&[effect]));
    let confidence = with.map(|candidate| weight(candidate)).sum::<f64>() / total;
    let mut alternatives: Vec<(&'static Hypothesis, f64)> = Vec::new();
    for candidate in candidates {
        let Some(other) = candidate.instead_of(effect, chosen) else { continue };
        let probability = weight(candidate) / total;
        match alternatives.iter_mut().find(|(known, _)| known.name == other.name) {
            Some((_, sum)) => *sum += probability,
            None => alternatives.push((other, probability)),
        }
    }
    alternatives.retain(|(_, probability)| *probability > ALTERNATIVE_FROM);
    alternatives.sort_by(|a, b| b.1.total_cmp(&a.1));
    Odds { confidence, alternatives }
}

#[cfg(test)]
mod tests {
    use test_press::press;

    use super::*;
    use crate::catalogue::CATALOGUE;

    fn effect(name: &str) -> &'static Hypothesis {
        CATALOGUE.iter().find(|effect| effect.name == name).unwrap()
    }

    fn set(names: &[&str], net: f64) -> Trial {
        let effects: Vec<_> = names.iter().map(|name| effect(name)).collect();
        Trial { effect: effects[effects.len() - 1], effects, net, machine: press(&[]) }
    }

    fn alternatives(of: &str, chosen: &[&str], candidates: &[Trial]) -> Vec<&'static str> {
        let chosen: Vec<Chosen> =
            chosen.iter().map(|name| Chosen { effect: effect(name), form: effect(name).forms[0] }).collect();
        let candidates: Vec<&Trial> = candidates.iter().collect();
        odds(effect(of), &chosen, &candidates).alternatives.iter().map(|(effect, _)| effect.name).collect()
    }

    #[test]
    fn an_alternative_belongs_to_the_effect_in_whose_place_it_may_stand() {
        let chosen = ["valve-hysteresis", "internal-leakage"];
        let candidates = [
            set(&chosen, 100.0),
            set(&["spool-stiction", "internal-leakage"], 98.0),
            set(&["valve-hysteresis", "external-leakage"], 99.0),
            set(&["internal-leakage", "null-drift"], 97.0),
            // Both are others: in whose place, nobody can say.
            set(&["spool-stiction", "external-leakage"], 99.5),
        ];
        assert_eq!(alternatives("valve-hysteresis", &chosen, &candidates), ["spool-stiction", "null-drift"]);
        assert_eq!(alternatives("internal-leakage", &chosen, &candidates), ["external-leakage"]);
    }

    #[test]
    fn of_a_single_effect_every_other_that_is_likely_is_an_alternative() {
        let candidates =
            [set(&["coulomb-friction"], 50.0), set(&["stribeck-friction"], 49.0), set(&["end-stop"], 20.0)];
        assert_eq!(alternatives("coulomb-friction", &["coulomb-friction"], &candidates), ["stribeck-friction"]);
    }

    #[test]
    fn probabilities_of_an_effect_and_what_stands_in_its_place_make_no_more_than_one() {
        let chosen = [Chosen { effect: effect("end-stop"), form: effect("end-stop").forms[0] }];
        let candidates = [set(&["end-stop"], 3.0), set(&["coulomb-friction"], 2.0)];
        let candidates: Vec<&Trial> = candidates.iter().collect();
        let Odds { confidence, alternatives } = odds(effect("end-stop"), &chosen, &candidates);
        // e³ and e² against 1.
        assert!(
            (confidence - 0.705).abs() < 1e-3 && (alternatives[0].1 - 0.259).abs() < 1e-3,
            "{confidence} {alternatives:?}"
        );
    }
}
