//! How far the machine may deviate from what is commanded and expected: configuration.
//!
//! An engineer states it in SI units ([`Deviation`]), by a rule from the machine's own values or by hand; the period has it per unit and in
//! periods ([`DeviationLimits`]). A healthy drive has a following error too. The rule's limits lie above what such a drive shows whose values
//! are off by [`OFF`], and last as long as the part that is judged needs to answer:
//!
//! | limit | by | for |
//! |---|---|---|
//! | following error | first jump + [`OFF`]·velocity/process gain + the encoder's step | the process loop's lag, 2/(3·process gain) |
//! | velocity error | [`OFF`]·velocity + first jump/lag | the same |
//! | spool | 1/10 of its travel at the largest command + 0.05 | lags and delay of the valve |
//! | range | the bounds of the set points, wider by the following error | – |
//! | rest | the following error | twice lags and delay of the valve |

use fixed::types::I4F28;
use model_core::control::Tuning;
use model_core::machine::{Bases, Machine, Parameter as P};
use model_core::number::{Number, PerUnit};

use super::fault::Response;
use super::limits::{Delay, LimitsError, patience, signal};
use super::stuck_sensor::Patience;
use crate::set_point::Bounds;

/// Share by which a value of a healthy drive may differ from the model's: gain of the flow, friction, lags.
pub const OFF: f64 = 0.3;
/// Share by which the spool's travel per volt may differ, and travel for zero, hysteresis and sensor.
const SPOOL_GAIN_OFF: f64 = 0.1;
const SPOOL_ZERO_OFF: f64 = 0.05;

/// Positions of the rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Least, m.
    pub from_m: f64,
    /// Largest, m.
    pub to_m: f64,
}

/// Permitted deviation, as an engineer states it; `None` is not watched. Position, velocity and spool may deviate by a multiple of their limits for the
/// same fraction of their times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// How long the measured position may be farther than so many m from the set point.
    pub position: Option<Delay>,
    /// How long the rod's velocity may differ by more than so many m/s from the set point's.
    pub velocity: Option<Delay>,
    /// How long the measured spool may differ by more than this from the valve's model under the same command, as a share of full travel.
    pub spool: Option<Delay>,
    /// Where the rod may be while it is controlled: within the end positions, with a margin. A rod that begins outside may come in.
    pub range: Option<Reach>,
    /// How far the rod may move, m, once the valve has been neutral for so long, s. In mode starting, only while its place is known: before, somebody
    /// may push it to its reference.
    pub rest: Option<Delay>,
    /// What the monitor's alarm leads to; `None` ignores it, as for recording a drive that is to be diagnosed.
    pub alarm: Option<Response>,
}

impl Deviation {
    /// Nothing is watched. For tests of other parts; no machine should be moved with it.
    pub const UNWATCHED: Self =
        Self { position: None, velocity: None, spool: None, range: None, rest: None, alarm: None };

    /// Limits by rule. The bounds must be such as the machine reaches with its values off by [`OFF`]: a healthy rod that is wanted faster than it can move
    /// has a following error. For a valve-controlled machine under this tuning, these set points, and a first set point that may be `jump_m` away.
    ///
    /// A tuning without a process gain, or a machine without lags, gives limits that [`super::Limits::new`] refuses: state them by hand.
    #[must_use]
    pub fn by_rule(machine: &Machine<f64>, tuning: &Tuning, bounds: &Bounds, jump_m: f64) -> Self {
        let per_s = tuning.process_gain_per_s;
        let lag_s = 2.0 / (3.0 * per_s);
        let valve_s = machine.spool_lag_s() + machine.get(P::TransportDelay);
        let slip_m_per_s = OFF * bounds.velocity_m_per_s;
        let off_m = jump_m + slip_m_per_s / per_s + tuning.position_resolution_m;
        let travel = (machine.get(P::ValveGain) * tuning.command_limit_v).abs();
        Self {
            position: Some(Delay { by: off_m, for_s: lag_s }),
            velocity: Some(Delay { by: slip_m_per_s + jump_m / lag_s, for_s: lag_s }),
            spool: Some(Delay { by: SPOOL_GAIN_OFF * travel + SPOOL_ZERO_OFF, for_s: valve_s }),
            range: Some(Reach { from_m: bounds.from_m - off_m, to_m: bounds.to_m + off_m }),
            rest: Some(Delay { by: off_m, for_s: 2.0 * valve_s }),
            alarm: Some(Response::RampDown),
        }
    }
}

/// Permitted deviation in the period: per unit, times in periods. A limit is passed when what exceeds it lasts for longer than its periods; twice
/// the limit may last half as long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviationLimits {
    /// Following error, of the stroke.
    pub position: Option<Patience>,
    /// Slope of the following error, strokes in a period.
    pub velocity: Option<Patience>,
    /// Spool, of full travel.
    pub spool: Option<Patience>,
    /// Least and largest position, of the stroke.
    pub range: Option<[PerUnit; 2]>,
    /// Way of the rod at neutral, of the stroke.
    pub rest: Option<Patience>,
    /// What the monitor's alarm leads to.
    pub alarm: Option<Response>,
    /// Share of the slope's filter in a period: its time is half of that for which the velocity may deviate.
    pub(super) share: I4F28,
}

impl DeviationLimits {
    /// From what is stated.
    ///
    /// # Errors
    /// A limit does not fit, or the range is empty.
    pub fn new(stated: &Deviation, bases: &Bases) -> Result<Self, LimitsError> {
        let Bases { stroke_m, tick_s, .. } = *bases;
        let range = match stated.range {
            None => None,
            Some(Reach { from_m, to_m }) => {
                let [from, to] = [signal("range.from_m", from_m, stroke_m)?, signal("range.to_m", to_m, stroke_m)?];
                if from >= to {
                    return Err(LimitsError::Range { from, to });
                }
                Some([from, to])
            }
        };
        // As long as the deviation may last, so that a step of the encoder is no velocity; at least one period.
        let filter_s = stated.velocity.map_or(0.0, |delay| 0.5 * delay.for_s);
        let share = if filter_s > tick_s { 1.0 - libm::exp(-tick_s / filter_s) } else { 1.0 };
        Ok(Self {
            position: patience("position error", stated.position, stroke_m, tick_s)?,
            velocity: patience("velocity error", stated.velocity, stroke_m / tick_s, tick_s)?,
            spool: patience("spool's deviation", stated.spool, 1.0, tick_s)?,
            range,
            rest: patience("rest", stated.rest, stroke_m, tick_s)?,
            alarm: stated.alarm,
            share: PerUnit::saturated(share).as_gain(),
        })
    }

    /// Whether each limit, where there is one, is above 0.
    pub(super) fn check(&self) -> Result<(), LimitsError> {
        let limits = [
            ("position error", self.position),
            ("velocity error", self.velocity),
            ("spool's deviation", self.spool),
            ("rest", self.rest),
        ];
        let refused = limits.into_iter().filter_map(|(name, limit)| Some((name, limit?.travel)));
        match refused.into_iter().find(|&(_, value)| value <= PerUnit::ZERO) {
            Some((name, value)) => Err(LimitsError::NotPositive { name, value }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use model_core::drive::Drive;
    use model_core::machine::Tick;

    use super::*;
    use crate::app::press;

    fn limits(tuning: &Tuning) -> Result<DeviationLimits, LimitsError> {
        let machine = press::machine();
        let drive = Drive::<PerUnit>::new::<64>(&machine, Tick::OneMillisecond).unwrap();
        DeviationLimits::new(&Deviation::by_rule(&machine, tuning, &press::BOUNDS, 1e-3), drive.bases())
    }

    #[test]
    fn the_rule_gives_the_press_the_limits_that_the_documents_state() {
        let limits = limits(&press::tuning(&press::machine())).unwrap();
        let near = |found: Option<Patience>, by: f64, periods| {
            let Patience { travel, periods: found } = found.unwrap();
            assert!((travel.to_f64() / by - 1.0).abs() < 0.01 && found == periods, "{travel:?} {found}");
        };
        near(limits.position, 1.8e-3 / 0.3, 49);
        near(limits.velocity, 31.45e-6 / 0.3, 49);
        near(limits.spool, 0.1031, 53);
        near(limits.rest, 1.8e-3 / 0.3, 106);
        let [from, to] = limits.range.unwrap();
        assert!((from.to_f64() * 300.0 - 8.2).abs() < 0.01 && (to.to_f64() * 300.0 - 291.8).abs() < 0.01);
        assert_eq!(limits.alarm, Some(Response::RampDown));
    }

    #[test]
    fn a_loop_without_gain_has_no_limits_by_rule() {
        let none = Tuning { process_gain_per_s: 0.0, ..press::tuning(&press::machine()) };
        let refused = limits(&none);
        assert!(matches!(refused, Err(LimitsError::DoesNotFit { .. })), "{refused:?}");
    }
}
