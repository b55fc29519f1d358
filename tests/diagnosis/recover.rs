//! The fit on signals that the model itself computed: it must find what was put in.

use diagnosis::catalogue::{CATALOGUE, Hypothesis};
use diagnosis::selection::Selection;
use diagnosis::selection::candidate::Reference;
use diagnosis::selection::{Candidate, Chosen, Question};
use identification::experiment::{JudgedSignal, Prepared};
use identification::fit::{Free, Freedom, From, fit};
use model_core::machine::{Machine, Parameter as P};
use recording::Signal;
use simulation::{StartOffset, simulate_f64};
use virtual_plant::PlantEffect;

use super::bed::{Case, Dice, press, valve_case};

/// The case's recordings with the model's own signals in place of the test bed's, free of noise.
fn computed(case: &Case, truth: &Machine<f64>) -> Vec<Prepared> {
    let replace = |mut prepared: Prepared| {
        let computed = simulate_f64(truth, &prepared.stimulus, StartOffset::none()).unwrap();
        for JudgedSignal { signal, recorded, .. } in &mut prepared.channels {
            recorded.clear();
            recorded.extend_from_slice(computed.signal(*signal).unwrap());
        }
        prepared
    };
    case.prepared(&case.training).into_iter().map(replace).collect()
}

#[test]
fn a_fit_to_the_models_own_signals_recovers_what_they_were_made_with() {
    let file = press();
    let case = valve_case(21, None, true, None);
    let mut truth = file.machine;
    for (index, (&parameter, &sigma)) in file.sigma.iter().enumerate() {
        let sign = if index % 2 == 0 { 1.0 } else { -1.0 };
        truth.set(parameter, truth.get(parameter) + sign * sigma);
    }
    let effect_parameters = [(P::InternalLeakage, 3e-12), (P::HoseCompliance, 3e-13), (P::CoulombFriction, 500.0)];
    for (parameter, effect_parameter) in effect_parameters {
        truth.set(parameter, effect_parameter);
    }
    let cases = computed(&case, &truth);
    let cases: Vec<&Prepared> = cases.iter().collect();
    let around = |(&parameter, &sigma): (&P, &f64)| Free {
        parameter,
        // A prior this wide has no influence.
        freedom: Freedom::Around { nominal: file.machine.get(parameter), sigma: 30.0 * sigma },
    };
    let effect_parameter = |(parameter, effect_parameter): (P, f64)| Free {
        parameter,
        freedom: Freedom::Logarithm { centre: 0.3 * effect_parameter, spread: 30.0, vanishes: true },
    };
    let free: Vec<Free> = file.sigma.iter().map(around).chain(effect_parameters.map(effect_parameter)).collect();
    let fit = fit(&file.machine, &free, &cases, &From::default(), 1e-12).unwrap();
    for estimate in &fit.estimates(1.0) {
        let put_in = truth.get(estimate.parameter);
        let off = estimate.value / put_in - 1.0;
        println!("{}: {put_in:e}, found {off:+.1e} of it off", estimate.parameter.description().key);
        assert!(off.abs() < 5e-3, "{}: {put_in:e} {:e}", estimate.parameter.description().key, estimate.value);
    }
    assert!(fit.converged);
}

/// Where nothing is missing, a search from any start drawn over the priors ends where the search from the nominal machine does. Where an effect is
/// missing, it ends in a valley that is deeper by at most a twentieth: very little compared with what the missing effect gains.
#[test]
fn drawn_starts_of_the_base_refit_end_no_lower_than_the_nominal_one() {
    const DRAWN: usize = 6;
    let mut dice = Dice::new(61);
    for (missing, effect_parameter) in
        [("nothing", 0.0), ("internal-leakage", 3e-12), ("valve-hysteresis", 0.03), ("coulomb-friction", 900.0)]
    {
        let case = valve_case(62, PlantEffect::named(missing, effect_parameter), true, None);
        let training = case.prepared(&case.training);
        let references: Vec<&Prepared> = training.iter().collect();
        let free = diagnosis::base_parameters(&case.file);
        let ends = |coordinates: &[(P, f64)]| {
            let from = From { coordinates, ..From::default() };
            fit(&case.file.machine, &free, &references, &from, 1e-6).unwrap().loss
        };
        let nominal = ends(&[]);
        let mut drawn = || free.iter().map(|free| (free.parameter, dice.between(-2.0, 2.0))).collect::<Vec<_>>();
        let losses: Vec<f64> = (0..DRAWN).map(|_| ends(&drawn()) / nominal).collect();
        println!("{missing} missing, over the nominal start's loss: {losses:.4?}");
        let least = if missing == "nothing" { 0.9999 } else { 0.95 };
        assert!(losses.iter().all(|loss| *loss > least), "{missing}: {losses:?}");
    }
}

/// The search for a friction that is equal in both directions may end short of what two separate forces reach, which are then about equal.
#[test]
fn where_a_richer_friction_ends_the_plainer_one_is_looked_for() {
    let case = valve_case(31, PlantEffect::named("coulomb-friction", 900.0), true, None);
    let training = case.prepared(&case.training);
    let references: Vec<&Prepared> = training.iter().collect();
    let judged: Vec<Signal> = training[0].channels.iter().map(|channel| channel.signal).collect();
    let scene = case.scene(&training[0], &judged);
    let base_parameters: Vec<Free> = diagnosis::base_parameters(&case.file);
    let frictions: Vec<&'static Hypothesis> = CATALOGUE
        .iter()
        .copied()
        .filter(|effect| effect.name.ends_with("friction") || effect.name == "friction-asymmetry")
        .collect();
    let question =
        Question { scene: &scene, base_parameters: &base_parameters, hypotheses: &frictions, training: &references };
    let base = Candidate::rough(&question, None).unwrap();
    let reference = Reference::new(&question, &base).unwrap();
    let leads = reference.leads(&frictions).unwrap();
    let lead = leads.iter().find(|lead| lead.effect.name == "friction-asymmetry").unwrap();
    let richer = reference.with(lead).unwrap().finished(&question).unwrap();
    let plain = richer.with_plain(&question).unwrap().unwrap();
    let force = plain.fit.machine.get(P::CoulombFriction);
    println!("{force:.0} N; {:.1} with one force, {:.1} with two", plain.fit.loss, richer.fit.loss);
    assert_eq!(plain.names(), ["coulomb-friction"]);
    assert!((force / 900.0 - 1.0).abs() < 0.1, "{force}");
    assert!(plain.fit.loss < 1.02 * richer.fit.loss && plain.fit.loss < 0.5 * base.fit.loss);
    let gone = [P::AsymmetricExtending, P::AsymmetricRetracting];
    assert!(gone.iter().all(|&gone| plain.fit.machine.get(gone).abs() < f64::MIN_POSITIVE));
    assert!(plain.with_plain(&question).unwrap().is_none(), "it extends nothing");
}

/// Held-out recordings veto a single effect: friction stays, and a backlash that no recording shows is removed.
#[test]
fn of_two_effects_held_out_recordings_take_out_the_one_they_gain_nothing_by() {
    let case = valve_case(31, PlantEffect::named("coulomb-friction", 900.0), true, None);
    let (training, held) = (case.prepared(&case.training), case.prepared(&case.held_out));
    let (references, held): (Vec<&Prepared>, Vec<&Prepared>) = (training.iter().collect(), held.iter().collect());
    let judged: Vec<Signal> = training[0].channels.iter().map(|channel| channel.signal).collect();
    let scene = case.scene(&training[0], &judged);
    let base_parameters: Vec<Free> = diagnosis::base_parameters(&case.file);
    let effects = ["coulomb-friction", "valve-hysteresis"];
    let named = |name| CATALOGUE.iter().copied().find(|effect| effect.name == name).unwrap();
    let hypotheses = effects.map(named);
    let question =
        Question { scene: &scene, base_parameters: &base_parameters, hypotheses: &hypotheses, training: &references };
    let base = Candidate::rough(&question, None).unwrap();
    let beside = |set: &Candidate, effect: &'static Hypothesis| {
        let effect = Chosen { effect, form: effect.forms[0] };
        Candidate { effects: set.effects.iter().copied().chain([effect]).collect(), ..set.clone() }
    };
    let reference = Reference::new(&question, &base).unwrap();
    let leads = reference.leads(&hypotheses).unwrap();
    let friction = leads.iter().find(|lead| lead.effect.name == effects[0]).unwrap();
    let one = reference.with(friction).unwrap().finished(&question).unwrap();
    let mut two = beside(&one, hypotheses[1]);
    two.fit.machine.set(P::HysteresisWidth, 0.05);

    let mut selection = Selection {
        inflated: base.fit.clone(),
        base,
        chosen: two,
        rounds: vec![Vec::new(), Vec::new()],
        joined: Vec::new(),
        jumps: None,
        searched: diagnosis::selection::Searched::default(),
    };
    assert!(selection.refused(&question, &[]).unwrap().is_empty(), "nothing is held out that could speak against it");
    let refused: Vec<&str> = selection.refused(&question, &held).unwrap().iter().map(|effect| effect.name).collect();
    assert_eq!((refused, selection.chosen.names()), (vec![effects[1]], vec![effects[0]]));
    assert!(selection.chosen.fit.machine.get(P::HysteresisWidth).abs() < f64::MIN_POSITIVE);
    assert!(selection.refused(&question, &held).unwrap().is_empty(), "one alone is confirmed or vetoed as a whole");
    let entered: Vec<&str> = selection.rounds[0].iter().map(|trial| trial.effect.name).collect();
    assert_eq!(entered, [effects[0]], "what is left stands in the round of its size");

    // Without the friction, backlash stands in for it below the spool, but explains almost nothing in the whole model: it is removed with the other.
    let mut both = beside(&beside(&selection.base, hypotheses[1]), named("linkage-backlash"));
    both.fit.machine.set(P::BacklashPlay, 0.01);
    let mut selection = Selection { chosen: both, ..selection };
    let refused: Vec<&str> = selection.refused(&question, &held).unwrap().iter().map(|effect| effect.name).collect();
    assert_eq!((refused, selection.chosen.names()), (vec!["linkage-backlash", effects[1]], vec![]));
}
