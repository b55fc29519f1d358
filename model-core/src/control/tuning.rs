//! What an engineer states of the controller, in SI units; and a rule that finds it from the machine.
#![expect(clippy::float_arithmetic, reason = "a tuning is found once, before a run, in real arithmetic")]

use crate::machine::{Machine, Parameter as P};

/// The controller as an engineer states it: configuration, SI units in the names. Gains are of velocity per position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Largest command, both signs, V.
    pub command_limit_v: f64,
    /// Fastest change of the command, V/s.
    pub slew_v_per_s: f64,
    /// Fastest that either loop asks of the rod, m/s.
    pub velocity_limit_m_per_s: f64,
    /// Spool travel to either side, in the loops' own coordinate, that is left of the valve's overlap: within it a correction
    /// moves the spool and passes no oil. It covers what is not known of the overlap; below that the valve chatters.
    pub kept_overlap: f64,
    /// How far ahead in time the model loop drives the valve: what is left of its lags and delay as `spool_gain` hastens it, s.
    pub lead_s: f64,
    /// Time over which the set point's acceleration is taken for that, s.
    pub lead_filter_s: f64,
    /// What a spool's distance from its target is answered with, 1: it hastens the spool over its overlap.
    pub spool_gain: f64,
    /// Model loop, velocity per distance between set point and model, 1/s.
    pub model_gain_per_s: f64,
    /// Process loop, velocity per distance between model and machine, 1/s.
    pub process_gain_per_s: f64,
    /// Process loop, velocity gained per distance and time, 1/s².
    pub process_integral_per_s2: f64,
    /// What the position's sensor cannot tell apart, m: half of it to either side is no difference between model and machine.
    pub position_resolution_m: f64,
    /// Time over which the difference of the load between model and machine is taken for real, s.
    pub load_filter_s: f64,
    /// Velocity that opposes what of the oil's force changes faster, m/s per N: it damps an oil spring. In the model loop the model's
    /// force counts, in the process loop the machine's less the model's.
    pub pressure_damping_m_per_s_n: f64,
}

/// A tick of 1 ms: what a controller adds to any delay.
const CONTROLLER_DELAY_S: f64 = 1e-3;
/// Below this an effective lag is the controller's own, s.
const LEAST_LAG_S: f64 = 4e-3;
/// Damping that an oil spring is given.
const DAMPED: f64 = 0.4;
/// A spring that turns further than this within the valve's lag is not damped by the valve, rad: it would rather stiffen it.
const WITHIN_REACH: f64 = 0.8;
/// Turns of the spring, rad, over which the load's difference is taken for real.
const LOAD_TURN: f64 = 6.0;
/// With more than this a loop that has to turn over the overlap at full command swings on.
const LARGEST_SPOOL_GAIN: f64 = 1.0;

impl Tuning {
    /// A tuning by rule, from the machine's lags; `spool_is_measured` tells whether the process loop has the spool.
    ///
    /// With T the valve's lags and τ its delay (with the controller's), the spool is hastened by g = T/3τ, at most 1: to slow signals
    /// it is then late by (T + τ)/(1 + g), which is the lead. A loop around it sees τ + T/(1 + g), and where it turns the time that
    /// the valve's rate limit takes over the overlap; the one around the machine what its position's sensor is late by as well. Two thirds of that sum's inverse is the gain of a loop around an integrator
    /// (damped by 0.6), and ten times its inverse the time in which the integral removes what is left.
    ///
    /// An oil spring of frequency ω and damping ζ = D/(2·√(c·m)) that the valve can follow is damped by the pressures to 0.4, as
    /// dF/dt = c·(v* − k·F − v) gives it k·√(c·m)/2. No gain is above ζ·ω, half of what swings. The position's resolution stays 0:
    /// the sensor is not the machine's.
    #[must_use]
    pub fn by_rule(machine: &Machine<f64>, spool_is_measured: bool) -> Self {
        let lags_s = machine.get(P::TimeConstant1) + machine.get(P::TimeConstant2);
        let delay_s = machine.get(P::TransportDelay) + CONTROLLER_DELAY_S;
        let turning_s = 2.0 * machine.get(P::DeadZone) / machine.get(P::RateLimit);
        let spool_gain = (lags_s / (3.0 * delay_s)).min(LARGEST_SPOOL_GAIN);
        let lag_s = |hastened: f64| (delay_s + lags_s / hastened + turning_s).max(LEAST_LAG_S);
        let model_s = lag_s(1.0 + spool_gain);
        let shown_s = machine.get(P::PositionLag) + machine.get(P::PositionDelay);
        let process_s = shown_s + if spool_is_measured { model_s } else { lag_s(1.0) };
        let spring = Spring::of(machine);
        let damping_m_per_s_n =
            if spring.per_s * model_s < WITHIN_REACH { spring.missing_damping_m_per_s_n() } else { 0.0 };
        let damped = if damping_m_per_s_n > 0.0 { DAMPED } else { spring.damping };
        let gain = |lag_s: f64| (1.0 / (1.5 * lag_s)).min(damped * spring.per_s);
        let opened = machine.get(P::FlowCoefficient) * libm::sqrt(machine.get(P::SupplyPressure));
        let larger_area = machine.get(P::AreaA).max(machine.get(P::AreaB));
        Self {
            command_limit_v: crate::coefficients::bases::COMMAND_V,
            slew_v_per_s: 1e3 * crate::coefficients::bases::COMMAND_V,
            velocity_limit_m_per_s: machine.get(P::FlowLimit).min(opened) / larger_area,
            kept_overlap: (0.1 * machine.get(P::DeadZone)).min(0.01),
            lead_s: (lags_s + delay_s) / (1.0 + spool_gain),
            lead_filter_s: 0.2 * (lags_s + delay_s),
            spool_gain,
            model_gain_per_s: gain(model_s),
            process_gain_per_s: gain(process_s),
            process_integral_per_s2: gain(process_s) * gain(process_s) / 6.7,
            position_resolution_m: 0.0,
            load_filter_s: (LOAD_TURN / spring.per_s).clamp(0.01, 1.0),
            pressure_damping_m_per_s_n: damping_m_per_s_n,
        }
    }
}

/// The oil in both chambers as a spring under the moving mass, at mid-stroke.
struct Spring {
    /// ω, rad/s
    per_s: f64,
    /// ζ
    damping: f64,
    /// √(c·m), N·s/m
    impedance_n_s_per_m: f64,
}

impl Spring {
    fn of(machine: &Machine<f64>) -> Self {
        let stiffness = |area: P, volume: P| {
            let capacity = machine.get(volume) / machine.get(P::BulkModulus) + machine.get(P::HoseCompliance);
            machine.get(area) * machine.get(area) / capacity
        };
        let stiffness_n_per_m = stiffness(P::AreaA, P::VolumeA) + stiffness(P::AreaB, P::VolumeB);
        let mass_kg = machine.get(P::MovingMass);
        let impedance_n_s_per_m = libm::sqrt(stiffness_n_per_m * mass_kg);
        Self {
            per_s: libm::sqrt(stiffness_n_per_m / mass_kg),
            damping: machine.get(P::ViscousFriction) / (2.0 * impedance_n_s_per_m),
            impedance_n_s_per_m,
        }
    }

    fn missing_damping_m_per_s_n(&self) -> f64 {
        2.0 * (DAMPED - self.damping).max(0.0) / self.impedance_n_s_per_m
    }
}
