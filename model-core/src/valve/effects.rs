//! What Fig. 5 does not have: effects of the valve link, a spool that swings, and its largest speed.
//!
//! In the order of the chain: the neutral drifts, the solenoid saturates, the hysteresis lags behind (all before the rate limiter); the
//! flow force pushes closed (before the lags); the spool swings instead of lagging, and its speed is limited; it sticks (after both; a spool of second order as it moves). Each is
//! `None` where its amount is 0, and the valve's step is then the one without the effect, bit for bit.

use crate::effects::LinkEffects;
use crate::number::Number;
use crate::number::relaxation::Relaxation;
use crate::ports::{AcrossEdges, Overlap};

/// Coefficients of the valve's effects at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
pub struct ValveEffects<N: Number> {
    #[doc(hidden)]
    pub drift: Option<NullDrift<N>>,
    #[doc(hidden)]
    pub saturation: Option<SolenoidSaturation<N>>,
    #[doc(hidden)]
    pub hysteresis: Option<Hysteresis<N>>,
    #[doc(hidden)]
    pub flow_force: Option<FlowForce<N>>,
    /// Where the spool is a second-order system.
    #[doc(hidden)]
    pub swing: Option<Swing<N>>,
    #[doc(hidden)]
    pub speed_limit: Option<SpeedLimit<N>>,
    #[doc(hidden)]
    pub stiction: Option<Stiction<N>>,
}

/// State of the valve's effects. An effect that is off leaves its part untouched.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct ValveEffectState<N> {
    /// Outputs of the three plays.
    plays: [N; 3],
    /// Share of the null drift that has happened, 0..1.
    drifted: N,
    /// Its rounding remainder.
    drifted_rest: N,
    /// The spool without stiction: output of the second lag.
    free: N,
}

impl<N: Number> ValveEffectState<N> {
    /// At rest for a long time at `target`: every play has settled there from its middle, nothing has drifted, nothing is stuck.
    pub(crate) fn at_rest(target: N) -> Self {
        Self { plays: [target; 3], drifted: N::ZERO, drifted_rest: N::ZERO, free: target }
    }

    /// The spool moves freely through this position.
    pub(crate) fn release(&mut self, spool: N) {
        self.free = spool;
    }
}

impl<N: Number> LinkEffects for ValveEffects<N> {}

impl<N: Number> ValveEffects<N> {
    /// Whether no effect is on.
    pub(crate) fn are_off(&self) -> bool {
        let Self { drift, saturation, hysteresis, flow_force, swing, speed_limit, stiction } = self;
        drift.is_none()
            && saturation.is_none()
            && hysteresis.is_none()
            && flow_force.is_none()
            && swing.is_none()
            && speed_limit.is_none()
            && stiction.is_none()
    }

    /// Output of the static characteristic over a tick, with drift, saturation and play.
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

    /// The target after the solenoid's saturation.
    #[inline]
    pub(crate) fn fed(&self, target: N) -> N {
        match &self.saturation {
            Some(saturation) => saturation.fed(target),
            None => target,
        }
    }

    /// Stiction of a spool without mass, which follows two lags: it jumps.
    #[inline]
    fn jumping(&self) -> Option<&Stiction<N>> {
        self.stiction.as_ref().filter(|_| self.swing.is_none())
    }

    /// Stiction of a spool of second order: it slides.
    #[inline]
    pub(crate) fn sliding(&self) -> Option<&Stiction<N>> {
        self.stiction.as_ref().filter(|_| self.swing.is_some())
    }

    /// Output of the second lag at the start of a tick; `spool` is the position that was handed on.
    #[inline]
    pub(crate) fn second_lag(&self, state: &ValveEffectState<N>, spool: N) -> N {
        if self.jumping().is_some() { state.free } else { spool }
    }

    /// The spool to hand on, from its last position and the second lag's output at the end of the tick.
    #[inline]
    pub(crate) fn handed_on(&self, state: &mut ValveEffectState<N>, spool: N, free: N) -> N {
        let Some(stiction) = self.jumping() else { return free };
        state.free = free;
        stiction.held(spool, free)
    }
}

/// `null-drift`: the neutral moves by `travel`·(1 − e^(−t/τ)), t since the state began; positive extends.
///
/// Per unit spool travel. A tick uses the mean of both ends: its error is (h/τ)²/12 of the drift that is left, and 4e-7 of the
/// travel in fixed point. The drift stands still while the drive input is below the command.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct NullDrift<N: Number> {
    pub travel: N,
    pub relaxation: Relaxation<N>,
}

impl<N: Number> NullDrift<N> {
    #[inline]
    fn step(&self, drifted: &mut N, rest: &mut N) -> N {
        let before = *drifted;
        (*drifted, *rest) = self.relaxation.towards(N::ONE, before, *rest);
        self.travel.times((before + *drifted).halved())
    }
}

/// `solenoid-saturation`: beyond the onset the travel d becomes `kept`·d/(1 + `curvature`·d), in both directions.
///
/// Per unit spool travel from the centre; smooth to the first derivative where the whole gain is kept. Error in fixed point: 2e-8 and
/// 8e-6·d² (the curvature's step). After the force characteristic of a proportional solenoid near its stop: Jelali & Kroll, *Hydraulic Servo-systems*, 2003, ch. 4.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct SolenoidSaturation<N: Number> {
    pub onset: N,
    pub curvature: N::Steep,
    /// Share of the gain.
    pub kept: N,
}

impl<N: Number> SolenoidSaturation<N> {
    #[inline]
    fn fed(&self, target: N) -> N {
        let straight = target.limited(self.onset);
        let beyond = target - straight;
        straight + beyond.times(self.kept).times(N::inverse_one_plus([beyond.magnitude()], [self.curvature]))
    }
}

/// `valve-hysteresis`: the mean of three plays, a Prandtl-Ishlinskii operator with equal weights.
///
/// A play of half-width w keeps its output until the target is w away, then follows at that distance. The half-widths are
/// ½·width·(1 − spread, 1, 1 + spread), so the mean settles `width` apart from above and from below, at any rate. Per unit spool
/// travel; exact but for one rounding. Krasnosel'skii & Pokrovskii, *Systems with Hysteresis*, 1989, §2 and §37.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Hysteresis<N: Number> {
    pub half_widths: [N; 3],
    /// ⅓
    pub third: N::Gain,
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

/// `flow-force`: the oil that flows through the open edges pushes the spool closed; it reduces the set value by c = `closing`·o·Δp.
///
/// o is the travel beyond the dead zone, since the steady flow force, 2·Cd·w·o·Δp·cos θ (Merritt, *Hydraulic Control Systems*, 1967,
/// eq. 5-29), depends on the opening. Δp ≥ 0 is the sum of both open edges' differences at the start of the tick. A tick uses the
/// mean of c at both ends, weighted as the slower lag weights them: ½ each where it is slow, only the end where there are no lags.
/// c at the end is solved for, so that no force, however strong, makes the spool oscillate from tick to tick. For a stuck spool that
/// follows two lags the force at its free position is used.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct FlowForce<N: Number> {
    /// Share of its opening by which the spool closes, per pressure.
    pub closing: N,
    pub overlap: Overlap<N>,
    /// Weights of both ends of the tick.
    pub weights: [N::Gain; 2],
    /// Share of each end's c that the lags let through within the tick.
    pub shares: [N; 2],
    /// 1, as a slope.
    pub unity: N::Steep,
}

impl<N: Number> FlowForce<N> {
    /// Reduction of the set value, signed like the opening, from the spool at the start of the tick and at its end without
    /// the force.
    #[inline]
    pub(crate) fn closes(&self, from: N, to: N, across: AcrossEdges<N>) -> N {
        let strength = |beyond: N| self.closing.times(beyond.select_positive(across.extending, across.retracting));
        let opened = self.overlap.beyond(from);
        let start = strength(opened).times(opened);
        let [early, late] = self.shares;
        let opens = self.overlap.beyond(to - early.times(start));
        let held = opens.times(N::inverse_one_plus([strength(opens).times(late)], [self.unity]));
        N::dot(self.weights, [start, strength(opens).times(held)])
    }
}

/// A spool that is a second-order system instead of two lags.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Swing<N: Number> {
    /// What its lead takes from its position in a tick: `back` of `coefficients::lags`.
    pub back: N::Gain,
    /// The share of an older set value, which a tick begins with, in l and in x: `older` of `coefficients::lags`.
    pub older: [N; 2],
}

impl<N: Number> Swing<N> {
    /// What l and x answer in a tick that begins with the first of these set values and ends with the other.
    #[inline]
    pub(crate) fn answered(&self, [first, last]: [N; 2]) -> [N; 2] {
        self.older.map(|share| last + share.of(first - last))
    }
}

/// Largest speed of the spool itself, as oil for its pilot or the solenoid's power limits it, both signs.
///
/// Per unit spool travel. A second-order spool can be pulled towards its set value only as hard as keeps it at this speed, and by
/// `valve.speed_overdrive` harder; then its speed itself is limited as well. Of two lags only the second is limited. Exact while the speed is at
/// its limit; else to second order in the tick. Both limits act from the moment within a tick at which they begin: as if they held for the whole tick, a
/// spool would start up to half a tick too early.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct SpeedLimit<N: Number> {
    /// Way in a tick.
    pub step: N,
    /// Of a second-order spool.
    pub swinging: Option<SwingingLimit<N>>,
}

/// Limits of a second-order spool.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct SwingingLimit<N: Number> {
    /// Largest lead l − x = x'/ω.
    pub lead: N,
    /// Largest distance to the set value that pulls.
    pub pull: N,
    /// Way in half a tick per lead: ω·h/2.
    pub ahead: N::Gain,
    /// 1
    pub unity: N::Steep,
}

impl<N: Number> SwingingLimit<N> {
    /// The set values that pull a spool with this lead at this position.
    #[inline]
    pub(crate) fn pulling(&self, (lag, spool): (N, N), sets: [N; 2]) -> [N; 2] {
        let middle = spool + (lag - spool).part(self.ahead);
        sets.map(|set| middle + (set - middle).limited(self.pull))
    }

    /// Both lags after a tick that began at these and would have ended at `lag` and `free`; `step` is the way in a tick at the largest speed.
    #[inline]
    pub(crate) fn held(&self, step: N, (began, from): (N, N), (lag, free): (N, N)) -> (N, N) {
        let lead = (lag - free).limited(self.lead);
        let excess = lag - free - lead;
        let gained = N::choose(excess.equals(N::ZERO), || N::ZERO, || self.gained(began - from, lag - free, excess));
        let held = from + (free - gained - from).limited(step);
        (held + lead, held)
    }

    /// The way that a spool gains in a tick by the part of its lead beyond the limit, `excess`: the lead changes evenly from its first to its last value, and
    /// is beyond the limit for the last share of the tick.
    fn gained(&self, first: N, last: N, excess: N) -> N {
        let beyond = excess.magnitude();
        let share = N::share(beyond, [((last - first).magnitude() - beyond).max(N::ZERO)], [self.unity]);
        share.of(excess).part(self.ahead)
    }
}

/// `spool-stiction`: static friction holds the spool until its target is more than `band` away. Once it moves, kinetic friction acts as if the target were
/// `kept` nearer.
///
/// Per unit spool travel. A spool that follows two lags has no mass: it jumps to within `kept` of the free spool at the end of the tick and stays again; exact; see
/// [`Spool`](crate::ports::Spool) for how the jump is placed within the tick. A spool of second order slides until its speed would turn round, at
/// the end of a tick, or is below `STILL`. Armstrong-Hélouvry, Dupont & Canudas de Wit, *Automatica* 30, 1994.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Stiction<N: Number> {
    pub band: N,
    pub kept: N,
    /// A lead x′/ω below this counts as rest: a spool that does not overshoot never turns round.
    pub still: N,
}

/// [`Stiction::still`], of full travel.
pub(crate) const STILL: f64 = 1e-6;

impl<N: Number> Stiction<N> {
    #[inline]
    fn held(&self, spool: N, free: N) -> N {
        let asked = free - spool;
        let jumps = asked.magnitude().above(self.band);
        N::choose(jumps, || free - asked.select_positive(self.kept, -self.kept), || spool)
    }

    /// Position plus lead, and position, of a spool of second order after a tick on the way to `set`; `towards` moves it without friction.
    #[inline]
    pub(crate) fn slid(&self, (lag, spool): (N, N), set: N, towards: impl Fn(N) -> (N, N)) -> (N, N) {
        let (lead, asked) = (lag - spool, set - spool);
        let rests = !lead.magnitude().above(self.still);
        let way = N::pick(rests, asked, lead);
        let (lag, moved) = towards(set - way.select_positive(self.kept, -self.kept));
        let onward = way.select_positive(lag - moved, moved - lag).above(N::ZERO);
        let held = rests & !asked.magnitude().above(self.band);
        (N::pick(held, spool, N::pick(onward, lag, moved)), N::pick(held, spool, moved))
    }
}

#[cfg(test)]
mod tests {
    use crate::drive::Drive;
    use crate::machine::{Machine, Parameter as P, Source, Tick};
    use crate::number::{Number, PerUnit, Scalar};
    use crate::ports::{AcrossEdges, Spool};
    use crate::valve::{Valve, ValveState};

    /// A valve of 0.1 travel per volt without any dynamics: its spool is its target.
    fn valve<N: Number<Real = f64>>(changes: &[(P, f64)]) -> Valve<N> {
        let mut machine = Machine::with_defaults(Source::Valve);
        for &(parameter, value) in
            [(P::AreaA, 3e-3), (P::AreaB, 2e-3), (P::VolumeA, 5e-4), (P::VolumeB, 3e-4)].iter().chain(changes)
        {
            machine.set(parameter, value);
        }
        *Drive::new::<64>(&machine, Tick::OneMillisecond).unwrap().valve().unwrap()
    }

    /// The spool after each of a few set values, one per tick.
    fn spools<const K: usize>(changes: &[(P, f64)], targets: [f64; K]) -> [f64; K] {
        let valve = valve::<PerUnit>(changes);
        let mut state: ValveState<PerUnit, 64> = valve.at_rest(PerUnit::ZERO);
        targets.map(|target| valve.step(&mut state, PerUnit::saturated(target)).to.to_f64())
    }

    fn assert_near<const K: usize>(found: [f64; K], expected: [f64; K]) {
        for (one, other) in found.iter().zip(&expected) {
            assert!((one - other).abs() < 3e-8, "{found:?}, expected {expected:?}");
        }
    }

    /// The step response of a second-order system, at ω·t.
    fn response(damping: f64, turn: f64) -> f64 {
        if damping < 1.0 {
            let swing = libm::sqrt(1.0 - damping * damping);
            let (sine, cosine) = (libm::sin(swing * turn), libm::cos(swing * turn));
            return 1.0 - libm::exp(-damping * turn) * (cosine + damping / swing * sine);
        }
        let root = libm::sqrt(damping * damping - 1.0);
        let (slow, fast) = (damping - root, damping + root);
        1.0 - (fast * libm::exp(-slow * turn) - slow * libm::exp(-fast * turn)) / (2.0 * root)
    }

    #[test]
    fn a_second_order_spool_answers_a_step_as_the_textbook_says() {
        fn check<N: Scalar<Real = f64>>(within: f64) {
            for damping in [0.3, 0.7, 0.999, 1.001, 2.0] {
                let hertz = 40.0;
                let valve = valve::<N>(&[(P::NaturalFrequency, hertz), (P::SpoolDamping, damping)]);
                let mut state: ValveState<N, 64> = valve.at_rest(N::ZERO);
                for tick in 1..=100 {
                    let found = valve.step(&mut state, N::saturated(0.5)).to.to_f64();
                    let turn = core::f64::consts::TAU * hertz * 1e-3 * f64::from(tick);
                    assert!((found - 0.5 * response(damping, turn)).abs() < within, "{damping} {tick}: {found}");
                }
            }
        }
        check::<PerUnit>(2e-7);
        check::<f64>(1e-7);
    }

    #[test]
    fn no_spool_moves_faster_than_its_own_limit_and_all_arrive() {
        for overdrive in [0.0, 0.5, 20.0] {
            let limits = [(P::NaturalFrequency, 60.0), (P::SpoolDamping, 0.8), (P::SpoolSpeedLimit, 10.0)];
            let valve = valve::<PerUnit>(&[&limits[..], &[(P::SpeedOverdrive, overdrive)]].concat());
            let mut state: ValveState<PerUnit, 64> = valve.at_rest(PerUnit::ZERO);
            let mut fastest = 0.0_f64;
            for _ in 0..300 {
                let Spool { from, to } = valve.step(&mut state, PerUnit::saturated(0.8));
                fastest = fastest.max(to.to_f64() - from.to_f64());
            }
            assert!(fastest <= 0.01 + 1e-8 && fastest > 0.0098, "{overdrive}: {fastest}");
            assert!((state.spool().to_f64() - 0.8).abs() < 1e-6, "{overdrive}");
        }
    }

    /// Against x″ = ω²·(pull within its limit) − 2·ζ·ω·x′ with x′ within its own, in 2000 steps a tick.
    #[test]
    fn the_limits_of_a_spool_begin_within_a_tick() {
        let (hertz, damping, speed) = (30.0, 0.6, 10.0);
        let turn = core::f64::consts::TAU * hertz;
        for overdrive in [0.0, 1.0, 20.0] {
            let pull = 2.0 * damping * speed / turn * (1.0 + overdrive);
            for delay in [0.0, 0.35e-3, 0.8e-3, 1.5e-3] {
                let changes = [
                    (P::NaturalFrequency, hertz),
                    (P::SpoolDamping, damping),
                    (P::SpoolSpeedLimit, speed),
                    (P::SpeedOverdrive, overdrive),
                    (P::TransportDelay, delay),
                ];
                let valve = valve::<PerUnit>(&changes);
                let mut state: ValveState<PerUnit, 64> = valve.at_rest(PerUnit::ZERO);
                let (mut spool, mut velocity, fine) = (0.0_f64, 0.0_f64, 0.5e-6);
                for tick in 0..60 {
                    let found = valve.step(&mut state, PerUnit::saturated(0.7)).to.to_f64();
                    for step in 0..2000 {
                        let set: f64 = if f64::from(tick * 2000 + step) * fine < delay { 0.0 } else { 0.7 };
                        let pulled = (set - spool).clamp(-pull, pull);
                        velocity += (turn * turn * pulled - 2.0 * damping * turn * velocity) * fine;
                        velocity = velocity.clamp(-speed, speed);
                        spool += velocity * fine;
                    }
                    assert!((found - spool).abs() < 5e-4, "{overdrive} {delay} {tick}: {found} instead of {spool}");
                }
            }
        }
    }

    #[test]
    fn hysteresis_settles_its_width_apart_from_below_and_from_above() {
        let changes = [(P::HysteresisWidth, 0.2)];
        assert_near(spools(&changes, [0.5, 0.8, 0.5, 0.2, 0.5]), [0.4, 0.7, 0.6, 0.3, 0.4]);
        // Half-widths 0.05, 0.1, 0.15. After 0.5 they hold 0.45, 0.4, 0.35; at 0.3 only the first has had to follow, to 0.35.
        let spread = [(P::HysteresisWidth, 0.2), (P::HysteresisSpread, 0.5)];
        assert_near(spools(&spread, [0.5, 0.3]), [0.4, (0.35 + 0.4 + 0.35) / 3.0]);
    }

    #[test]
    fn a_stuck_spool_makes_a_staircase_of_a_ramp() {
        let found = spools(&[(P::StictionBand, 0.1)], [0.06, 0.11, 0.16, 0.205, 0.22, 0.13, 0.11]);
        assert_near(found, [0.0, 0.11, 0.11, 0.11, 0.22, 0.22, 0.11]);
    }

    #[test]
    fn a_jump_ends_short_by_what_kinetic_friction_keeps() {
        let found = spools(&[(P::StictionBand, 0.1), (P::StictionKept, 0.2)], [0.06, 0.11, 0.16, 0.2, -0.02]);
        assert_near(found, [0.0, 0.09, 0.09, 0.18, 0.0]);
    }

    /// A spool of second order that sticks, from rest at 0: where it is after each of the ticks of a target.
    fn sliding<N: Scalar<Real = f64>, const K: usize>(damping: f64, target: impl Fn(f64) -> f64) -> [f64; K] {
        let valve = valve::<N>(&[
            (P::NaturalFrequency, TURN / (core::f64::consts::TAU * 1e-3)),
            (P::SpoolDamping, damping),
            (P::StictionBand, 0.1),
            (P::StictionKept, 0.4),
        ]);
        let mut state: ValveState<N, 64> = valve.at_rest(N::ZERO);
        core::array::from_fn(|tick| valve.step(&mut state, N::saturated(target(tick as f64))).to.to_f64())
    }

    /// ω·h
    const TURN: f64 = 0.05;

    #[test]
    fn a_spool_of_second_order_slides_until_it_would_turn_round() {
        fn check<N: Scalar<Real = f64>>() {
            assert!(sliding::<N, 50>(0.7, |_| 0.099).iter().all(|at| at.to_bits() == 0), "held");
            // The spring pulls it towards 0.2 − 0.4·0.1; beyond that it turns round, and stays there if that is within the band of 0.2.
            let damping = 0.3;
            let way = sliding::<N, 200>(damping, |_| 0.2);
            assert!((way[20] - 0.16 * response(damping, 21.0 * TURN)).abs() < 1e-4, "{}", way[20]);
            let swing = libm::sqrt(1.0 - damping * damping);
            let furthest = 0.16 * response(damping, core::f64::consts::PI / swing);
            assert!((way[100] - furthest).abs() < 1e-4, "{} {furthest}", way[100]);
            assert!(way[100..].iter().all(|at| at.to_bits() == way[100].to_bits()), "it rests");
            // One that does not overshoot creeps to its place, and sticks there all the same.
            let (first, second) = (0.2, 0.25);
            let way = sliding::<N, 700>(1.5, |tick| if tick < 600.0 { first } else { second });
            assert!((way[599] - 0.16).abs() < 1e-4, "{}", way[599]);
            assert!((way[699] - way[599]).abs() < 1e-5, "{} {}", way[599], way[699]);
            // Along a ramp it trails by its kinetic friction and by its damping, and does not stop.
            let slope = 2e-3;
            let ramp = sliding::<N, 400>(0.7, |tick| slope * tick);
            let behind = slope * 399.0 - ramp[399];
            assert!((behind - 0.04 - 1.4 * slope / TURN).abs() < slope, "{behind}");
            assert!(ramp[60..].windows(2).all(|pair| pair[1] - pair[0] > 0.5 * slope));
        }
        check::<PerUnit>();
        check::<f64>();
    }

    #[test]
    fn a_jump_is_handed_on_as_the_straight_line_over_its_tick() {
        let valve = valve::<f64>(&[(P::StictionBand, 0.1)]);
        let mut state: ValveState<f64, 64> = valve.at_rest(0.0);
        assert_eq!(valve.step(&mut state, 0.5), Spool { from: 0.0, to: 0.5 });
        assert_eq!(valve.step(&mut state, 0.5), Spool { from: 0.5, to: 0.5 });
    }

    #[test]
    fn the_neutral_has_drifted_to_63_percent_after_its_time_constant() {
        let valve = valve::<PerUnit>(&[(P::NullDriftTravel, -0.1), (P::NullDriftTime, 1.0)]);
        let mut state: ValveState<PerUnit, 64> = valve.at_rest(PerUnit::ZERO);
        for _ in 0..1000 {
            valve.step(&mut state, PerUnit::ZERO);
        }
        // The last tick's mean lies half a tick before 1 s.
        let exact = -0.1 * (1.0 - libm::exp(-0.9995));
        assert!((state.spool().to_f64() - exact).abs() < 1e-8, "{}", state.spool().to_f64());
    }

    #[test]
    fn the_slowest_drift_does_not_stall() {
        let valve = valve::<PerUnit>(&[(P::NullDriftTravel, 0.5), (P::NullDriftTime, 1e5)]);
        let mut state: ValveState<PerUnit, 64> = valve.at_rest(PerUnit::ZERO);
        for _ in 0..100_000 {
            valve.step(&mut state, PerUnit::ZERO);
        }
        // 100 s of 1e5.
        assert!((state.spool().to_f64() - 0.5 * 9.995e-4).abs() < 1e-7, "{}", state.spool().to_f64());
    }

    #[test]
    fn half_a_travel_beyond_the_onset_is_halved_by_a_curvature_of_two() {
        let changes = [(P::SolenoidOnset, 0.5), (P::SolenoidCurvature, 2.0)];
        assert_near(spools(&changes, [0.4, 1.0, -1.0]), [0.4, 0.75, -0.75]);
    }

    #[test]
    fn beyond_a_knee_the_gain_is_less() {
        let changes = [(P::SolenoidOnset, 0.5), (P::SolenoidLoss, 0.2)];
        assert_near(spools(&changes, [0.4, 1.0, -1.0]), [0.4, 0.9, -0.9]);
    }

    #[test]
    fn a_flow_force_as_strong_as_the_valve_halves_the_opening() {
        let changes = [(P::SupplyPressure, 5e6), (P::FlowForce, 2e-7), (P::DeadZone, 0.1)];
        let valve = valve::<PerUnit>(&changes);
        let across = AcrossEdges { extending: PerUnit::ONE, retracting: PerUnit::saturated(3.0) };
        let spool = |target: f64| {
            let mut state: ValveState<PerUnit, 64> = valve.at_rest(PerUnit::ZERO);
            valve.step_against(&mut state, PerUnit::saturated(target), across).to.to_f64()
        };
        // 0.5 beyond the dead zone extending, against 1; 0.4 retracting, against 3.
        assert_near([spool(0.6), spool(-0.5), spool(0.05)], [0.35, -0.2, 0.05]);
    }

    #[test]
    fn no_flow_force_makes_the_spool_swing_for_ever() {
        for lags in [[0.0, 0.0], [1e-3, 0.0], [0.0, 0.02], [1e-4, 1e-4], [0.018, 0.0279], [0.1, 1e-3]] {
            let changes = [(P::FlowForce, 1e-6), (P::TimeConstant1, lags[0]), (P::TimeConstant2, lags[1])];
            let valve = valve::<f64>(&changes);
            let across = AcrossEdges { extending: 8.0, retracting: 8.0 };
            let mut state: ValveState<f64, 64> = valve.at_rest(0.0);
            for _ in 0..5000 {
                valve.step_against(&mut state, 0.9, across);
            }
            let Spool { from, to } = valve.step_against(&mut state, 0.9, across);
            // 0.9/(1 + 7·8)
            assert!((from - to).abs() < 1e-9 && (to - 0.9 / 57.0).abs() < 1e-9, "{lags:?}: {from} {to}");
        }
    }
}
