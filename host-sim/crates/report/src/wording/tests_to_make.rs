//! The catalogue's tests that tell an effect from others, for the kind of drive at hand.

use std::borrow::Cow;

use diagnosis::catalogue::{CATALOGUE, Hypothesis};
use model_core::machine::Source;

/// What is said of a hydraulic drive, and of a mass that a force moves.
const OF_MASS: [(&str, &str); 3] = [
    ("both pressures recorded", "the force recorded"),
    ("closed-valve hold", "hold"),
    ("a pressure sensor's offset", "the force sensor's offset"),
];

/// The test that is surest to show an effect.
#[must_use]
pub fn separated_by(effect: &Hypothesis, source: Source) -> Cow<'static, str> {
    of(effect.separated_by, source)
}

/// The effects that look alike in such a drive, and by what test each is told apart.
pub fn look_alikes(effect: &Hypothesis, source: Source) -> impl Iterator<Item = (&'static str, Cow<'static, str>)> {
    let is_of =
        move |name: &str| CATALOGUE.iter().find(|known| known.name == name).is_none_or(|known| known.is_of(source));
    let alike = effect.look_alikes.iter().filter(move |other| is_of(other.effect));
    alike.map(move |other| (other.effect, of(other.told_apart_by, source)))
}

fn of(test: &'static str, source: Source) -> Cow<'static, str> {
    if source != Source::Force {
        return test.into();
    }
    OF_MASS.into_iter().fold(test.into(), |test: Cow<'static, str>, (hydraulic, mass)| {
        if test.contains(hydraulic) { test.replace(hydraulic, mass).into() } else { test }
    })
}

#[cfg(test)]
mod tests {
    use model_core::effects::Effect;

    use super::*;

    #[test]
    fn of_a_mass_no_test_asks_for_a_valve_or_a_pressure() {
        for effect in
            CATALOGUE.iter().filter(|effect| effect.is_of(Source::Force) && effect.name != Effect::SensorOffset.name())
        {
            assert!(effect.look_alikes.len() >= look_alikes(effect, Source::Force).count());
            let tests =
                look_alikes(effect, Source::Force).map(|(_, test)| test).chain([separated_by(effect, Source::Force)]);
            for test in tests {
                assert!(
                    !["valve", "pressure", "supply"].iter().any(|word| test.contains(word)),
                    "{}: {test}",
                    effect.name
                );
            }
        }
        assert_eq!(look_alikes(CATALOGUE[0], Source::Valve).count(), CATALOGUE[0].look_alikes.len());
    }
}
