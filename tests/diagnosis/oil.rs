//! Recordings in oil of a measured temperature, each in warmer oil than the one before.

use model_core::machine::Parameter as P;
use recording::{Recording, Signal};
use virtual_plant::PlantEffect;
use virtual_plant::concealed::{Concealed, Lot, draw};

use super::bed::{Case, accepted};

fn mean_oil_c(recording: &Recording) -> f64 {
    let read = recording.signal(Signal::OilTemperature).unwrap();
    read.iter().sum::<f64>() / read.len() as f64
}

#[test]
fn oil_that_thins_from_recording_to_recording_is_named_with_its_loss_per_kelvin() {
    let only = vec!["oil-temperature".to_owned()];
    let lot = Lot { seed: 11, concealed: Concealed::Single, hard: false, only, thermometer: true };
    let drawn = draw(&lot, 0).unwrap().unwrap();
    let case = Case::of(&drawn);
    let (training, diagnosis) = (&case.training, case.diagnose());
    let [PlantEffect::OilGrade(oil)] = drawn.truth.forms[..] else { panic!("{:?}", drawn.truth.forms) };
    let put_in = oil.mean_loss_per_k(mean_oil_c(&training[0]), mean_oil_c(&training[training.len() - 1]));
    let found = diagnosis.machine_after.get(P::ViscosityLossPerKelvin);
    println!("{put_in:.4} 1/K, found {found:.4}");
    assert_eq!(accepted(&diagnosis), "oil-temperature");
    assert!((found / put_in - 1.0).abs() < 0.15, "{put_in} 1/K, found {found}");
}
