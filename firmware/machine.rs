// Constants of a drive, written by `host-sim export`: change the machine file and export again.

use model_core::machine::{Parameter, Source, Tick};

/// What the drive is called.
pub const NAME: &str = "press-63-40";
/// Where its oil comes from.
pub const SOURCE: Source = Source::Valve;
/// Control period that the values were checked for.
pub const TICK: Tick = Tick::OneMillisecond;
/// Ticks of the shortest delay line that holds its delays.
pub const DELAY_LINE: usize = 16;
/// Every value that is not the default, SI.
#[rustfmt::skip]
#[allow(clippy::unreadable_literal, reason = "every digit of an exported value counts")]
pub const VALUES: &[(Parameter, f64)] = &[
    (Parameter::FlowLimit, 0.0003), // supply.flow_limit_m3_per_s
    (Parameter::ValveGain, 0.0559), // valve.gain_per_v
    (Parameter::ValveOffset, 0.0345), // valve.offset
    (Parameter::DeadZone, 0.1049), // valve.dead_zone
    (Parameter::RateLimit, 12.0), // valve.rate_limit_per_s
    (Parameter::TimeConstant1, 0.018), // valve.time_constants_s[0]
    (Parameter::TimeConstant2, 0.0279), // valve.time_constants_s[1]
    (Parameter::TransportDelay, 0.007), // valve.transport_delay_s
    (Parameter::AreaA, 0.003117), // cylinder.area_a_m2
    (Parameter::AreaB, 0.001861), // cylinder.area_b_m2
    (Parameter::VolumeA, 0.00052), // cylinder.volume_a_m3
    (Parameter::VolumeB, 0.00033), // cylinder.volume_b_m3
    (Parameter::MovingMass, 18.3), // cylinder.moving_mass_kg
    (Parameter::ViscousFriction, 100000.0), // cylinder.viscous_friction_n_s_per_m
];
