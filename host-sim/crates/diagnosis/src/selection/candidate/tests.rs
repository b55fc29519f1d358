use identification::fit::{Freedom, StartState, effective_samples};
use machine_file::LoadSource;
use recording::Signal;
use test_press::{extending, press, recorded};

use super::*;
use crate::catalogue::{AMOUNT_KNOWN, CATALOGUE};
use crate::test_scene::scene;

/// A candidate model of one effect in its plainest form, as if a fit had ended at this machine.
fn accepted_alone(name: &str, scene: &Scene<'_>, base_parameters: &[Free], machine: &Machine<f64>) -> Candidate {
    let effect = CATALOGUE.iter().find(|effect| effect.name == name).unwrap();
    let form = effect.forms[0];
    let free: Vec<Free> = base_parameters
        .iter()
        .copied()
        .chain(form.iter().map(|effect_parameter| effect_parameter.free(scene)))
        .collect();
    let coordinates = free.iter().map(|free| free.coordinate(machine.get(free.parameter))).collect();
    let starts = vec![StartState::default()];
    let fit =
        Fit { machine: *machine, free, coordinates, starts, normal_equations: Vec::new(), converged: true, loss: 0.0 };
    let effects = vec![Chosen { effect, form }];
    Candidate {
        effects,
        fit,
        jumps: Vec::new(),
        residuals: Vec::new(),
        is_finished: true,
        is_inflated: false,
        counts: effective_samples,
    }
}

#[test]
fn a_spring_that_begins_inside_the_stroke_is_no_stop_however_damped() {
    let machine = press(&[]);
    let scene = scene(&machine, &[Signal::Position]);
    let stop = |share: f64, damping: f64| -> (bool, bool) {
        let stiffness = scene.full_force_n() / (share * machine.get(Parameter::Stroke));
        let values =
            [(Parameter::StopStiffness, stiffness), (Parameter::StopExtended, 0.24), (Parameter::StopDamping, damping)];
        let candidate = accepted_alone("end-stop", &scene, &[], &machine.with(&values));
        let question = Question { scene: &scene, base_parameters: &[], hypotheses: &[], training: &[] };
        (candidate.is_possible(&scene), candidate.is_plausible(&question))
    };
    // The full force makes steel give by a ten-thousandth of the stroke, rubber by a hundredth.
    assert_eq!([1e-4, 1e-3, 1e-2].map(|share| stop(share, 1e3)), [(true, true); 3]);
    // A stop that gives by a tenth may be the likeliest effect, but is not accepted.
    assert_eq!([stop(0.1, 1e3), stop(0.3, 1e4)], [(true, false); 2]);
}

#[test]
fn a_small_stiction_that_hardly_jumps_is_the_form_of_the_play_beside_it() {
    let machine = press(&[]);
    let scene = scene(&machine, &[Signal::Spool]);
    let beside = |band: f64, kept: f64, width: f64| -> (bool, bool) {
        let effect_parameters =
            [(Parameter::StictionBand, band), (Parameter::StictionKept, kept), (Parameter::HysteresisWidth, width)];
        let mut candidate = accepted_alone("spool-stiction", &scene, &[], &machine.with(&effect_parameters));
        let play = CATALOGUE.iter().find(|effect| effect.name == "valve-hysteresis").unwrap();
        candidate.effects.push(Chosen { effect: play, form: play.forms[0] });
        let question = Question { scene: &scene, base_parameters: &[], hypotheses: &[], training: &[] };
        (candidate.is_possible(&scene), candidate.is_plausible(&question))
    };
    // It may be the likeliest effect, but is not accepted.
    assert_eq!(beside(0.005, 0.9, 0.02), (true, false));
    // A stiction that jumps is accepted however small it is, and one as wide as the play does not only shape the play.
    assert_eq!([beside(0.005, 0.2, 0.02), beside(0.02, 0.9, 0.02)], [(true, true); 2]);
}

#[test]
fn what_keeps_more_than_two_thirds_of_its_band_hardly_jumps() {
    let machine = press(&[]);
    let scene = scene(&machine, &[Signal::Spool]);
    let keeping = |kept: f64| {
        let effect_parameters = [(Parameter::StictionBand, 0.01), (Parameter::StictionKept, kept)];
        accepted_alone("spool-stiction", &scene, &[], &machine.with(&effect_parameters)).hardly_jumps()
    };
    assert_eq!([0.1, 0.6, 0.7, 0.95].map(keeping), [false, false, true, true]);
    let play = [(Parameter::HysteresisWidth, 0.01), (Parameter::StictionKept, 0.9)];
    assert!(!accepted_alone("valve-hysteresis", &scene, &[], &machine.with(&play)).hardly_jumps());
}

#[test]
fn without_an_effect_a_base_parameter_has_what_that_had_of_it() {
    // A load of 500 N, as the difference of two forces, one larger than the supply can give and the other nearly as large.
    let machine = press(&[(Parameter::ViscousFriction, 4e4), (Parameter::LoadForce, 500.0)]);
    let case = Prepared::new(&extending(&machine), &machine, LoadSource::Constant, None).unwrap();
    let training = [&case];
    let scene = scene(&machine, &[Signal::Position]);
    let load = Free { parameter: Parameter::LoadForce, freedom: Freedom::Around { nominal: 500.0, sigma: 1e5 } };
    let question = Question { scene: &scene, base_parameters: &[load], hypotheses: &[], training: &training };

    let moved = machine.with(&[(Parameter::LoadForce, -59_500.0), (Parameter::LoadSpringForce, -60_000.0)]);
    let candidate = accepted_alone("position-dependent-load", &scene, &[load], &moved);

    let without = candidate.without(&question, 0).unwrap();
    let found = without.fit.machine;
    assert!((found.get(Parameter::LoadForce) - 500.0).abs() < 50.0, "{} N", found.get(Parameter::LoadForce));
    assert!(found.get(Parameter::LoadSpringForce) == 0.0 && without.effects.is_empty());
    assert!(without.worst_over_noise(&question) < 1.05, "{}", without.worst_over_noise(&question));
}

#[test]
fn of_two_pressure_sensors_the_one_that_presses_against_its_tolerance_is_tried_in_place_of_the_other() {
    // A reads 8 bar too little. The offset of B was taken for it, as far as the load and A's own tolerance let it.
    let machine = press(&[(Parameter::ViscousFriction, 4e4)]);
    let noise = [(Signal::PressureA, 1e4), (Signal::PressureB, 1e4), (Signal::Position, 1e-5)];
    let truth = machine.with(&[(Parameter::PressureAOffset, -8e5)]);
    let case = Prepared::new(&recorded(&truth, &noise), &machine, LoadSource::Constant, None).unwrap();
    let training = [&case];
    let scene = scene(&machine, &[Signal::Position, Signal::PressureA, Signal::PressureB]);
    let within = |parameter| Free { parameter, freedom: Freedom::Within { most: 5e4, is_signed: true } };
    let load = Free { parameter: Parameter::LoadForce, freedom: Freedom::Around { nominal: 0.0, sigma: 50.0 } };
    let base = [load, within(Parameter::PressureAOffset), within(Parameter::PressureBOffset)];
    let question = Question { scene: &scene, base_parameters: &base, hypotheses: &[], training: &training };
    let effect = CATALOGUE.iter().find(|effect| effect.name == "sensor-offset").unwrap();
    let of_b = effect.forms.iter().find(|form| form[0].parameter == Parameter::PressureBOffset).unwrap();
    let wrong = machine.with(&[
        (Parameter::PressureAOffset, -4.95e4),
        (Parameter::PressureBOffset, 6e5),
        (Parameter::LoadForce, 900.0),
    ]);
    let mut candidate = accepted_alone("sensor-offset", &scene, &base[..2], &wrong);
    candidate.effects = vec![Chosen { effect, form: of_b }];
    candidate.fit.free = base[..2].iter().copied().chain(of_b.iter().map(|offset| offset.free(&scene))).collect();
    candidate.fit.coordinates =
        candidate.fit.free.iter().map(|free| free.coordinate(wrong.get(free.parameter))).collect();
    let found = candidate.finished(&question).unwrap().fit.machine;
    let read = |parameter| found.get(parameter);
    assert!((read(Parameter::PressureAOffset) + 8e5).abs() < 2e4, "{} Pa", read(Parameter::PressureAOffset));
    assert!(read(Parameter::PressureBOffset).abs() < 2e4, "{} Pa", read(Parameter::PressureBOffset));
}

/// Of a drive whose file holds a leak, and that now leaks by another amount.
#[test]
fn a_base_near_its_noise_makes_up_for_a_change_by_what_is_left_of_the_amount() {
    const THEN: f64 = 2e-12;
    let machine = press(&[(Parameter::ViscousFriction, 4e4), (Parameter::InternalLeakage, THEN)]);
    let noise = [(Signal::PressureA, 1e4), (Signal::PressureB, 1e4), (Signal::Position, 1e-5)];
    let effect = *CATALOGUE.iter().find(|effect| effect.name == "internal-leakage").unwrap();
    let held = [effect];
    let changeable: Vec<&EffectParameter> = effect.forms[0].iter().collect();
    let judged = [Signal::Position, Signal::PressureA, Signal::PressureB];
    let scene = Scene { held: &held, changeable: &changeable, ..scene(&machine, &judged) };
    let known = Freedom::Near { nominal: THEN, most: AMOUNT_KNOWN * THEN, within: None };
    let free = [Free { parameter: Parameter::InternalLeakage, freedom: known }];
    let made_up = |leak: f64| {
        let truth = machine.with(&[(Parameter::InternalLeakage, leak)]);
        let case = Prepared::new(&recorded(&truth, &noise), &machine, LoadSource::Constant, None).unwrap();
        let training = [&case];
        let question = Question { scene: &scene, base_parameters: &free, hypotheses: &held, training: &training };
        let base = Candidate::rough(&question, None).unwrap();
        let changed = accepted_alone("internal-leakage", &scene, &[], &truth);
        (base.uses_up(&question, effect.forms[0]), base.makes_up_for_change(&question, &changed))
    };
    assert_eq!(made_up(1.02 * THEN), (false, false));
    assert_eq!(made_up(1.13 * THEN), (true, true));
    // Far off, the misfit itself has to go.
    assert_eq!(made_up(3.0 * THEN), (true, false));
}

#[test]
fn less_by_one_amount_and_more_by_another_is_a_trade_unless_one_of_them_is_next_to_nothing() {
    // Both amounts of a form with these two, then and now, in their usual sizes.
    let trades = |name: &str, own: [Parameter; 2], then: [f64; 2], now: [f64; 2]| {
        let effect = *CATALOGUE.iter().find(|effect| effect.name == name).unwrap();
        let amount = |form: Form, own| form.iter().find(|it: &&EffectParameter| it.parameter == own);
        let has_both = |form: &&Form| own.iter().all(|own| amount(form, *own).is_some());
        let form = effect.forms.iter().find(has_both).unwrap();
        let plain = press(&[]);
        let units = own.map(|own| amount(form, own).unwrap().unit(&scene(&plain, &[])));
        let with = |shares: [f64; 2]| plain.with(&[(own[0], shares[0] * units[0]), (own[1], shares[1] * units[1])]);
        let machine = with(then);
        let (held, changeable): ([&Hypothesis; 1], Vec<&EffectParameter>) = ([effect], form.iter().collect());
        let scene = Scene { held: &held, changeable: &changeable, ..scene(&machine, &[]) };
        let question = Question { scene: &scene, base_parameters: &[], hypotheses: &held, training: &[] };
        accepted_alone(name, &scene, &[], &with(now)).trades(&question, form)
    };
    let returned = [Parameter::ReturnResistance, Parameter::ReturnLaminar];
    assert!(trades("tank-back-pressure", returned, [0.1, 1.0], [0.9, 0.4]));
    assert!(!trades("tank-back-pressure", returned, [1.0, 0.5], [2.3, 1.2]));
    let leaks = [Parameter::ExternalLeakageA, Parameter::ExternalLeakageB];
    assert!(!trades("external-leakage", leaks, [1.0, 0.002], [2.4, 0.0017]));
}
