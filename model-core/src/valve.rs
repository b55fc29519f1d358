//! The valve link: command → slider. Fig. 5, (15), (16) of the paper.
//!
//! Static characteristic → rate limiter → transport delay → two first-order lags. The command is held over a tick.
//! Within a tick the set value ramps at the limit until it arrives, so its *mean* over the tick is exact in the area
//! that reaches the slider whatever the tick is; the lags answer that mean exactly (no discretisation error of their own).

use crate::number::Number;

/// Coefficients of the valve at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Valve<N: Number> {
    /// Slider travel per 10 V. (15)
    pub(crate) gain: N::Gain,
    /// Slider travel at 0 V. (15)
    pub(crate) offset: N,
    /// Largest change of the set value in a tick.
    pub(crate) step_limit: N,
    /// 1 / (2·`step_limit`); 0 where nothing limits.
    pub(crate) half_per_step: N::Steep,
    /// Whole ticks of delay.
    pub(crate) delay_ticks: usize,
    /// The rest of the delay, in ticks, 0..1.
    pub(crate) delay_rest: N,
    /// e^(−h/T1)
    pub(crate) decay_1: N::Gain,
    /// e^(−h/T2)
    pub(crate) decay_2: N::Gain,
    /// T1·(e^(−h/T1) − e^(−h/T2)) / (T1 − T2)
    pub(crate) cross: N::Gain,
}

/// State of the valve, with the delay line of `DELAY` ticks (a power of two).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(serialize = "N: serde::Serialize", deserialize = "N: serde::Deserialize<'de>"))
)]
pub struct ValveState<N: Number, const DELAY: usize> {
    /// Set value after the rate limiter.
    set: N,
    /// Means of the set value over past ticks, a ring.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    line: [N; DELAY],
    /// Where the next mean is written.
    head: u32,
    /// Output of the first lag.
    lag: N,
    /// Slider position; 1 is full travel.
    slider: N,
}

/// The slider over one tick; between the two it moves linearly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slider<N> {
    /// At the start of the tick.
    pub from: N,
    /// At its end.
    pub to: N,
}

impl<N: Number> Valve<N> {
    /// The valve at rest with `command` (in 10 V) having been held for long.
    #[must_use]
    pub fn at_rest<const DELAY: usize>(&self, command: N) -> ValveState<N, DELAY> {
        let set = self.target(command);
        ValveState { set, line: [set; DELAY], head: 0, lag: set, slider: set }
    }

    /// One tick with `command` (in 10 V, any size) held.
    #[inline]
    pub fn step<const DELAY: usize>(&self, state: &mut ValveState<N, DELAY>, command: N) -> Slider<N> {
        let mean = self.limit_rate(&mut state.set, command);
        let delayed = self.delay(&mut state.line, &mut state.head, mean);
        let from = state.slider;
        // Both lags relax towards the mean; `cross` is what the first hands to the second meanwhile.
        let (first, second) = (state.lag - delayed, state.slider - delayed);
        state.lag = delayed + N::dot([self.decay_1], [first]);
        state.slider = delayed + N::dot([self.decay_2, self.cross], [second, first]);
        Slider { from, to: state.slider }
    }

    /// Static characteristic. (15)
    #[inline]
    fn target(&self, command: N) -> N {
        N::dot([self.gain], [command]) + self.offset
    }

    /// Moves the set value and returns its mean over the tick: it ramps for the share |d|/limit of it, then rests.
    #[inline]
    fn limit_rate(&self, set: &mut N, command: N) -> N {
        let step = (self.target(command) - *set).limited(self.step_limit);
        *set = *set + step;
        *set - step.times(step.magnitude().amplified(self.half_per_step))
    }

    /// The mean of the set value over a tick that lies `delay_ticks + delay_rest` ticks back.
    #[inline]
    #[expect(clippy::indexing_slicing, reason = "the index is masked to the length, a power of two")]
    fn delay<const DELAY: usize>(&self, line: &mut [N; DELAY], head: &mut u32, mean: N) -> N {
        const { assert!(DELAY.is_power_of_two() && DELAY <= 1 << 30, "the delay line's length is a power of two") };
        let newest = *head as usize;
        line[newest & (DELAY - 1)] = mean;
        *head = head.wrapping_add(1);
        let younger = line[newest.wrapping_sub(self.delay_ticks) & (DELAY - 1)];
        let older = line[newest.wrapping_sub(self.delay_ticks).wrapping_sub(1) & (DELAY - 1)];
        younger + (older - younger).times(self.delay_rest)
    }
}

impl<N: Number, const DELAY: usize> ValveState<N, DELAY> {
    /// The state of a drive without a valve.
    pub(crate) fn idle() -> Self {
        Self { set: N::ZERO, line: [N::ZERO; DELAY], head: 0, lag: N::ZERO, slider: N::ZERO }
    }

    /// Slider position; 1 is full travel, positive extends the rod.
    #[must_use]
    pub fn slider(&self) -> N {
        self.slider
    }
}
