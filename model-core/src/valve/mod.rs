//! ```text
//! y = 0.0559·U + 0.0345                                                  (15)
//! G(s) = 1/((1 + 0.018·s)·(1 + 0.0279·s))·e^(−0.007·s)                   (16)
//! ```
//!
//! The valve link: command → spool, Fig. 5: static characteristic → rate limiter → transport delay → two first-order lags. As computed, over a
//! tick h with the command U held; every number of (15) and (16) is a parameter:
//!
//! ```text
//! y  = gain·U + offset                                                   (15)
//! r' = r + limited(y − r)                          rate limiter; its mean over the tick goes on
//! d  = that mean, delay ticks ago                  e^(−delay·s)          (16)
//! l' = d + e^(−h/T1)·(l − d)                       1/(1 + T1·s)          (16)
//! x' = d + e^(−h/T2)·(x − d) + cross·(l − d)       1/(1 + T2·s)          (16)
//! ```
//!
//! A spool that is a second-order system (`valve.natural_frequency_hz`) hands back: l' has a part of x − d as well, see `coefficients::lags`.
//! Its largest speed acts behind the lags.
//!
//! Within a tick the set value ramps at the limit until it arrives. Its *mean* over the tick keeps the area that reaches the spool
//! exact for any tick length; the lags answer that mean exactly (no discretisation error of their own).
//!
//! Formats: the command is a signal, 1 being 10 V; the spool is a signal, 1 being full travel (±8, step 3.7e-9); gains and decays are gains
//! (below 4). Signs: a positive command moves the spool in the direction that opens P-A and B-T; a negative gain reverses this.

pub(crate) mod effects;

use effects::{SpeedLimit, Swing, ValveEffectState, ValveEffects};

use crate::effects::{AnyEffect, Keeps, Knows};
use crate::number::Number;
use crate::ports::{AcrossEdges, Spool};

/// Coefficients of the valve at one tick, with those of its effects.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(bound = "N: crate::number::Written, E: serde::Serialize")
)]
pub struct Valve<N: Number, E = ValveEffects<N>> {
    /// Spool travel per 10 V. (15)
    #[doc(hidden)]
    pub gain: N::Gain,
    /// Spool travel at 0 V. (15)
    #[doc(hidden)]
    pub offset: N,
    /// Largest change of the set value in a tick.
    #[doc(hidden)]
    pub step_limit: N,
    /// 1 / (2·`step_limit`); 0 where nothing limits.
    #[doc(hidden)]
    pub half_per_step: N::Steep,
    /// Whole ticks of delay.
    #[doc(hidden)]
    pub delay_ticks: usize,
    /// Remainder of the delay, in ticks, 0..1.
    #[doc(hidden)]
    pub delay_rest: N,
    /// e^(−h/T1); of a second-order spool, what is left of its lead.
    #[doc(hidden)]
    pub decay_1: N::Gain,
    /// e^(−h/T2)
    #[doc(hidden)]
    pub decay_2: N::Gain,
    /// T1·(e^(−h/T1) − e^(−h/T2)) / (T1 − T2)
    #[doc(hidden)]
    pub cross: N::Gain,
    #[doc(hidden)]
    pub effects: E,
}

/// State of the valve, with the delay line of `DELAY` ticks (a power of two).
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
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
    /// Output of the first lag; of a second-order spool x + x′/ω.
    lag: N,
    /// Spool position; 1 is full travel.
    spool: N,
    effects: ValveEffectState<N>,
}

impl<N: Number, E> Valve<N, E> {
    /// The same valve with these effects.
    #[inline]
    pub(crate) fn with<F>(&self, effects: F) -> Valve<N, F> {
        let &Self { gain, offset, step_limit, half_per_step, delay_ticks, delay_rest, decay_1, decay_2, cross, .. } =
            self;
        Valve { gain, offset, step_limit, half_per_step, delay_ticks, delay_rest, decay_1, decay_2, cross, effects }
    }
}

impl<N: Number> Valve<N> {
    /// The valve at rest after `command` (in 10 V) was held for a long time, with no oil flowing.
    ///
    /// Hysteresis has settled in the middle of its width, the neutral has not yet drifted, and the spool is not stuck.
    #[must_use]
    pub fn at_rest<const DELAY: usize>(&self, command: N) -> ValveState<N, DELAY> {
        self.at_rest_with::<AnyEffect, DELAY>(command)
    }

    pub(crate) fn at_rest_with<V: Knows<ValveEffects<N>>, const DELAY: usize>(
        &self,
        command: N,
    ) -> ValveState<N, DELAY> {
        ValveState::at_rest(V::its(&self.effects).fed(self.target(command)))
    }

    /// One tick with `command` (in 10 V, any size) held and no flow force.
    #[inline]
    pub fn step<const DELAY: usize>(&self, state: &mut ValveState<N, DELAY>, command: N) -> Spool<N> {
        self.step_against(state, command, AcrossEdges::NONE)
    }

    /// One tick with `command` (in 10 V, any size) held, against the force of the oil that flows.
    #[inline]
    pub fn step_against<const DELAY: usize>(
        &self,
        state: &mut ValveState<N, DELAY>,
        command: N,
        across: AcrossEdges<N>,
    ) -> Spool<N> {
        self.step_with::<AnyEffect, DELAY>(state, command, across)
    }
}

impl<N: Number, E: Keeps<ValveEffects<N>>> Valve<N, E> {
    #[inline]
    pub(crate) fn step_with<V: Knows<ValveEffects<N>>, const DELAY: usize>(
        &self,
        state: &mut ValveState<N, DELAY>,
        command: N,
        across: AcrossEdges<N>,
    ) -> Spool<N> {
        let effects = V::of(self.effects.kept());
        let target = self.target(command);
        let target = effects.map_or(target, |effects| effects.characteristic(target, &mut state.effects));
        let mean = self.limit_rate(&mut state.set, target);
        let [younger, older] = self.delay(&mut state.line, &mut state.head, mean);
        let change = older - younger;
        let delayed = younger + self.delay_rest.of(change);
        let from = state.spool;
        let second = effects.map_or(from, |effects| effects.second_lag(&state.effects, from));
        let lags = (state.lag, second);
        let (mut lag, mut free) = self.moved(effects, lags, delayed, change);
        if let Some(force) = effects.and_then(|effects| effects.flow_force.as_ref()) {
            (lag, free) = self.moved(effects, lags, delayed - force.closes(second, free, across), change);
        }
        state.lag = lag;
        state.spool = effects.map_or(free, |effects| effects.handed_on(&mut state.effects, from, free));
        Spool { from, to: state.spool }
    }

    /// Whether the spool feels a flow force.
    #[inline]
    pub(crate) fn feels_flow<V: Knows<ValveEffects<N>>>(&self) -> bool {
        V::of(self.effects.kept()).is_some_and(|effects| effects.flow_force.is_some())
    }
}

impl<N: Number, E> Valve<N, E> {
    /// Both lags a tick later, on the way to `set` in the mean over the tick, which begins `change` further for the rest of the delay.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "so a drive that is compiled with its values keeps nothing of what it has not"
    )]
    fn moved(&self, effects: Option<&ValveEffects<N>>, lags: (N, N), set: N, change: N) -> (N, N) {
        match effects.and_then(ValveEffects::sliding) {
            Some(stiction) => stiction.slid(lags, set, |set| self.towards(effects, lags, set, change)),
            None => self.towards(effects, lags, set, change),
        }
    }

    /// The same without stiction.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as `moved`")]
    fn towards(&self, effects: Option<&ValveEffects<N>>, lags: (N, N), set: N, change: N) -> (N, N) {
        let limit = effects.and_then(|effects| effects.speed_limit.as_ref());
        match effects.and_then(|effects| effects.swing.as_ref()) {
            None => {
                let (lag, free) = self.lagged(lags, set);
                (lag, limit.map_or(free, |limit| lags.1 + (free - lags.1).limited(limit.step)))
            }
            Some(swing) => {
                let last = set - self.delay_rest.of(change);
                self.swung(swing, limit, lags, [last + change, last])
            }
        }
    }

    /// Both lags a tick later, on the way to `set`; `cross` is what the first hands to the second meanwhile.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn lagged(&self, (first, second): (N, N), set: N) -> (N, N) {
        let (first, second) = (first - set, second - set);
        (set + first.part(self.decay_1), set + N::dot([self.decay_2, self.cross], [second, first]))
    }

    /// A second-order spool a tick later, which begins with the first of these set values and ends with the other.
    // By itself on a controller: a drive without it that is compiled with its values then keeps nothing of it.
    #[cfg_attr(target_os = "none", inline(never))]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn swung(&self, swing: &Swing<N>, limit: Option<&SpeedLimit<N>>, lags: (N, N), sets: [N; 2]) -> (N, N) {
        let limit = limit.and_then(|limit| Some((limit, limit.swinging.as_ref()?)));
        let [lag_set, spool_set] = swing.answered(limit.map_or(sets, |(_, swinging)| swinging.pulling(lags, sets)));
        let (first, second) = lags;
        let lag = N::dot([self.decay_1, swing.back], [first - lag_set, second - lag_set]);
        let spool = N::dot([self.decay_2, self.cross], [second - spool_set, first - spool_set]);
        let moved = (lag_set + lag, spool_set + spool);
        limit.map_or(moved, |(limit, swinging)| swinging.held(limit.step, lags, moved))
    }

    /// Static characteristic. (15)
    #[inline]
    pub(crate) fn target(&self, command: N) -> N {
        N::dot([self.gain], [command]) + self.offset
    }

    /// Moves the set value and returns its mean over the tick: it ramps for the share |d|/limit of the tick, then rests.
    #[inline]
    fn limit_rate(&self, set: &mut N, target: N) -> N {
        let step = (target - *set).limited(self.step_limit);
        *set = *set + step;
        *set - step.magnitude_amplified(self.half_per_step).of(step)
    }

    /// The set value `delay_ticks` ticks back and one more: a tick that lies `delay_ticks + delay_rest` back begins with the share `delay_rest` of the
    /// older one.
    #[inline]
    #[expect(clippy::indexing_slicing, reason = "the index is masked to the length, a power of two")]
    fn delay<const DELAY: usize>(&self, line: &mut [N; DELAY], head: &mut u32, mean: N) -> [N; 2] {
        const { assert!(DELAY.is_power_of_two() && DELAY <= 1 << 30, "the delay line's length is a power of two") };
        let newest = *head as usize;
        line[newest & (DELAY - 1)] = mean;
        *head = head.wrapping_add(1);
        let younger = line[newest.wrapping_sub(self.delay_ticks) & (DELAY - 1)];
        let older = line[newest.wrapping_sub(self.delay_ticks).wrapping_sub(1) & (DELAY - 1)];
        [younger, older]
    }
}

impl<N: Number, const DELAY: usize> ValveState<N, DELAY> {
    /// The state of a drive without a valve.
    pub(crate) fn idle() -> Self {
        Self::at_rest(N::ZERO)
    }

    /// Everything settled at this set value.
    pub(crate) fn at_rest(set: N) -> Self {
        let effects = ValveEffectState::at_rest(set);
        Self { set, line: [set; DELAY], head: 0, lag: set, spool: set, effects }
    }

    /// The spool on its way: it is at `spool`, the first lag's output is at `lag`, and the set value has been `set` for longer than the delay.
    #[must_use]
    pub fn on_its_way(spool: N, lag: N, set: N) -> Self {
        let mut effects = ValveEffectState::at_rest(set);
        effects.release(spool);
        Self { set, line: [set; DELAY], head: 0, lag, spool, effects }
    }

    /// Spool position; 1 is full travel, positive extends the rod.
    #[must_use]
    pub fn spool(&self) -> N {
        self.spool
    }
}
