//! A spool that has no closed form (effects, a mass on a spring, a largest speed): small steps over the exact set value, joined by a smooth curve.
//!
//! The set value after rate limit and delay is exact ([`Spool`] without lags). On it act, in this order: hysteresis, saturation and
//! drift on the set value; the two lags, exact over each step for a set value that is linear in it, or a mass on a damped spring, by the midpoint
//! rule in finer steps; flow force, which shifts the target of the second lag or of the spring; the largest speed; stiction on the result of the lags, or on the mass itself. Steps of at most 0.125 ms keep the error of the spool within 1e-5 of its travel.

use super::linear::{Spool, SpoolParameters, Swings};
use crate::effect::valve::ValveEffect;
use crate::flow::edges::Edges;
use crate::physics::State;

/// Number of steps of a curve.
const STEPS: usize = 8;
/// Longest curve, s.
const LONGEST_S: f64 = 1e-3;

/// A step: positions at its start and end, and the velocities there, taken from inside the step.
#[derive(Clone, Copy, Debug, Default)]
struct Step {
    from: f64,
    to: f64,
    speed_from: f64,
    speed_to: f64,
}

/// The spool over a short interval: a cubic on each step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Curve {
    start_s: f64,
    step_s: f64,
    steps: [Step; STEPS],
}

impl Curve {
    fn resting_at(start_s: f64, position: f64) -> Self {
        let step = Step { from: position, to: position, ..Step::default() };
        Self { start_s, step_s: LONGEST_S, steps: [step; STEPS] }
    }

    #[must_use]
    pub(crate) fn position(&self, time_s: f64) -> f64 {
        let along = ((time_s - self.start_s) / self.step_s).clamp(0.0, STEPS as f64);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the number of steps")]
        let index = (along as usize).min(STEPS - 1);
        let (u, step) = (along - index as f64, &self.steps[index]);
        let rest = 1.0 - u;
        let ends = step.from * rest * rest * (1.0 + 2.0 * u) + step.to * u * u * (1.0 + 2.0 * rest);
        ends + self.step_s * u * rest * (step.speed_from * rest - step.speed_to * u)
    }
}

/// An effect on the set value, with its memory.
#[derive(Clone, Copy, Debug)]
enum Shape {
    /// Half widths, and the outputs of the elements.
    Plays {
        half: [f64; 3],
        outputs: [f64; 3],
    },
    BoucWen {
        width: f64,
        turning: f64,
        state: f64,
    },
    Drift {
        travel: f64,
        period_s: f64,
        start_s: f64,
    },
    Saturation {
        ceiling: f64,
    },
}

/// Half widths of the plays relative to the mean half width, and their weights.
const PLAYS: ([f64; 3], [f64; 3]) = ([0.5, 1.0, 1.9], [0.45, 0.32, 0.23]);

impl Shape {
    fn of(effect: ValveEffect, set: f64, start_s: f64) -> Option<Self> {
        match effect {
            ValveEffect::WeightedPlays { width } => {
                let mean: f64 = PLAYS.0.iter().zip(PLAYS.1).map(|(half, weight)| half * weight).sum();
                Some(Self::Plays { half: PLAYS.0.map(|half| 0.5 * width * half / mean), outputs: [set; 3] })
            }
            ValveEffect::BoucWen { width, turning } => Some(Self::BoucWen { width, turning, state: 0.0 }),
            ValveEffect::NullDrift { travel, period_s } => Some(Self::Drift { travel, period_s, start_s }),
            ValveEffect::Saturation { ceiling } => Some(Self::Saturation { ceiling }),
            ValveEffect::Stiction { .. } | ValveEffect::FlowForce { .. } => None,
        }
    }

    /// The set value after this effect, when the input has moved from `before` to `set` at `time_s`.
    fn pass(&mut self, time_s: f64, before: f64, set: f64) -> f64 {
        match self {
            Self::Plays { half, outputs } => {
                for (output, half) in outputs.iter_mut().zip(half) {
                    *output = output.clamp(set - *half, set + *half);
                }
                outputs.iter().zip(PLAYS.1).map(|(output, weight)| output * weight).sum()
            }
            Self::BoucWen { width, turning, state } => {
                let change = (set - before) / *turning;
                let parts = (change.abs() / 0.05).ceil().max(1.0);
                let part = change / parts;
                let mut done = 0.0;
                while done < parts {
                    let closing = if part * *state > 0.0 { *state * *state } else { 0.0 };
                    *state = (*state + part * (1.0 - closing)).clamp(-1.0, 1.0);
                    done += 1.0;
                }
                set - 0.5 * *width * *state
            }
            Self::Drift { travel, period_s, start_s } => {
                let turns = (time_s - *start_s) / *period_s;
                set + *travel * (turns + 0.25 * libm::sin(std::f64::consts::TAU * turns))
            }
            Self::Saturation { ceiling } => *ceiling * libm::tanh(set / *ceiling),
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Sticking {
    break_away: f64,
    kinetic: f64,
    jump_s: f64,
    moving: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct FlowForce {
    closing_per_pa: f64,
    braking_s_per_root_pa: f64,
}

/// The spool with its command history and the memory of its effects.
#[derive(Clone, Debug)]
pub(crate) struct ShapedSpool {
    set: Spool,
    lags_s: [f64; 2],
    swings: Option<Swings>,
    speed_per_s: f64,
    shapes: Vec<Shape>,
    sticking: Option<Sticking>,
    flow_force: FlowForce,
    time_s: f64,
    /// Set value before and after the effects on it.
    raw: f64,
    shaped: f64,
    /// Output of the first lag.
    inner: f64,
    /// The position to which the second lag's spring pulls.
    pulled_to: f64,
    /// Output of the second lag or of the spring: the spool position, if it does not stick.
    free: f64,
    /// Speed of a mass on a spring, 1/s.
    moves_per_s: f64,
    x: f64,
    curve: Curve,
}

impl ShapedSpool {
    /// At rest on the set value of `command_v`.
    pub(crate) fn at_rest(parameters: SpoolParameters, effects: &[ValveEffect], start_s: f64, command_v: f64) -> Self {
        let unlagged =
            SpoolParameters { time_constants_s: [0.0; 2], swings: None, speed_per_s: f64::INFINITY, ..parameters };
        let raw = parameters.gain_per_v * command_v + parameters.offset;
        let mut shapes: Vec<Shape> = effects.iter().filter_map(|&effect| Shape::of(effect, raw, start_s)).collect();
        let x = shapes.iter_mut().fold(raw, |set, shape| shape.pass(start_s, set, set));
        let sticking = effects.iter().find_map(|effect| match *effect {
            ValveEffect::Stiction { break_away, kinetic_share, jump_s } => {
                Some(Sticking { break_away, kinetic: kinetic_share * break_away, jump_s, moving: false })
            }
            _ => None,
        });
        let flow_force = effects.iter().find_map(|effect| match *effect {
            ValveEffect::FlowForce { closing_per_pa, braking_s_per_root_pa } => {
                Some(FlowForce { closing_per_pa, braking_s_per_root_pa })
            }
            _ => None,
        });
        Self {
            set: Spool::at_rest(unlagged, start_s, command_v),
            lags_s: if parameters.swings.is_some() { [0.0; 2] } else { parameters.time_constants_s },
            swings: parameters.swings,
            speed_per_s: parameters.speed_per_s,
            shapes,
            sticking,
            flow_force: flow_force.unwrap_or_default(),
            time_s: start_s,
            raw,
            shaped: x,
            inner: x,
            pulled_to: x,
            free: x,
            moves_per_s: 0.0,
            x,
            curve: Curve::resting_at(start_s, x),
        }
    }

    pub(crate) fn command(&mut self, time_s: f64, command_v: f64) {
        self.set.command(time_s, command_v);
    }

    /// Its position at the end of the last curve.
    pub(crate) fn position(&self) -> f64 {
        self.x
    }

    /// The curve from `from_s` on and its end, at most `to_s`. The pressures at its start are used throughout.
    pub(crate) fn curve_from(&mut self, from_s: f64, to_s: f64, edges: &Edges, state: &State<f64>) -> (Curve, f64) {
        if from_s < self.time_s || to_s <= from_s {
            return (self.curve, self.time_s);
        }
        let end_s = to_s.min(from_s + LONGEST_S);
        let step_s = (end_s - from_s) / STEPS as f64;
        let mut curve = Curve { start_s: from_s, step_s, steps: [Step::default(); STEPS] };
        for (index, step) in curve.steps.iter_mut().enumerate() {
            *step = self.step(from_s + step_s * (index + 1) as f64, step_s, edges, state);
        }
        self.time_s = end_s;
        self.curve = curve;
        (curve, end_s)
    }

    fn step(&mut self, end_s: f64, step_s: f64, edges: &Edges, state: &State<f64>) -> Step {
        let raw = self.set.piece_from(end_s).0.position(end_s);
        let before = self.raw;
        self.raw = raw;
        // The input of each effect is the output of the one before; only the first needs the input before the step, the others are memoryless.
        let shaped = self.shapes.iter_mut().fold(raw, |set, shape| shape.pass(end_s, before, set));
        let inner = lagged(self.inner, self.shaped, shaped, step_s, self.lags_s[0]);
        self.shaped = shaped;
        self.inner = inner;
        let (pushed, slower) = self.pushed(edges, state);
        let pulled_to = inner - pushed;
        let lag_s = self.lags_s[1] + slower;
        let (moved_from, limit) = (self.moves_per_s, self.speed_per_s);
        let free = if let Some(swings) = self.swings {
            let pull = [self.pulled_to, pulled_to];
            let (free, moves_per_s) =
                swings.moved((self.free, self.moves_per_s), pull, step_s, limit, self.sticking.as_ref());
            self.moves_per_s = moves_per_s;
            free
        } else {
            let free = lagged(self.free, self.pulled_to, pulled_to, step_s, lag_s);
            self.free + (free - self.free).clamp(-limit * step_s, limit * step_s)
        };
        let (is_swinging, moves_to) = (self.swings.is_some(), self.moves_per_s);
        let speed = |target: f64, at: f64, from: f64, to: f64| {
            if lag_s > 0.0 { ((target - at) / lag_s).clamp(-limit, limit) } else { (to - from) / step_s }
        };
        let (free_from, pulled_from) = (self.free, self.pulled_to);
        self.free = free;
        self.pulled_to = pulled_to;
        let from = self.x;
        match self.sticking.as_mut().filter(|_| !is_swinging) {
            None => {
                self.x = free;
                let [speed_from, speed_to] = if is_swinging {
                    [moved_from, moves_to]
                } else {
                    [speed(pulled_from, free_from, free_from, free), speed(pulled_to, free, free_from, free)]
                };
                Step { from, to: free, speed_from, speed_to }
            }
            Some(sticking) => {
                self.x = sticking.moved(from, free, step_s);
                let speed = (self.x - from) / step_s;
                Step { from, to: self.x, speed_from: speed, speed_to: speed }
            }
        }
    }

    /// How far the flow pushes the spool closed, and by how much it lengthens the second lag, s.
    fn pushed(&self, edges: &Edges, state: &State<f64>) -> (f64, f64) {
        let opening = edges.opening(self.x);
        let (high, low) =
            if opening > 0.0 { (state.pressure_a, state.pressure_b) } else { (state.pressure_b, state.pressure_a) };
        let across_pa = (state.supply - high + low).max(0.0);
        let slower = if opening.abs() > 0.0 { self.flow_force.braking_s_per_root_pa * across_pa.sqrt() } else { 0.0 };
        (self.flow_force.closing_per_pa * opening * across_pa, slower)
    }
}

/// A mass that would come no further than this before its spring pulls it back rests, of full travel.
const STILL: f64 = 1e-6;
/// Finer steps of a mass on a spring within a step.
const FINER: u32 = 8;

impl Swings {
    /// Position and speed of the mass after a step in which the spring's foot moves along `pull`; by the midpoint rule. Friction holds it at rest,
    /// brakes it as it moves, and stops it where it would turn round.
    fn moved(
        self,
        (mut x, mut v): (f64, f64),
        pull: [f64; 2],
        step_s: f64,
        limit: f64,
        sticking: Option<&Sticking>,
    ) -> (f64, f64) {
        let fine_s = step_s / f64::from(FINER);
        let most = self.pulled * limit * self.drag_per_s;
        let gains =
            |x: f64, v: f64, foot: f64| (self.pull_per_s2 * (foot - x)).clamp(-most, most) - self.drag_per_s * v;
        for index in 0..FINER {
            let foot = |share: f64| pull[0] + (pull[1] - pull[0]) * (f64::from(index) + share) / f64::from(FINER);
            let asked = foot(0.0) - x;
            // One that does not overshoot never turns round: it creeps.
            let rests = v.abs() <= STILL * self.pull_per_s2.sqrt();
            let way = if rests { asked } else { v };
            if sticking.is_some_and(|sticking| rests && asked.abs() <= sticking.break_away) {
                v = 0.0;
                continue;
            }
            let rubbed = sticking.map_or(0.0, |sticking| sticking.kinetic.copysign(way));
            let foot = |share: f64| foot(share) - rubbed;
            let (half_x, half_v) = (x + 0.5 * fine_s * v, v + 0.5 * fine_s * gains(x, v, foot(0.0)));
            let half_v = half_v.clamp(-limit, limit);
            x += fine_s * half_v;
            v = (v + fine_s * gains(half_x, half_v, foot(0.5))).clamp(-limit, limit);
            if sticking.is_some() && v * way <= 0.0 {
                v = 0.0;
            }
        }
        (x, v)
    }
}

impl Sticking {
    /// The new position of the spool from `x`, while its spring pulls it to `free`.
    fn moved(&mut self, x: f64, free: f64, step_s: f64) -> f64 {
        let pull = free - x;
        self.moving |= pull.abs() > self.break_away;
        if !self.moving {
            return x;
        }
        let left = pull.abs() - self.kinetic;
        if left <= 0.0 {
            self.moving = false;
            return x;
        }
        let moved = x + left.copysign(pull) * -libm::expm1(-step_s / self.jump_s);
        // It has arrived, or very nearly: it sticks again.
        self.moving = self.jump_s > 0.0 && left > 0.02 * self.break_away;
        moved
    }
}

/// A first-order lag over one step, exact for an input that is linear in it.
fn lagged(output: f64, input_from: f64, input_to: f64, step_s: f64, lag_s: f64) -> f64 {
    if lag_s <= 0.0 {
        return input_to;
    }
    let behind = (input_to - input_from) / step_s * lag_s;
    input_to - behind + (output - input_from + behind) * libm::exp(-step_s / lag_s)
}

#[cfg(test)]
mod tests;
