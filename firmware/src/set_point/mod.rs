//! Set points over time: steps, ramps and trajectories, as legs that follow one another.
//!
//! A leg leads from where the last one ended to its own end:
//!
//! ```text
//! jump     the position at once, velocity 0: a raw step
//! line     constant velocity: a ramp
//! smooth   r(s) = 10·s³ − 15·s⁴ + 6·s⁵, velocity 30·s²·(1 − s)²/T: from rest to rest, without a jump of the acceleration
//! ```
//!
//! A step within limits of velocity and acceleration is a smooth leg that is just long enough: its velocity is at most 1.875/T and its
//! acceleration at most 10/√3/T², times its way. Everything is checked when a [`Course`] is made of the legs; a period's set
//! point then takes a few multiplications, and is exact to 1e-8 of the stroke.
//!
//! Set points that come from elsewhere are checked from tick to tick ([`Envelope`]).

mod envelope;
mod refused;
mod stretch;

use heapless::Vec;
use model_core::machine::Bases;
use model_core::number::{Number, PerUnit};

use stretch::{Shape, Stretch};

pub use envelope::{Envelope, Followed, Refusal};
pub use model_core::control::SetPoint;
pub use refused::SetPointError;

/// Permitted set points, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bounds {
    /// Least position, m.
    pub from_m: f64,
    /// Largest position, m.
    pub to_m: f64,
    /// Largest velocity, both signs, m/s; a jump in a course has none.
    pub velocity_m_per_s: f64,
    /// Largest acceleration, both signs, m/s²: of a smooth leg, and from tick to tick of what a period is given.
    pub acceleration_m_per_s2: f64,
}

/// One leg as an engineer states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Leg {
    /// To a position at once. A period refuses it: no bound of acceleration permits it.
    Jump {
        /// Target, m.
        to_m: f64,
    },
    /// To a position at constant velocity. A period refuses it where its velocity, within a tick, is more than the acceleration permits.
    Line {
        /// Target, m.
        to_m: f64,
        /// In which time, s.
        duration_s: f64,
    },
    /// To a position, from rest to rest.
    Smooth {
        /// Target, m.
        to_m: f64,
        /// In which time, s.
        duration_s: f64,
    },
    /// To a position from rest to rest, as fast as the bounds permit.
    Fastest {
        /// Target, m.
        to_m: f64,
    },
    /// Stays at its position.
    Rest {
        /// For which time, s.
        duration_s: f64,
    },
}

/// Longest leg, s.
const LONGEST_S: f64 = 3600.0;
/// Ratio of the largest velocity of a smooth leg to its mean.
const PEAK_VELOCITY: f64 = 1.875;
/// Largest acceleration of a smooth leg, times the square of its duration, divided by its way: 10/√3.
const PEAK_ACCELERATION: f64 = 5.773_502_691_896_258;
/// Factor by which the shortest leg within a bound may exceed it: the rounding of its own computation.
const ROUNDED: f64 = 1.0 + 1e-9;

/// At most `LEGS` legs that follow one another: configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Course<const LEGS: usize> {
    stretches: Vec<Stretch, LEGS>,
    end: PerUnit,
}

/// How far a course has got.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CourseState {
    leg: usize,
    tick: u32,
}

impl<const LEGS: usize> Course<LEGS> {
    /// The course along `legs` from `from_m`, where the rod must be when it begins.
    ///
    /// # Errors
    /// There are too many legs, or one leaves the bounds; the error says which.
    pub fn new(bases: &Bases, bounds: &Bounds, from_m: f64, legs: &[Leg]) -> Result<Self, SetPointError> {
        bounds.check(bases)?;
        bounds.position(0, from_m)?;
        let mut stretches = Vec::new();
        let mut at_m = from_m;
        for (index, leg) in legs.iter().enumerate() {
            let stretch = bounds.stretch(bases, index, at_m, *leg)?;
            at_m = leg.to_m().unwrap_or(at_m);
            stretches.push(stretch).map_err(|_| SetPointError::TooMany { found: legs.len(), room: LEGS })?;
        }
        Ok(Self { stretches, end: PerUnit::saturated(at_m / bases.stroke_m) })
    }

    /// Returns the set point of this period, and moves on to the next. After the last leg: its end, at rest.
    pub fn step(&self, state: &mut CourseState) -> SetPoint {
        while let Some(stretch) = self.stretches.get(state.leg) {
            if state.tick < stretch.ticks {
                let set_point = stretch.at(state.tick);
                state.tick += 1;
                return set_point;
            }
            *state = CourseState { leg: state.leg + 1, tick: 0 };
        }
        SetPoint { position: self.end, velocity: PerUnit::ZERO }
    }

    /// Whether the course has ended.
    #[must_use]
    pub fn is_done(&self, state: &CourseState) -> bool {
        state.leg >= self.stretches.len()
    }

    /// Length, ticks.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.stretches.iter().map(|stretch| u64::from(stretch.ticks)).sum()
    }
}

impl Leg {
    fn to_m(self) -> Option<f64> {
        match self {
            Leg::Jump { to_m } | Leg::Line { to_m, .. } | Leg::Smooth { to_m, .. } | Leg::Fastest { to_m } => {
                Some(to_m)
            }
            Leg::Rest { .. } => None,
        }
    }
}

impl Bounds {
    fn check(&self, bases: &Bases) -> Result<(), SetPointError> {
        let stretch = 0.0 <= self.from_m && self.from_m < self.to_m && self.to_m <= bases.stroke_m;
        let moves = self.velocity_m_per_s > 0.0 && self.acceleration_m_per_s2 > 0.0;
        if stretch && moves { Ok(()) } else { Err(SetPointError::Bounds(*self)) }
    }

    fn position(&self, leg: usize, to_m: f64) -> Result<(), SetPointError> {
        if (self.from_m..=self.to_m).contains(&to_m) {
            return Ok(());
        }
        Err(SetPointError::Position { leg, to_m, from_m: self.from_m, most_m: self.to_m })
    }

    fn stretch(&self, bases: &Bases, index: usize, from_m: f64, leg: Leg) -> Result<Stretch, SetPointError> {
        let to_m = leg.to_m().unwrap_or(from_m);
        self.position(index, to_m)?;
        let way_m = to_m - from_m;
        let (shape, duration_s) = match leg {
            Leg::Jump { .. } => (Shape::Jump, bases.tick_s),
            Leg::Line { duration_s, .. } | Leg::Rest { duration_s } => (Shape::Line, duration_s),
            Leg::Smooth { duration_s, .. } => (Shape::Smooth, duration_s),
            Leg::Fastest { .. } => (Shape::Smooth, self.shortest_s(way_m).max(bases.tick_s)),
        };
        let ticks = ticks(index, duration_s, bases.tick_s)?;
        // Whole ticks, and not shorter than requested: within the bounds wherever the requested duration is.
        let mean_m_per_s = way_m / (f64::from(ticks) * bases.tick_s);
        let velocity_m_per_s = match shape {
            Shape::Jump => 0.0,
            Shape::Line => mean_m_per_s.abs(),
            Shape::Smooth => PEAK_VELOCITY * mean_m_per_s.abs(),
        };
        if velocity_m_per_s > ROUNDED * self.velocity_m_per_s {
            return Err(SetPointError::Velocity { leg: index, velocity_m_per_s, most_m_per_s: self.velocity_m_per_s });
        }
        let acceleration_m_per_s2 = match shape {
            Shape::Smooth => PEAK_ACCELERATION * mean_m_per_s.abs() / (f64::from(ticks) * bases.tick_s),
            Shape::Jump | Shape::Line => 0.0,
        };
        if acceleration_m_per_s2 > ROUNDED * self.acceleration_m_per_s2 {
            let most_m_per_s2 = self.acceleration_m_per_s2;
            return Err(SetPointError::Acceleration { leg: index, acceleration_m_per_s2, most_m_per_s2 });
        }
        Ok(Stretch {
            shape,
            from: PerUnit::saturated(from_m / bases.stroke_m),
            way: PerUnit::saturated(way_m / bases.stroke_m),
            velocity: PerUnit::saturated(mean_m_per_s / bases.velocity_m_per_s),
            ticks,
            inverse: (1 << 60) / u64::from(ticks),
        })
    }

    /// Shortest duration of a smooth leg within the bounds.
    fn shortest_s(&self, way_m: f64) -> f64 {
        let way_m = way_m.abs();
        let by_acceleration_s = libm::sqrt(PEAK_ACCELERATION * way_m / self.acceleration_m_per_s2);
        (PEAK_VELOCITY * way_m / self.velocity_m_per_s).max(by_acceleration_s)
    }
}

fn ticks(leg: usize, duration_s: f64, tick_s: f64) -> Result<u32, SetPointError> {
    let found = libm::ceil(duration_s / tick_s - 1e-6);
    if !(found >= 1.0 && duration_s <= LONGEST_S) {
        return Err(SetPointError::Duration { leg, duration_s });
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 7.2 million")]
    Ok(found as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn bases() -> Bases {
        Bases {
            pressure_pa: 7e6,
            velocity_m_per_s: 0.2,
            flow_m3_per_s: 6e-4,
            force_n: 2.2e4,
            stroke_m: 0.3,
            command_v: 10.0,
            pump_speed_rev_per_s: 50.0,
            temperature_c: 25.0,
            tick_s: 1e-3,
        }
    }

    pub(super) const BOUNDS: Bounds =
        Bounds { from_m: 0.01, to_m: 0.29, velocity_m_per_s: 0.05, acceleration_m_per_s2: 0.5 };

    fn course(legs: &[Leg]) -> Result<Course<4>, SetPointError> {
        Course::new(&bases(), &BOUNDS, 0.1, legs)
    }

    #[test]
    fn a_smooth_leg_is_half_way_at_half_time_and_its_velocity_is_the_slope_of_its_position() {
        let course = course(&[Leg::Smooth { to_m: 0.2, duration_s: 4.0 }]).unwrap();
        let mut state = CourseState::default();
        let points: std::vec::Vec<SetPoint> = (0..4001).map(|_| course.step(&mut state)).collect();
        assert!((points[2000].position.to_f64() * 0.3 - 0.15).abs() < 1e-8);
        assert!((points[4000].position.to_f64() * 0.3 - 0.2).abs() < 1e-8 && course.is_done(&state));
        for k in 1..4000 {
            let slope_m_per_s = 0.3 * (points[k + 1].position.to_f64() - points[k - 1].position.to_f64()) / 2e-3;
            let velocity_m_per_s = 0.2 * points[k].velocity.to_f64();
            assert!((slope_m_per_s - velocity_m_per_s).abs() < 5e-6, "{k}: {slope_m_per_s} {velocity_m_per_s}");
        }
    }

    #[test]
    fn the_fastest_leg_touches_a_bound_and_passes_none() {
        let course = course(&[Leg::Fastest { to_m: 0.25 }, Leg::Fastest { to_m: 0.249 }]).unwrap();
        let mut state = CourseState::default();
        let mut before = course.step(&mut state);
        let (mut fastest, mut hardest) = (0.0_f64, 0.0_f64);
        while !course.is_done(&state) {
            let now = course.step(&mut state);
            fastest = fastest.max(0.2 * now.velocity.to_f64().abs());
            hardest = hardest.max(0.2 * (now.velocity.to_f64() - before.velocity.to_f64()).abs() / 1e-3);
            before = now;
        }
        assert!(fastest < 0.05 * (1.0 + 1e-6) && fastest > 0.05 * 0.999, "{fastest}");
        assert!(hardest < 0.5 * 1.001 && hardest > 0.4, "{hardest}");
    }

    #[test]
    fn the_fastest_leg_is_never_refused_for_its_own_rounding() {
        for millimetres in 20..280 {
            let to_m = 1e-3 * f64::from(millimetres);
            assert!(course(&[Leg::Fastest { to_m }]).is_ok(), "{to_m}");
        }
    }

    #[test]
    fn jumps_lines_and_rests_follow_one_another_and_the_end_stays() {
        let legs = [Leg::Line { to_m: 0.11, duration_s: 1.0 }, Leg::Jump { to_m: 0.2 }, Leg::Rest { duration_s: 0.5 }];
        let course = course(&legs).unwrap();
        assert_eq!(course.ticks(), 1501);
        let mut state = CourseState::default();
        let first = course.step(&mut state);
        assert!(
            (first.position.to_f64() * 0.3 - 0.1).abs() < 1e-8 && (0.2 * first.velocity.to_f64() - 0.01).abs() < 1e-8
        );
        let last = (0..5000).map(|_| course.step(&mut state)).last().unwrap();
        assert!((last.position.to_f64() * 0.3 - 0.2).abs() < 1e-8 && last.velocity == PerUnit::ZERO);
    }

    #[test]
    fn what_is_absurd_is_refused_with_its_value() {
        let line = |to_m, duration_s| course(&[Leg::Rest { duration_s: 1.0 }, Leg::Line { to_m, duration_s }]);
        assert!(matches!(line(0.4, 10.0), Err(SetPointError::Position { leg: 1, .. })));
        assert!(matches!(line(f64::NAN, 10.0), Err(SetPointError::Position { leg: 1, .. })));
        assert!(matches!(line(0.2, 0.0), Err(SetPointError::Duration { leg: 1, .. })));
        assert!(matches!(line(0.2, f64::INFINITY), Err(SetPointError::Duration { .. })));
        assert!(matches!(line(0.2, f64::NAN), Err(SetPointError::Duration { .. })));
        assert!(matches!(line(0.2, 1.0), Err(SetPointError::Velocity { leg: 1, .. })));
        let smooth = course(&[Leg::Smooth { to_m: 0.102, duration_s: 0.1 }]);
        assert!(matches!(smooth, Err(SetPointError::Acceleration { leg: 0, .. })), "{smooth:?}");
        let five = course(&[Leg::Rest { duration_s: 1.0 }; 5]);
        assert_eq!(five, Err(SetPointError::TooMany { found: 5, room: 4 }));
        let bounds = Bounds { velocity_m_per_s: f64::NAN, ..BOUNDS };
        assert!(matches!(Course::<4>::new(&bases(), &bounds, 0.1, &[]), Err(SetPointError::Bounds(_))));
    }
}
