//! The controller's parameters as an engineer states them, in SI units, and a rule that computes them from the machine.
#![expect(clippy::float_arithmetic, reason = "a tuning is found once, before a run, in real arithmetic")]

use crate::machine::{Machine, Parameter as P};

/// The controller as an engineer states it: configuration, SI units in the names. Gains are of velocity per position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Largest command, both signs, V.
    pub command_limit_v: f64,
    /// Fastest change of the command, V/s.
    pub slew_v_per_s: f64,
    /// Largest velocity that either loop demands of the rod, m/s.
    pub velocity_limit_m_per_s: f64,
    /// Spool travel to either side that remains of the valve's overlap in the loops' own coordinate: within it a correction
    /// moves the spool and passes no oil. It covers the uncertainty of the overlap; with a smaller value the valve chatters.
    pub kept_overlap: f64,
    /// How far ahead in time the model loop drives the valve: the valve's lags and delay that remain with `spool_gain`, s.
    pub lead_s: f64,
    /// Time over which the set point's acceleration is filtered for this lead, s.
    pub lead_filter_s: f64,
    /// Gain on the spool's distance from its target, 1: it makes the spool cross its overlap faster.
    pub spool_gain: f64,
    /// Model loop, velocity per distance between set point and model, 1/s.
    pub model_gain_per_s: f64,
    /// Process loop, velocity per distance between model and machine, 1/s.
    pub process_gain_per_s: f64,
    /// Process loop, velocity gained per distance and time, 1/s².
    pub process_integral_per_s2: f64,
    /// Resolution of the position's sensor, m: within half of it to either side, a difference between model and machine is ignored.
    pub position_resolution_m: f64,
    /// Filter time of the difference of load between model and machine: only slower differences count as load, s.
    pub load_filter_s: f64,
    /// Velocity against the faster changes of the oil's force, m/s per N: it damps an oil spring. The model loop uses the model's
    /// force, the process loop the machine's less the model's.
    pub pressure_damping_m_per_s_n: f64,
}

/// A tick of 1 ms: the delay that a controller adds to any other.
const CONTROLLER_DELAY_S: f64 = 1e-3;
/// Least effective lag, s; a shorter one would be the controller's own.
const LEAST_LAG_S: f64 = 4e-3;
/// Damping ratio that the controller gives to an oil spring.
const DAMPED: f64 = 0.4;
/// If a spring's phase advances by more than this within the valve's lag, rad, the valve does not damp it: it would rather stiffen it.
const WITHIN_REACH: f64 = 0.8;
/// Phase of the spring, rad, that the filter time of the load's difference covers.
const LOAD_TURN: f64 = 6.0;
/// With a larger gain, a loop that has to reverse over the overlap at full command keeps oscillating.
const LARGEST_SPOOL_GAIN: f64 = 1.0;

impl Tuning {
    /// A tuning by rule, from the machine's lags; `spool_is_measured` says whether the process loop has the spool.
    ///
    /// With T the valve's lags and τ its delay (including the controller's), the spool's gain is g = T/3τ, at most 1. For slow signals
    /// the spool is then late by (T + τ)/(1 + g), which is the lead. The effective lag of a loop is τ + T/(1 + g), plus the time in which
    /// the rate limit lets the spool cross its overlap on reversing; for the loop around the machine, plus its position sensor's lag. Two thirds
    /// of its inverse is the gain of a loop around an integrator (damping 0.6); in ten times this lag the integral removes what is left.
    ///
    /// An oil spring of frequency ω and damping ζ = D/(2·√(c·m)) that the valve can follow is damped to 0.4 by the pressures, since
    /// dF/dt = c·(v* − k·F − v) adds a damping of k·√(c·m)/2. No gain is above ζ·ω, half of the gain that oscillates. The position's
    /// resolution stays 0: the sensor is not part of the machine.
    #[must_use]
    pub fn by_rule(machine: &Machine<f64>, spool_is_measured: bool) -> Self {
        let lags_s = machine.spool_lag_s();
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
