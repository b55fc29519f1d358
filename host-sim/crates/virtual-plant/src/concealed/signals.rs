//! Excitations at random, between −1 and 1, to be scaled to a command or to a set position.

use recording::excitation::signals::Excitation;
use recording::seeded_noise::Noise;

/// The kind of excitation of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Steps of several sizes, each to both sides, with rests.
    Steps,
    Sweep,
    RandomSteps,
    /// A triangle of half a hertz or so.
    Triangle,
    /// A triangle that creeps through the dead zone once or twice.
    SlowTriangle,
    /// Ramps with plateaus.
    Trapezoids,
}

/// The excitations of the training recordings in this order, each case with another start, and those of the held-out recordings.
pub(crate) const TRAINING: [Kind; 6] =
    [Kind::Steps, Kind::RandomSteps, Kind::Triangle, Kind::Sweep, Kind::Trapezoids, Kind::SlowTriangle];
pub(crate) const HELD_OUT: [Kind; 2] = [Kind::RandomSteps, Kind::Trapezoids];

/// The signal at every tick, within ±1, starting at rest.
pub(crate) fn draw(kind: Kind, duration_s: f64, tick_s: f64, dice: &mut Noise) -> Vec<f64> {
    let seed = dice.uniform(0.0, 1e9).to_bits();
    match kind {
        Kind::Sweep => {
            let (from_hz, to_hz) = (dice.uniform(0.3, 0.6), dice.uniform(2.0, 5.0));
            Excitation::Sweep { amplitude_v: 1.0, from_hz, to_hz, duration_s }.sample(tick_s)
        }
        Kind::RandomSteps => {
            let (shortest_s, longest_s) = (dice.uniform(0.08, 0.15), dice.uniform(0.35, 0.6));
            Excitation::Random { amplitude_v: 1.0, shortest_s, longest_s, duration_s, seed }.sample(tick_s)
        }
        Kind::Triangle => {
            let frequency_hz = dice.uniform(0.4, 1.0);
            Excitation::Triangle { amplitude_v: 1.0, frequency_hz, duration_s }.sample(tick_s)
        }
        Kind::SlowTriangle => {
            let frequency_hz = dice.uniform(1.0, 1.6) / duration_s;
            Excitation::Triangle { amplitude_v: 0.6, frequency_hz, duration_s }.sample(tick_s)
        }
        Kind::Steps => {
            let mut points = vec![(0.0, 0.0)];
            let mut now_s = dice.uniform(0.1, 0.25);
            let mut size = dice.uniform(0.25, 0.45);
            while now_s < duration_s {
                let hold_s = dice.uniform(0.25, 0.5);
                for height in [size, 0.0, -size, 0.0] {
                    points.push((now_s, height));
                    now_s += if height.abs() > 0.0 { hold_s } else { 0.2 };
                }
                size = if size > 0.9 { dice.uniform(0.3, 0.6) } else { (size * dice.uniform(1.4, 1.9)).min(1.0) };
            }
            held(&points, duration_s, tick_s, 0.0)
        }
        Kind::Trapezoids => {
            let mut points = vec![(0.0, 0.0)];
            let (mut now_s, mut side) = (dice.uniform(0.1, 0.3), dice.sign());
            while now_s < duration_s {
                points.push((now_s, side * dice.uniform(0.3, 1.0)));
                side = -side;
                now_s += dice.uniform(0.5, 1.0);
            }
            held(&points, duration_s, tick_s, dice.uniform(2.5, 6.0))
        }
    }
}

/// Levels that apply from given times on, each approached at `slope_per_s` (0: at once).
fn held(points: &[(f64, f64)], duration_s: f64, tick_s: f64, slope_per_s: f64) -> Vec<f64> {
    let mut level = 0.0;
    (0..=ticks(duration_s, tick_s))
        .map(|tick| {
            let time_s = tick as f64 * tick_s + 1e-9;
            let target = points.iter().rev().find(|point| point.0 <= time_s).map_or(0.0, |point| point.1);
            let reach = if slope_per_s > 0.0 { slope_per_s * tick_s } else { f64::INFINITY };
            level += (target - level).clamp(-reach, reach);
            level
        })
        .collect()
}

/// Number of ticks in a time.
pub(crate) fn ticks(duration_s: f64, tick_s: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of ticks")]
    let count = (duration_s / tick_s).round() as usize;
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_stays_within_one_and_moves() {
        for kind in TRAINING {
            for seed in 0..5 {
                let signal = draw(kind, 4.5, 2e-3, &mut Noise::new(seed, 0));
                assert_eq!(signal.len(), 2251, "{kind:?}");
                let (low, high) = signal.iter().fold((0.0_f64, 0.0_f64), |(low, high), &s| (low.min(s), high.max(s)));
                assert!(high <= 1.0 && low >= -1.0 && high - low > 0.5, "{kind:?} {low} {high}");
                assert!(signal[0].abs() < 1e-9);
            }
        }
    }
}
