//! An effect's parameters, and the forms in which tests switch it on.

use super::parameter::Parameter;
use crate::effects::{Effect, effects};

/// An effect, or something else, switched on: a name, and the values that are set, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    /// The effect's name, with what distinguishes the form where one effect has several.
    pub name: &'static str,
    /// What is set.
    pub values: &'static [(Parameter, f64)],
}

/// What an installed drive has beside the paper's model and that is no effect, on the press of [`Effect::trial`]: the spool as a second-order
/// system, its largest speed, volumes that follow the piston, pressure in the tank line.
pub const BASE_FORMS: &[Form] = &[
    Form { name: "second-order spool", values: &[NO_LAG, NO_SECOND_LAG, NATURAL, DAMPED, LATE] },
    Form {
        name: "second-order spool of limited speed",
        values: &[NO_LAG, NO_SECOND_LAG, NATURAL, DAMPED, LATE, SPEED, (Parameter::SpeedOverdrive, 2.0)],
    },
    Form { name: "second-order spool of limited pull", values: &[NO_LAG, NO_SECOND_LAG, NATURAL, DAMPED, LATE, SPEED] },
    Form { name: "lags and limited speed", values: &[SPEED] },
    Form { name: "volumes that follow the piston", values: &[(Parameter::VolumeFollows, 1.0)] },
    Form { name: "pressure in the tank line", values: &[(Parameter::TankPressure, 3e5)] },
];

const NO_LAG: (Parameter, f64) = (Parameter::TimeConstant1, 0.0);
const NO_SECOND_LAG: (Parameter, f64) = (Parameter::TimeConstant2, 0.0);
const NATURAL: (Parameter, f64) = (Parameter::NaturalFrequency, 25.0);
const DAMPED: (Parameter, f64) = (Parameter::SpoolDamping, 0.6);
/// No whole number of ticks.
const LATE: (Parameter, f64) = (Parameter::TransportDelay, 7.35e-3);
const SPEED: (Parameter, f64) = (Parameter::SpoolSpeedLimit, 8.0);

macro_rules! forms {
    ([] $($effect:ident $name:literal in $link:ident {
        $($parameter:ident: $key:literal, $unit:literal, $min:expr, $max:expr, $default:expr, $meaning:literal;)*
    } trial {
        $($trial:literal: $($tried:ident = $size:expr),*;)*
    } strong {
        $($strong:literal: $($strained:ident = $strength:expr),*;)*
    })*) => {
        impl Effect {
            /// Its parameters, in the order of the machine file.
            #[must_use]
            pub const fn parameters(self) -> &'static [Parameter] {
                match self { $(Effect::$effect => &[$(Parameter::$parameter),*],)* }
            }

            /// Forms of a moderate size, on a 63/40 × 300 mm press: host and target compute the same, and their cost is counted. The first, which
            /// costs most, is part of all effects at once.
            #[must_use]
            pub const fn trial(self) -> &'static [Form] {
                match self {
                    $(Effect::$effect => &[$(Form {
                        name: concat!($name, $trial), values: &[$((Parameter::$tried, $size)),*],
                    }),*],)*
                }
            }

            /// Forms in which an error of the effect's equations would show, on the same press: fixed point is held against `f64`, and one tick
            /// against another.
            #[must_use]
            pub const fn strong(self) -> &'static [Form] {
                match self {
                    $(Effect::$effect => &[$(Form {
                        name: concat!($name, $strong), values: &[$((Parameter::$strained, $strength)),*],
                    }),*],)*
                }
            }
        }
    };
}
effects! { forms => }

#[cfg(test)]
mod tests {
    use super::*;

    /// Every form of an effect.
    fn forms(effect: Effect) -> impl Iterator<Item = &'static Form> {
        effect.trial().iter().chain(effect.strong())
    }

    #[test]
    fn every_effect_has_a_trial_and_a_strong_form_and_each_sets_something_of_its_own() {
        for &effect in Effect::ALL {
            assert!(!effect.trial().is_empty() && !effect.strong().is_empty(), "{}", effect.name());
            for form in forms(effect) {
                assert!(form.values.iter().any(|(parameter, _)| parameter.effect() == Some(effect)), "{}", form.name);
            }
        }
    }

    #[test]
    fn every_parameter_of_an_effect_is_set_in_one_of_its_forms_within_its_range() {
        for &effect in Effect::ALL {
            for parameter in effect.parameters() {
                let set = forms(effect).any(|form| form.values.iter().any(|(set, _)| set == parameter));
                assert!(set, "{}", parameter.description().key);
            }
            for &(parameter, value) in forms(effect).flat_map(|form| form.values) {
                let description = parameter.description();
                assert!((description.min..=description.max).contains(&value), "{} = {value}", description.key);
            }
        }
    }

    #[test]
    fn an_effect_is_found_by_its_name_and_no_other() {
        for &effect in Effect::ALL {
            assert_eq!(Effect::named(effect.name()), Some(effect));
            assert!(effect.parameters().iter().all(|parameter| parameter.effect() == Some(effect)));
        }
        assert_eq!(Effect::named("unnamed"), None);
    }
}
