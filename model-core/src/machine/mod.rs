//! A drive's SI parameters.

mod forms;
mod parameter;

use core::f64::consts::{PI, TAU};

use crate::effects::{Effect, Link};
use crate::number::{Real, SUM_UNIT};

pub use forms::{BASE_FORMS, Form};
pub use parameter::{Description, Fallback, Parameter};

/// Atmospheric pressure, Pa.
pub const ATMOSPHERE_PA: f64 = 1.013e5;

/// Lowest possible floor of cavitation, Pa: the vacuum, where pressures are relative to the atmosphere. A lower value means that there is
/// no floor.
pub const LOWEST_FLOOR_PA: f64 = -ATMOSPHERE_PA;

/// What moves the rod: where the oil comes from, or a force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// A proportional valve on a constant supply: the paper's drive.
    Valve,
    /// A pump whose flow a directional valve leads into A or B; the other port returns to tank.
    Pump,
    /// No oil: a force that somebody measures moves the mass, and only mechanics and sensing take part.
    Force,
}

impl Source {
    /// Its name in reports: `valve`, `pump` or `force`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Source::Valve => "valve",
            Source::Pump => "pump",
            Source::Force => "force",
        }
    }

    /// Whether a drive of this kind has this link.
    #[must_use]
    pub const fn has(self, link: Link) -> bool {
        match self {
            Source::Valve => true,
            Source::Pump => !matches!(link, Link::Valve),
            Source::Force => matches!(link, Link::Mechanics | Link::Sensing),
        }
    }

    /// Whether this effect acts in a drive of this kind: the one of a link that it has, and where a force moves the mass, one that needs no simulated
    /// pressure.
    #[must_use]
    pub const fn has_effect(self, effect: Effect) -> bool {
        self.has(effect.link())
            && !(matches!(self, Source::Force) && matches!(effect, Effect::PressureDependentFriction))
    }
}

/// SI parameters of one drive, over a real number type (`f64`, or a dual number for derivatives).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine<R> {
    /// Where the oil comes from.
    pub source: Source,
    values: [R; Parameter::COUNT],
}

impl Machine<f64> {
    /// A machine with every default. Required parameters are NaN until they are set; where a force moves the mass, there are no areas and no volumes
    /// instead: 0.
    #[must_use]
    pub fn with_defaults(source: Source) -> Self {
        let missing = if source == Source::Force { 0.0 } else { f64::NAN };
        let mut machine = Self { source, values: [missing; Parameter::COUNT] };
        for &parameter in Parameter::ALL {
            if let Fallback::Value(value) = parameter.description().default {
                machine.set(parameter, value);
            }
        }
        machine
    }

    /// The machine with these values changed, SI.
    #[must_use]
    pub fn with(mut self, values: &[(Parameter, f64)]) -> Self {
        for &(parameter, value) in values {
            self.set(parameter, value);
        }
        self
    }
}

impl<R: Copy> Machine<R> {
    /// The value of a parameter, in its SI unit.
    #[must_use]
    #[expect(clippy::indexing_slicing, reason = "values has one entry for each variant")]
    pub fn get(&self, parameter: Parameter) -> R {
        self.values[parameter as usize]
    }

    /// Sets a parameter, in its SI unit.
    #[expect(clippy::indexing_slicing, reason = "values has one entry for each variant")]
    pub fn set(&mut self, parameter: Parameter, value: R) {
        self.values[parameter as usize] = value;
    }

    /// The same machine over another number type.
    #[must_use]
    pub fn map<S>(&self, convert: impl Fn(R) -> S) -> Machine<S> {
        Machine { source: self.source, values: self.values.map(convert) }
    }
}

impl<R: Real> Machine<R> {
    /// Stiffness of the oil columns in both chambers that hold the rod, N/m: (A²/Va + (αA)²/Vb)·E0.
    #[must_use]
    pub fn oil_spring_n_per_m(&self) -> R {
        let side = |area, volume| self.get(area) * self.get(area) / self.get(volume);
        let both = side(Parameter::AreaA, Parameter::VolumeA) + side(Parameter::AreaB, Parameter::VolumeB);
        both * self.get(Parameter::BulkModulus)
    }

    /// By how much the spool is late behind a slow set value, without its dead time, s: the sum of both lags, or 2·ζ/ω.
    #[must_use]
    pub fn spool_lag_s(&self) -> R {
        if self.get(Parameter::NaturalFrequency).is_nil() {
            self.get(Parameter::TimeConstant1) + self.get(Parameter::TimeConstant2)
        } else {
            let turns_per_s = R::constant(PI) * self.get(Parameter::NaturalFrequency);
            self.get(Parameter::SpoolDamping) / turns_per_s
        }
    }

    /// The spool's lead over its position per speed, s: what the first lag's output is ahead, T2, or 1/ω.
    #[must_use]
    pub fn spool_lead_s(&self) -> R {
        let hertz = self.get(Parameter::NaturalFrequency);
        if hertz.is_nil() { self.get(Parameter::TimeConstant2) } else { R::ONE / (R::constant(TAU) * hertz) }
    }

    /// How much of the piston's displacement from mid-stroke the chamber volumes follow: 1 by `volume_follows_piston`, and what the effect
    /// `position-dependent-volume` adds.
    #[must_use]
    pub(crate) fn volume_share(&self) -> R {
        self.get(Parameter::VolumeFollows) + self.get(Parameter::VolumeShare)
    }
}

impl Machine<f64> {
    /// Whether the drive has this parameter: all but those of a link that it lacks, and areas only where there are any.
    fn uses(&self, parameter: Parameter) -> bool {
        let is_area = matches!(parameter, Parameter::AreaA | Parameter::AreaB);
        self.source != Source::Force
            || parameter.is_of(Source::Force)
                && !(is_area && self.get(Parameter::AreaA).max(self.get(Parameter::AreaB)) <= 0.0)
    }

    /// Checks every parameter that the drive uses against its range.
    ///
    /// # Errors
    /// The first parameter out of range, with its value and what was expected.
    pub fn check(&self) -> Result<(), MachineError> {
        for &parameter in Parameter::ALL.iter().filter(|parameter| self.uses(**parameter)) {
            let description = parameter.description();
            let value = self.get(parameter);
            // NaN is in no range.
            if !(description.min <= value && value <= description.max) {
                return Err(MachineError::OutOfRange { parameter, value });
            }
            if parameter.is_whole() && value > libm::floor(value) {
                return Err(MachineError::NotWhole { parameter, value });
            }
        }
        let lag_s = self.get(Parameter::TimeConstant1).max(self.get(Parameter::TimeConstant2));
        if self.get(Parameter::NaturalFrequency) > 0.0 && lag_s > 0.0 {
            return Err(MachineError::LagsBesideFrequency { hertz: self.get(Parameter::NaturalFrequency), lag_s });
        }
        let (floor_pa, tank_pa) = (self.get(Parameter::CavitationFloor), self.get(Parameter::TankPressure));
        if floor_pa > Parameter::CavitationFloor.description().min && !(LOWEST_FLOOR_PA..=tank_pa).contains(&floor_pa) {
            return Err(MachineError::Floor { floor_pa, tank_pa });
        }
        Ok(())
    }
}

/// Why a machine does not become a drive.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MachineError {
    /// A parameter is not in its range.
    #[error(
        "{} = {value} {}: expected {} to {}",
        .parameter.description().key, .parameter.description().unit, .parameter.description().min, .parameter.description().max
    )]
    OutOfRange {
        /// The parameter.
        parameter: Parameter,
        /// Its value in its unit.
        value: f64,
    },
    /// A parameter that selects an entry of a list is not a whole number.
    #[error("{} = {value}: expected a whole number", .parameter.description().key)]
    NotWhole {
        /// The parameter.
        parameter: Parameter,
        /// Its value.
        value: f64,
    },
    /// The spool has lags and is a second-order system as well.
    #[error(
        "valve.natural_frequency_hz = {hertz} Hz beside valve.time_constants_s of {lag_s} s: expected one of the two"
    )]
    LagsBesideFrequency {
        /// The natural frequency in Hz.
        hertz: f64,
        /// The larger lag in s.
        lag_s: f64,
    },
    /// The pressure at which oil cavitates is physically impossible, or above the tank's.
    #[error(
        "effects.cavitation.floor_pa = {floor_pa} Pa: expected {LOWEST_FLOOR_PA} (vacuum) to supply.tank_pressure_pa = {tank_pa} Pa"
    )]
    Floor {
        /// That pressure in Pa.
        floor_pa: f64,
        /// The tank's in Pa.
        tank_pa: f64,
    },
    /// A coefficient computed from the parameter does not fit the fixed-point format.
    #[error(
        "{} = {value} {}: {coefficient} becomes {scaled:.6}, which does not fit; expected a magnitude below {limit}",
        .parameter.description().key, .parameter.description().unit
    )]
    DoesNotFit {
        /// The parameter that moves the coefficient most.
        parameter: Parameter,
        /// Its value in its unit.
        value: f64,
        /// The coefficient, in words.
        coefficient: &'static str,
        /// The coefficient's value.
        scaled: f64,
        /// What its magnitude must stay below.
        limit: f64,
    },
    /// The oil spring's frequency is too high for the tick.
    #[error(
        "cylinder.moving_mass_kg = {mass_kg} kg: too little for its oil spring at a tick of {tick_s} s, as (ω·tick)² = {turn:.1}; \
         expected below {limit:.1}: a shorter tick, at least {least_kg:.6} kg, or a chamber {times:.2} times the volume"
    )]
    OilSpringTooFast {
        /// The moving mass in kg.
        mass_kg: f64,
        /// The tick in s.
        tick_s: f64,
        /// (ω·tick)² of the mass, viscous friction included, on the stiffer chamber.
        turn: f64,
        /// What it must stay below.
        limit: f64,
        /// The least mass that fits, in kg.
        least_kg: f64,
        /// Factor on the stiffer chamber's capacity that would fit.
        times: f64,
    },
    /// The delay line is shorter than a delay.
    #[error("{} = {value} s: needs {ticks} ticks of delay line, has {line}", .parameter.description().key)]
    DelayTooLong {
        /// Which delay.
        parameter: Parameter,
        /// The delay in s.
        value: f64,
        /// Ticks needed.
        ticks: usize,
        /// Ticks there are.
        line: usize,
    },
}

/// Period of the model's step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Tick {
    /// 0.5 ms
    HalfMillisecond,
    /// 1 ms
    OneMillisecond,
    /// 2 ms
    TwoMilliseconds,
}

impl Tick {
    /// Length in s.
    #[must_use]
    pub const fn seconds(self) -> f64 {
        match self {
            Tick::HalfMillisecond => 5e-4,
            Tick::OneMillisecond => 1e-3,
            Tick::TwoMilliseconds => 2e-3,
        }
    }
}

/// What 1 means, per quantity, in SI units. Flow and velocity belong together: flow 1 moves the piston's side A at velocity 1. Where a force moves the
/// mass, the piston is one on which pressure 1 makes force 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bases {
    /// Pressure 1, Pa: the supply pressure; its default where a force moves the mass.
    pub pressure_pa: f64,
    /// Velocity 1, m/s.
    pub velocity_m_per_s: f64,
    /// Flow 1, m³/s.
    pub flow_m3_per_s: f64,
    /// Force 1, N.
    pub force_n: f64,
    /// Position 1, m: the stroke.
    pub stroke_m: f64,
    /// Command 1, V: 10 V; more or less where the format would not hold the command that opens the valve fully, as where it counts in mA.
    pub command_v: f64,
    /// Pump speed 1, revolutions per second.
    pub pump_speed_rev_per_s: f64,
    /// Temperature 1, °C; 0 is 0 °C.
    pub temperature_c: f64,
    /// Tick, s.
    pub tick_s: f64,
}

impl Bases {
    /// Void 1 ([`DriveState::voids`](crate::drive::DriveState::voids)), m³.
    #[must_use]
    #[expect(clippy::float_arithmetic, reason = "what a scale is in SI units")]
    pub fn void_m3(&self) -> f64 {
        SUM_UNIT * self.tick_s * self.flow_m3_per_s
    }
}
