//! What the sensors would show without noise and rounding: the true signals after play, lag, ringing and wrong scales.

use std::collections::VecDeque;

use super::sensors::Reading;
use crate::effect::PlantEffect;
use crate::effect::sensing::{MeasuredSignal, SensingEffect};
use crate::plant::PlantState;

/// The position at one moment, with its velocity.
#[derive(Clone, Copy, Debug)]
struct Point {
    time_s: f64,
    position_m: f64,
    velocity_m_per_s: f64,
}

/// Longest step for effects that have a memory, s.
const STEP_S: f64 = 1e-4;

/// One effect on the position, with its memory.
#[derive(Clone, Debug)]
enum View {
    /// Half of the play, and how far the rod is from the middle of the play.
    Backlash {
        half_m: f64,
        off_m: f64,
    },
    /// Second order: output and its derivative.
    Filter {
        rad_per_s: f64,
        damping: f64,
        output: [f64; 2],
    },
    Delay {
        delay_s: f64,
        history: VecDeque<Point>,
    },
    /// A mode that the rod's motion excites: deflection and its integral.
    Ringing {
        rad_per_s: f64,
        damping: f64,
        share: f64,
        mode: [f64; 2],
    },
}

impl View {
    fn of(effect: SensingEffect, start: Point) -> Option<Self> {
        let radians = |hertz: f64| std::f64::consts::TAU * hertz;
        match effect {
            SensingEffect::Backlash { play_m } => Some(Self::Backlash { half_m: 0.5 * play_m, off_m: 0.0 }),
            SensingEffect::PositionFilter { frequency_hz, damping } => {
                let output = [start.position_m, 0.0];
                Some(Self::Filter { rad_per_s: radians(frequency_hz), damping, output })
            }
            SensingEffect::PositionDelay { delay_s } => Some(Self::Delay { delay_s, history: VecDeque::from([start]) }),
            SensingEffect::Flexibility { frequency_hz, damping, share } => {
                Some(Self::Ringing { rad_per_s: radians(frequency_hz), damping, share, mode: [0.0; 2] })
            }
            SensingEffect::Offset { .. } | SensingEffect::Factor { .. } => None,
        }
    }

    /// The position as the sensor sees it, after the rod has moved from one point to the next.
    fn pass(&mut self, from: Point, to: Point) -> f64 {
        let parts = ((to.time_s - from.time_s) / STEP_S).ceil().max(1.0);
        let step_s = (to.time_s - from.time_s) / parts;
        let (mut before_m, mut done) = (from.position_m, 0.0);
        let mut seen_m = to.position_m;
        while done < parts {
            done += 1.0;
            let at_m = between(from, to, done / parts);
            seen_m = match self {
                Self::Backlash { half_m, off_m } => {
                    *off_m = taken_up(*off_m, at_m - before_m, *half_m);
                    at_m - *off_m
                }
                Self::Filter { rad_per_s, damping, output } => {
                    let pull = *rad_per_s * (at_m - output[0]) - 2.0 * *damping * output[1];
                    output[1] += step_s * *rad_per_s * pull;
                    output[0] += step_s * output[1];
                    output[0]
                }
                Self::Ringing { rad_per_s, damping, share, mode } => {
                    // q̈ + 2ζω·q̇ + ω²·q = −a; the acceleration is the change of the rod's own velocity.
                    let speed = (at_m - before_m) / step_s.max(1e-12);
                    let change = speed - mode_speed(from, to, (done - 1.0) / parts, step_s);
                    mode[1] -= change + step_s * *rad_per_s * (2.0 * *damping * mode[1] + *rad_per_s * mode[0]);
                    mode[0] += step_s * mode[1];
                    at_m + *share * mode[0]
                }
                Self::Delay { .. } => at_m,
            };
            before_m = at_m;
        }
        if let Self::Delay { delay_s, history } = self {
            history.push_back(to);
            let wanted_s = to.time_s - *delay_s;
            while history.len() > 2 && history[1].time_s <= wanted_s {
                history.pop_front();
            }
            seen_m = match (history.front(), history.get(1)) {
                (Some(&old), Some(&new)) if wanted_s > old.time_s => {
                    between(old, new, (wanted_s - old.time_s) / (new.time_s - old.time_s))
                }
                (Some(old), _) => old.position_m,
                (None, _) => to.position_m,
            };
        }
        seen_m
    }
}

/// The rod's mean velocity over the step that ends at `along`; before the first point it is the velocity at that point.
fn mode_speed(from: Point, to: Point, along: f64, step_s: f64) -> f64 {
    let part = step_s / (to.time_s - from.time_s).max(1e-12);
    if along > 0.0 {
        (between(from, to, along) - between(from, to, along - part)) / step_s.max(1e-12)
    } else {
        from.velocity_m_per_s
    }
}

/// The cubic through both points that has their velocities.
fn between(from: Point, to: Point, u: f64) -> f64 {
    let (rest, length_s) = (1.0 - u, to.time_s - from.time_s);
    let ends = from.position_m * rest * rest * (1.0 + 2.0 * u) + to.position_m * u * u * (1.0 + 2.0 * rest);
    ends + length_s * u * rest * (from.velocity_m_per_s * rest - to.velocity_m_per_s * u)
}

/// Play with rounded corners: the rod first moves freely within it, and near the flank it takes the encoder along.
fn taken_up(off_m: f64, change_m: f64, half_m: f64) -> f64 {
    let parts = (change_m.abs() / (0.02 * half_m)).ceil().clamp(1.0, 1000.0);
    let part = change_m / parts;
    let (mut off_m, mut done) = (off_m, 0.0);
    while done < parts {
        let near = (off_m / half_m * part.signum()).max(0.0);
        off_m = (off_m + part * (1.0 - near.powi(8))).clamp(-half_m, half_m);
        done += 1.0;
    }
    off_m
}

/// The sensors' view of the plant, with the memory of its effects.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sight {
    effects: Vec<SensingEffect>,
    views: Vec<View>,
    /// The last point, and the result of each view at it.
    last: Option<Point>,
    seen_m: Vec<Point>,
}

impl Sight {
    pub(crate) fn new(effects: &[PlantEffect]) -> Self {
        let sensing =
            |effect: &PlantEffect| if let PlantEffect::Sensing(effect) = effect { Some(*effect) } else { None };
        Self { effects: effects.iter().filter_map(sensing).collect(), ..Self::default() }
    }

    /// What sensors without noise would show. Times rise from call to call.
    pub(crate) fn see(&mut self, time_s: f64, state: &PlantState) -> Reading {
        let now = Point { time_s, position_m: state.position_m, velocity_m_per_s: state.velocity_m_per_s };
        let mut reading = Reading {
            spool: state.spool,
            position_m: self.position(now),
            pressure_a_pa: state.pressure_a_pa,
            pressure_b_pa: state.pressure_b_pa,
            supply_pressure_pa: state.supply_pressure_pa,
        };
        for effect in &self.effects {
            let (channel, factor, offset) = match *effect {
                SensingEffect::Offset { channel, offset } => (channel, 1.0, offset),
                SensingEffect::Factor { channel, excess } => (channel, 1.0 + excess, 0.0),
                _ => continue,
            };
            let value = match channel {
                MeasuredSignal::Spool => &mut reading.spool,
                MeasuredSignal::Position => &mut reading.position_m,
                MeasuredSignal::PressureA => &mut reading.pressure_a_pa,
                MeasuredSignal::PressureB => &mut reading.pressure_b_pa,
            };
            *value = *value * factor + offset;
        }
        reading
    }

    fn position(&mut self, now: Point) -> f64 {
        let Some(last) = self.last.replace(now) else {
            self.views = self.effects.iter().filter_map(|&effect| View::of(effect, now)).collect();
            self.seen_m = vec![now; self.views.len()];
            return now.position_m;
        };
        let (mut from, mut to) = (last, now);
        for (view, seen) in self.views.iter_mut().zip(&mut self.seen_m) {
            let position_m = view.pass(from, to);
            let velocity_m_per_s = (position_m - seen.position_m) / (to.time_s - seen.time_s);
            let next = Point { time_s: to.time_s, position_m, velocity_m_per_s };
            from = std::mem::replace(seen, next);
            to = next;
        }
        to.position_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rod on a sine of 30 mm and 1 Hz, seen every millisecond.
    fn seen(effect: SensingEffect) -> Vec<(f64, f64)> {
        let mut sight = Sight::new(&[PlantEffect::Sensing(effect)]);
        let rod = |k: u32| {
            let phase = std::f64::consts::TAU * f64::from(k) * 1e-3;
            let (position_m, velocity_m_per_s) = (0.1 + 0.03 * phase.sin(), 0.03 * std::f64::consts::TAU * phase.cos());
            PlantState { position_m, velocity_m_per_s, ..PlantState::default() }
        };
        (0..2000).map(|k| (rod(k).position_m, sight.see(f64::from(k) * 1e-3, &rod(k)).position_m)).collect()
    }

    #[test]
    fn play_follows_by_half_of_it_on_either_side_and_rests_after_a_reversal() {
        let seen = seen(SensingEffect::Backlash { play_m: 1e-3 });
        assert!((seen[1500].1 - seen[1500].0 - 0.5e-3).abs() < 5e-5, "retracting");
        assert!((seen[1900].1 - seen[1900].0 + 0.5e-3).abs() < 5e-5, "extending");
        // After the reversal the rod takes 41 ms to move 1 mm; half of this is within the play.
        let rest = (seen[1250].1 - seen[1275].1).abs();
        assert!(rest < 1e-4, "{rest}");
    }

    #[test]
    fn a_delay_and_a_slow_filter_lag_by_their_time_at_any_speed() {
        for (effect, lag_s) in [
            (SensingEffect::PositionDelay { delay_s: 0.0125 }, 0.0125),
            (SensingEffect::PositionFilter { frequency_hz: 20.0, damping: 0.8 }, 1.6 / (std::f64::consts::TAU * 20.0)),
        ] {
            let seen = seen(effect);
            for k in [1000_u16, 1100, 1600] {
                let phase = std::f64::consts::TAU * (f64::from(k) * 1e-3 - lag_s);
                let expected = 0.1 + 0.03 * phase.sin();
                assert!((seen[usize::from(k)].1 - expected).abs() < 1.5e-4, "{effect:?} {k}");
            }
        }
    }

    #[test]
    fn a_flexible_structure_rings_at_its_own_frequency_after_a_jerk() {
        let mut sight = Sight::new(&[PlantEffect::Sensing(SensingEffect::Flexibility {
            frequency_hz: 25.0,
            damping: 0.02,
            share: 1.0,
        })]);
        let mut off = Vec::new();
        for k in 0..500_u32 {
            let time_s = f64::from(k) * 1e-3;
            let position_m = 0.2 * (time_s - 0.1).max(0.0);
            let velocity_m_per_s = if time_s > 0.1 { 0.2 } else { 0.0 };
            let state = PlantState { position_m, velocity_m_per_s, ..PlantState::default() };
            off.push(sight.see(time_s, &state).position_m - position_m);
        }
        let crossings = off[110..].windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
        assert!((18..=21).contains(&crossings), "{crossings}");
        let largest = off.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        assert!((0.8e-3..1.4e-3).contains(&largest), "v/ω is 1.27 mm, found {largest}");
    }

    #[test]
    fn an_offset_moves_one_channel_only() {
        let offset = SensingEffect::Offset { channel: MeasuredSignal::PressureA, offset: 2e5 };
        let mut sight = Sight::new(&[PlantEffect::Sensing(offset)]);
        let state = PlantState { pressure_a_pa: 1e6, pressure_b_pa: 1e6, ..PlantState::default() };
        let reading = sight.see(0.0, &state);
        assert!((reading.pressure_a_pa - 1.2e6).abs() < 1e-3 && (reading.pressure_b_pa - 1e6).abs() < 1e-3);
    }
}
