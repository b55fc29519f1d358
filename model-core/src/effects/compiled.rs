//! Which effects a step is compiled for: the equations are written once, and a drive without effects spends no time on checks for each of them.
//!
//! A step asks its vocabulary, a type, for the coefficients of each link's effects ([`Knows::of`]). That of a baked drive answers with the constants
//! themselves, so that every branch on an effect is a branch on a constant, in each function by itself, whatever the compiler inlines.

use crate::number::{Mask, Number};

/// A group of effects that a drive may have.
pub(crate) trait Vocabulary: Copy + core::fmt::Debug {
    /// Whether there is none.
    const PLAIN: bool;
    /// Whether the drive is known when the program is compiled: what [`Knows::of`] gives is then constant.
    const KNOWN: bool = false;
    /// Whether a valve may feed the chambers.
    const METERED: bool = true;
    /// Whether a pump may feed them.
    const PUMPED: bool = false;
    /// Whether the oil's viscosity may change.
    const WARMS: bool = false;
    /// Whether a correction table may add to a flow or to the spool.
    const TABLED: bool = false;
    /// Whether viscous friction is too strong for a gain, where this is known.
    const HARD: Option<bool> = None;

    /// What a step remembers of an effect, where it is on.
    fn on<T>(effect: Option<&T>) -> Option<&T>;

    /// Whether a coefficient is known to be 0.
    #[inline]
    fn is_off(coefficient: impl Number) -> bool {
        Self::KNOWN && coefficient.is_nothing().all()
    }
}

/// A vocabulary that has the coefficients `T` of a link's effects.
pub(crate) trait Knows<T: LinkEffects>: Vocabulary {
    /// The coefficients, where there are any; `kept` are those of the link.
    fn of(kept: Option<&T>) -> Option<&T>;

    /// The same where the link has them.
    #[inline]
    fn its(kept: &T) -> &T {
        Self::of(Some(kept)).unwrap_or(kept)
    }
}

/// Coefficients of a link's effects, or a type that keeps none.
pub trait Keeps<T>: Copy {
    /// The coefficients.
    fn kept(&self) -> Option<&T>;
}

/// Coefficients of a link's effects.
pub trait LinkEffects: Copy {}

impl<T: LinkEffects> Keeps<T> for T {
    #[inline]
    fn kept(&self) -> Option<&T> {
        Some(self)
    }
}

impl<T: LinkEffects> Keeps<T> for Option<T> {
    #[inline]
    fn kept(&self) -> Option<&T> {
        self.as_ref()
    }
}

/// No coefficients of effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Nothing;

impl<T> Keeps<T> for Nothing {
    #[inline]
    fn kept(&self) -> Option<&T> {
        None
    }
}

/// No effect: every one is known to be off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain;

/// Any effect may be on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AnyEffect;

impl Vocabulary for Plain {
    const PLAIN: bool = true;

    #[inline]
    fn on<T>(_: Option<&T>) -> Option<&T> {
        None
    }
}

impl<T: LinkEffects> Knows<T> for Plain {
    #[inline]
    fn of(_: Option<&T>) -> Option<&T> {
        None
    }
}

impl Vocabulary for AnyEffect {
    const PLAIN: bool = false;
    const PUMPED: bool = true;
    const WARMS: bool = true;
    const TABLED: bool = true;

    #[inline]
    fn on<T>(effect: Option<&T>) -> Option<&T> {
        effect
    }
}

impl<T: LinkEffects> Knows<T> for AnyEffect {
    #[inline]
    fn of(kept: Option<&T>) -> Option<&T> {
        kept
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use proptest::prelude::*;

    use crate::drive::{Drive, DriveInput, DriveState, Load};
    use crate::machine::{Machine, Parameter as P, Source, Tick};
    use crate::number::{Number, PerUnit};
    use crate::ports::ChamberState;

    fn press(changes: &[(P, f64)]) -> Drive<PerUnit> {
        let mut machine = Machine::with_defaults(Source::Valve);
        let cylinder = [(P::AreaA, 3.117e-3), (P::AreaB, 1.861e-3), (P::VolumeA, 5.2e-4), (P::VolumeB, 3.3e-4)];
        for &(parameter, value) in cylinder.iter().chain(changes) {
            machine.set(parameter, value);
        }
        Drive::new::<64>(&machine, Tick::OneMillisecond).unwrap()
    }

    #[test]
    fn a_drive_with_an_effect_that_the_step_has_to_ask_for_is_not_plain() {
        assert!(press(&[]).plain && press(&[(P::DeadZoneDifference, 0.01), (P::HoseCompliance, 1e-13)]).plain);
        for effect in [
            (P::InternalLeakage, 1e-12),
            (P::CoulombFriction, 100.0),
            (P::AirShare, 0.01),
            (P::HysteresisWidth, 0.01),
            (P::MeteringRatio, 0.1),
            (P::BacklashPlay, 1e-3),
            (P::ViscosityLoss, 0.1),
        ] {
            let drive = press(&[effect]);
            assert!(!drive.plain && drive.without_effects().is_none(), "{effect:?}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn the_step_without_effects_is_the_one_with_all_of_them_off(
            moments in prop::collection::vec((any::<i32>(), 0..28_u32, any::<i32>(), 0..28_u32), 1..12),
            mass_kg in 5.0..500.0_f64, pressures in prop::array::uniform2(-1.0..2.0_f64),
        ) {
            let plain = press(&[(P::MovingMass, mass_kg), (P::DeadZone, 0.05), (P::TimeConstant1, 0.01)]);
            let asking = Drive { plain: false, ..plain };
            let paper = plain.without_effects().unwrap();
            let [a, b] = pressures.map(PerUnit::saturated);
            let mut state: DriveState<PerUnit> = plain.at_rest(PerUnit::ZERO, ChamberState { a, b }, PerUnit::travel(0.5));
            let (mut other, mut alone) = (state, paper.at_rest(PerUnit::ZERO, ChamberState { a, b }, PerUnit::travel(0.5)));
            prop_assert_eq!(state, alone);
            for (command, less, force, weaker) in moments {
                let command = PerUnit::from_bits(command >> less);
                let entry = DriveInput::Command(command);
                let force = PerUnit::from_bits(force >> weaker);
                for _ in 0..60 {
                    let seen = plain.step(&mut state, entry, Load { from: force, to: force });
                    let as_seen = asking.step(&mut other, entry, Load { from: force, to: force });
                    prop_assert_eq!(seen, as_seen);
                    prop_assert_eq!(state, other);
                    prop_assert_eq!(paper.step(&mut alone, command, Load { from: force, to: force }), seen);
                    prop_assert_eq!((alone, paper.sensed(&alone)), (state, plain.sensed(&state)));
                }
            }
        }
    }
}
