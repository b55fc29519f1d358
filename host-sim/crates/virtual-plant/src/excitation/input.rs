//! What drives the plant: commands at the control ticks, and a load force over time.

use thiserror::Error;

/// Speed of the pump and position of its directional valve, held from one tick to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PumpCommand {
    /// Turns per second; displacement × speed is what the pump delivers.
    pub speed_rev_per_s: f64,
    /// +1: pump to A, B to tank. −1: pump to B, A to tank. 0: both ports closed.
    pub direction: i8,
}

/// A command for one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Valve drives: V.
    Valve(f64),
    /// Pump drives.
    Pump(PumpCommand),
}

/// One value per tick, held until the next tick (row k of a recording).
#[derive(Clone, Debug, PartialEq)]
pub enum Commands {
    /// Valve drives: command, V.
    Valve(Vec<f64>),
    /// Pump drives.
    Pump(Vec<PumpCommand>),
}

impl Commands {
    /// Number of ticks.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Valve(commands) => commands.len(),
            Self::Pump(commands) => commands.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Force on the rod over time, in addition to the machine's constant load: linear between its points,
/// constant before the first and after the last.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadProfile {
    points: Vec<(f64, f64)>,
}

/// Why points do not make a load profile.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum LoadError {
    /// A point lies before its predecessor.
    #[error("load profile: point {index} at {found_s} s lies before {previous_s} s")]
    Backwards {
        /// Which point.
        index: usize,
        /// Its time, s.
        found_s: f64,
        /// The time of the point before, s.
        previous_s: f64,
    },
    /// A time or a force is not a number.
    #[error("load profile: point {index} is ({time_s} s, {force_n} N), expected finite numbers")]
    NotFinite {
        /// Which point.
        index: usize,
        /// Its time, s.
        time_s: f64,
        /// Its force, N.
        force_n: f64,
    },
}

impl LoadProfile {
    /// No force in addition to the machine's own load.
    #[must_use]
    pub const fn none() -> Self {
        Self { points: Vec::new() }
    }

    /// From points (time s, force N; positive extends). Two points at one time are a step.
    pub fn through(points: Vec<(f64, f64)>) -> Result<Self, LoadError> {
        let mut previous_s = f64::NEG_INFINITY;
        for (index, &(time_s, force_n)) in points.iter().enumerate() {
            if !time_s.is_finite() || !force_n.is_finite() {
                return Err(LoadError::NotFinite { index, time_s, force_n });
            }
            if time_s < previous_s {
                return Err(LoadError::Backwards { index, found_s: time_s, previous_s });
            }
            previous_s = time_s;
        }
        Ok(Self { points })
    }

    /// The same profile, delayed by a time.
    #[must_use]
    pub fn later(&self, by_s: f64) -> Self {
        Self { points: self.points.iter().map(|&(time_s, force_n)| (time_s + by_s, force_n)).collect() }
    }

    /// The straight line that applies from `time_s` on, and the time of the next corner (or infinity).
    pub(crate) fn line_from(&self, time_s: f64) -> (LoadLine, f64) {
        let next = self.points.partition_point(|&(at, _)| at <= time_s);
        let corner_s = self.points.get(next).map_or(f64::INFINITY, |point| point.0);
        let before = next.checked_sub(1).and_then(|index| self.points.get(index));
        let line = match (before, self.points.get(next)) {
            (Some(&(from_s, from_n)), Some(&(to_s, to_n))) => {
                LoadLine { start_s: from_s, force_n: from_n, slope_n_per_s: (to_n - from_n) / (to_s - from_s) }
            }
            (Some(&(start_s, force_n)), None) | (None, Some(&(start_s, force_n))) => {
                LoadLine { start_s, force_n, slope_n_per_s: 0.0 }
            }
            (None, None) => LoadLine::default(),
        };
        (line, corner_s)
    }
}

/// A straight piece of a load profile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LoadLine {
    start_s: f64,
    force_n: f64,
    slope_n_per_s: f64,
}

impl LoadLine {
    pub(crate) fn at(&self, time_s: f64) -> f64 {
        self.force_n + self.slope_n_per_s * (time_s - self.start_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_is_linear_between_points_and_steps_where_two_share_a_time() {
        let profile = LoadProfile::through(vec![(1.0, 0.0), (2.0, 10.0), (2.0, -5.0)]).unwrap();
        assert_eq!(profile.line_from(0.0).1.to_bits(), 1.0_f64.to_bits());
        assert!((profile.line_from(1.5).0.at(1.5) - 5.0).abs() < 1e-12);
        assert!((profile.line_from(2.0).0.at(2.0) + 5.0).abs() < 1e-12);
        assert!(profile.line_from(3.0).1.is_infinite());
    }

    #[test]
    fn a_profile_that_goes_back_in_time_is_refused_with_its_point() {
        let found = LoadProfile::through(vec![(1.0, 0.0), (0.5, 0.0)]);
        assert_eq!(found, Err(LoadError::Backwards { index: 1, found_s: 0.5, previous_s: 1.0 }));
    }
}
