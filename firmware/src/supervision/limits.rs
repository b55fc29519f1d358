//! Limits of a rig: what is too far, too fast or too long. Configuration.
//!
//! An engineer states them in SI units ([`Allowed`]); the period has them per unit and in periods ([`Limits`]).

use model_core::machine::{Bases, Machine, Parameter};
use model_core::number::{Number, PerUnit};

use super::deviation::{Deviation, DeviationLimits};
use super::stuck_sensor::Patience;
use crate::measured::AnalogSignal;
use crate::set_point::{Bounds, Envelope, SetPointError};

/// How long a deviation may last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delay {
    /// How far the compared value must have moved or differ, in its SI unit.
    pub by: f64,
    /// For how long, s.
    pub for_s: f64,
}

/// Limits of a rig as an engineer states them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowed {
    /// How often a device is asked in a period before it counts as silent; at least once.
    pub attempts: u8,
    /// Time without a fault before the rod follows, s.
    pub settling_s: f64,
    /// Permitted set points.
    pub bounds: Bounds,
    /// How far the first set point may be from the rod when following begins, or from the held set point when it goes on, m. From then on the bounds hold from tick to tick.
    pub jump_m: f64,
    /// Resolution of set points that come from elsewhere, m; 0 where they are as fine as the number format.
    pub set_point_step_m: f64,
    /// Greatest command, both signs, V.
    pub command_v: f64,
    /// Greatest slope of the command while the rod is controlled, V/s.
    pub slew_v_per_s: f64,
    /// Slope of the command while it ramps down, V/s.
    pub ramp_v_per_s: f64,
    /// How long the encoder may stand still while the model's rod moves by so many m.
    pub still_position: Option<Delay>,
    /// How long the spool's sensor may stand still while the model's spool moves by this, as a share of full travel.
    pub still_spool: Option<Delay>,
    /// How long a pressure sensor may stand still while the model's pressure moves by so many Pa.
    pub still_pressure: Option<Delay>,
    /// How long the voltage at the valve may differ by more than so many V from the output, where it is read back.
    pub read_back: Option<Delay>,
    /// How far the machine may deviate from what is commanded and expected.
    pub deviation: Deviation,
}

/// Limits of a rig in the period: per unit, times in periods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// How often a device is asked in a period before it counts as silent; at least once.
    pub attempts: u8,
    /// Periods without a fault before the rod follows.
    pub settling: u16,
    /// Permitted set points.
    pub envelope: Envelope,
    /// Greatest distance of the first set point from the rod, as a share of the stroke.
    pub most_jump: PerUnit,
    /// The command, in units of 10 V, at which the valve passes nothing: the middle of its dead zone, −offset/gain where that is symmetric.
    pub neutral: PerUnit,
    /// Greatest command, both signs, in units of 10 V.
    pub most_command: PerUnit,
    /// Greatest change of the command in a period while the rod is controlled.
    pub slew: PerUnit,
    /// Change of the command in a period while it ramps down.
    pub ramp: PerUnit,
    /// How long the position may stand still; `None` means for ever.
    pub still_position: Option<Patience>,
    /// How long each signal may stand still, in the order of [`AnalogSignal::ALL`]. The model does not compute an oil temperature.
    pub still: [Option<Patience>; AnalogSignal::COUNT],
    /// How far the voltage at the valve may differ from the output, in units of 10 V, and for how long by more; where it is read back.
    pub read_back: Option<Patience>,
    /// How far the machine may deviate from what is commanded and expected.
    pub deviation: DeviationLimits,
}

/// Why limits are not valid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LimitsError {
    /// The bounds of set points are not valid.
    #[error(transparent)]
    SetPoint(#[from] SetPointError),
    /// A limit does not fit its format.
    #[error("{name} = {value:e} in its SI unit: does not fit; expected up to 8 of its base, or 65535 periods")]
    DoesNotFit {
        /// Which.
        name: &'static str,
        /// Its value, in its SI unit.
        value: f64,
    },
    /// A limit that must be above 0 is not.
    #[error("{name} = {value:?}; expected above 0")]
    NotPositive {
        /// Which.
        name: &'static str,
        /// Its value.
        value: PerUnit,
    },
    /// The range of the position is empty.
    #[error("range {from:?} to {to:?}; expected a least position below the largest")]
    Range {
        /// Least position.
        from: PerUnit,
        /// Largest position.
        to: PerUnit,
    },
    /// The neutral command is beyond the greatest one.
    #[error("neutral = {neutral:?}; expected within {most:?}, both signs")]
    Neutral {
        /// Neutral command.
        neutral: PerUnit,
        /// Greatest command.
        most: PerUnit,
    },
}

/// `value` as a signal, relative to this base.
pub(super) fn signal(name: &'static str, value: f64, base: f64) -> Result<PerUnit, LimitsError> {
    PerUnit::signal(value / base).ok_or(LimitsError::DoesNotFit { name, value })
}

/// Periods that last at least so many seconds.
fn periods(name: &'static str, value: f64, tick_s: f64) -> Result<u16, LimitsError> {
    // A time that is a whole number of ticks keeps that number, whatever its last digits are.
    let periods = libm::ceil(value / tick_s - 1e-6);
    if !(0.0..=f64::from(u16::MAX)).contains(&periods) {
        return Err(LimitsError::DoesNotFit { name, value });
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the limits just checked")]
    let periods = periods as u16;
    Ok(periods)
}

pub(super) fn patience(
    name: &'static str,
    delay: Option<Delay>,
    base: f64,
    tick_s: f64,
) -> Result<Option<Patience>, LimitsError> {
    let Some(Delay { by, for_s }) = delay else { return Ok(None) };
    Ok(Some(Patience { travel: signal(name, by, base)?, periods: periods(name, for_s, tick_s)? }))
}

impl Limits {
    /// From the limits that are stated for this machine.
    ///
    /// # Errors
    /// A limit does not fit, or is not valid.
    pub fn new(allowed: &Allowed, machine: &Machine<f64>, bases: &Bases) -> Result<Self, LimitsError> {
        let Bases { stroke_m, command_v, pressure_pa, tick_s, .. } = *bases;
        let middle = 0.5 * machine.get(Parameter::DeadZoneDifference);
        let neutral_v = (middle - machine.get(Parameter::ValveOffset)) / machine.get(Parameter::ValveGain);
        let still_pressure = patience("still_pressure", allowed.still_pressure, pressure_pa, tick_s)?;
        let still_spool = patience("still_slider", allowed.still_spool, 1.0, tick_s)?;
        let limits = Self {
            attempts: allowed.attempts,
            settling: periods("settling_s", allowed.settling_s, tick_s)?,
            envelope: Envelope::new(&allowed.bounds, bases, allowed.set_point_step_m)?,
            most_jump: signal("jump_m", allowed.jump_m, stroke_m)?,
            neutral: signal("neutral_v", neutral_v, command_v)?,
            most_command: signal("command_v", allowed.command_v, command_v)?,
            slew: signal("slew_v_per_s", allowed.slew_v_per_s, command_v / tick_s)?,
            ramp: signal("ramp_v_per_s", allowed.ramp_v_per_s, command_v / tick_s)?,
            still_position: patience("still_position", allowed.still_position, stroke_m, tick_s)?,
            still: [None, still_spool, still_pressure, still_pressure, None],
            read_back: patience("read_back", allowed.read_back, command_v, tick_s)?,
            deviation: DeviationLimits::new(&allowed.deviation, bases)?,
        };
        limits.check()?;
        Ok(limits)
    }

    /// The same with the command read back, which may be off for so long.
    ///
    /// # Errors
    /// The limit does not fit.
    pub fn reading_back(self, away: Delay, bases: &Bases) -> Result<Self, LimitsError> {
        Ok(Self { read_back: patience("read_back", Some(away), bases.command_v, bases.tick_s)?, ..self })
    }

    /// Checks what the period relies on.
    ///
    /// # Errors
    /// The first limit that is not valid.
    pub fn check(&self) -> Result<(), LimitsError> {
        let positive = [
            ("most_jump", self.most_jump),
            ("most_command", self.most_command),
            ("slew", self.slew),
            ("ramp", self.ramp),
        ];
        if let Some(&(name, value)) = positive.iter().find(|(_, value)| *value <= PerUnit::ZERO) {
            return Err(LimitsError::NotPositive { name, value });
        }
        self.deviation.check()?;
        let (neutral, most) = (self.neutral, self.most_command);
        if neutral.magnitude() > most { Err(LimitsError::Neutral { neutral, most }) } else { Ok(()) }
    }

    /// Periods after which a ramp from any command has arrived at neutral.
    #[must_use]
    pub fn periods_to_neutral(&self) -> u32 {
        let farthest = self.most_command + self.neutral.magnitude();
        farthest.to_bits().unsigned_abs().div_ceil(self.ramp.to_bits().unsigned_abs().max(1))
    }
}

#[cfg(test)]
mod tests {
    use model_core::drive::Drive;
    use model_core::machine::Tick;

    use super::*;
    use crate::mock::press;
    use crate::supervision::deviation::Reach;

    fn allowed() -> Allowed {
        Allowed {
            attempts: 3,
            settling_s: 0.1,
            bounds: Bounds { from_m: 0.015, to_m: 0.285, velocity_m_per_s: 0.1, acceleration_m_per_s2: 1.0 },
            jump_m: 0.03,
            set_point_step_m: 0.0,
            command_v: 9.5,
            slew_v_per_s: 400.0,
            ramp_v_per_s: 20.0,
            still_position: Some(Delay { by: 0.003, for_s: 0.05 }),
            still_spool: None,
            still_pressure: Some(Delay { by: 7e5, for_s: 0.1 }),
            read_back: Some(Delay { by: 0.1, for_s: 0.003 }),
            deviation: Deviation::UNWATCHED,
        }
    }

    fn limits(allowed: &Allowed, tick: Tick) -> Result<Limits, LimitsError> {
        limits_of(press(), allowed, tick)
    }

    fn limits_of(mut machine: Machine<f64>, allowed: &Allowed, tick: Tick) -> Result<Limits, LimitsError> {
        machine.set(Parameter::ValveGain, 0.0559);
        machine.set(Parameter::ValveOffset, 0.0345);
        let drive = Drive::<PerUnit>::new::<64>(&machine, tick).unwrap();
        Limits::new(allowed, &machine, drive.bases())
    }

    #[test]
    fn seconds_become_periods_and_si_units_per_unit() {
        let limits = limits(&allowed(), Tick::TwoMilliseconds).unwrap();
        assert_eq!((limits.settling, limits.read_back.unwrap().periods), (50, 2));
        let near = |found: PerUnit, expected: f64| (found.to_f64() - expected).abs() < 4e-9;
        assert!(near(limits.most_jump, 0.1) && near(limits.slew, 0.08) && near(limits.ramp, 0.004));
        assert!(near(limits.neutral, -0.0345 / 0.559));
        assert!(near(limits.still[2].unwrap().travel, 0.1));
        // From +9.5 V to -0.617 V by 40 mV per period.
        assert_eq!(limits.periods_to_neutral(), 253);
    }

    #[test]
    fn neutral_is_the_middle_of_a_dead_zone_that_is_wider_on_one_side() {
        let mut machine = press();
        machine.set(Parameter::DeadZone, 0.1);
        machine.set(Parameter::DeadZoneDifference, 0.06);
        let limits = limits_of(machine, &allowed(), Tick::OneMillisecond).unwrap();
        assert!((limits.neutral.to_f64() - (0.03 - 0.0345) / 0.559).abs() < 4e-9);
    }

    #[test]
    fn what_is_no_limit_is_refused_by_name() {
        let refused = |allowed| limits(&allowed, Tick::OneMillisecond).unwrap_err();
        let far = Allowed { jump_m: 3.0, ..allowed() };
        assert_eq!(refused(far), LimitsError::DoesNotFit { name: "jump_m", value: 3.0 });
        let long = Allowed { settling_s: 66.0, ..allowed() };
        assert_eq!(refused(long), LimitsError::DoesNotFit { name: "settling_s", value: 66.0 });
        let steep = Allowed { slew_v_per_s: -1.0, ..allowed() };
        assert!(matches!(refused(steep), LimitsError::NotPositive { name: "slew", .. }));
        let reversed = Allowed { bounds: Bounds { from_m: 0.29, ..allowed().bounds }, ..allowed() };
        assert!(matches!(refused(reversed), LimitsError::SetPoint(SetPointError::Bounds(_))));
        let reach = Reach { from_m: 0.2, to_m: 0.1 };
        let empty = Deviation { range: Some(reach), ..Deviation::UNWATCHED };
        assert!(matches!(refused(Allowed { deviation: empty, ..allowed() }), LimitsError::Range { .. }));
        let none = Deviation { spool: Some(Delay { by: 0.0, for_s: 0.1 }), ..Deviation::UNWATCHED };
        let named = LimitsError::NotPositive { name: "spool's deviation", value: PerUnit::ZERO };
        assert_eq!(refused(Allowed { deviation: none, ..allowed() }), named);
        let narrow = Allowed { command_v: 0.5, ..allowed() };
        assert!(matches!(refused(narrow), LimitsError::Neutral { .. }));
    }
}
