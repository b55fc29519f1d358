//! Position from an encoder's count, which wraps around and is tracked.
//!
//! An incremental encoder shows only changes. Count 0 is at the reference, unless the rod's position is given ([`Travel::home`]). A change
//! within a period that the rod cannot make is a jump: the count is tracked from there, but the rod's position must be given again.

use model_core::machine::Bases;
use model_core::number::PerUnit;
use model_core::sensing::Linkage;

use super::line::StraightLine;
use super::scale::CalibrationError;

/// Which way the rod moves while the count rises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rising {
    /// Out.
    Extends,
    /// In.
    Retracts,
}

impl Rising {
    fn sign(self) -> i64 {
        match self {
            Rising::Extends => 1,
            Rising::Retracts => -1,
        }
    }
}

/// An encoder that the rod turns in proportion: a rack, a wire, a scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder {
    /// Counts per metre of rod, all edges counted: four per impulse.
    pub counts_per_m: f64,
    /// Which way the rod moves while they rise.
    pub rising: Rising,
    /// Position at the reference, m; 0 is fully in.
    pub reference_m: f64,
    /// Largest speed of the rod, m/s.
    pub fastest_m_per_s: f64,
}

/// Counts since the reference are limited to this, so that the sum with one more change still fits.
const HELD: i64 = 1 << 62;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    /// In proportion.
    Straight {
        line: StraightLine,
        /// Counts over the stroke, and position at count 0 as a share of the stroke: used only when the rod's position is given.
        counts: f64,
        reference: f64,
    },
    /// Through the linkage triangle, with the encoder on its joint.
    Joint(Linkage<PerUnit>),
}

/// From counts to position: configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    way: Way,
    sign: i64,
    /// Largest change of the count in a period.
    most: u32,
}

/// Where the count was, and where it started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TravelState {
    /// Last count.
    count: i32,
    /// Counts since the reference.
    travelled: i64,
    /// Periods since the last count.
    missed: u32,
}

/// The count changed by more than the rod can travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Jump {
    /// By this many counts.
    pub counts: i32,
}

impl Travel {
    /// With an encoder that the rod turns in proportion.
    ///
    /// # Errors
    /// The scale does not fit.
    pub fn straight(encoder: &Encoder, bases: &Bases) -> Result<Self, CalibrationError> {
        let Encoder { counts_per_m: per_m, rising, reference_m, fastest_m_per_s } = *encoder;
        let refused = CalibrationError::Position { per_m, reference_m };
        let steps_per_m = f64::from(1_u32 << 28) / bases.stroke_m;
        let line = StraightLine::new(steps_per_m / per_m, reference_m * steps_per_m).ok_or(refused)?;
        // One count more, because both counts are whole numbers.
        let most = libm::ceil(fastest_m_per_s * bases.tick_s * per_m) + 1.0;
        if !(1.0..f64::from(i32::MAX)).contains(&most) {
            return Err(refused);
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the limits just checked")]
        let most = most as u32;
        let (counts, reference) = (per_m * bases.stroke_m, reference_m / bases.stroke_m);
        Ok(Self { way: Way::Straight { line, counts, reference }, sign: rising.sign(), most })
    }

    /// With the encoder on the joint of the linkage triangle; `rising` says which way the angle grows with the count, and `most` is the
    /// largest change of the count in a period.
    #[must_use]
    pub fn joint(linkage: Linkage<PerUnit>, rising: Rising, most: u32) -> Self {
        Self { way: Way::Joint(linkage), sign: rising.sign(), most }
    }

    /// Tracks from this count on; the reference is at count 0.
    #[must_use]
    pub fn start(count: i32) -> TravelState {
        TravelState { count, travelled: count.into(), missed: 0 }
    }

    /// The position, as a share of the stroke.
    #[must_use]
    pub fn position(&self, state: &TravelState) -> PerUnit {
        let travelled = self.sign * state.travelled;
        match &self.way {
            Way::Straight { line, .. } => PerUnit::from_bits(line.at(travelled)),
            Way::Joint(linkage) => {
                #[expect(clippy::cast_possible_truncation, reason = "held within the type")]
                let counts = travelled.clamp(i32::MIN.into(), i32::MAX.into()) as i32;
                linkage.position(counts)
            }
        }
    }

    /// Sets the rod's present position to `position`, as a share of the stroke. It computes in real numbers: not for a period with an open valve.
    pub fn home(&self, state: &mut TravelState, position: PerUnit) {
        let counts = match &self.way {
            Way::Straight { counts, reference, .. } => (position.to_f64() - reference) * counts,
            Way::Joint(linkage) => linkage.counts(position),
        };
        // A cast from f64 saturates.
        #[expect(clippy::cast_possible_truncation, reason = "rounded to a whole count")]
        let travelled = libm::round(counts) as i64;
        state.travelled = self.sign * travelled.clamp(-HELD, HELD);
    }

    /// A period without a count.
    pub fn miss(state: &mut TravelState) {
        state.missed = state.missed.saturating_add(1);
    }

    /// Whether the rod can have reached this count since the last one.
    #[must_use]
    pub fn admits(&self, state: &TravelState, count: i32) -> bool {
        let most = u64::from(self.most) * (u64::from(state.missed) + 1);
        u64::from(count.wrapping_sub(state.count).unsigned_abs()) <= most
    }

    /// Takes a period's count, and tracks it whatever its value is.
    ///
    /// # Errors
    /// The count changed by more than the rod can travel since the last one.
    pub fn follow(&self, state: &mut TravelState, count: i32) -> Result<(), Jump> {
        let change = count.wrapping_sub(state.count);
        let admitted = self.admits(state, count);
        state.travelled = (state.travelled + i64::from(change)).clamp(-HELD, HELD);
        state.count = count;
        state.missed = 0;
        if admitted { Ok(()) } else { Err(Jump { counts: change }) }
    }
}

#[cfg(test)]
mod tests {
    use model_core::drive::Drive;
    use model_core::machine::{Parameter, Tick};
    use model_core::number::Number;
    use proptest::prelude::*;

    use super::*;
    use crate::mock::press;

    /// 3600 impulses, counted fourfold, on a pinion of 0.2 m circumference.
    fn encoder() -> Encoder {
        Encoder { counts_per_m: 72_000.0, rising: Rising::Extends, reference_m: 0.0, fastest_m_per_s: 0.5 }
    }

    fn travel(encoder: &Encoder) -> Travel {
        let drive = Drive::<PerUnit>::new::<64>(&press(), Tick::OneMillisecond).unwrap();
        Travel::straight(encoder, drive.bases()).unwrap()
    }

    #[test]
    fn a_turn_is_its_circumference_of_the_stroke() {
        let travel = travel(&encoder());
        let mut state = Travel::start(0);
        travel.follow(&mut state, 14_400).unwrap_err();
        assert!((travel.position(&state).to_f64() - 0.2 / 0.3).abs() < 4e-9);
        let retracts = Encoder { rising: Rising::Retracts, reference_m: 0.3, ..encoder() };
        assert!((self::travel(&retracts).position(&state).to_f64() - 0.1 / 0.3).abs() < 4e-9);
    }

    #[test]
    fn more_than_the_rod_can_travel_is_a_jump_that_happens_once() {
        // 0.5 m/s are 36 counts per period, and one more.
        let travel = travel(&encoder());
        let mut state = Travel::start(1000);
        assert_eq!(travel.follow(&mut state, 1037), Ok(()));
        assert_eq!(travel.follow(&mut state, 999), Err(Jump { counts: -38 }));
        assert_eq!(travel.follow(&mut state, 999), Ok(()));
        Travel::miss(&mut state);
        assert_eq!(travel.follow(&mut state, 999 + 74), Ok(()));
    }

    #[test]
    fn on_the_joint_the_linkage_says_the_position() {
        let mut machine = press();
        machine.set(Parameter::EncoderCounts, 14_400.0);
        let linkage = Linkage::<PerUnit>::new(&machine).unwrap();
        let travel = Travel::joint(linkage, Rising::Retracts, 40);
        let mut state = Travel::start(0);
        let _ = travel.follow(&mut state, -2000);
        assert_eq!(travel.position(&state), linkage.position(2000));
    }

    #[test]
    fn a_rod_is_where_somebody_says_it_is_to_half_a_count() {
        let linkage = Linkage::<PerUnit>::new(&press()).unwrap();
        let joint = Travel::joint(linkage, Rising::Retracts, 40);
        let retracts = Encoder { rising: Rising::Retracts, reference_m: 0.3, ..encoder() };
        // A count is 0.005 % of the stroke; on the joint, with 3600 per turn, about 0.27 %.
        for (travel, half_a_count) in [(travel(&retracts), 2.4e-5), (travel(&encoder()), 2.4e-5), (joint, 2.8e-3)] {
            let mut state = Travel::start(12_345);
            for percent in [0.0, 25.0, 60.0, 100.0] {
                travel.home(&mut state, PerUnit::saturated(percent / 100.0));
                let found = travel.position(&state).to_f64();
                assert!((found - percent / 100.0).abs() <= half_a_count, "{found} {percent}");
            }
        }
    }

    proptest! {
        #[test]
        fn a_count_that_goes_round_is_followed(from_end in -2000..2000_i32, steps in prop::collection::vec(-37_i32..=37, 1..300)) {
            let travel = travel(&encoder());
            let start = i32::MAX.wrapping_add(from_end);
            let mut state = Travel::start(start);
            travel.home(&mut state, PerUnit::ZERO);
            let (mut count, mut sum) = (start, 0);
            for step in steps {
                count = count.wrapping_add(step);
                sum += step;
                prop_assert_eq!(travel.follow(&mut state, count), Ok(()));
                prop_assert!((travel.position(&state).to_f64() - f64::from(sum) / 21_600.0).abs() < 4e-9);
            }
        }

        #[test]
        fn no_count_is_too_far(counts in prop::collection::vec(any::<i32>(), 1..100)) {
            let travel = travel(&encoder());
            let mut state = Travel::start(0);
            for count in counts {
                let _ = travel.follow(&mut state, count);
                let _ = travel.position(&state);
            }
        }
    }
}
