//! Properties that a drawn case must have.

use rayon::prelude::*;

use model_core::machine::Parameter as P;

use virtual_plant::concealed::{Concealed, Drawn, Lot, ON_REQUEST, OUTSIDE, VOCABULARY, draw, to_json};
use virtual_plant::{LoadEffect, PlantEffect};

fn lot(concealed: Concealed, seed: u64, only: &[&str]) -> Lot {
    let only = only.iter().map(|name| (*name).to_owned()).collect();
    Lot { seed, concealed, hard: seed % 2 == 1, only, thermometer: false }
}

#[test]
fn a_case_is_the_same_again_and_another_seed_is_another_case() {
    let text = |seed: u64| {
        let drawn = draw(&lot(Concealed::Single, seed, &["internal-leakage"]), 2).unwrap().unwrap();
        let files: Vec<String> = drawn.recordings.iter().map(|(_, recording)| recording.to_csv()).collect();
        (files, drawn.file.to_text("m.toml").unwrap(), to_json(&[(drawn.id, drawn.truth)]))
    };
    let one = text(1);
    assert_eq!(one, text(1));
    assert_ne!(one.1, text(2).1);
}

#[test]
fn every_name_can_be_drawn_and_stays_inside_its_stroke() {
    let names: Vec<&str> = VOCABULARY.iter().chain(&ON_REQUEST).chain(&OUTSIDE).copied().collect();
    names.par_iter().enumerate().for_each(|(index, name)| {
        let drawn = draw(&lot(Concealed::Single, 4, &[name]), index as u64).unwrap().unwrap();
        assert_eq!(drawn.truth.effects, [*name]);
        assert!(drawn.truth.forms.iter().all(|form| form.name() == *name));
        let stroke_m = drawn.file.machine.get(P::Stroke);
        for (file, recording) in &drawn.recordings {
            assert!(recording.len() > 700, "{name} {file}");
            for state in &recording.truth {
                assert!((0.0..=stroke_m).contains(&state.position_m), "{name} {file}");
                assert!(state.pressure_a_pa.is_finite() && state.spool.is_finite(), "{name} {file}");
            }
        }
        assert!(drawn.truth.visible.iter().all(|visible| *visible > 1.0), "{name}: {:?}", drawn.truth.visible);
    });
}

#[test]
fn no_rod_begins_beyond_a_stop() {
    /// How far a stop yields under the full force, m.
    const GIVES_M: f64 = 1e-3;
    (0..8_u64).into_par_iter().for_each(|index| {
        let drawn = draw(&lot(Concealed::Single, 77, &["end-stop"]), index).unwrap().unwrap();
        let PlantEffect::Load(LoadEffect::EndStop { at_m, extending, .. }) = drawn.truth.forms[0] else {
            panic!("{:?}", drawn.truth.forms)
        };
        for (file, recording) in &drawn.recordings {
            let beyond_m = if extending { 1.0 } else { -1.0 } * (recording.truth[0].position_m - at_m);
            assert!(beyond_m < GIVES_M, "{index} {file}: {beyond_m}");
        }
    });
}

#[test]
fn a_thermometer_finds_warmer_oil_in_each_recording_and_changes_nothing_else() {
    let none = lot(Concealed::None, 6, &[]);
    let (plain, measured) = (draw(&none, 0), draw(&Lot { thermometer: true, ..none.clone() }, 0));
    let (plain, mut measured) = (plain.unwrap().unwrap(), measured.unwrap().unwrap());
    let mut before = f64::MIN;
    for ((_, plain), (_, measured)) in plain.recordings.iter().zip(&mut measured.recordings) {
        let oil_c = std::mem::take(&mut measured.oil_temperature_c);
        assert_eq!((oil_c.len(), &*measured), (plain.len(), plain));
        let mean_c = oil_c.iter().sum::<f64>() / oil_c.len() as f64;
        assert!(mean_c > before + 4.0 && (10.0..90.0).contains(&mean_c), "{mean_c}");
        before = mean_c;
    }
    let thins =
        draw(&Lot { thermometer: true, ..lot(Concealed::Single, 6, &["oil-temperature"]) }, 0).unwrap().unwrap();
    assert!(thins.truth.visible[0] > 1.0 && matches!(thins.truth.forms[0], PlantEffect::OilGrade(_)));
    assert!(thins.recordings[0].1.to_csv().lines().next().unwrap().contains("oil_temperature [°C]"));
}

#[test]
fn two_effects_are_two_and_a_lot_takes_each_name_in_turn() {
    let pair = draw(&lot(Concealed::Pair, 8, &[]), 1).unwrap().unwrap().truth;
    assert_eq!((pair.effects.len(), pair.visible.len()), (2, 2));
    assert_ne!(pair.effects[0], pair.effects[1]);
    let only = ["internal-leakage", "linkage-backlash"];
    let mut two = [0, 1].map(|k| draw(&lot(Concealed::Single, 2, &only), k).unwrap().unwrap().truth.effects[0]);
    two.sort_unstable();
    assert_eq!(two, only);
}

#[test]
fn an_effect_that_the_noise_hides_may_be_left_out() {
    let mut truth = draw(&lot(Concealed::None, 4, &[]), 0).unwrap().unwrap().truth;
    assert!(truth.effects.is_empty());
    assert_eq!(truth.accept(), [Vec::<&str>::new()]);
    truth.effects = vec!["end-stop", "null-drift"];
    truth.visible = vec![1.1, 3.0];
    assert_eq!(truth.accept(), [vec!["end-stop", "null-drift"], vec!["null-drift"]]);
    truth.effects = vec!["presliding", "null-drift"];
    truth.plainer = vec![Some(("coulomb-friction", 1.2)), None];
    truth.visible = vec![3.0, 1.1];
    let [whole, plainer] = [["presliding", "null-drift"], ["coulomb-friction", "null-drift"]];
    assert_eq!(truth.accept(), [&whole[..], &plainer, &whole[..1]]);
    // The noise may hide each of two effects alone, and still show both together.
    truth.visible = vec![1.1, 1.1];
    truth.visible_together = Some(1.3);
    assert_eq!(truth.accept(), [&whole[..], &plainer, &whole[1..], &whole[..1]]);
    truth.visible_together = Some(1.2);
    assert_eq!(truth.accept().last().map(Vec::len), Some(0));
}

#[test]
fn what_the_noise_or_a_load_hides_of_a_richer_friction_may_be_called_plain() {
    let drawn = |seed: u64, name: &str| {
        let lot = Lot { hard: true, ..lot(Concealed::Single, seed, &[name]) };
        (0..6_u64).into_par_iter().map(|index| draw(&lot, index).unwrap().unwrap()).collect::<Vec<_>>()
    };
    let is_plain = |drawn: &Drawn| drawn.truth.accept().contains(&vec!["coulomb-friction"]);
    let asymmetric = drawn(5, "friction-asymmetry");
    assert!(asymmetric.iter().any(is_plain), "a load is known to some per cent");
    assert!(!asymmetric.iter().all(is_plain));
    let soft = drawn(6, "presliding");
    assert!(soft.iter().filter(|drawn| drawn.truth.visible[0] >= 1.25).count() > 2);
    for drawn in soft {
        let PlantEffect::Friction(friction) = drawn.truth.forms[0] else { panic!("{:?}", drawn.truth.forms) };
        let share = friction.stiffness_n_per_m / drawn.file.machine.oil_spring_n_per_m();
        // Plain friction does not reproduce what soft bristles show.
        let shows = drawn.truth.visible[0] >= 1.25;
        assert!(share > 0.1 || !shows || !is_plain(&drawn), "{share}");
    }
    let lot = Lot { hard: true, ..lot(Concealed::Single, 5, &["internal-leakage"]) };
    assert_eq!(draw(&lot, 0).unwrap().unwrap().truth.plainer, [None]);
}
