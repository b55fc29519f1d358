use identification::experiment::Prepared;
use machine_file::LoadSource;
use model_core::machine::Parameter as P;
use recording::Signal;
use test_press::{press, recorded};

use super::*;
use crate::catalogue::CATALOGUE;
use crate::test_scene::scene;

/// Hands to `seen` a press with recorded pressures and position, which has parameters that its machine file lacks.
pub(crate) fn with_press(unknown: &[(P, f64)], seen: impl FnOnce(&Question<'_>)) {
    let nominal = press(&[(P::ViscousFriction, 2e4)]);
    let truth = nominal.with(unknown);
    let judged = [Signal::PressureA, Signal::PressureB, Signal::Position];
    let recording = recorded(&truth, &[(Signal::PressureA, 1e4), (Signal::PressureB, 1e4), (Signal::Position, 1e-5)]);
    let case = Prepared::new(&recording, &nominal, LoadSource::Constant, None).unwrap();
    let (training, scene) = ([&case], scene(&nominal, &judged));
    seen(&Question { scene: &scene, base_parameters: &[], hypotheses: CATALOGUE, training: &training });
}

/// A candidate model with one more effect, in the form that begins with a given effect parameter, refitted.
pub(crate) fn added(question: &Question<'_>, candidate: &Candidate, name: &str, first: Option<P>) -> Candidate {
    let effect = *CATALOGUE.iter().find(|effect| effect.name == name).unwrap();
    let reference = Reference::new(question, candidate).unwrap();
    let leads = reference.leads(&[effect]).unwrap();
    let is_asked = |lead: &&Lead| first.is_none_or(|first| lead.form[0].parameter == first);
    let lead = leads.iter().find(is_asked).unwrap();
    reference.with(lead).unwrap().finished(question).unwrap()
}

/// The plainer effect was found before the other missing effect: its extension is then also looked for beside that one, and found.
#[test]
fn an_extension_is_found_beside_what_was_added_later() {
    let unknown = [
        (P::StribeckForce, 300.0),
        (P::StribeckExcess, 300.0),
        (P::StribeckVelocity, 0.01),
        (P::ReturnResistance, 1.5e13),
    ];
    with_press(&unknown, |question| {
        let with = |candidate: &Candidate, name: &str| added(question, candidate, name, None);
        let base = Candidate::rough(question, None).unwrap();
        let friction = with(&base, "coulomb-friction");
        let both = with(&friction, "tank-back-pressure");

        let found = enriched(question, &both, &|_| ()).unwrap();
        let names: Vec<_> = found.iter().map(Candidate::names).collect();
        assert!(
            found
                .iter()
                .all(|candidate| candidate.names().contains(&"tank-back-pressure") && candidate.effects.len() == 2),
            "{names:?}"
        );
        let best = found.iter().min_by(|a, b| a.fit.loss.total_cmp(&b.fit.loss)).unwrap().finished(question).unwrap();
        assert_eq!(best.names(), ["stribeck-friction", "tank-back-pressure"]);
        assert!(best.fit.loss < 0.5 * both.fit.loss, "{} {}", best.fit.loss, both.fit.loss);
        let sliding = best.fit.machine.get(P::StribeckForce);
        assert!((sliding / 300.0 - 1.0).abs() < 0.05, "{sliding}");

        // The effect that was added last had its extensions tried in its own round.
        let alone = with(&base, "tank-back-pressure");
        assert!(enriched(question, &with(&alone, "coulomb-friction"), &|_| ()).unwrap().is_empty());
        assert!(enriched(question, &base, &|_| ()).unwrap().is_empty());
    });
}

/// Edges of four sizes beside friction, of which the plain form with one effect parameter was found, and its refined forms.
fn refined_edges(sizes: [(P, f64); 3], found: P, seen: impl FnOnce(&Candidate, &[Candidate])) {
    let unknown = [sizes[0], sizes[1], sizes[2], (P::CoulombFriction, 300.0)];
    with_press(&unknown, |question| {
        let base = Candidate::rough(question, None).unwrap();
        let edges = added(question, &base, "metering-asymmetry", Some(found));
        let both = added(question, &edges, "coulomb-friction", None);
        seen(&both, &refined(question, &both, &|_| ()).unwrap());
    });
}

#[test]
fn edges_of_four_sizes_refine_those_of_two_wherever_the_set_has_them() {
    let little = [(P::MeteringDirections, -0.04), (P::MeteringPorts, 0.03), (P::MeteringRatio, 0.03)];
    for (plain, size, other) in [(P::MeteringRatio, -0.3, little[1]), (P::MeteringPorts, -0.45, little[2])] {
        let sizes = [(plain, size), little[0], other];
        refined_edges(sizes, plain, |both, found| {
            assert!(sizes[1..].iter().all(|(more, _)| both.fit.machine.get(*more) == 0.0), "the plain form alone");
            let [best] = found else { panic!("{}", found.len()) };
            assert_eq!(best.names(), ["coulomb-friction", "metering-asymmetry"]);
            for (parameter, value) in sizes {
                let fitted = best.fit.machine.get(parameter);
                assert!((fitted - value).abs() < 0.01, "{parameter:?} {fitted}");
            }
        });
    }
}

/// Edges of two sizes beside a return line that is not looked for: edges of all sizes explain some of its misfit, but not most.
#[test]
fn what_takes_less_than_three_quarters_refines_nothing() {
    with_press(&[(P::MeteringRatio, -0.3), (P::ReturnResistance, 1.5e13)], |question| {
        let base = Candidate::rough(question, None).unwrap();
        let edges = added(question, &base, "metering-asymmetry", Some(P::MeteringRatio));
        let effect = edges.effects[0].effect;
        let finer = edges.instead(question, 0, Chosen { effect, form: effect.refined[0] }, &[]).unwrap();
        let share = misfit_above_noise(&finer.residuals) / misfit_above_noise(&edges.residuals);
        assert!(share < 0.95 && share > 0.3, "{share}");
        assert!(refined(question, &edges, &|_| ()).unwrap().is_empty());
    });
}
