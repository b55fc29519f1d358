//! Signals to excite a drive with: the paper's steps, sweeps, random steps, triangles.

use crate::seeded_noise::Noise;

/// A command signal over time, V.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Excitation {
    /// Nothing.
    Zero {
        /// Length, s.
        duration_s: f64,
    },
    /// One step: 0.1 s of rest, the amplitude, 0.35 s of rest.
    Step {
        /// Height, V; its sign is the direction.
        amplitude_v: f64,
        /// How long it is held, s.
        hold_s: f64,
    },
    /// The paper's sequence: 0.1 s rest, U for 0.5 s, 0 for 0.35 s, −U for 0.5 s, 0 for 0.35 s.
    Steps {
        /// U, V.
        amplitude_v: f64,
    },
    /// A sine whose frequency rises (or falls) logarithmically.
    Sweep {
        /// Amplitude, V.
        amplitude_v: f64,
        /// Frequency at the start, Hz.
        from_hz: f64,
        /// Frequency at the end, Hz.
        to_hz: f64,
        /// Length, s.
        duration_s: f64,
    },
    /// 0.1 s of rest, then steps of random height and length.
    Random {
        /// Heights are distributed evenly within ± this value, V.
        amplitude_v: f64,
        /// Shortest step, s.
        shortest_s: f64,
        /// Longest step, s.
        longest_s: f64,
        /// Length, s.
        duration_s: f64,
        /// The same seed gives the same signal.
        seed: u64,
    },
    /// A triangle wave that starts upwards from zero.
    Triangle {
        /// Amplitude, V.
        amplitude_v: f64,
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Length, s.
        duration_s: f64,
    },
}

const REST_S: f64 = 0.1;
const PAPER_HOLD_S: f64 = 0.5;
const PAPER_PAUSE_S: f64 = 0.35;

impl Excitation {
    /// The paper's sequence of steps with U volts.
    #[must_use]
    pub const fn paper_steps(amplitude_v: f64) -> Self {
        Self::Steps { amplitude_v }
    }

    /// The paper's sweep: 6.5 V, 0.4 to 5 Hz in 4 s.
    #[must_use]
    pub const fn paper_sweep() -> Self {
        Self::Sweep { amplitude_v: 6.5, from_hz: 0.4, to_hz: 5.0, duration_s: 4.0 }
    }

    /// Steps within ±10 V of 0.08 to 0.5 s, over 4 s.
    #[must_use]
    pub const fn random_steps(seed: u64) -> Self {
        Self::Random { amplitude_v: 10.0, shortest_s: 0.08, longest_s: 0.5, duration_s: 4.0, seed }
    }

    /// Length, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        match *self {
            Self::Zero { duration_s }
            | Self::Sweep { duration_s, .. }
            | Self::Random { duration_s, .. }
            | Self::Triangle { duration_s, .. } => duration_s,
            Self::Step { hold_s, .. } => REST_S + hold_s + PAPER_PAUSE_S,
            Self::Steps { .. } => REST_S + 2.0 * (PAPER_HOLD_S + PAPER_PAUSE_S),
        }
    }

    /// The command at each control tick, V, from 0 to the length inclusive.
    #[must_use]
    pub fn sample(&self, tick_s: f64) -> Vec<f64> {
        // A tick that lies on an edge of the signal, except for rounding, counts as after the edge.
        let hair_s = 1e-6 * tick_s;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of ticks")]
        let last = (self.duration_s() / tick_s).round() as usize;
        let times = (0..=last).map(|tick| tick as f64 * tick_s + hair_s);
        let phases = |phases: &[(f64, f64)], time_s: f64| {
            phases.iter().rev().find(|phase| phase.0 <= time_s).map_or(0.0, |phase| phase.1)
        };
        match *self {
            Self::Zero { .. } => times.map(|_| 0.0).collect(),
            Self::Step { amplitude_v, hold_s } => {
                let steps = [(REST_S, amplitude_v), (REST_S + hold_s, 0.0)];
                times.map(|time_s| phases(&steps, time_s)).collect()
            }
            Self::Steps { amplitude_v } => {
                let (hold, cycle) = (REST_S + PAPER_HOLD_S, PAPER_HOLD_S + PAPER_PAUSE_S);
                let steps = [(REST_S, amplitude_v), (hold, 0.0), (REST_S + cycle, -amplitude_v), (hold + cycle, 0.0)];
                times.map(|time_s| phases(&steps, time_s)).collect()
            }
            Self::Sweep { amplitude_v, from_hz, to_hz, duration_s } => {
                let growth = libm::log(to_hz / from_hz) / duration_s;
                let turns = |time_s: f64| {
                    if growth.abs() > 0.0 { from_hz * libm::expm1(growth * time_s) / growth } else { from_hz * time_s }
                };
                times.map(|time_s| amplitude_v * libm::sin(std::f64::consts::TAU * turns(time_s - hair_s))).collect()
            }
            Self::Random { amplitude_v, shortest_s, longest_s, duration_s, seed } => {
                let mut noise = Noise::new(seed, 0);
                let mut steps = Vec::new();
                let mut start_s = REST_S;
                while start_s <= duration_s {
                    steps.push((start_s, noise.uniform(-amplitude_v, amplitude_v)));
                    start_s += noise.uniform(shortest_s, longest_s);
                }
                times.map(|time_s| phases(&steps, time_s)).collect()
            }
            Self::Triangle { amplitude_v, frequency_hz, .. } => times
                .map(|time_s| {
                    let turn = (frequency_hz * (time_s - hair_s) + 0.25).rem_euclid(1.0);
                    amplitude_v * (1.0 - 4.0 * (turn - 0.5).abs())
                })
                .collect(),
        }
    }
}

/// A small fast signal on top of the command, which keeps the spool moving. Part of the command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dither {
    /// Amplitude, V.
    pub amplitude_v: f64,
    /// Frequency, Hz; below half the control rate.
    pub frequency_hz: f64,
}

impl Dither {
    /// Its contribution to the command at this time, V.
    #[must_use]
    pub fn at(&self, time_s: f64) -> f64 {
        self.amplitude_v * libm::sin(std::f64::consts::TAU * self.frequency_hz * time_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paper_sequence_changes_at_the_printed_times() {
        let volts = Excitation::paper_steps(4.0).sample(1e-3);
        assert_eq!(volts.len(), 1801);
        for (tick, expected) in [(99, 0.0), (100, 4.0), (599, 4.0), (600, 0.0), (949, 0.0), (950, -4.0), (1450, 0.0)] {
            assert!((volts[tick] - expected).abs() < 1e-12, "tick {tick}");
        }
    }

    #[test]
    fn the_sweep_starts_at_zero_and_passes_the_right_number_of_periods() {
        let volts = Excitation::paper_sweep().sample(1e-3);
        let rising = volts.windows(2).filter(|pair| pair[0] <= 0.0 && pair[1] > 0.0).count();
        // (5 − 0.4) / ln(5 / 0.4) · 4 s = 7.28 periods
        assert_eq!(rising, 8);
        assert!(volts[0].abs() < 1e-12 && volts.iter().all(|volts| volts.abs() <= 6.5));
    }

    #[test]
    fn random_steps_repeat_with_their_seed_and_hold_at_least_the_shortest() {
        let volts = Excitation::random_steps(3).sample(1e-3);
        assert_eq!(volts, Excitation::random_steps(3).sample(1e-3));
        assert_ne!(volts, Excitation::random_steps(4).sample(1e-3));
        let changes: Vec<usize> = (1..volts.len()).filter(|&k| (volts[k] - volts[k - 1]).abs() > 0.0).collect();
        assert!(changes.windows(2).all(|pair| (80..=501).contains(&(pair[1] - pair[0]))));
    }

    #[test]
    fn a_triangle_rises_first_and_reaches_both_ends() {
        let volts = Excitation::Triangle { amplitude_v: 2.0, frequency_hz: 1.0, duration_s: 1.0 }.sample(0.01);
        assert!(volts[0].abs() < 1e-12 && (volts[25] - 2.0).abs() < 1e-12 && (volts[75] + 2.0).abs() < 1e-12);
    }
}
