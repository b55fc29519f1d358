//! Everything in the table of effects (`model-core/src/effects/mod.rs`) also exists elsewhere. Each assertion says where a new effect is missing.

use std::collections::BTreeSet;

use diagnosis::catalogue::CATALOGUE;
use model_core::effects::Effect;
use virtual_plant::{PlantEffect, concealed};

use super::root;

/// The names of the table that the others do not have.
fn missing<'a>(others: impl IntoIterator<Item = &'a str>) -> Vec<&'static str> {
    let others: BTreeSet<&str> = others.into_iter().collect();
    Effect::ALL.iter().map(|effect| effect.name()).filter(|name| !others.contains(name)).collect()
}

#[test]
fn every_effect_has_a_hypothesis_in_the_same_link() {
    assert_eq!(missing(CATALOGUE.iter().map(|hypothesis| hypothesis.name)), [""; 0], "no file in the catalogue");
    for hypothesis in CATALOGUE {
        let effect = Effect::named(hypothesis.name);
        let effect = effect.unwrap_or_else(|| panic!("{}: not in the table of effects", hypothesis.name));
        assert_eq!(hypothesis.subsystem.to_string(), effect.link().name(), "{}", hypothesis.name);
    }
}

#[test]
fn every_effect_has_a_law_of_its_own_in_the_virtual_plant_and_can_be_drawn() {
    assert_eq!(missing(PlantEffect::known().map(|(name, _)| name)), [""; 0], "the virtual plant does not know it");
    let drawn = concealed::VOCABULARY.iter().chain(&concealed::ON_REQUEST);
    assert_eq!(missing(drawn.copied()), [""; 0], "no concealed case is drawn with it");
}

#[test]
fn every_effect_has_a_section_in_the_book() {
    let text = std::fs::read_to_string(root().join("docs/effects.md")).unwrap();
    let sections = text.lines().filter_map(|line| line.strip_prefix("## "));
    assert_eq!(
        missing(sections),
        [""; 0],
        "docs/effects.md; `RENEW=1 cargo test -p system-tests --test book catalogue` writes it"
    );
}
