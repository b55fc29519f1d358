//! Does the model still predict what the sensors show? The innovation (measured − predicted) of every signal is monitored.
//!
//! The square of a signal's innovation ν over its spread σ is averaged over a memory of 1/λ ticks; a single square counts for at most 32:
//!
//! ```text
//! s ← s + λ·(min(ν²/σ², 32) − s)        expected: 1         alarm: s > h
//! ```
//!
//! The limit h follows from how often a false alarm may come (`monitor/limit.rs`); with four signals each gets a quarter of that rate. This
//! file's test shows the actual rate.
//!
//! The first signal beyond its limit names the link whose model is wrong. Of several in one tick the first in the chain counts, because
//! its error reaches every later link: spool → valve, pressures → flow and chambers, position → mechanics. A load that the model lacks
//! shows in the pressures as well: the name says where to look, and the diagnosis finds the cause from the recording.

mod limit;
mod sensitivity;

use fixed::types::{I4F28, U16F16};
use model_core::control::{Observed, Predicted};
use model_core::machine::Bases;
use model_core::number::{Number, PerUnit};

use limit::{effective, limit};

pub use sensitivity::{MonitorError, Sensitivity, Spread};

/// The monitored signals, in the order of the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MonitoredSignal {
    /// Spool position.
    Spool,
    /// Pressure in A.
    PressureA,
    /// Pressure in B.
    PressureB,
    /// Position of the rod.
    Position,
}

/// Link of the model that a signal belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Link {
    /// Command to spool.
    Valve,
    /// Spool to pressures.
    FlowAndChambers,
    /// Pressures to position.
    Mechanics,
}

impl Link {
    /// All of them, in the order of the chain.
    pub const ALL: [Self; 3] = [Self::Valve, Self::FlowAndChambers, Self::Mechanics];

    /// Its name for programs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Valve => "valve",
            Self::FlowAndChambers => "flow-and-chambers",
            Self::Mechanics => "mechanics",
        }
    }
}

impl MonitoredSignal {
    /// All of them, in the order of the chain.
    pub const ALL: [MonitoredSignal; SIGNALS] =
        [MonitoredSignal::Spool, MonitoredSignal::PressureA, MonitoredSignal::PressureB, MonitoredSignal::Position];

    /// The link whose output it is.
    #[must_use]
    pub const fn link(self) -> Link {
        match self {
            MonitoredSignal::Spool => Link::Valve,
            MonitoredSignal::PressureA | MonitoredSignal::PressureB => Link::FlowAndChambers,
            MonitoredSignal::Position => Link::Mechanics,
        }
    }
}

/// How many signals are monitored.
pub const SIGNALS: usize = 4;

/// Measured − predicted, per unit; `None` where there is no such sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Innovation {
    /// In the order of [`MonitoredSignal::ALL`].
    values: [Option<PerUnit>; SIGNALS],
}

impl Innovation {
    /// Measured − predicted of each signal, per unit, in the order of [`MonitoredSignal::ALL`]; `None` where there is no reading.
    #[must_use]
    pub const fn new(values: [Option<PerUnit>; SIGNALS]) -> Self {
        Self { values }
    }

    /// From what the model predicted and the sensors show for the same instant.
    #[must_use]
    pub fn of(predicted: &Predicted, seen: &Observed) -> Self {
        let spool = seen.spool.map(|spool| spool - predicted.spool);
        let a = seen.pressures.map(|pressures| pressures.a - predicted.pressure_a);
        let b = seen.pressures.map(|pressures| pressures.b - predicted.pressure_b);
        Self { values: [spool, a, b, Some(seen.position - predicted.position)] }
    }

    /// The same with another innovation of the spool: measured less the valve's model under the command that the valve got. A process loop that
    /// opens the valve further than the reference model's is then no fault of the valve.
    #[must_use]
    pub fn with_spool(self, off: PerUnit) -> Self {
        let [_, a, b, position] = self.values;
        Self { values: [Some(off), a, b, position] }
    }
}

/// Coefficients: configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monitor {
    /// λ
    share: I4F28,
    watches: [Watch; SIGNALS],
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Watch {
    /// 1/2σ
    half_inverse: U16F16,
    /// h/4
    limit: PerUnit,
}

/// The averages, and whether an alarm was given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MonitorState {
    /// Mean square of half the innovation over its spread: halved, so that a square of 32 fits.
    quarters: [PerUnit; SIGNALS],
    alarmed: bool,
}

impl MonitorState {
    /// Nothing has been seen, and no alarm has been given.
    pub const AT_REST: Self = Self { quarters: [PerUnit::from_bits(1 << 26); SIGNALS], alarmed: false };

    /// The ratio of each innovation's mean square to the expected one, in the order of [`MonitoredSignal::ALL`].
    #[must_use]
    pub fn squares(&self) -> [f64; SIGNALS] {
        self.quarters.map(|quarter| 4.0 * quarter.to_f64())
    }
}

/// A signal beyond its limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Miss {
    /// Which.
    pub signal: MonitoredSignal,
    /// The link whose model is wrong.
    pub link: Link,
    /// Measured − predicted in the tick of the alarm, relative to the signal's base.
    pub innovation: PerUnit,
    /// A quarter of the ratio of the innovation's mean square to the expected one, at most 8.
    pub quarter: PerUnit,
}

impl Miss {
    /// The ratio of the innovation's mean square to the expected one, at most 32.
    #[must_use]
    pub fn square(&self) -> f64 {
        4.0 * self.quarter.to_f64()
    }
}

/// Largest ratio of a squared innovation to its expected value: no single reading counts for more.
const MOST: f64 = 32.0;
/// √8
const LARGEST: PerUnit = PerUnit::from_bits(759_250_124);

impl Monitor {
    /// The monitor with the period and scales of `bases`.
    ///
    /// # Errors
    /// A spread or a time is out of its range, or no limit makes false alarms as rare as required.
    pub fn new(sensitivity: &Sensitivity, bases: &Bases) -> Result<Self, MonitorError> {
        Self::with_period(sensitivity, bases, bases.tick_s)
    }

    /// The same of innovations that come every `period_s` seconds: those of a recording's rows.
    ///
    /// # Errors
    /// As those of [`Monitor::new`].
    pub fn with_period(sensitivity: &Sensitivity, bases: &Bases, period_s: f64) -> Result<Self, MonitorError> {
        let Sensitivity { spool, pressure, position, memory_s, between_false_alarms_s } = *sensitivity;
        let time = |name, found_s: f64, least_s: f64, most_s: f64| {
            // NaN is in no range.
            if least_s <= found_s && found_s <= most_s {
                Ok(())
            } else {
                Err(MonitorError::Time { name, found_s, least_s, most_s })
            }
        };
        time("memory", memory_s, 2.0 * period_s, 1e3)?;
        time("time between false alarms", between_false_alarms_s, memory_s, 1e10)?;
        let share = period_s / memory_s;
        let chance = period_s / between_false_alarms_s / SIGNALS as f64;
        let watch = |signal: MonitoredSignal, spread: Spread, base: f64| {
            time("correlation", spread.correlation_s, 0.0, memory_s)?;
            let sigma = spread.sigma / base;
            // NaN fails this comparison.
            let half_inverse = if sigma > 0.0 && sigma < 1.0 { PerUnit::steep(0.5 / sigma) } else { None };
            let refused = MonitorError::Sigma { signal, sigma: spread.sigma, least: base / 131_072.0 };
            let limit = limit(effective(share, spread.correlation_s / period_s), chance);
            if limit < MOST {
                Ok(Watch { half_inverse: half_inverse.ok_or(refused)?, limit: PerUnit::saturated(0.25 * limit) })
            } else {
                Err(MonitorError::TooShort { signal, limit, most: MOST })
            }
        };
        Ok(Self {
            share: PerUnit::saturated(share).as_gain(),
            watches: [
                watch(MonitoredSignal::Spool, spool, 1.0)?,
                watch(MonitoredSignal::PressureA, pressure, bases.pressure_pa)?,
                watch(MonitoredSignal::PressureB, pressure, bases.pressure_pa)?,
                watch(MonitoredSignal::Position, position, bases.stroke_m)?,
            ],
        })
    }

    /// The ratios above which an alarm is given, in the order of [`MonitoredSignal::ALL`].
    #[must_use]
    pub fn limits(&self) -> [f64; SIGNALS] {
        self.watches.map(|watch| 4.0 * watch.limit.to_f64())
    }

    /// Nothing has been seen, and no alarm has been given.
    #[must_use]
    pub fn at_rest(&self) -> MonitorState {
        MonitorState::AT_REST
    }

    /// Forgets what has been seen; an alarm that was given stays given.
    pub fn forget(&self, state: &mut MonitorState) {
        state.quarters = self.at_rest().quarters;
    }

    /// Takes the innovation of a tick; returns the first signal beyond its limit, but only once until the state is reset.
    pub fn watch(&self, state: &mut MonitorState, innovation: &Innovation) -> Option<Miss> {
        let mut missed = None;
        let signals =
            MonitoredSignal::ALL.into_iter().zip(&self.watches).zip(&mut state.quarters).zip(innovation.values);
        for (((signal, watch), quarter), value) in signals {
            let Some(value) = value else { continue };
            let half = value.amplified(watch.half_inverse).limited(LARGEST);
            *quarter = *quarter + PerUnit::dot([self.share], [half.times(half) - *quarter]);
            if missed.is_none() && *quarter > watch.limit {
                missed = Some(Miss { signal, link: signal.link(), innovation: value, quarter: *quarter });
            }
        }
        if state.alarmed {
            return None;
        }
        state.alarmed = missed.is_some();
        missed
    }
}

#[cfg(test)]
mod tests {
    use model_core::machine::{Machine, Parameter, Source, Tick};

    use super::*;
    use crate::control::Reference;

    /// Standard normal numbers (Box and Muller, on splitmix64).
    struct Normal(u64);

    impl Normal {
        fn uniform(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut mixed = self.0;
            mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn next(&mut self) -> f64 {
            let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
            radius * (core::f64::consts::TAU * self.uniform()).cos()
        }
    }

    fn press() -> Machine<f64> {
        let mut machine = Machine::with_defaults(Source::Valve);
        for (parameter, value) in [
            (Parameter::AreaA, 3.117e-3),
            (Parameter::AreaB, 1.861e-3),
            (Parameter::VolumeA, 5.2e-4),
            (Parameter::VolumeB, 3.3e-4),
            (Parameter::ValveGain, 0.0559),
            (Parameter::TimeConstant1, 0.018),
        ] {
            machine.set(parameter, value);
        }
        machine
    }

    fn reference(machine: &Machine<f64>) -> Reference<64> {
        Reference::at_rest(machine, Tick::OneMillisecond, 0.5).unwrap()
    }

    fn sensitivity(correlation_s: f64, memory_s: f64, between_false_alarms_s: f64) -> Sensitivity {
        let spread = |sigma| Spread { sigma, correlation_s };
        Sensitivity {
            spool: spread(2e-3),
            pressure: spread(4e4),
            position: spread(2e-4),
            memory_s,
            between_false_alarms_s,
        }
    }

    const SIGMAS: [f64; SIGNALS] = [2e-3, 4e4 / 7e6, 4e4 / 7e6, 2e-4 / 0.3];

    /// False alarms in so many ticks of normal innovations, each correlated with the one before by `rho`.
    fn false_alarms(monitor: &Monitor, rho: f64, ticks: u32) -> u32 {
        let mut normal = Normal(1);
        let mut state = monitor.at_rest();
        let mut now = [0.0; SIGNALS];
        let mut alarms = 0;
        for _ in 0..ticks {
            for value in &mut now {
                *value = rho * *value + (1.0 - rho * rho).sqrt() * normal.next();
            }
            let values = core::array::from_fn(|k| Some(PerUnit::saturated(now[k] * SIGMAS[k])));
            if monitor.watch(&mut state, &Innovation { values }).is_some() {
                alarms += 1;
                state = monitor.at_rest();
            }
        }
        alarms
    }

    #[test]
    fn false_alarms_come_no_more_often_than_is_stated_and_the_limit_is_not_far_from_where_they_would() {
        let bases = *reference(&press()).bases();
        let (ticks, stated_s) = (2_000_000_u32, 5.0);
        let allowed = f64::from(ticks) * bases.tick_s / stated_s;
        // Correlated innovations are counted as fewer independent ones, which makes the limit more conservative.
        for (rho, memory_s, near) in [(0.0, 0.05, 0.8), (0.0, 0.5, 0.9), (0.9, 0.05, 0.55), (0.9, 0.5, 0.75)] {
            let correlation_s = if rho > 0.0 { -bases.tick_s / f64::ln(rho) } else { 0.0 };
            let monitor = Monitor::new(&sensitivity(correlation_s, memory_s, stated_s), &bases).unwrap();
            let limit = 4.0 * monitor.watches[0].limit.to_f64();
            let found = false_alarms(&monitor, rho, ticks);
            std::println!("rho {rho}, memory {memory_s} s: limit {limit:.2}, {found} false alarms, {allowed} allowed");
            assert!(f64::from(found) <= allowed, "{rho} {memory_s}: {found} of {allowed}");
            let mut eager = monitor;
            for watch in &mut eager.watches {
                watch.limit = PerUnit::saturated(near * watch.limit.to_f64());
            }
            let found = false_alarms(&eager, rho, ticks);
            assert!(f64::from(found) > allowed, "{rho} {memory_s}: only {found} at {near} of the limit");
        }
    }

    /// The first miss of a machine that the model does not describe, and after how many ticks.
    fn first_miss(change: impl Fn(&mut Machine<f64>), bias: [f64; SIGNALS]) -> Option<(Miss, u32)> {
        let mut other = press();
        change(&mut other);
        let (mut model, mut machine) = (reference(&press()), reference(&other));
        let monitor = Monitor::new(&sensitivity(0.0, 0.1, 86_400.0), model.bases()).unwrap();
        let (mut state, mut normal) = (monitor.at_rest(), Normal(5));
        for tick in 0..4000_u32 {
            let command = PerUnit::saturated(0.4 * (f64::from(tick) * 3e-3).sin());
            let (predicted, shown) = (model.step(command), machine.step(command));
            let mut seen = |value: PerUnit, k: usize| value + PerUnit::saturated((normal.next() + bias[k]) * SIGMAS[k]);
            let observed = Observed {
                spool: Some(seen(shown.spool, 0)),
                pressures: Some(model_core::ports::ChamberState {
                    a: seen(shown.pressure_a, 1),
                    b: seen(shown.pressure_b, 2),
                }),
                position: seen(shown.position, 3),
            };
            if let Some(miss) = monitor.watch(&mut state, &Innovation::of(&predicted, &observed)) {
                return Some((miss, tick));
            }
        }
        None
    }

    #[test]
    fn a_model_that_is_right_is_left_alone() {
        assert_eq!(first_miss(|_| {}, [0.0; SIGNALS]), None);
    }

    #[test]
    fn the_link_that_misses_is_named() {
        let none = [0.0; SIGNALS];
        let valve = first_miss(|machine| machine.set(Parameter::ValveGain, 0.0559 * 1.2), none).unwrap();
        assert_eq!(valve.0.link, Link::Valve);
        let leaking = first_miss(|machine| machine.set(Parameter::InternalLeakage, 3e-11), none).unwrap();
        assert_eq!(leaking.0.link, Link::FlowAndChambers);
        let slipping = first_miss(|_| {}, [0.0, 0.0, 0.0, 5.0]).unwrap();
        assert_eq!(slipping.0.link, Link::Mechanics);
        assert!(slipping.1 < 100, "five times its spread is seen within the memory: {}", slipping.1);
    }

    #[test]
    fn a_miss_is_told_once_and_a_missing_sensor_never_misses() {
        let monitor = Monitor::new(&sensitivity(0.0, 0.1, 1e4), reference(&press()).bases()).unwrap();
        let far = Innovation { values: [None, Some(PerUnit::ONE), None, None] };
        let mut state = monitor.at_rest();
        let told: std::vec::Vec<Miss> = (0..5000).filter_map(|_| monitor.watch(&mut state, &far)).collect();
        assert_eq!(told.len(), 1);
        assert_eq!((told[0].signal, told[0].innovation), (MonitoredSignal::PressureA, PerUnit::ONE));
        assert!(told[0].square() > 1.0, "{:?}", told[0]);
        assert_eq!(state.quarters[0], monitor.at_rest().quarters[0]);
    }

    #[test]
    fn what_cannot_be_told_from_chance_is_refused() {
        let bases = *reference(&press()).bases();
        let refused = |sensitivity: Sensitivity| Monitor::new(&sensitivity, &bases).unwrap_err();
        let nothing = Spread { sigma: 0.0, correlation_s: 0.0 };
        let right = sensitivity(0.0, 0.1, 1e4);
        let found = refused(Sensitivity { spool: nothing, ..right });
        assert!(matches!(found, MonitorError::Sigma { signal: MonitoredSignal::Spool, .. }), "{found}");
        let found = refused(Sensitivity { memory_s: f64::NAN, ..right });
        assert!(matches!(found, MonitorError::Time { name: "memory", .. }), "{found}");
        let found = refused(Sensitivity { memory_s: 0.002, between_false_alarms_s: 1e10, ..right });
        assert!(matches!(found, MonitorError::TooShort { .. }), "{found}");
    }
}
