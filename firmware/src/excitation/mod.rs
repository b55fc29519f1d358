//! Excitations of a commissioning run: set points that move the rod to and fro about the place where it stands, so that a recording shows how the drive answers.
//!
//! With the phase φ, its rate ω = dφ/dt, and a window g that rises from 0 to 1 over the first period of the sine and falls over its last one:
//!
//! ```text
//! sine      y = A·g·sin φ                  ω = 2π·f
//! sweep     y = A·g·sin φ                  ω = 2π·f₀·(f₁/f₀)^(t/T): every octave takes the same time
//!           A = 1/√(1/A₀² + (ω/v)² + (ω²/a)²)
//! strokes   y = A·(1 − cos φ)/2 there and back, with a rest at either end; at a quarter, half, three quarters and all of v, short ones slower, within the acceleration a
//! ```
//!
//! v and a are 80 % of the bounds' velocity and acceleration. The rest is for the window and for rounding: no excitation is refused by the
//! [`Envelope`](crate::set_point::Envelope) of its bounds, which checks it tick by tick like any other set point. So does the period with its other limits.
//! What [`plan`] plays is not made here, and moves a model in place of a set point.
//!
//! The sine is that of `micromath`, single precision: within 0.002 of the amplitude, with a smooth slope. That is good enough here and nowhere else in the
//! period, since what is played is recorded. The rate of a sweep is within 1 % of what is stated, in all its length.

pub mod plan;
mod refused;

use micromath::F32Ext;
use model_core::control::SetPoint;
use model_core::machine::Bases;
use model_core::number::{Number, PerUnit};

use crate::set_point::Bounds;

pub use refused::{ExcitationError, PlanError};

/// How the rod is to be moved, as an engineer states it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Excitation {
    /// A sine.
    Sine {
        /// Amplitude, m.
        amplitude_m: f64,
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Length, s: at least two periods.
        duration_s: f64,
    },
    /// A sine whose frequency grows.
    Sweep {
        /// Amplitude, m, that is not exceeded; it falls with the frequency as the bounds demand.
        amplitude_m: f64,
        /// Frequency at the start, Hz.
        from_hz: f64,
        /// Frequency at the end, Hz: at least twice that at the start.
        to_hz: f64,
        /// Length, s: at least one period of each.
        duration_s: f64,
    },
    /// Strokes at four speeds.
    Strokes {
        /// Length of a stroke, m; positive extends first.
        amplitude_m: f64,
        /// Rest at each of its ends, s.
        rest_s: f64,
    },
}

/// Share of the bounds that an excitation uses.
const USED: f64 = 0.8;
/// Longest excitation, s: so long a sweep keeps its rate within 1 %.
const LONGEST_S: f64 = 120.0;
/// Longest rest, s.
const LONGEST_REST_S: f64 = 10.0;
/// Fewest ticks in a period of a sine.
const FEWEST_TICKS: f64 = 10.0;
/// Least octaves of a sweep: one.
const LEAST_RATIO: f64 = 2.0;
/// Speeds of the strokes.
const SHARES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
const TURN: f64 = core::f64::consts::TAU;

/// An excitation from a place of the rod, in the period's numbers: configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    from: PerUnit,
    shape: Shape,
    ticks: u32,
    /// Velocity, of its base, of one stroke in a tick.
    per_pace: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Sine(Sine),
    Strokes(Strokes),
}

/// A sine, of one frequency or of one that grows.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sine {
    /// Turns in a tick at the start, and the share by which they grow in each.
    rate: f32,
    growth: f32,
    /// 1/A₀², and what the square and the fourth power of the rate add to it; of the stroke.
    least: f32,
    squared: f32,
    fourth: f32,
    /// Ticks of the window's two ends.
    rise: u32,
    fall: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Strokes {
    /// Of the stroke.
    amplitude: f32,
    /// Ticks of one way, at each speed.
    ways: [u32; SHARES.len()],
    rest: u32,
}

/// How far an excitation has got.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WaveState {
    tick: u32,
    /// Phase, 2³² a turn.
    turns: u32,
    /// Turns in a tick, 2³² a turn.
    rate: Option<f32>,
    /// Distance from the place at the start, strokes.
    offset: f32,
}

/// What an excitation may do, in one place for its checks.
struct Room<'a> {
    bases: &'a Bases,
    bounds: &'a Bounds,
    from_m: f64,
}

impl Excitation {
    /// The excitation about `from`, a share of the stroke, within these bounds.
    ///
    /// # Errors
    /// It does not fit: the error says what was found and what is expected.
    pub fn about(&self, from: PerUnit, bases: &Bases, bounds: &Bounds) -> Result<Wave, ExcitationError> {
        let room = Room { bases, bounds, from_m: from.to_f64() * bases.stroke_m };
        let (shape, ticks) = match *self {
            Excitation::Sine { amplitude_m, frequency_hz, duration_s } => {
                room.sine(amplitude_m, frequency_hz, duration_s)?
            }
            Excitation::Sweep { amplitude_m, from_hz, to_hz, duration_s } => {
                room.sweep(amplitude_m, [from_hz, to_hz], duration_s)?
            }
            Excitation::Strokes { amplitude_m, rest_s } => room.strokes(amplitude_m, rest_s)?,
        };
        let per_pace = single(bases.stroke_m / (bases.tick_s * bases.velocity_m_per_s));
        Ok(Wave { from, shape, ticks, per_pace })
    }
}

impl Room<'_> {
    fn velocity_m_per_s(&self) -> f64 {
        USED * self.bounds.velocity_m_per_s
    }

    fn acceleration_m_per_s2(&self) -> f64 {
        USED * self.bounds.acceleration_m_per_s2
    }

    /// A distance on both sides of the place, or only on one, is within the bounds.
    fn amplitude(&self, amplitude_m: f64, both: bool) -> Result<(), ExcitationError> {
        let (out_m, in_m) = (self.bounds.to_m - self.from_m, self.from_m - self.bounds.from_m);
        let most_m = match (both, amplitude_m > 0.0) {
            (true, _) => out_m.min(in_m),
            (false, true) => out_m,
            (false, false) => in_m,
        };
        let size_m = if both { amplitude_m } else { amplitude_m.abs() };
        // NaN fails this comparison.
        if size_m > 0.0 && size_m <= most_m { Ok(()) } else { Err(ExcitationError::Amplitude { amplitude_m, most_m }) }
    }

    fn frequency(&self, found_hz: f64, least_hz: f64) -> Result<(), ExcitationError> {
        let most_hz = 1.0 / (FEWEST_TICKS * self.bases.tick_s);
        if found_hz > 0.0 && (least_hz..=most_hz).contains(&found_hz) {
            return Ok(());
        }
        Err(ExcitationError::Frequency { found_hz, least_hz, most_hz })
    }

    fn sine(&self, amplitude_m: f64, frequency_hz: f64, duration_s: f64) -> Result<(Shape, u32), ExcitationError> {
        self.amplitude(amplitude_m, true)?;
        self.frequency(frequency_hz, 1.0 / LONGEST_S)?;
        let rate_per_s = TURN * frequency_hz;
        let (velocity_m_per_s, most_m_per_s) = (amplitude_m * rate_per_s, self.velocity_m_per_s());
        if velocity_m_per_s > most_m_per_s {
            return Err(ExcitationError::Velocity { velocity_m_per_s, most_m_per_s });
        }
        let (acceleration_m_per_s2, most_m_per_s2) = (velocity_m_per_s * rate_per_s, self.acceleration_m_per_s2());
        if acceleration_m_per_s2 > most_m_per_s2 {
            return Err(ExcitationError::Acceleration { acceleration_m_per_s2, most_m_per_s2 });
        }
        self.wave(amplitude_m, [frequency_hz; 2], duration_s, false)
    }

    fn sweep(&self, amplitude_m: f64, [from, to]: [f64; 2], duration_s: f64) -> Result<(Shape, u32), ExcitationError> {
        self.amplitude(amplitude_m, true)?;
        self.frequency(from, 1.0 / LONGEST_S)?;
        self.frequency(to, LEAST_RATIO * from)?;
        self.wave(amplitude_m, [from, to], duration_s, true)
    }

    fn wave(
        &self,
        amplitude_m: f64,
        [from_hz, to_hz]: [f64; 2],
        duration_s: f64,
        falls: bool,
    ) -> Result<(Shape, u32), ExcitationError> {
        let Bases { stroke_m, tick_s, .. } = *self.bases;
        let least_s = 1.0 / from_hz + 1.0 / to_hz;
        if !(least_s..=LONGEST_S).contains(&duration_s) {
            return Err(ExcitationError::Duration { duration_s, least_s, most_s: LONGEST_S });
        }
        let ticks = whole(duration_s / tick_s);
        // Of the stroke, by the turns in a tick.
        let per_turn = if falls { TURN / tick_s } else { 0.0 };
        let by_velocity = per_turn * stroke_m / self.velocity_m_per_s();
        let by_acceleration = per_turn * per_turn * stroke_m / self.acceleration_m_per_s2();
        let least = stroke_m / amplitude_m;
        let sine = Sine {
            rate: single(from_hz * tick_s),
            growth: single(libm::exp(libm::log(to_hz / from_hz) / f64::from(ticks)) - 1.0),
            least: single(least * least),
            squared: single(by_velocity * by_velocity),
            fourth: single(by_acceleration * by_acceleration),
            rise: whole(1.0 / (from_hz * tick_s)),
            fall: whole(1.0 / (to_hz * tick_s)),
        };
        Ok((Shape::Sine(sine), ticks))
    }

    fn strokes(&self, amplitude_m: f64, rest_s: f64) -> Result<(Shape, u32), ExcitationError> {
        let Bases { stroke_m, tick_s, .. } = *self.bases;
        self.amplitude(amplitude_m, false)?;
        if !(tick_s..=LONGEST_REST_S).contains(&rest_s) {
            return Err(ExcitationError::Duration { duration_s: rest_s, least_s: tick_s, most_s: LONGEST_REST_S });
        }
        let half_turn = 0.5 * TURN;
        let way_m = amplitude_m.abs();
        let by_acceleration_s = half_turn * libm::sqrt(0.5 * way_m / self.acceleration_m_per_s2());
        let ways_s = SHARES.map(|share| {
            let by_velocity_s = 0.5 * half_turn * way_m / (share * self.velocity_m_per_s());
            by_velocity_s.max(by_acceleration_s)
        });
        let duration_s = 2.0 * ways_s.iter().map(|way_s| way_s + rest_s).sum::<f64>();
        if duration_s > LONGEST_S {
            return Err(ExcitationError::Duration { duration_s, least_s: tick_s, most_s: LONGEST_S });
        }
        let ways = ways_s.map(|way_s| whole(way_s / tick_s));
        let rest = whole(rest_s / tick_s);
        let ticks = ways.iter().map(|way| 2 * (way + rest)).sum();
        Ok((Shape::Strokes(Strokes { amplitude: single(amplitude_m / stroke_m), ways, rest }), ticks))
    }
}

/// Ticks, at least one; what is asked for takes at most [`LONGEST_S`].
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some hundred thousand at most")]
fn whole(ticks: f64) -> u32 {
    libm::ceil(ticks - 1e-6).max(1.0) as u32
}

#[expect(clippy::cast_possible_truncation, reason = "seven digits are enough for a motion that is recorded")]
fn single(value: f64) -> f32 {
    value as f32
}

impl Wave {
    /// Returns the set point of this period, and moves on. After the end: the place where it began, at rest.
    pub fn step(&self, state: &mut WaveState) -> SetPoint {
        if self.is_done(state) {
            return SetPoint { position: self.from, velocity: PerUnit::ZERO };
        }
        state.tick += 1;
        let offset = match &self.shape {
            Shape::Sine(sine) => sine.step(state, self.ticks),
            Shape::Strokes(strokes) => strokes.at(state.tick),
        };
        let pace = offset - state.offset;
        state.offset = offset;
        SetPoint { position: self.from + word(offset), velocity: word(pace * self.per_pace) }
    }

    /// Whether it has ended.
    #[must_use]
    pub fn is_done(&self, state: &WaveState) -> bool {
        state.tick >= self.ticks
    }

    /// Length, ticks.
    #[must_use]
    pub fn ticks(&self) -> u32 {
        self.ticks
    }
}

impl Sine {
    fn step(&self, state: &mut WaveState, ticks: u32) -> f32 {
        let rate = state.rate.unwrap_or(self.rate);
        state.rate = Some(rate + rate * self.growth);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most a tenth of a turn")]
        let turned = (rate * WHOLE_TURN) as u32;
        state.turns = state.turns.wrapping_add(turned);
        let square = rate * rate;
        let amplitude = 1.0 / libm::sqrtf(self.least + square * (self.squared + square * self.fourth));
        let window = smooth(share(state.tick, self.rise)) * smooth(share(ticks - state.tick, self.fall));
        amplitude * window * sine(state.turns)
    }
}

impl Strokes {
    fn at(&self, tick: u32) -> f32 {
        let mut left = tick;
        for way in self.ways {
            for (turned, rests) in [(0, HALF_TURN), (HALF_TURN, 0)] {
                if left < way {
                    // A quarter of a turn on, the sine is a cosine.
                    let half = share(left, way) * (0.5 * WHOLE_TURN);
                    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most half a turn")]
                    let turns = (half as u32).wrapping_add(turned);
                    return self.raised(turns);
                }
                left -= way;
                if left < self.rest {
                    return self.raised(rests);
                }
                left -= self.rest;
            }
        }
        0.0
    }

    /// A·(1 − cos φ)/2.
    fn raised(&self, turns: u32) -> f32 {
        0.5 * self.amplitude * (1.0 - sine(turns.wrapping_add(QUARTER_TURN)))
    }
}

const WHOLE_TURN: f32 = 4_294_967_296.0;
const QUARTER_TURN: u32 = 1 << 30;
const HALF_TURN: u32 = 1 << 31;

/// Sine of a phase with 2³² a turn, within 0.002.
fn sine(turns: u32) -> f32 {
    #[expect(clippy::cast_precision_loss, reason = "a phase to 1e-7 of a turn")]
    let angle = turns.cast_signed() as f32 * (core::f32::consts::PI / 2_147_483_648.0);
    // Not that of the standard library, which a test links.
    F32Ext::sin(angle)
}

/// Which share of `whole` has passed, 0 to 1.
fn share(passed: u32, whole: u32) -> f32 {
    #[expect(clippy::cast_precision_loss, reason = "at most 120 000 ticks")]
    let share = passed.min(whole) as f32 / whole as f32;
    share
}

/// 3·s² − 2·s³
fn smooth(share: f32) -> f32 {
    share * share * (3.0 - 2.0 * share)
}

fn word(value: f32) -> PerUnit {
    #[expect(clippy::cast_possible_truncation, reason = "a cast holds what is beyond the format at its end")]
    let bits = (value * 268_435_456.0) as i32;
    PerUnit::from_bits(bits)
}

#[cfg(test)]
mod tests;
