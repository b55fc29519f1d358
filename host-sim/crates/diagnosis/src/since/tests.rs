use machine_file::MachineFile;
use model_core::machine::Parameter as P;
use test_press::press;

use super::*;
use crate::base_parameters::base_parameters;
use crate::catalogue::{Form, Scene};
use crate::selection::screen::shapes;
use crate::test_scene::scene;

/// A drive with these values, known to these standard deviations and with these tolerances.
fn file(values: &[(P, f64)], sigma: &[(P, f64)], tolerance: &[(P, f64)]) -> MachineFile {
    let mut file = MachineFile::from_machine("press", press(values));
    (file.sigma, file.has_sigma_table) = (sigma.iter().copied().collect(), true);
    file.tolerance = tolerance.iter().copied().collect();
    file
}

fn moves(file: &MachineFile) -> Moves {
    let sheet = base_parameters(file);
    Moves::of(file, &sheet, Some(&held(file, &sheet)), &[])
}

/// The base parameters since such a file was written.
fn since(file: &MachineFile) -> Vec<Free> {
    moves(file).free
}

fn of(free: &[Free], parameter: P) -> Free {
    *free.iter().find(|free| free.parameter == parameter).unwrap()
}

/// How a form is told: its parameters.
fn parameters(form: Form) -> Vec<P> {
    form.iter().map(|own| own.parameter).collect()
}

/// What a question of the forms of an effect that a drive with these values holds is answered with.
fn asked<T>(values: &[(P, f64)], name: &str, answer: impl Fn(&Hypothesis, &Scene<'_>) -> T) -> T {
    let file = file(values, &[], &[]);
    let held = held(&file, &[]);
    let changeable = changeable(&file.machine, &[], &held);
    let scene = Scene { held: &held, changeable: &changeable, ..scene(&file.machine, &[]) };
    answer(CATALOGUE.iter().find(|effect| effect.name == name).unwrap(), &scene)
}

#[test]
fn of_a_tolerance_that_was_fitted_a_part_is_left_around_its_value_and_of_another_all() {
    let tolerances = [(P::MeteringRatio, 0.08), (P::InternalLeakage, 1e-12), (P::AirShare, 0.01)];
    let free = since(&file(&[(P::MeteringRatio, 0.03), (P::AirShare, 0.002)], &[], &tolerances));
    let ratio = of(&free, P::MeteringRatio);
    assert_eq!((ratio.nominal(), ratio.tolerance(), ratio.near()), (0.03, Some(0.08), None));
    assert!((ratio.value(40.0) - 0.046).abs() < 1e-9, "{ratio:?}");
    // The file never held a leak, and air is of the day.
    assert!((of(&free, P::InternalLeakage).value(40.0) - 1e-12).abs() < 1e-15);
    assert!((of(&free, P::AirShare).value(40.0) - 0.01).abs() < 1e-5);
}

#[test]
fn the_tanks_pressure_is_of_the_day_unless_it_acts_like_what_may_have_changed() {
    let sigma = [(P::TankPressure, 5e4), (P::MovingMass, 5.0)];
    let known = |further: &[(P, f64)]| {
        let values = [&[(P::TankPressure, 5e5), (P::MovingMass, 100.0)], further].concat();
        let free = since(&file(&values, &sigma, &[]));
        // As far above as a fit may go.
        [P::TankPressure, P::MovingMass]
            .map(|parameter| of(&free, parameter).value(40.0) - of(&free, parameter).nominal())
    };
    let is_near = |found: [f64; 2], expected: [f64; 2]| {
        assert!(found.iter().zip(expected).all(|(found, expected)| (found / expected - 1.0).abs() < 1e-9), "{found:?}");
    };
    is_near(known(&[]), [40.0 * 5e4, 2.0]);
    is_near(known(&[(P::ReturnResistance, 1e13)]), [2e4, 2.0]);
}

#[test]
fn the_overlap_is_open_where_an_edge_may_have_worn() {
    let freedom = |difference: f64| {
        let values = [(P::DeadZone, 0.05), (P::DeadZoneDifference, difference)];
        of(&since(&file(&values, &[(P::DeadZone, 0.01)], &[(P::DeadZoneDifference, 0.03)])), P::DeadZone)
    };
    assert!(freedom(0.0).near().is_some() && freedom(0.06).near().is_none());
}

#[test]
fn an_amount_that_may_have_changed_has_its_tenth_whatever_the_file_says_of_it() {
    let leaks = file(&[(P::InternalLeakage, 2e-12)], &[(P::InternalLeakage, 1e-11)], &[]);
    let free = since(&leaks);
    assert!((of(&free, P::InternalLeakage).near().unwrap() / 2e-13 - 1.0).abs() < 1e-9 && free.len() == 1);
    // No fit moves what jumps; that it has changed takes more than a tenth all the same.
    let sticks = [(P::StictionBand, 0.02), (P::StictionKept, 0.2)];
    assert!(since(&file(&sticks, &[], &[])).is_empty());
    let is_changed = |band| {
        asked(&sticks, "spool-stiction", |effect, scene| {
            scene.is_changed(effect.amounts().find(|own| own.parameter == P::StictionBand).unwrap(), band)
        })
    };
    assert_eq!((is_changed(0.0215), is_changed(0.025)), (Some(false), Some(true)));
}

#[test]
fn what_has_become_more_of_an_effect_is_no_other_form_of_it() {
    let forms = |values: &[(P, f64)], name: &str| {
        asked(values, name, |effect, scene| effect.forms_in(scene).map(parameters).collect::<Vec<_>>())
    };
    let all_edges = [P::MeteringRatio, P::MeteringPorts, P::MeteringDirections];
    assert_eq!(forms(&[(P::MeteringRatio, 0.2)], "metering-asymmetry"), [[P::MeteringRatio]]);
    assert_eq!(forms(&all_edges.map(|cut| (cut, 0.2)), "metering-asymmetry"), [all_edges]);
    let of_return = forms(&[(P::ReturnResistance, 1e13)], "tank-back-pressure");
    assert_eq!(of_return, [vec![P::ReturnResistance], vec![P::ReturnResistance, P::ReturnLaminar]]);
    assert_eq!(forms(&[(P::ValveLeakageOpening, 0.02), (P::ValveLeakageReach, 0.05)], "valve-leakage").len(), 1);
    // A floor has no amount.
    let file = file(&[(P::CavitationFloor, -5e4)], &[], &[]);
    let on = held(&file, &[]);
    assert!(on.iter().any(|effect| effect.name == "cavitation"));
    assert!(on.iter().all(|effect| !may_be_found(effect, &on, &on, &[])));
}

#[test]
fn a_rigid_friction_may_have_become_elastic() {
    let stiffness = |values: &[(P, f64)]| {
        asked(values, "coulomb-friction", |effect, scene| {
            let elastic = effect.forms_in(scene).find(|form| form.len() == 2).unwrap();
            shapes(scene, elastic)
        })
    };
    let rigid = stiffness(&[(P::CoulombFriction, 500.0)]);
    assert!(rigid.len() == 1 && rigid[0][0].1 > 1e6, "{rigid:?}");
    let elastic = stiffness(&[(P::CoulombFriction, 500.0), (P::PreslidingStiffness, 3e7)]);
    assert_eq!(elastic, [vec![(P::PreslidingStiffness, 3e7)]]);
}

#[test]
fn an_effect_is_tested_where_the_recordings_would_show_half_of_it() {
    let leaks = file(&[(P::InternalLeakage, 2e-12)], &[], &[]);
    let moves = moves(&leaks);
    // Alone, the recordings would know it to this share of itself.
    let untested_by = |alone: f64| {
        let known = 0.5 * AMOUNT_KNOWN;
        let std = 2e-12 / (1.0 / alone.powi(2) + 1.0 / (known * known)).sqrt();
        let estimate = Estimate { parameter: P::InternalLeakage, before: 2e-12, value: 2e-12, std, at_bound: false };
        moves.untested(&moves.held, &[estimate]).len()
    };
    assert_eq!((untested_by(0.01), untested_by(0.15), untested_by(0.18), untested_by(10.0)), (0, 0, 1, 1));
    assert_eq!(moves.untested(&[], &[]).len(), 1, "no form of it can be tried");
}
