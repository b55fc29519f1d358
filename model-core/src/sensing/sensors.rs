//! Sensors with errors: play, lag and dead time of the position's sensor, offsets and gain errors of all sensors.
//!
//! rod → play → first-order lag → dead time → gain error → sensed position. The others read true·(1 + factor) + offset. The lag
//! is exact for a position that moves linearly within each tick; a fraction of a tick in the dead time is interpolated linearly. A sensed
//! position is a signal: steps of 2⁻²⁸ strokes, ±8 strokes. Where no sensor effect is on, it is the position itself.

use crate::number::Number;
use crate::ports::{ChamberState, MotionState};

/// Coefficients of all sensors at one tick. With `None` the sensor reads the true value.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
pub struct Sensors<N: Number> {
    /// Half the play between rod and sensor, strokes.
    #[doc(hidden)]
    pub half_play: Option<N>,
    #[doc(hidden)]
    pub lag: Option<Lag<N>>,
    #[doc(hidden)]
    pub delay: Option<Delay<N>>,
    /// 1 + gain error of the position's sensor.
    #[doc(hidden)]
    pub position: Option<N::Gain>,
    #[doc(hidden)]
    pub pressure_a: Option<Reading<N>>,
    #[doc(hidden)]
    pub pressure_b: Option<Reading<N>>,
    #[doc(hidden)]
    pub spool: Option<Reading<N>>,
    /// 1
    #[doc(hidden)]
    pub unity: N::Gain,
}

/// First-order lag over a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Lag<N: Number> {
    /// e^(−h/T)
    pub decay: N::Gain,
    /// T/h·(1 − e^(−h/T)): by how much the output falls behind, per travel of a tick.
    pub behind: N::Gain,
}

/// Dead time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[doc(hidden)]
pub struct Delay<N> {
    /// Whole ticks.
    pub ticks: usize,
    /// Remainder of the dead time, in ticks, 0..1.
    pub rest: N,
}

/// Gain and offset of a sensor's reading.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Reading<N: Number> {
    /// 1 + gain error.
    pub factor: N::Gain,
    /// Offset that is added to the true value.
    pub offset: N,
}

impl<N: Number> Reading<N> {
    #[inline]
    fn of(&self, signal: N) -> N {
        N::dot([self.factor], [signal]) + self.offset
    }
}

/// State of the sensors, with the dead time's line of `DELAY` ticks (a power of two). Unchanged where the position is read without error.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(serialize = "N: serde::Serialize", deserialize = "N: serde::Deserialize<'de>"))
)]
pub struct SensedState<N: Number, const DELAY: usize> {
    /// What the sensor showed at the state's start, strokes: the gain error is relative to it.
    origin: N,
    /// Output of the play, strokes. At the start the rod stands in the middle of its play, unless the sensor is told to [`show`](Self::show) otherwise.
    played: N,
    /// By how much the lag's output is behind.
    behind: N,
    /// Outputs of the lag at past ticks, a ring.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    line: [N; DELAY],
    /// Where the next output is written.
    head: u32,
    /// Sensed position before its gain error.
    position: N,
}

/// What the sensors read.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
pub struct Sensed<N: Number> {
    /// Spool; 1 is full travel.
    pub spool: N,
    /// Pressure in A, per unit of supply pressure.
    pub pressure_a: N,
    /// Pressure in B.
    pub pressure_b: N,
    /// Position.
    pub position: N::Travel,
    /// Velocity of the rod, by a sensor of its own.
    pub velocity: N,
}

impl<N: Number, const DELAY: usize> SensedState<N, DELAY> {
    /// At rest, after the rod stood here for a long time.
    pub(crate) fn at_rest(position: N::Travel) -> Self {
        let origin = N::of_travel(position);
        Self { origin, played: origin, behind: N::ZERO, line: [origin; DELAY], head: 0, position: origin }
    }

    /// The rod stands beside the middle of its play: the sensor shows this position, strokes.
    pub fn show(&mut self, reading: N) {
        (self.origin, self.played, self.position, self.line) = (reading, reading, reading, [reading; DELAY]);
    }

    /// The rod has moved evenly for longer than the lag: its output differs by this from the position, strokes.
    pub fn trail(&mut self, behind: N) {
        let reading = self.played + behind;
        (self.behind, self.position, self.line) = (behind, reading, [reading; DELAY]);
    }

    /// The rod is further by this than the run has moved it, strokes, and was so for longer than lag and delay.
    pub fn shift(&mut self, further: N) {
        (self.played, self.position) = (self.played + further, self.position + further);
        self.line = self.line.map(|reading| reading + further);
    }
}

impl<N: Number> Sensors<N> {
    /// Whether the position's sensor needs its state.
    #[inline]
    pub(crate) fn follows(&self) -> bool {
        self.half_play.is_some() || self.lag.is_some() || self.delay.is_some()
    }

    /// The position's sensor after a tick.
    #[inline]
    pub(crate) fn step<const DELAY: usize>(&self, state: &mut SensedState<N, DELAY>, position: N::Travel) {
        if !self.follows() {
            return;
        }
        let rod = N::of_travel(position);
        let before = state.played;
        state.played = match self.half_play {
            Some(half) => before.max(rod - half).min(rod + half),
            None => rod,
        };
        state.behind = match &self.lag {
            Some(lag) => N::dot([lag.decay, lag.behind], [state.behind, before - state.played]),
            None => N::ZERO,
        };
        let lagged = state.played + state.behind;
        state.position = match &self.delay {
            Some(delay) => delay.passed(&mut state.line, &mut state.head, lagged),
            None => lagged,
        };
    }

    /// What the sensors read.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn read<const DELAY: usize>(
        &self,
        state: &SensedState<N, DELAY>,
        spool: N,
        pressures: ChamberState<N>,
        motion: &MotionState<N>,
    ) -> Sensed<N> {
        let read = |reading: &Option<Reading<N>>, signal: N| reading.map_or(signal, |reading| reading.of(signal));
        Sensed {
            spool: read(&self.spool, spool),
            pressure_a: read(&self.pressure_a, pressures.a),
            pressure_b: read(&self.pressure_b, pressures.b),
            position: self.position(state, motion.position),
            velocity: motion.velocity,
        }
    }

    #[inline]
    fn position<const DELAY: usize>(&self, state: &SensedState<N, DELAY>, position: N::Travel) -> N::Travel {
        if !self.follows() && self.position.is_none() {
            return position;
        }
        let sensed = if self.follows() { state.position } else { N::of_travel(position) };
        let sensed = self.position.map_or(sensed, |factor| state.origin + N::dot([factor], [sensed - state.origin]));
        N::travelled(N::ZERO.as_travel(), [self.unity], [sensed])
    }
}

impl<N: Number> Delay<N> {
    /// Stores a value and returns the value of `ticks + rest` ticks before.
    #[inline]
    #[expect(clippy::indexing_slicing, reason = "the index is masked to the length, a power of two")]
    fn passed<const DELAY: usize>(&self, line: &mut [N; DELAY], head: &mut u32, value: N) -> N {
        const { assert!(DELAY.is_power_of_two() && DELAY <= 1 << 30, "the delay line's length is a power of two") };
        let newest = *head as usize;
        line[newest & (DELAY - 1)] = value;
        *head = head.wrapping_add(1);
        let younger = line[newest.wrapping_sub(self.ticks) & (DELAY - 1)];
        let older = line[newest.wrapping_sub(self.ticks).wrapping_sub(1) & (DELAY - 1)];
        younger + (older - younger).times(self.rest)
    }
}
