//! Oil under suction: the floor of the pressures is named where it acts, and not where it does not act.

use virtual_plant::concealed::{Concealed, Lot, draw};

use super::bed::{Case, accepted};

#[test]
fn oil_that_is_drawn_on_is_named_and_a_drive_without_it_is_not_called_that() {
    let of = |concealed, only: &[&str]| {
        let only = only.iter().map(|name| (*name).to_owned()).collect();
        let lot = Lot { seed: 1, concealed, hard: false, only, thermometer: false };
        accepted(&Case::of(&draw(&lot, 0).unwrap().unwrap()).diagnose())
    };
    assert_eq!(of(Concealed::Single, &["cavitation"]), "cavitation");
    assert_eq!(of(Concealed::None, &[]), "none");
}
