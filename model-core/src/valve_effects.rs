//! Effects of the valve link: what the slider does beyond Fig. 5.
//!
//! In the order of the chain: the neutral drifts, the solenoid saturates, the play lags behind (all before the rate limiter); the
//! flow force pushes closed (before the lags); the slider sticks (after them). Each is `None` where its strength is nil, and
//! the valve's step is then the one without it, bit for bit.

use crate::flow::Overlap;
use crate::number::Number;
use crate::relaxation::Relaxation;
use crate::valve::AcrossEdges;

/// Coefficients of the valve's effects at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ValveEffects<N: Number> {
    pub(crate) drift: Option<NullDrift<N>>,
    pub(crate) saturation: Option<SolenoidSaturation<N>>,
    pub(crate) hysteresis: Option<Hysteresis<N>>,
    pub(crate) flow_force: Option<FlowForce<N>>,
    pub(crate) stiction: Option<Stiction<N>>,
}

/// State of the valve's effects. An effect that is off leaves its part untouched.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct ValveEffectState<N> {
    /// Outputs of the three plays.
    plays: [N; 3],
    /// Share of the null drift that has come, 0..1.
    drifted: N,
    /// What its rounding left.
    drifted_rest: N,
    /// The slider without stiction: output of the second lag.
    free: N,
}

impl<N: Number> ValveEffectState<N> {
    /// At rest for long at `target`: every play has settled there from the middle, nothing has drifted, nothing is stuck.
    pub(crate) fn at_rest(target: N) -> Self {
        Self { plays: [target; 3], drifted: N::ZERO, drifted_rest: N::ZERO, free: target }
    }
}

impl<N: Number> ValveEffects<N> {
    /// The static characteristic's output with drift, saturation and play, over a tick.
    #[inline]
    pub(crate) fn characteristic(&self, target: N, state: &mut ValveEffectState<N>) -> N {
        let drifted = match &self.drift {
            Some(drift) => target + drift.step(&mut state.drifted, &mut state.drifted_rest),
            None => target,
        };
        let fed = self.fed(drifted);
        match &self.hysteresis {
            Some(hysteresis) => hysteresis.step(&mut state.plays, fed),
            None => fed,
        }
    }

    /// The target that the solenoid feeds.
    #[inline]
    pub(crate) fn fed(&self, target: N) -> N {
        match &self.saturation {
            Some(saturation) => saturation.fed(target),
            None => target,
        }
    }

    /// Output of the second lag at the start of a tick, where the slider handed on stands at `slider`.
    #[inline]
    pub(crate) fn second_lag(&self, state: &ValveEffectState<N>, slider: N) -> N {
        if self.stiction.is_some() { state.free } else { slider }
    }

    /// The slider handed on, from where it was to where the second lag's output is at the end of the tick.
    #[inline]
    pub(crate) fn handed_on(&self, state: &mut ValveEffectState<N>, slider: N, free: N) -> N {
        let Some(stiction) = &self.stiction else { return free };
        state.free = free;
        stiction.held(slider, free)
    }
}

/// `null-drift`: the neutral moves by `travel`·(1 − e^(−t/τ)), t from where the state began; positive extends.
///
/// Per unit slider travel. The mean of both ends stands for the tick: off by (h/τ)²/12 of what is left, and by 4e-7 of the
/// travel in fixed point. The drift stands still while the chain is entered below the command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NullDrift<N: Number> {
    pub(crate) travel: N,
    pub(crate) relaxation: Relaxation<N>,
}

impl<N: Number> NullDrift<N> {
    #[inline]
    fn step(&self, drifted: &mut N, rest: &mut N) -> N {
        let before = *drifted;
        (*drifted, *rest) = self.relaxation.towards(N::ONE, before, *rest);
        self.travel.times((before + *drifted).halved())
    }
}

/// `solenoid-saturation`: beyond the onset the travel d becomes d/(1 + `curvature`·d), to both sides.
///
/// Per unit slider travel from the centre; smooth to the first derivative. In fixed point within 2e-8 and 8e-6·d² (the curvature's
/// step). After the force characteristic of a proportional solenoid near its stop: Jelali & Kroll, *Hydraulic Servo-systems*, 2003, ch. 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SolenoidSaturation<N: Number> {
    pub(crate) onset: N,
    pub(crate) curvature: N::Steep,
}

impl<N: Number> SolenoidSaturation<N> {
    #[inline]
    fn fed(&self, target: N) -> N {
        let straight = target.limited(self.onset);
        let beyond = target - straight;
        straight + beyond.times(N::inverse_one_plus([beyond.magnitude()], [self.curvature]))
    }
}

/// `valve-hysteresis`: the mean of three plays, a Prandtl-Ishlinskii operator with equal weights.
///
/// A play of half-width w keeps its output until the target is w away, then follows at that distance. The half-widths are
/// ½·width·(1 − spread, 1, 1 + spread), so the mean settles `width` apart from above and from below, at any rate. Per unit slider
/// travel; exact but for one rounding. Krasnosel'skii & Pokrovskii, *Systems with Hysteresis*, 1989, §2 and §37.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hysteresis<N: Number> {
    pub(crate) half_widths: [N; 3],
    /// ⅓
    pub(crate) third: N::Gain,
}

impl<N: Number> Hysteresis<N> {
    #[inline]
    fn step(&self, plays: &mut [N; 3], target: N) -> N {
        for (play, &half) in plays.iter_mut().zip(&self.half_widths) {
            *play = play.max(target - half).min(target + half);
        }
        target + N::dot([self.third; 3], plays.map(|play| play - target))
    }
}

/// `flow-force`: the oil that flows through the open edges pushes the slider closed, by `closing`·o·Δp of set value.
///
/// o is the travel beyond the dead zone: the steady flow force, 2·Cd·w·o·Δp·cos θ (Merritt, *Hydraulic Control Systems*, 1967,
/// eq. 5-29), is one of the opening. Δp ≥ 0 is the sum of both open edges' differences at the start of the tick; o is taken where
/// the force lets the slider come to by the end of the tick, o = `free`/(1 + `share`·`closing`·Δp), so that no force, however
/// strong, makes the slider swing from tick to tick. A stuck slider's force is that of where it would be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FlowForce<N: Number> {
    /// Share of its opening that the slider closes by, per pressure.
    pub(crate) closing: N,
    pub(crate) overlap: Overlap<N>,
    /// How much of a set value the lags let through in a tick.
    pub(crate) share: N,
    /// 1, as a slope.
    pub(crate) unity: N::Steep,
}

impl<N: Number> FlowForce<N> {
    /// What the set value is reduced by, signed like the opening; `free` is the slider at the end of the tick without the force.
    #[inline]
    pub(crate) fn closes(&self, free: N, across: AcrossEdges<N>) -> N {
        let beyond = self.overlap.beyond(free);
        let strength = self.closing.times(beyond.select_positive(across.extending, across.retracting));
        beyond.times(N::inverse_one_plus([strength.times(self.share)], [self.unity])).times(strength)
    }
}

/// `spool-stiction`: the slider stays until it is asked for more than `band` elsewhere, then jumps there and stays again.
///
/// Per unit slider travel; exact. The jump ends where the free slider is at the end of the tick; see [`Slider`](crate::valve::Slider) for
/// how it lies within the tick. A stick-slip limit of Armstrong-Hélouvry, Dupont & Canudas de Wit, *Automatica* 30, 1994.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stiction<N: Number> {
    pub(crate) band: N,
}

impl<N: Number> Stiction<N> {
    #[inline]
    fn held(&self, slider: N, free: N) -> N {
        if (free - slider).magnitude() > self.band { free } else { slider }
    }
}
