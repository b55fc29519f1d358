use super::*;
use crate::fit::{Freedom, recorded};
use crate::hypothesis::CATALOGUE;
use crate::machine_file::LoadSource;
use crate::press::{press, scene};
use crate::recording::Signal;

#[test]
fn without_an_effect_an_ordinary_parameter_has_what_that_had_of_it() {
    // A load of 500 N, said by more force than the supply has one way and nearly as much the other.
    let machine = press(&[(Parameter::ViscousFriction, 4e4), (Parameter::LoadForce, 500.0)]);
    let case = Prepared::new(&recorded(&machine), &machine, LoadSource::Constant, None).unwrap();
    let training = [&case];
    let scene = scene(&machine, &[Signal::Position]);
    let load = Free { parameter: Parameter::LoadForce, freedom: Freedom::Around { nominal: 500.0, sigma: 1e5 } };
    let question = Question { scene: &scene, ordinary: &[load], hypotheses: &[], training: &training };

    let effect = CATALOGUE.iter().find(|effect| effect.name == "position-dependent-load").unwrap();
    let form = effect.forms[0];
    let mut moved = machine;
    moved.set(Parameter::LoadForce, -59_500.0);
    moved.set(Parameter::LoadSpringForce, -60_000.0);
    let free: Vec<Free> = [load].into_iter().chain(form.iter().map(|strength| strength.free(&scene))).collect();
    let coordinates = free.iter().map(|free| free.coordinate(moved.get(free.parameter))).collect();
    let starts = vec![StartState::default()];
    let fit = Fit { machine: moved, free, coordinates, starts, information: Vec::new(), converged: true, loss: 0.0 };
    let effects = vec![Chosen { effect, form }];
    let set = Candidate { effects, fit, jumps: Vec::new(), residuals: Vec::new(), is_finished: true };

    let without = set.without(&question, 0).unwrap();
    let found = without.fit.machine;
    assert!((found.get(Parameter::LoadForce) - 500.0).abs() < 50.0, "{} N", found.get(Parameter::LoadForce));
    assert!(found.get(Parameter::LoadSpringForce) == 0.0 && without.effects.is_empty());
    assert!(without.worst_over_noise(&question) < 1.05, "{}", without.worst_over_noise(&question));
}
