//! What a drawn case has to be.

use model_core::parameter::Parameter as P;

use super::*;

fn lot(concealed: Concealed, seed: u64, only: &[&str]) -> Lot {
    Lot { seed, concealed, hard: seed % 2 == 1, only: only.iter().map(|name| (*name).to_owned()).collect() }
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
    for (index, name) in VOCABULARY.iter().chain(&ON_REQUEST).chain(&OUTSIDE).enumerate() {
        let outside = name.starts_with('~');
        let mut found = false;
        for index in (0..6).map(|k| 10 * index as u64 + k) {
            let (concealed, only) =
                if outside { (Concealed::Outside, vec![]) } else { (Concealed::Single, vec![*name]) };
            let Some(drawn) = draw(&lot(concealed, 4, &only), index).unwrap() else { continue };
            if drawn.truth.effects != [*name] {
                continue;
            }
            for (file, recording) in &drawn.recordings {
                let stroke_m = drawn.file.machine.get(P::Stroke);
                assert!(recording.len() > 700, "{name} {file}");
                assert!(
                    recording.truth.iter().all(|state| (0.0..=stroke_m).contains(&state.position_m)
                        && state.pressure_a_pa.is_finite()
                        && state.spool.is_finite()),
                    "{name} {file}"
                );
            }
            assert!(drawn.truth.visible.iter().all(|visible| *visible >= 1.0));
            found = true;
            break;
        }
        assert!(found, "{name}");
    }
}

#[test]
fn an_effect_that_the_noise_hides_may_be_left_out() {
    let mut truth = draw(&lot(Concealed::None, 4, &[]), 0).unwrap().unwrap().truth;
    assert!(truth.effects.is_empty());
    assert_eq!(truth.accept(), [Vec::<&str>::new()]);
    truth.effects = vec!["end-stop", "null-drift"];
    truth.visible = vec![1.1, 3.0];
    assert_eq!(truth.accept(), [vec!["end-stop", "null-drift"], vec!["null-drift"]]);
}
