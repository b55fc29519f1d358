//! Does the machine do what it is told? State and check, once a period.
//!
//! ```text
//! e  = y − y*                        following error: measured position less the set point that was followed
//! s' = s + share·((e − e before) − s)    velocity error, strokes in a period: the slope of e, filtered
//! |e|, |s|, |x − x̂|                  beyond its limit: its sum over these periods exceeds limit·time: a fault
//! y                                  outside its range: a fault at once
//! |y − (y when the valve had closed)|    at neutral
//! ```
//!
//! So a deviation that is just beyond its limit may last for the limit's time, one of four times the limit for a quarter of it.
//!
//! x̂ is the valve's model under the command that the valve really got, not the reference model's spool: the process loop may open a healthy
//! valve further than the model's.

use model_core::number::{Number, PerUnit};

use super::deviation::DeviationLimits;
use super::fault::Fault;
use super::sense::apart;
use super::stuck_sensor::Patience;

/// What is known in a period in which the valve is commanded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Now {
    /// Measured position, of the stroke.
    pub(crate) position: PerUnit,
    /// Position of the set point that was followed; `None` while the command ramps down.
    pub(crate) wanted: Option<PerUnit>,
    /// Measured spool less that of the valve's model, where there are both.
    pub(crate) spool_off: Option<PerUnit>,
}

/// After so many periods a rod at rest is judged from where it is then: a leaking valve lets it creep, 10 s a limit at a period of a millisecond.
const RENEWED: u16 = 10_000;

/// What the check remembers from period to period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Deviating {
    /// Following error of the last period, and its filtered slope.
    error: Option<PerUnit>,
    slope: PerUnit,
    /// Each deviation's sum over the successive periods in which it is beyond its limit, in steps of the format.
    position: i64,
    velocity: i64,
    spool: i64,
    /// Where the rod may be: the range, and where it began.
    range: [PerUnit; 2],
    /// Periods at neutral, and where the rod was when the valve had closed.
    neutral: u16,
    rested: Option<PerUnit>,
}

/// Sums up what is beyond a limit; returns whether it is too much, and whatever its size after the limit's time.
fn lasts(sum: &mut i64, patience: Patience, off: PerUnit) -> bool {
    let off = off.magnitude();
    *sum = if off > patience.travel { sum.saturating_add(off.to_bits().into()) } else { 0 };
    *sum > i64::from(patience.travel.to_bits()) * i64::from(patience.periods)
}

impl Deviating {
    /// Nothing seen yet.
    pub(crate) const NEW: Self = Self {
        error: None,
        slope: PerUnit::from_bits(0),
        position: 0,
        velocity: 0,
        spool: 0,
        range: [PerUnit::from_bits(i32::MIN), PerUnit::from_bits(i32::MAX)],
        neutral: 0,
        rested: None,
    };

    /// Following begins with the rod here; from outside the range it may come in, and move out by `slack` as it settles.
    pub(crate) fn begin(&mut self, limits: &DeviationLimits, position: PerUnit, slack: PerUnit) {
        let [from, to] = limits.range.unwrap_or(Self::NEW.range);
        let range = [Ord::min(from, position - slack), Ord::max(to, position + slack)];
        *self = Self { range, ..Self::NEW };
    }

    /// The set point begins anew: its jump is no velocity. What the rod and the spool are off by has lasted as long as before.
    pub(crate) fn resume(&mut self) {
        let Self { position, spool, range, .. } = *self;
        *self = Self { position, spool, range, ..Self::NEW };
    }

    /// A period in which the valve is commanded; the first deviation beyond its limit, if there is one.
    pub(crate) fn controlled(&mut self, limits: &DeviationLimits, now: &Now) -> Option<Fault> {
        let (Now { position, wanted, spool_off }, [from, to]) = (*now, self.range);
        let error = wanted.map(|wanted| position - wanted);
        if let (Some(error), Some(before)) = (error, self.error) {
            self.slope = self.slope + PerUnit::dot([limits.share], [(error - before) - self.slope]);
        }
        self.error = error;
        // Each is counted in every period, whatever the others show.
        let spool = limits.spool.zip(spool_off).is_some_and(|(limit, off)| lasts(&mut self.spool, limit, off));
        let far = limits.position.zip(error).is_some_and(|(limit, error)| lasts(&mut self.position, limit, error));
        let fast = error.and(limits.velocity).is_some_and(|limit| lasts(&mut self.velocity, limit, self.slope));
        let outside = limits.range.is_some() && !(from..=to).contains(&position);
        match (spool_off, error) {
            (Some(off), _) if spool => Some(Fault::SpoolDeviates { off }),
            (_, Some(off)) if far => Some(Fault::FollowingError { off }),
            _ if fast => Some(Fault::VelocityError { off: self.slope }),
            _ if outside => Some(Fault::PositionOutside { position }),
            _ => None,
        }
    }

    /// A period with the valve at neutral: the rod may creep, but not by the limit within [`RENEWED`] periods; whether the rod may be judged says `judged`.
    pub(crate) fn at_neutral(&mut self, limits: &DeviationLimits, position: PerUnit, judged: bool) -> Option<Fault> {
        let rest = limits.rest.as_ref()?;
        if !judged {
            (self.neutral, self.rested) = (0, None);
            return None;
        }
        self.neutral = self.neutral.saturating_add(1);
        match self.rested {
            Some(rested) if apart(position, rested, rest.travel) => {
                // It is judged anew: a rod that has come to rest can be acknowledged.
                self.displaced();
                Some(Fault::MovesAtNeutral { from: rested, to: position })
            }
            None if self.neutral > rest.periods => {
                (self.neutral, self.rested) = (0, Some(position));
                None
            }
            Some(_) if self.neutral >= RENEWED => {
                (self.neutral, self.rested) = (0, Some(position));
                None
            }
            _ => None,
        }
    }

    /// The rod's position was given, or lost: where it rested is no longer known.
    pub(crate) fn displaced(&mut self) {
        (self.neutral, self.rested) = (0, None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::supervision::deviation::{Deviation, Reach};
    use crate::supervision::limits::Delay;
    use model_core::drive::Drive;
    use model_core::machine::Tick;

    use crate::mock::press;

    /// 3 mm or 60 mm/s for 20 ms, 0.1 of the spool for 5 ms, 15 to 285 mm, 2 mm after 10 ms at neutral.
    fn limits() -> DeviationLimits {
        let drive = Drive::<PerUnit>::new::<64>(&press(), Tick::OneMillisecond).unwrap();
        let delay = |by, for_s| Some(Delay { by, for_s });
        let stated = Deviation {
            position: delay(3e-3, 0.02),
            velocity: delay(0.06, 0.02),
            spool: delay(0.1, 0.005),
            range: Some(Reach { from_m: 0.015, to_m: 0.285 }),
            rest: delay(2e-3, 0.01),
            alarm: None,
        };
        DeviationLimits::new(&stated, drive.bases()).unwrap()
    }

    fn millimetres(position: f64) -> PerUnit {
        PerUnit::saturated(position / 300.0)
    }

    /// The first fault, and the period that tells it, of a rod whose positions and set points are given in mm per period.
    fn told(at: impl Fn(f64) -> (f64, f64), spool_off: Option<f64>) -> Option<(Fault, u32)> {
        let (limits, mut deviating) = (limits(), Deviating::NEW);
        deviating.begin(&limits, millimetres(at(0.0).0), millimetres(1.0));
        (1..500).find_map(|period| {
            let (position, wanted) = at(f64::from(period));
            let now = Now {
                position: millimetres(position),
                wanted: Some(millimetres(wanted)),
                spool_off: spool_off.map(PerUnit::saturated),
            };
            deviating.controlled(&limits, &now).map(|fault| (fault, period))
        })
    }

    #[test]
    fn each_deviation_is_told_after_its_time_and_not_within_its_limit() {
        let far = |by: f64| told(move |_| (150.0, 150.0 + by), None);
        assert!(matches!(far(3.1), Some((Fault::FollowingError { .. }, 20))), "{:?}", far(3.1));
        assert!(matches!(far(-3.1), Some((Fault::FollowingError { off }, 20)) if off > PerUnit::ZERO));
        assert_eq!(far(2.9), None);
        let off = |by| told(|_| (150.0, 150.0), Some(by));
        assert!(matches!(off(-0.11), Some((Fault::SpoolDeviates { .. }, 5))), "{:?}", off(-0.11));
        assert!(
            matches!(off(0.51), Some((Fault::SpoolDeviates { .. }, 1))),
            "five times as much, at once: {:?}",
            off(0.51)
        );
        assert_eq!(off(0.09), None);
        // 0.12 mm in a period are 120 mm/s; the filter of 10 ms needs 7 periods for half of them, then twice the limit lasts half its time.
        let fast = |per_period: f64| told(move |k| (150.0 + per_period * k.min(40.0), 150.0), None);
        let found = fast(0.12);
        assert!(matches!(found, Some((Fault::VelocityError { .. }, 20..=24))), "{found:?}");
        assert_eq!(fast(0.055), None);
    }

    #[test]
    fn a_rod_leaves_its_range_at_once_and_may_come_in_from_outside() {
        let found = told(|k| (280.0 + k, 280.0 + k), None);
        assert!(matches!(found, Some((Fault::PositionOutside { .. }, 6))), "{found:?}");
        assert_eq!(told(|k| (10.0 + 0.1 * k.min(100.0), 10.0 + 0.1 * k.min(100.0)), None), None);
        let out = told(|k| (10.0 - 0.1 * k, 10.0 - 0.1 * k), None);
        assert!(matches!(out, Some((Fault::PositionOutside { .. }, 10..=11))), "{out:?}");
    }

    #[test]
    fn a_step_of_the_encoder_is_no_velocity_and_neither_is_the_first_set_point() {
        assert_eq!(told(|k| (150.0 + 0.5 * (k / 20.0).floor() % 2.0, 150.0), None), None);
        let (limits, mut deviating) = (limits(), Deviating::NEW);
        deviating.begin(&limits, millimetres(150.0), PerUnit::ZERO);
        for period in 0..200 {
            if period == 100 {
                deviating.resume();
            }
            let wanted = Some(millimetres(if period < 100 { 150.0 } else { 152.5 }));
            let now = Now { position: millimetres(150.0), wanted, spool_off: None };
            assert_eq!(deviating.controlled(&limits, &now), None, "{period}");
        }
    }

    #[test]
    fn a_rod_that_moves_with_the_valve_at_neutral_is_told_once_the_valve_had_its_time() {
        let (limits, mut deviating) = (limits(), Deviating::NEW);
        let mut told = |k: f64, judged| deviating.at_neutral(&limits, millimetres(150.0 + 0.1 * k), judged);
        // It runs on at 0.1 mm a period; 10 periods are the valve's.
        let found = (0..60).find(|&k| told(f64::from(k), true).is_some());
        assert_eq!(found, Some(31));
        assert_eq!((0..60).find(|&k| told(f64::from(k), false).is_some()), None, "somebody may push it");
        // 1.5 mm in 10 s, for a minute.
        assert_eq!((0..60_000).find(|&k| told(1.5e-3 * f64::from(k), true).is_some()), None, "it creeps");
    }
}
