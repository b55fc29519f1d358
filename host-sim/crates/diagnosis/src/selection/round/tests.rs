use identification::fit::{Free, Freedom};
use model_core::machine::Parameter as P;

use super::*;
use crate::selection::decision_rule::VALVE_FIRST_FROM;
use crate::selection::misfit_ranking::ranked_by_misfit;
use crate::selection::search::tests::{added, with_press};

/// A refitted candidate model of two effects and its base, on a press whose machine file lacks the `unknown` parameters.
fn with_two(unknown: &[(P, f64)], effects: [&str; 2], seen: impl FnOnce(&Question<'_>, &Candidate, Candidate)) {
    with_press(unknown, |question| {
        let base = Candidate::rough(question, None).unwrap();
        let first = added(question, &base, effects[0], None);
        let both = added(question, &first, effects[1], None);
        seen(question, &base, both);
    });
}

#[test]
fn what_the_other_effect_makes_superfluous_goes_unless_it_was_found_valve_first() {
    let unknown = [(P::CoulombFriction, 300.0)];
    with_two(&unknown, ["internal-leakage", "coulomb-friction"], |question, base, both| {
        let left = |stay: &[&str]| reduced(question, base, both.clone(), stay).unwrap().unwrap().names();
        assert_eq!(left(&[]), ["coulomb-friction"]);
        assert_eq!(left(&["internal-leakage"]), ["coulomb-friction", "internal-leakage"]);
    });
}

#[test]
fn two_effects_that_are_there_stay() {
    let unknown = [(P::CoulombFriction, 300.0), (P::ReturnResistance, 1.5e13)];
    with_two(&unknown, ["tank-back-pressure", "coulomb-friction"], |question, base, both| {
        let left = reduced(question, base, both, &[]).unwrap().unwrap();
        assert_eq!(left.names(), ["coulomb-friction", "tank-back-pressure"]);
    });
}

#[test]
fn of_effects_that_follow_little_of_what_is_missing_nothing_is_left() {
    with_two(&[(P::ReturnResistance, 1.5e13)], ["internal-leakage", "coulomb-friction"], |question, base, both| {
        assert!(
            both.is_plausible(question) && misfit_above_noise(&both.residuals) < misfit_above_noise(&base.residuals)
        );
        assert!(reduced(question, base, both, &[]).unwrap().is_none());
    });
}

/// Metering edges of different sizes, refitted beside friction, where the machine file lacks the friction and these sizes.
fn of_all_sizes(sizes: &[(P, f64)], seen: impl FnOnce(&Question<'_>, Candidate)) {
    let unknown = [sizes, &[(P::CoulombFriction, 300.0)]].concat();
    with_press(&unknown, |question| {
        let base = Candidate::rough(question, None).unwrap();
        let edges = added(question, &base, "metering-asymmetry", Some(P::MeteringRatio));
        let both = added(question, &edges, "coulomb-friction", None);
        let effect = both.effects[0].effect;
        seen(question, both.instead(question, 0, Chosen { effect, form: effect.refined[0] }, &[]).unwrap());
    });
}

#[test]
fn a_refined_form_goes_back_to_the_plain_one_where_that_does_as_well_beside_a_later_effect() {
    of_all_sizes(&[(P::MeteringRatio, -0.3)], |question, finer| {
        let plain = unrefined(question, finer.clone()).unwrap();
        assert_eq!(plain.effect_parameters() + 2, finer.effect_parameters());
        assert_eq!(plain.names(), finer.names());
    });
    let all = [(P::MeteringRatio, -0.3), (P::MeteringPorts, 0.1), (P::MeteringDirections, -0.1)];
    of_all_sizes(&all, |question, finer| {
        assert_eq!(unrefined(question, finer.clone()).unwrap().effect_parameters(), finer.effect_parameters());
    });
}

#[test]
fn a_set_enters_its_round_unless_a_better_fit_of_its_effects_is_there() {
    with_two(&[(P::CoulombFriction, 300.0)], ["internal-leakage", "coulomb-friction"], |question, base, both| {
        let [(candidate, net)] = &ranked(question, base, vec![both.without(question, 0).unwrap()])[..] else {
            panic!()
        };
        for (known, left) in [(net - 1.0, *net), (net + 1.0, net + 1.0)] {
            let mut rounds = vec![vec![trial(candidate, known)]];
            enter(question, base, &mut rounds, candidate);
            let nets: Vec<f64> = rounds[0].iter().map(|trial| trial.net).collect();
            assert_eq!(nets, [left]);
        }
        // A candidate model that gained little when its round was ranked is not likely now, unless its gain `now` says otherwise.
        let round = [trial(&both.without(question, 1).unwrap(), 50.0), trial(candidate, 10.0)];
        assert!(!is_likeliest(candidate, None, &round));
        assert!(!is_likeliest(candidate, Some(40.0), &round));
        assert!(is_likeliest(candidate, Some(49.0), &round));
    });
}

/// The plainer effect that was not accepted may still be the true one: what extends it and is far less likely is not taken in its place.
#[test]
fn an_extension_is_not_likely_beside_a_plainer_effect_that_is_far_likelier() {
    with_press(&[(P::CoulombFriction, 300.0)], |question| {
        let base = Candidate::rough(question, None).unwrap();
        let [plain, extension] =
            ["coulomb-friction", "position-dependent-friction"].map(|name| added(question, &base, name, None));
        let is_likely = |of: &Candidate, plain_net: f64, extension_net: f64| {
            is_likeliest(of, None, &[trial(&plain, plain_net), trial(&extension, extension_net)])
        };
        assert!(is_likely(&extension, 54.0, 50.0) && !is_likely(&extension, 58.0, 50.0));
        assert!(is_likely(&plain, 50.0, 58.0), "the extension counts as the same effect");
    });
}

/// Candidate models of one effect each that lack a nonlinear flow gain, where the flow coefficient and the mass are free.
fn beside_a_curved_gain(effects: [&str; 2], seen: impl FnOnce(&Question<'_>, &Candidate, Vec<(Candidate, f64)>)) {
    with_press(&[(P::FlowGainLinear, 0.8), (P::CoulombFriction, 300.0)], |question| {
        let free = [P::FlowCoefficient, P::MovingMass].map(|parameter| {
            let nominal = question.scene.machine.get(parameter);
            Free { parameter, freedom: Freedom::Around { nominal, sigma: 0.05 * nominal } }
        });
        let question = &Question { base_parameters: &free, ..*question };
        let base = Candidate::rough(question, None).unwrap();
        let candidates = effects.map(|name| added(question, &base, name, None));
        seen(question, &base, ranked(question, &base, candidates.to_vec()));
    });
}

#[test]
fn candidate_models_far_off_are_refitted_with_inflated_noise_and_pulled_less() {
    beside_a_curved_gain(["coulomb-friction", "internal-leakage"], |question, base, candidates| {
        let before: Vec<Candidate> = candidates.iter().map(|(candidate, _)| candidate.clone()).collect();
        let after = ranked_by_misfit(question, base, candidates, None).unwrap();
        assert_eq!(after.len(), before.len());
        for (candidate, _) in &after {
            let was = before.iter().find(|one| one.names() == candidate.names()).unwrap();
            assert!(was.worst_over_noise(question) > VALVE_FIRST_FROM, "{:?}", was.names());
            assert!(
                candidate.pulled(question) < 0.5 * was.pulled(question),
                "{:?} {}",
                candidate.names(),
                candidate.pulled(question)
            );
        }
    });
}

#[test]
fn a_candidate_model_at_its_noise_keeps_its_refit() {
    with_press(&[(P::CoulombFriction, 300.0)], |question| {
        let base = Candidate::rough(question, None).unwrap();
        let candidates = ["coulomb-friction", "internal-leakage"].map(|name| added(question, &base, name, None));
        let candidates = ranked(question, &base, candidates.to_vec());
        let told = |candidates: &[(Candidate, f64)]| -> Vec<_> {
            candidates.iter().map(|(candidate, net)| (candidate.names(), *net, candidate.fit.machine)).collect()
        };
        let before = told(&candidates);
        assert_eq!(told(&ranked_by_misfit(question, &base, candidates, None).unwrap()), before);
    });
}
