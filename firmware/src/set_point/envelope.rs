//! Bounds that hold from tick to tick, for set points that come from elsewhere.
//!
//! With the position y* and the velocity v* of a set point, and the pace p = y* − (y* before), strokes in a period:
//!
//! ```text
//! from ≤ y* ≤ to     |v*| ≤ velocity                       each set point by itself
//! |p| ≤ velocity·T/stroke                                  its position moves no faster than is permitted
//! |p − (p before)| ≤ acceleration·T²/stroke                and changes its pace no faster
//! |v* − (v* before)| ≤ acceleration·T                      nor does the velocity that is stated
//! ```
//!
//! A model that is driven by a command accelerates as its valve permits. Its position and velocity are held within the bounds all the same, and so is the way
//! on which it would come to rest: v*² / (2·acceleration).
//!
//! The first set point, with which following begins or goes on, may be as far from the rod as a stated jump, and begins at rest. Positions that are
//! rounded to a resolution seem to move to and fro by it: the bounds of the paces are wider by 1 and 2 steps of it.

use fixed::types::U16F16;
use model_core::control::SetPoint;
use model_core::machine::Bases;
use model_core::number::{Number, PerUnit};

use super::{Bounds, SetPointError};

/// Rounding of a course's positions, strokes, and of its velocities, of the velocity base.
const ROUNDED_POSITION: f64 = 2e-8;
const ROUNDED_VELOCITY: f64 = 1e-6;

/// Bounds per unit, for set points that come from elsewhere, period by period: configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Envelope {
    from: PerUnit,
    to: PerUnit,
    velocity: PerUnit,
    /// Greatest change of the position in a period, strokes, and the same without any rounding: with more a set point does not brake.
    pace: PerUnit,
    cruise: PerUnit,
    /// Greatest change of that change, and the same without any rounding: by so much a set point brakes.
    turn: PerUnit,
    brake: PerUnit,
    /// Greatest change of the velocity in a period.
    gain: PerUnit,
    /// Velocity, of its base, that one stroke in a period is.
    per_pace: U16F16,
    /// Way, in strokes, on which the velocity base comes to rest.
    stop: U16F16,
}

/// Why a set point is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// Its position or its velocity is outside the bounds.
    Outside,
    /// Its position is farther from the one before than is permitted.
    Jump,
    /// It accelerates more than is permitted.
    Steep,
}

/// The set point that is followed: state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Followed {
    /// The set point, of the stroke and of the velocity base.
    pub at: SetPoint,
    /// Change of its position in the last period, strokes.
    pace: PerUnit,
    /// Whether it is one that was given, and not only the place where the rod was.
    given: bool,
}

impl Envelope {
    /// The envelope of `bounds`, for positions that are rounded to `step_m`; 0 where they are as fine as the format.
    ///
    /// # Errors
    /// The bounds are not valid.
    pub fn new(bounds: &Bounds, bases: &Bases, step_m: f64) -> Result<Self, SetPointError> {
        let Bases { stroke_m, velocity_m_per_s, tick_s, .. } = *bases;
        bounds.check(bases)?;
        // NaN fails this comparison.
        if !(0.0..=stroke_m).contains(&step_m) {
            return Err(SetPointError::Resolution { step_m, most_m: stroke_m });
        }
        let strokes = |metres: f64| PerUnit::saturated(metres / stroke_m);
        let acceleration = bounds.acceleration_m_per_s2;
        let turn_m = acceleration * tick_s * tick_s;
        let rounded_m = ROUNDED_POSITION * stroke_m;
        Ok(Self {
            from: strokes(bounds.from_m),
            to: strokes(bounds.to_m),
            velocity: PerUnit::saturated(bounds.velocity_m_per_s / velocity_m_per_s),
            pace: strokes(bounds.velocity_m_per_s * tick_s + step_m + rounded_m),
            cruise: strokes(bounds.velocity_m_per_s * tick_s),
            turn: strokes(turn_m + 2.0 * (step_m + rounded_m)),
            brake: Ord::max(strokes(turn_m), PerUnit::from_bits(1)),
            gain: PerUnit::saturated(acceleration * tick_s / velocity_m_per_s + ROUNDED_VELOCITY),
            per_pace: PerUnit::steep(stroke_m / (tick_s * velocity_m_per_s)).unwrap_or(U16F16::MAX),
            stop: PerUnit::steep(velocity_m_per_s * velocity_m_per_s / (2.0 * acceleration * stroke_m))
                .unwrap_or(U16F16::MAX),
        })
    }

    /// Whether this set point by itself is permitted.
    #[must_use]
    pub fn admits(&self, set_point: SetPoint) -> bool {
        self.admits_from(self.from, set_point)
    }

    /// The same for one that follows a set point `here`.
    fn admits_from(&self, here: PerUnit, set_point: SetPoint) -> bool {
        let [from, to] = self.bounds_from(here);
        (from..=to).contains(&set_point.position) && set_point.velocity.magnitude() <= self.velocity
    }

    /// The bounds as they are `here`: from outside them a set point may come in, and go no farther out.
    fn bounds_from(&self, here: PerUnit) -> [PerUnit; 2] {
        [Ord::min(self.from, here), Ord::max(self.to, here)]
    }

    /// Whether `wanted` may follow `followed`; the first one may be as far away as `jump`, in strokes.
    ///
    /// # Errors
    /// It may not.
    pub fn next(&self, followed: &Followed, wanted: SetPoint, jump: PerUnit) -> Result<Followed, Refusal> {
        let pace = wanted.position - followed.at.position;
        if !self.admits_from(followed.at.position, wanted) {
            return Err(Refusal::Outside);
        }
        if pace.magnitude() > if followed.given { self.pace } else { jump } {
            return Err(Refusal::Jump);
        }
        let turns = followed.given && (pace - followed.pace).magnitude() > self.turn;
        if turns || (wanted.velocity - followed.at.velocity).magnitude() > self.gain {
            return Err(Refusal::Steep);
        }
        // A jump at the start is no motion that goes on.
        let pace = if followed.given { pace } else { PerUnit::ZERO };
        Ok(Followed { at: wanted, pace, given: true })
    }

    /// The motion of a model that a command drives, after `followed`; `None` where it leaves the bounds, or could not come to rest within them.
    #[must_use]
    pub fn driven(&self, followed: &Followed, motion: SetPoint) -> Option<Followed> {
        let (here, SetPoint { position, velocity }) = (followed.at.position, motion);
        let way = velocity.times(velocity).amplified(self.stop);
        let ends = SetPoint { position: position + velocity.select_positive(way, -way), velocity };
        let within = self.admits_from(here, motion) && self.admits_from(here, ends);
        within.then_some(Followed { at: motion, pace: position - here, given: true })
    }

    /// A period later, where nothing new is wanted: the set point comes to rest at the permitted acceleration, within the bounds.
    #[must_use]
    pub fn braked(&self, followed: &Followed) -> Followed {
        let moved = followed.pace.limited(self.cruise);
        let (pace, here) = (moved - moved.limited(self.brake), followed.at.position);
        let [from, to] = self.bounds_from(here);
        // `clamp` would panic if the bounds were in the wrong order.
        let position = Ord::max(from, Ord::min(to, here + pace));
        // At a bound it stands.
        let pace = if position == here { PerUnit::ZERO } else { pace };
        Followed { at: SetPoint { position, velocity: pace.amplified(self.per_pace) }, pace, ..*followed }
    }
}

impl Followed {
    /// At rest where the rod is; nothing was given yet.
    #[must_use]
    pub const fn resting(position: PerUnit) -> Self {
        let rest = PerUnit::from_bits(0);
        Self { at: SetPoint { position, velocity: rest }, pace: rest, given: false }
    }

    /// Whether it does not move.
    #[must_use]
    pub(crate) fn rests(&self) -> bool {
        self.pace == PerUnit::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::set_point::tests::{BOUNDS, bases};
    use crate::set_point::{Course, CourseState, Leg};

    const STEP_M: f64 = 1e-6;

    fn envelope(step_m: f64) -> Envelope {
        Envelope::new(&BOUNDS, &bases(), step_m).unwrap()
    }

    fn at(position_m: f64, velocity_m_per_s: f64) -> SetPoint {
        SetPoint {
            position: PerUnit::saturated(position_m / 0.3),
            velocity: PerUnit::saturated(velocity_m_per_s / 0.2),
        }
    }

    const JUMP: PerUnit = PerUnit::from_bits((1 << 28) / 300); // 1 mm

    fn given(position_m: f64) -> Followed {
        envelope(0.0).next(&Followed::resting(at(position_m, 0.0).position), at(position_m, 0.0), JUMP).unwrap()
    }

    #[test]
    fn a_set_point_from_elsewhere_is_admitted_within_the_bounds_only() {
        let admits = |position_m, velocity_m_per_s| envelope(0.0).admits(at(position_m, velocity_m_per_s));
        assert!(admits(0.15, -0.049) && admits(0.0101, 0.0));
        assert!(!admits(0.0099, 0.0) && !admits(0.291, 0.0) && !admits(0.15, -0.051) && !admits(-1e9, 0.0));
        let extreme = SetPoint { position: PerUnit::saturated(0.5), velocity: PerUnit::from_bits(i32::MIN) };
        assert!(!envelope(0.0).admits(extreme));
        let refused = Envelope::new(&BOUNDS, &bases(), f64::NAN);
        assert!(matches!(refused, Err(SetPointError::Resolution { .. })), "{refused:?}");
    }

    #[test]
    fn the_first_one_may_jump_and_the_second_may_not() {
        let first = Followed::resting(at(0.15, 0.0).position);
        let jumped = envelope(0.0).next(&first, at(0.1509, 0.0), JUMP).unwrap();
        assert_eq!(envelope(0.0).next(&first, at(0.152, 0.0), JUMP), Err(Refusal::Jump));
        assert_eq!(envelope(0.0).next(&first, at(0.15, 0.02), JUMP), Err(Refusal::Steep));
        assert_eq!(envelope(0.0).next(&jumped, at(0.1518, 0.0), JUMP), Err(Refusal::Jump));
        assert!(envelope(0.0).next(&jumped, at(0.1509, 0.0), JUMP).is_ok());
    }

    /// The first refusal along positions of k ticks each, whose velocities are stated or 0.
    fn refused(envelope: &Envelope, stated: bool, position_m: impl Fn(f64) -> f64) -> Option<Refusal> {
        let mut followed = given(position_m(0.0));
        for tick in 1..300 {
            let [before, now] = [tick - 1, tick].map(|tick| position_m(1e-3 * f64::from(tick)));
            let wanted = at(now, if stated { (now - before) / 1e-3 } else { 0.0 });
            match envelope.next(&followed, wanted, JUMP) {
                Ok(next) => followed = next,
                Err(refusal) => return Some(refusal),
            }
        }
        None
    }

    /// A rod that accelerates to a velocity and keeps it.
    fn accelerating(a: f64, v: f64) -> impl Fn(f64) -> f64 {
        move |t| if a * t < v { 0.1 + 0.5 * a * t * t } else { 0.1 + v * t - 0.5 * v * v / a }
    }

    #[test]
    fn velocity_and_acceleration_are_held_from_tick_to_tick_whether_the_velocity_is_stated_or_not() {
        for stated in [true, false] {
            let found = |a, v| refused(&envelope(0.0), stated, accelerating(a, v));
            assert_eq!(found(0.49, 0.0499), None);
            assert_eq!(found(0.49, 0.06), Some(if stated { Refusal::Outside } else { Refusal::Jump }));
            assert_eq!(found(0.55, 0.04), Some(Refusal::Steep));
        }
        // A ramp that begins at once.
        assert_eq!(refused(&envelope(0.0), false, |t| 0.1 + 0.04 * t), Some(Refusal::Steep));
    }

    #[test]
    fn positions_in_whole_steps_pass_where_their_step_is_stated() {
        let stepped = |t: f64| (accelerating(0.45, 0.045)(t) / STEP_M).round() * STEP_M;
        assert_eq!(refused(&envelope(STEP_M), false, stepped), None);
        assert_eq!(refused(&envelope(0.0), false, stepped), Some(Refusal::Steep));
    }

    #[test]
    fn a_coarse_step_is_no_pace_to_brake_from() {
        let coarse = envelope(1e-4);
        let moved = coarse.next(&given(0.15), at(0.1501, 0.0), JUMP).unwrap();
        let mut followed = moved;
        while !followed.rests() {
            followed = coarse.braked(&followed);
        }
        // 50 mm/s are permitted and 0.5 m/s²: 2.5 mm, where 100 mm/s would take 10.
        let ran_m = (followed.at.position - moved.at.position).to_f64() * 0.3;
        assert!(ran_m < 2.6e-3, "{ran_m}");
    }

    #[test]
    fn a_rod_outside_its_bounds_is_led_in_and_not_farther_out() {
        let here = Followed::resting(at(0.292, 0.0).position);
        assert_eq!(envelope(0.0).next(&here, at(0.2925, 0.0), JUMP), Err(Refusal::Outside));
        let mut followed = envelope(0.0).next(&here, at(0.292, 0.0), JUMP).unwrap();
        for tick in 1..200 {
            let t = 1e-3 * f64::from(tick);
            followed = envelope(0.0)
                .next(&followed, at(0.292 - 0.2 * t * t, 0.0), JUMP)
                .unwrap_or_else(|refusal| panic!("{tick}: {refusal:?}"));
            if 0.4 * t > 0.045 {
                break;
            }
        }
        assert!(followed.at.position < at(0.29, 0.0).position);
        assert_eq!(envelope(0.0).next(&followed, at(0.2921, 0.0), JUMP), Err(Refusal::Outside));
    }

    #[test]
    fn no_smooth_leg_within_the_bounds_is_refused() {
        for millimetres in [20.0, 101.0, 137.0, 290.0] {
            let legs = [Leg::Fastest { to_m: 1e-3 * millimetres }, Leg::Fastest { to_m: 0.15 }];
            let course = Course::<2>::new(&bases(), &BOUNDS, 0.1, &legs).unwrap();
            let (mut state, mut followed) = (CourseState::default(), given(0.1));
            while !course.is_done(&state) {
                followed = envelope(0.0).next(&followed, course.step(&mut state), JUMP).unwrap();
            }
        }
    }

    #[test]
    fn a_driven_model_is_followed_as_long_as_it_could_come_to_rest_within_the_bounds() {
        // 50 mm/s are permitted, and 0.5 m/s²: 40 mm/s take 1.6 mm.
        let driven = |position_m, velocity_m_per_s| {
            envelope(0.0).driven(&given(0.15), at(position_m, velocity_m_per_s)).is_some()
        };
        assert!(driven(0.2883, 0.04) && !driven(0.2885, 0.04) && driven(0.2885, -0.04));
        assert!(driven(0.0117, -0.04) && !driven(0.0115, -0.04) && driven(0.0115, 0.04));
        assert!(driven(0.15, 0.0499) && !driven(0.15, 0.0501) && !driven(0.15, -0.0501));
        assert!(!driven(0.2901, 0.0) && !driven(1e9, 1e9) && !driven(-1e9, -1e9));
        // It brakes from where and as fast as the model was.
        let mut followed = envelope(0.0).driven(&given(0.15), at(0.150_03, 0.03)).unwrap();
        while !followed.rests() {
            followed = envelope(0.0).braked(&followed);
        }
        let ran_m = followed.at.position.to_f64() * 0.3 - 0.150_03;
        assert!((ran_m - 0.9e-3).abs() < 0.05e-3, "{ran_m}");
    }

    #[test]
    fn what_is_no_longer_given_comes_to_rest_at_the_permitted_acceleration_and_within_the_bounds() {
        for (from_m, ends_m) in [(0.15, 0.152_0), (0.2895, 0.29)] {
            // 45 mm/s; v²/2a is 2.03 mm with the 0.5 m/s² that are permitted.
            let pace = PerUnit::saturated(0.045e-3 / 0.3);
            let mut followed = Followed { pace, ..given(from_m) };
            let mut ticks = 0;
            while followed.pace != PerUnit::ZERO {
                let next = envelope(0.0).braked(&followed);
                assert!(
                    (followed.pace - next.pace).magnitude() <= envelope(0.0).brake
                        || next.at.position == at(0.29, 0.0).position
                );
                followed = next;
                ticks += 1;
            }
            let position_m = followed.at.position.to_f64() * 0.3;
            std::println!("{position_m:.6} m after {ticks} ticks");
            assert!((position_m - ends_m).abs() < 0.05e-3, "{position_m}");
            // At a bound it stands as soon as it is there.
            assert!(if from_m < 0.2 { (90..=91).contains(&ticks) } else { ticks < 20 }, "{ticks}");
            assert_eq!(followed.at.velocity, PerUnit::ZERO);
        }
    }
}
