use super::*;
use crate::candidate::Reference;
use crate::hypothesis::CATALOGUE;
use crate::machine_file::LoadSource;
use crate::press::{press, scene};
use crate::recording::{Column, Recording};
use crate::simulate::EntryPoint;

/// Noise of the slider's sensor, of full travel.
const OF_SLIDER: f64 = 1e-3;

/// What sensors with a little noise record of the press, driven to and fro, its slider and its position.
fn recorded(machine: &Machine<f64>) -> Recording {
    let time_s: Vec<f64> = (0..2000).map(|row| f64::from(row) * 1e-3).collect();
    let command = time_s.iter().map(|t| 2.5 * (5.0 * t).sin() + 1.5 * (13.0 * t).sin()).collect();
    let driven = vec![
        Column::si(Signal::Time, time_s.clone()),
        Column::si(Signal::Command, command),
        Column::si(Signal::Position, vec![0.12; time_s.len()]),
    ];
    let at_start = Recording::new("driven", driven.clone()).unwrap();
    let entry = (EntryPoint::Command, LoadSource::Constant, model_core::machine::Tick::OneMillisecond);
    let stimulus = Stimulus::new(&at_start, machine, entry.0, entry.1, entry.2).unwrap();
    let run = simulate::<f64>(machine, &stimulus, StartOffset::none()).unwrap();
    let read = |signal, noise: f64, stream| {
        let mut generator = Noise::new(3, stream);
        let values = run.signal(signal).unwrap().iter().map(|value| value + generator.gaussian(noise)).collect();
        Column::si(signal, values)
    };
    let sensors = [read(Signal::Spool, OF_SLIDER, 1), read(Signal::Position, 1e-5, 2)];
    Recording::new("made", driven.into_iter().take(2).chain(sensors).collect()).unwrap()
}

fn prepared(recording: &Recording, machine: &Machine<f64>) -> Prepared {
    Prepared::new(recording, machine, LoadSource::Constant, None).unwrap()
}

#[test]
fn what_the_sliders_noise_does_below_it_adds_to_the_noise_there_and_nothing_to_its_own() {
    let machine = press(&[(Parameter::ViscousFriction, 4e4)]);
    let own = prepared(&recorded(&machine), &machine);
    let followed = followed(&[&own], &machine).unwrap().unwrap();
    let noise = |case: &Prepared, signal| case.channels.iter().find(|one| one.signal == signal).unwrap().noise;
    let of = |signal| (noise(&own, signal), noise(&followed[0], signal));
    let (slider, with_slider) = of(Signal::Spool);
    assert!((with_slider - slider).abs() < 1e-12, "{slider} {with_slider}");
    assert!((slider / OF_SLIDER - 1.0).abs() < 0.2, "{slider}");
    // Held for a row each, independent errors e of the opening add K·e·h a row: over n rows a walk of K·e·h·√n, and half of that in the mean.
    let speed = (machine.get(Parameter::FlowCoefficient) * (0.5 * machine.get(Parameter::SupplyPressure)).sqrt())
        / machine.get(Parameter::AreaA);
    let walk = speed * OF_SLIDER * 1e-3 * (2000.0_f64 / 2.0).sqrt();
    let (position, with_position) = of(Signal::Position);
    let added = (with_position * with_position - position * position).sqrt();
    assert!((0.2..2.0).contains(&(added / walk)), "{added} of about {walk}");
}

#[test]
fn nothing_is_followed_where_the_slider_was_not_recorded() {
    let machine = press(&[]);
    let recording = recorded(&machine);
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
fn a_slider_that_reads_too_much_and_edges_that_lie_apart_are_the_same_but_for_the_valves_offset() {
    let machine = press(&[(Parameter::ViscousFriction, 4e4), (Parameter::DeadZone, 0.03)]);
    let read = {
        let mut read = machine;
        read.set(Parameter::SpoolOffset, 0.015);
        read
    };
    let case = prepared(&recorded(&read), &machine);
    let (training, judged) = ([&case], [Signal::Spool, Signal::Position]);
    let scene = scene(&machine, &judged);
    let hypotheses: Vec<_> = CATALOGUE.to_vec();
    let free = crate::fit::Free {
        parameter: Parameter::ValveOffset,
        freedom: crate::fit::Freedom::Around { nominal: 0.0, sigma: 0.02 },
    };
    let question = Question { scene: &scene, ordinary: &[free], hypotheses: &hypotheses, training: &training };
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
    let value = |set: &Candidate, parameter| set.fit.machine.get(parameter);
    assert!((value(&other, Parameter::SpoolOffset) - 0.015).abs() < 2e-4, "{}", value(&other, Parameter::SpoolOffset));
    assert!((value(&edges, Parameter::DeadZoneDifference) - 0.03).abs() < 4e-4);
    // Only the prior of the valve's offset tells: the slider that reads too much needs none.
    let (apart, read) = (edges.fit.loss, other.fit.loss);
    let bent = 0.5 * (0.015_f64 / 0.02).powi(2);
    assert!((apart - read - bent).abs() < 0.2 * bent, "{apart} {read} {bent}");
    let back = misread(&question, &other).unwrap().unwrap();
    assert_eq!(back.names(), ["dead-zone-asymmetry"]);
    assert!((back.fit.loss - apart).abs() < 0.05, "{} {apart}", back.fit.loss);
    assert!(misread(&question, &base).unwrap().is_none());
}
