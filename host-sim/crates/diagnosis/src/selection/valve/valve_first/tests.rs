use machine_file::LoadSource;
use recording::{Column, Recording};
use test_press::{press, recorded, recorded_for};

use super::*;
use crate::catalogue::CATALOGUE;
use crate::selection::candidate::Reference;
use crate::selection::decision_rule::VALVE_FIRST_FROM;
use crate::test_scene::scene;

/// Noise of the spool's sensor, of full travel.
const OF_SPOOL: f64 = 1e-3;

/// What the spool's and the position's sensors record.
const SENSORS: [(Signal, f64); 2] = [(Signal::Spool, OF_SPOOL), (Signal::Position, 1e-5)];

fn prepared(recording: &Recording, machine: &Machine<f64>) -> Prepared {
    Prepared::new(recording, machine, LoadSource::Constant, None).unwrap()
}

#[test]
fn what_the_spools_noise_does_below_it_adds_to_the_noise_there_and_nothing_to_its_own() {
    let machine = press(&[(Parameter::ViscousFriction, 4e4)]);
    let own = prepared(&recorded(&machine, &SENSORS), &machine);
    let followed = followed(&[&own], &machine).unwrap().unwrap();
    let noise = |case: &Prepared, signal| case.channels.iter().find(|one| one.signal == signal).unwrap().noise;
    let of = |signal| (noise(&own, signal), noise(&followed[0], signal));
    let (spool, with_spool) = of(Signal::Spool);
    assert!((with_spool - spool).abs() < 1e-12, "{spool} {with_spool}");
    assert!((spool / OF_SPOOL - 1.0).abs() < 0.2, "{spool}");
    // Independent errors e of the opening, each held for one row, add K·e·h per row: over n rows a random walk of K·e·h·√n, and half of that in the
    // mean.
    let speed = (machine.get(Parameter::FlowCoefficient) * (0.5 * machine.get(Parameter::SupplyPressure)).sqrt())
        / machine.get(Parameter::AreaA);
    let walk = speed * OF_SPOOL * 1e-3 * (2000.0_f64 / 2.0).sqrt();
    let (position, with_position) = of(Signal::Position);
    let added = (with_position * with_position - position * position).sqrt();
    assert!((0.2..2.0).contains(&(added / walk)), "{added} of about {walk}");
}

#[test]
fn nothing_is_followed_where_the_spool_was_not_recorded() {
    let machine = press(&[]);
    let recording = recorded(&machine, &SENSORS);
    let blind: Vec<Column> = [Signal::Time, Signal::Command, Signal::Position]
        .map(|signal| {
            let values = if signal == Signal::Time { recording.time_s() } else { recording.signal(signal).unwrap() };
            Column::si(signal, values.to_vec())
        })
        .to_vec();
    let case = prepared(&Recording::new("blind", blind).unwrap(), &machine);
    assert!(followed(&[&case], &machine).unwrap().is_none());
}

#[test]
fn a_spool_that_reads_too_much_and_edges_that_lie_apart_are_the_same_but_for_the_valves_offset() {
    let machine = press(&[(Parameter::ViscousFriction, 4e4), (Parameter::DeadZone, 0.03)]);
    let read = {
        let mut read = machine;
        read.set(Parameter::SpoolOffset, 0.015);
        read
    };
    let case = prepared(&recorded(&read, &SENSORS), &machine);
    let (training, judged) = ([&case], [Signal::Spool, Signal::Position]);
    let scene = scene(&machine, &judged);
    let hypotheses: Vec<_> = CATALOGUE.to_vec();
    let free = identification::fit::Free {
        parameter: Parameter::ValveOffset,
        freedom: identification::fit::Freedom::Around { nominal: 0.0, sigma: 0.02 },
    };
    let question = Question { scene: &scene, base_parameters: &[free], hypotheses: &hypotheses, training: &training };
    let base = Candidate::rough(&question, None).unwrap();
    let of = |name: &str| -> Candidate {
        let effect = *CATALOGUE.iter().find(|effect| effect.name == name).unwrap();
        let reference = Reference::new(&question, &base).unwrap();
        let lead = &reference.leads(&[effect]).unwrap()[0];
        reference.with(lead).unwrap().finished(&question).unwrap()
    };
    let edges = of("dead-zone-asymmetry");
    let other = misread(&question, &edges).unwrap().unwrap();
    assert_eq!(other.names(), ["sensor-offset"]);
    let value = |candidate: &Candidate, parameter| candidate.fit.machine.get(parameter);
    assert!((value(&other, Parameter::SpoolOffset) - 0.015).abs() < 2e-4, "{}", value(&other, Parameter::SpoolOffset));
    assert!((value(&edges, Parameter::DeadZoneDifference) - 0.03).abs() < 4e-4);
    // Only the prior of the valve's offset distinguishes them: the spool that reads too much needs no offset.
    let (apart, read) = (edges.fit.loss, other.fit.loss);
    let bent = 0.5 * (0.015_f64 / 0.02).powi(2);
    assert!((apart - read - bent).abs() < 0.2 * bent, "{apart} {read} {bent}");
    let back = misread(&question, &other).unwrap().unwrap();
    assert_eq!(back.names(), ["dead-zone-asymmetry"]);
    assert!((back.fit.loss - apart).abs() < 0.05, "{} {apart}", back.fit.loss);
    assert!(misread(&question, &base).unwrap().is_none());
}

/// A saturation of the spool that the model lacks hides nothing below the spool: where the recorded spool meters the oil, friction gains if, and only
/// if, it is there.
#[test]
fn an_effect_gains_on_its_own_side_whatever_the_valve_lacks() {
    let nominal = press(&[(Parameter::ViscousFriction, 2e4)]);
    let saturated = nominal.with(&[(Parameter::SolenoidOnset, 0.1), (Parameter::SolenoidLoss, 0.7)]);
    let truth = |force: f64| saturated.with(&[(Parameter::CoulombFriction, force)]);
    let sensors = [(Signal::Spool, OF_SPOOL), (Signal::PressureA, 2e4), (Signal::Position, 1e-5)];
    let judged = sensors.map(|(signal, _)| signal);
    let scene = scene(&nominal, &judged);
    let coulomb = *CATALOGUE.iter().find(|effect| effect.name == "coulomb-friction").unwrap();
    for (force, expected) in [(300.0, true), (0.0, false)] {
        let case = prepared(&recorded(&truth(force), &sensors), &nominal);
        // The same drive through sensors in another order, so that each has another noise.
        let held_out = prepared(&recorded(&truth(force), &[sensors[2], sensors[0], sensors[1]]), &nominal);
        let training = [&case];
        let question = Question { scene: &scene, base_parameters: &[], hypotheses: CATALOGUE, training: &training };
        let base = Candidate::rough(&question, None).unwrap();
        let chosen = Chosen { effect: coulomb, form: coulomb.forms[0] };
        let with = Candidate { effects: vec![chosen], ..base };
        assert!(with.worst_over_noise(&question) > VALVE_FIRST_FROM);
        assert_eq!(gains_on_own_side(&question, &with, coulomb, &[&held_out]).unwrap(), expected, "{force} N");
    }
}

#[test]
fn a_side_that_has_explained_itself_is_not_asked_again_while_the_chain_is_far_off() {
    let nominal = press(&[(Parameter::ViscousFriction, 2e4)]);
    let judged = [Signal::Spool, Signal::Position];
    let scene = scene(&nominal, &judged);
    let open = |loss: f64, explained: &[Side]| -> Vec<Side> {
        let truth = nominal.with(&[(Parameter::SolenoidOnset, 0.1), (Parameter::SolenoidLoss, loss)]);
        let case = prepared(&recorded(&truth, &SENSORS), &nominal);
        let training = [&case];
        let question = Question { scene: &scene, base_parameters: &[], hypotheses: CATALOGUE, training: &training };
        let near = Candidate::rough(&question, None).unwrap().fit;
        let mut course = Course::of(&question, &near).unwrap();
        course.explained = explained.to_vec();
        course.open(&question).into_iter().map(Side::of_effect).collect()
    };
    let all: Vec<Side> = CATALOGUE.iter().copied().map(Side::of_effect).collect();
    let only = |kept: Side| -> Vec<Side> { all.iter().copied().filter(|side| *side == kept).collect() };
    assert_eq!(open(0.7, &[Side::Below]), only(Side::Valve));
    assert_eq!(open(0.7, &[Side::Valve]), only(Side::Below));
    assert!(open(0.7, &[Side::Valve, Side::Below]).is_empty());
    assert_eq!(open(0.7, &[]), all);
    // Near the noise, all effects are open and the whole model is searched.
    assert_eq!(open(0.0, &[Side::Below]), all);
}

/// Two training recordings and a held-out one of a valve with stiction, judged by the valve's side alone.
fn asked_of_a_sticking_valve(further: &[(Parameter, f64)], ask: impl FnOnce(&Question<'_>, &Prepared)) {
    let nominal = press(&[(Parameter::ViscousFriction, 4e4), (Parameter::DeadZone, 0.03)]);
    let sticking = nominal.with(&[(Parameter::StictionBand, 0.012), (Parameter::StictionKept, 0.2)]).with(further);
    let sensors = [(Signal::Spool, 3e-4), (Signal::Position, 1e-5), (Signal::PressureA, 2e4)];
    // The same drive through sensors in another order, so that each has another noise.
    let orders = [[0, 1, 2], [1, 0, 2], [2, 1, 0]];
    let cases = orders.map(|order| {
        let case = prepared(&recorded(&sticking, &order.map(|index| sensors[index])), &nominal);
        case.judged_by(|signal| signal == Signal::Spool)
    });
    let around = |parameter, sigma| identification::fit::Free {
        parameter,
        freedom: identification::fit::Freedom::Around { nominal: nominal.get(parameter), sigma },
    };
    let base_parameters = [
        around(Parameter::ValveGain, 0.003),
        around(Parameter::TimeConstant1, 0.002),
        around(Parameter::ValveOffset, 0.01),
    ];
    let hypotheses: Vec<_> = CATALOGUE.iter().copied().filter(|one| Side::of_effect(one) == Side::Valve).collect();
    let judged = [Signal::Spool];
    let scene = scene(&nominal, &judged);
    let training = [&cases[0], &cases[1]];
    ask(
        &Question { scene: &scene, base_parameters: &base_parameters, hypotheses: &hypotheses, training: &training },
        &cases[2],
    );
}

#[test]
fn jumps_tell_a_play_beside_stiction_with_both_effect_parameters_and_held_out_ones_confirm_both() {
    let play = [(Parameter::HysteresisWidth, 0.02), (Parameter::HysteresisSpread, 0.6)];
    asked_of_a_sticking_valve(&play, |question, held_out| {
        let (chosen, round) = super::super::stiction::stuck(question, &|_| ()).unwrap().unwrap();
        assert_eq!(chosen.names(), ["spool-stiction", "valve-hysteresis"]);
        assert!(round.iter().any(|trial| trial.is_of(&chosen)));
        let value = |parameter| chosen.fit.machine.get(parameter);
        assert!((value(Parameter::StictionBand) / 0.012 - 1.0).abs() < 0.1, "{}", value(Parameter::StictionBand));
        // Except where it turns, half the play adds to how far the free spool is ahead: the two are less well determined than their sum.
        let width = value(Parameter::HysteresisWidth);
        assert!((width / 0.02 - 1.0).abs() < 0.2, "{width}");
        for effect in &chosen.effects {
            assert_eq!(
                super::super::stiction::confirms(question, &chosen, effect.effect, &[held_out]).unwrap(),
                Some(true)
            );
        }
    });
}

#[test]
fn jumps_tell_no_play_that_is_not_there_and_held_out_ones_confirm_none() {
    asked_of_a_sticking_valve(&[], |question, held_out| {
        let (chosen, _) = super::super::stiction::stuck(question, &|_| ()).unwrap().unwrap();
        assert_eq!(chosen.names(), ["spool-stiction"]);
        let value = |parameter| chosen.fit.machine.get(parameter);
        assert!((value(Parameter::StictionBand) / 0.012 - 1.0).abs() < 0.1, "{}", value(Parameter::StictionBand));
        let play = *CATALOGUE.iter().find(|effect| effect.name == "valve-hysteresis").unwrap();
        let mut both = chosen;
        both.effects.insert(0, Chosen { effect: play, form: play.forms[0] });
        assert_eq!(super::super::stiction::confirms(question, &both, play, &[held_out]).unwrap(), Some(false));
    });
}

#[test]
fn a_spool_that_does_not_stick_is_left_alone() {
    asked_of_a_sticking_valve(&[(Parameter::StictionBand, 0.0)], |question, _| {
        assert!(super::super::stiction::stuck(question, &|_| ()).unwrap().is_none());
    });
}

/// Derivatives of a long recording are computed only at every n-th row, whereas jumps can be at any row.
#[test]
fn jumps_tell_how_far_ahead_the_free_spool_is_however_long_the_recording_is() {
    const FURTHER: f64 = 1e-3;
    let nominal = press(&[(Parameter::ViscousFriction, 4e4)]);
    let (band, kept) = (0.012, 0.2);
    let truth = nominal.with(&[(Parameter::StictionBand, band), (Parameter::StictionKept, kept)]);
    let judged = [Signal::Spool];
    let scene = scene(&nominal, &judged);
    let free = identification::fit::Free {
        parameter: Parameter::ValveOffset,
        freedom: identification::fit::Freedom::Around { nominal: 0.0, sigma: 0.01 },
    };
    for rows in [2_000, 150_000] {
        let case = prepared(&recorded_for(&truth, &[(Signal::Spool, 3e-4)], rows), &nominal);
        let sticking = super::super::spool_jumps::Sticking::of(&[&case], 1).unwrap();
        let at = 0.5 * band * (1.0 + kept);
        let told = |ahead: f64| {
            let freed = sticking.freed(ahead);
            let training: Vec<&Prepared> = freed.iter().collect();
            let question =
                Question { scene: &scene, base_parameters: &[free], hypotheses: CATALOGUE, training: &training };
            let candidate = Candidate::rough(&question, None).unwrap().finished(&question).unwrap();
            sticking.further(&candidate, &training).unwrap()
        };
        let (nearer, there) = (told(at - FURTHER), told(at));
        // A jump is seen up to one row after the spool broke away; meanwhile the free spool has moved on.
        assert!(there.abs() < 0.1 * at, "{rows} rows: {there} beside {at}");
        assert!(((nearer - there) / FURTHER - 1.0).abs() < 0.05, "{rows} rows: {nearer} {there}");
    }
}
