//! The valve's spool: from command to spool position, in closed form.
//!
//! Set value w = gain·U + offset (15), held over each command interval; a rate limiter that is exact
//! in continuous time (r moves towards w at ± the rate and then stays at w); a transport delay; two
//! first-order lags in series (16). Since r is piecewise linear, the lags have a closed solution on
//! each piece of r, and x(t) has no integration error.

use std::collections::VecDeque;

use model_core::machine::{Machine, Parameter};

/// The valve's parameters, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpoolParameters {
    /// Spool travel per volt. (15)
    pub(crate) gain_per_v: f64,
    /// Spool position at zero volts.
    pub(crate) offset: f64,
    /// Largest speed of the set value, 1/s; may be infinite.
    pub(crate) rate_per_s: f64,
    /// The two lags, s; 0 is no lag. (16)
    pub(crate) time_constants_s: [f64; 2],
    /// Dead time, s. (16)
    pub(crate) delay_s: f64,
    /// A mass on a spring in place of both lags, where the spool is one.
    pub(crate) swings: Option<Swings>,
    /// Largest speed of the spool itself, 1/s; may be infinite.
    pub(crate) speed_per_s: f64,
}

/// A spool as a mass on a damped spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Swings {
    /// Stiffness over mass, 1/s².
    pub(crate) pull_per_s2: f64,
    /// Damping over mass, 1/s.
    pub(crate) drag_per_s: f64,
    /// The pull that it can be given, as a multiple of the one that keeps it at its largest speed.
    pub(crate) pulled: f64,
}

impl SpoolParameters {
    /// Reads them from a machine.
    #[must_use]
    pub(crate) fn of(machine: &Machine<f64>) -> Self {
        Self {
            gain_per_v: machine.get(Parameter::ValveGain),
            offset: machine.get(Parameter::ValveOffset),
            rate_per_s: machine.get(Parameter::RateLimit),
            time_constants_s: [machine.get(Parameter::TimeConstant1), machine.get(Parameter::TimeConstant2)],
            delay_s: machine.get(Parameter::TransportDelay),
            swings: Swings::of(machine),
            speed_per_s: machine.get(Parameter::SpoolSpeedLimit),
        }
    }
}

impl Swings {
    fn of(machine: &Machine<f64>) -> Option<Self> {
        let per_s = std::f64::consts::TAU * machine.get(Parameter::NaturalFrequency);
        let drag_per_s = 2.0 * machine.get(Parameter::SpoolDamping) * per_s;
        let pulled = 1.0 + machine.get(Parameter::SpeedOverdrive);
        (per_s > 0.0).then_some(Self { pull_per_s2: per_s * per_s, drag_per_s, pulled })
    }
}

impl SpoolParameters {
    /// Whether its motion has a closed form.
    pub(crate) fn is_linear(&self) -> bool {
        self.swings.is_none() && self.speed_per_s.is_infinite()
    }
}

/// One linear piece of the rate-limited set value r(t), from its start until the next piece.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ramp {
    start_s: f64,
    value: f64,
    slope_per_s: f64,
}

impl Ramp {
    fn at(&self, time_s: f64) -> f64 {
        self.value + self.slope_per_s * (time_s - self.start_s)
    }
}

/// The spool on one linear piece of its delayed set value: x(t) in closed form, smooth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpoolPiece {
    start_s: f64,
    /// Delayed set value at the start of the piece, and its slope.
    value: f64,
    slope_per_s: f64,
    /// Lags in the order in which they act; those of 0 come first.
    lags_s: [f64; 2],
    /// Deviations of the first lag and of the spool from their particular solutions, at the start of the piece.
    transient: [f64; 2],
}

impl SpoolPiece {
    /// A spool that stays where it is.
    #[must_use]
    pub(crate) const fn resting_at(position: f64) -> Self {
        Self { start_s: 0.0, value: position, slope_per_s: 0.0, lags_s: [0.0; 2], transient: [0.0; 2] }
    }

    /// `states` are the first lag's output and the spool position at the start of the ramp.
    fn new(ramp: Ramp, lags_s: [f64; 2], states: [f64; 2]) -> Self {
        let [first, second] = lags_s;
        let first_transient = if first > 0.0 { states[0] - ramp.value + ramp.slope_per_s * first } else { 0.0 };
        let second_transient =
            if second > 0.0 { states[1] - ramp.value + ramp.slope_per_s * (first + second) } else { 0.0 };
        Self {
            start_s: ramp.start_s,
            value: ramp.value,
            slope_per_s: ramp.slope_per_s,
            lags_s,
            transient: [first_transient, second_transient],
        }
    }

    /// Output of the first lag and spool position, at a time not before the piece's start.
    fn states(&self, time_s: f64) -> [f64; 2] {
        let t = time_s - self.start_s;
        let [first, second] = self.lags_s;
        let set = self.value + self.slope_per_s * t;
        if second <= 0.0 {
            return [set, set];
        }
        let mut inner = set;
        let mut x = set - self.slope_per_s * (first + second) + self.transient[1] * (-t / second).exp();
        if first > 0.0 {
            inner += self.transient[0] * (-t / first).exp() - self.slope_per_s * first;
            // The second lag's response to exp(-t/first), finite and exact also for equal lags.
            let gap = (t * (1.0 / second - 1.0 / first)).abs();
            let quotient = if gap > 0.0 { -(-gap).exp_m1() / gap } else { 1.0 };
            x += self.transient[0] * (t / second) * (-t / first.max(second)).exp() * quotient;
        }
        [inner, x]
    }

    /// Spool position, 1, at a time within the piece.
    #[must_use]
    pub(crate) fn position(&self, time_s: f64) -> f64 {
        self.states(time_s)[1]
    }
}

/// The spool with its command history, fed command by command.
#[derive(Clone, Debug)]
pub(crate) struct Spool {
    parameters: SpoolParameters,
    /// Pieces of r, by the time at which they act on the lags (delay added). The first one is active.
    ramps: VecDeque<Ramp>,
    target: f64,
    piece: SpoolPiece,
}

impl Spool {
    /// At rest on the set value of `command_v`, as if that command had always been there.
    #[must_use]
    pub(crate) fn at_rest(parameters: SpoolParameters, start_s: f64, command_v: f64) -> Self {
        let target = parameters.gain_per_v * command_v + parameters.offset;
        let [one, two] = parameters.time_constants_s;
        let lags_s = if two > 0.0 { [one, two] } else { [two, one] };
        let ramp = Ramp { start_s, value: target, slope_per_s: 0.0 };
        Self {
            parameters,
            ramps: VecDeque::from([ramp]),
            target,
            piece: SpoolPiece::new(ramp, lags_s, [target, target]),
        }
    }

    /// Holds `command_v` from `time_s` on. Commands come in the order of time.
    pub(crate) fn command(&mut self, time_s: f64, command_v: f64) {
        let target = self.parameters.gain_per_v * command_v + self.parameters.offset;
        if target.total_cmp(&self.target).is_eq() {
            return;
        }
        self.target = target;
        let acts_s = time_s + self.parameters.delay_s;
        // The remaining part of the previous command is dropped.
        while self.ramps.len() > 1 && self.ramps.back().is_some_and(|ramp| ramp.start_s >= acts_s) {
            self.ramps.pop_back();
        }
        let value = self.ramps.back().map_or(target, |ramp| ramp.at(acts_s));
        let duration_s = (target - value).abs() / self.parameters.rate_per_s;
        if duration_s > 0.0 {
            let slope_per_s = self.parameters.rate_per_s.copysign(target - value);
            self.ramps.push_back(Ramp { start_s: acts_s, value, slope_per_s });
        }
        self.ramps.push_back(Ramp { start_s: acts_s + duration_s, value: target, slope_per_s: 0.0 });
    }

    /// The piece that is active from `time_s` on, and the time of the next corner of the set value
    /// (infinite if none is known). Times must not decrease.
    pub(crate) fn piece_from(&mut self, time_s: f64) -> (SpoolPiece, f64) {
        while let Some(&next) = self.ramps.get(1)
            && next.start_s <= time_s
        {
            let states = self.piece.states(next.start_s.max(self.piece.start_s));
            self.piece = SpoolPiece::new(next, self.piece.lags_s, states);
            self.ramps.pop_front();
        }
        (self.piece, self.ramps.get(1).map_or(f64::INFINITY, |next| next.start_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spool(lags: [f64; 2], rate_per_s: f64, delay_s: f64) -> Spool {
        let parameters = SpoolParameters {
            gain_per_v: 0.05,
            offset: 0.01,
            rate_per_s,
            time_constants_s: lags,
            delay_s,
            swings: None,
            speed_per_s: f64::INFINITY,
        };
        Spool::at_rest(parameters, 0.0, 0.0)
    }

    fn position(spool: &mut Spool, time_s: f64) -> f64 {
        spool.piece_from(time_s).0.position(time_s)
    }

    #[test]
    fn a_spool_at_rest_stays() {
        let mut spool = spool([0.02, 0.03], 12.0, 0.007);
        spool.command(0.0, 0.0);
        assert!((position(&mut spool, 5.0) - 0.01).abs() < 1e-16);
    }

    #[test]
    fn without_lags_the_ramp_arrives_after_the_delay_and_stops_on_the_target() {
        let mut spool = spool([0.0, 0.0], 10.0, 0.0035);
        spool.command(0.0, 4.0); // 0.2 away: 0.02 s
        assert!((position(&mut spool, 0.003) - 0.01).abs() < 1e-15);
        assert!((position(&mut spool, 0.0135) - 0.11).abs() < 1e-14);
        assert!((position(&mut spool, 0.1) - 0.21).abs() < 1e-15);
    }

    #[test]
    fn an_unlimited_rate_jumps() {
        let mut spool = spool([0.0, 0.0], f64::INFINITY, 0.0);
        spool.command(1.0, 2.0);
        assert!((position(&mut spool, 1.0) - 0.11).abs() < 1e-15);
    }

    #[test]
    fn closed_form_agrees_with_small_euler_steps_for_any_order_of_lags() {
        for lags in [[0.018, 0.0279], [0.0279, 0.018], [0.02, 0.02], [0.02, 0.02 + 1e-12], [0.03, 0.0], [0.0, 0.03]] {
            let mut spool = spool(lags, 12.0, 0.0023);
            let commands = [(0.0, 8.0), (0.012, -6.0), (0.1, 1.0)];
            let (mut r, mut a, mut x, step) = (0.01, 0.01, 0.01, 1e-6);
            let mut next = 0;
            for k in 0..200_000_u32 {
                let t = f64::from(k) * step;
                while commands.get(next).is_some_and(|&(at, _)| at <= t) {
                    spool.command(commands[next].0, commands[next].1);
                    next += 1;
                }
                if k % 1000 == 0 {
                    assert!((position(&mut spool, t) - x).abs() < 5e-5, "{lags:?} {t}");
                }
                let delayed = commands.iter().rev().find(|(at, _)| at + 0.0023 <= t).map_or(0.0, |c| c.1);
                r += (0.05 * delayed + 0.01 - r).clamp(-12.0 * step, 12.0 * step);
                a = if lags[0] > 0.0 { a + step * (r - a) / lags[0] } else { r };
                x = if lags[1] > 0.0 { x + step * (a - x) / lags[1] } else { a };
            }
        }
    }
}
