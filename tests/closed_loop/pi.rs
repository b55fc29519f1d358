//! The controller that model-following control is compared with: a PI controller, tuned on the nominal plant by search.

use model_core::machine::{Machine, Parameter as P};
use system_tests::rig::{COMMAND_LIMIT_V, Controller, Readings, Rig, SLEW_V_PER_S, TICK, Wanted, rms_mm};

/// Proportional and integral gain, and the jump over the overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gains {
    pub(crate) proportional_v_per_m: f64,
    pub(crate) integral_v_per_m_s: f64,
    /// Share of the valve's overlap that is jumped over.
    pub(crate) jumped: f64,
}

/// A PI controller around the neutral command; the integral is held while the output is limited.
pub(crate) struct Pi {
    gains: Gains,
    neutral_v: f64,
    overlap_v: f64,
    integral_v: f64,
    last_v: f64,
}

/// Error over which the jump grows to its full height, V: without this the output would chatter between two encoder steps.
const JUMP_WITHIN_V: f64 = 0.05;

impl Pi {
    pub(crate) fn new(machine: &Machine<f64>, gains: Gains) -> Self {
        let per_volt = machine.get(P::ValveGain);
        let neutral_v = -machine.get(P::ValveOffset) / per_volt;
        let overlap_v = machine.get(P::DeadZone) / per_volt;
        Self { gains, neutral_v, overlap_v, integral_v: 0.0, last_v: neutral_v }
    }
}

impl Controller for Pi {
    fn command_v(&mut self, wanted: Wanted, seen: &Readings) -> f64 {
        let error_m = wanted.position_m - seen.position_m;
        let linear_v = self.gains.proportional_v_per_m * error_m + self.integral_v;
        let jump_v = self.gains.jumped * self.overlap_v * (linear_v / JUMP_WITHIN_V).clamp(-1.0, 1.0);
        let wanted_v = self.neutral_v + linear_v + jump_v;
        let slew_v = SLEW_V_PER_S * TICK.seconds();
        let command_v =
            wanted_v.clamp(self.last_v - slew_v, self.last_v + slew_v).clamp(-COMMAND_LIMIT_V, COMMAND_LIMIT_V);
        let pushes_on = (wanted_v - command_v) * error_m > 0.0;
        if !pushes_on {
            self.integral_v += self.gains.integral_v_per_m_s * TICK.seconds() * error_m;
        }
        self.last_v = command_v;
        command_v
    }
}

/// The gains with the smallest error on `nominal` and this error, mm: a grid over four decades, then ever finer grids around its best point.
pub(crate) fn tuned(nominal: &Rig, jumped: f64) -> (Gains, f64) {
    let gains = |[proportional, integral]: [f64; 2]| Gains {
        proportional_v_per_m: proportional.exp2(),
        integral_v_per_m_s: integral.exp2(),
        jumped,
    };
    let error_mm = |at: [f64; 2]| rms_mm(&nominal.run(&mut Pi::new(&nominal.machine, gains(at))));
    let mut best = ([0.0; 2], f64::INFINITY);
    let mut look = |at: [f64; 2]| {
        let found_mm = error_mm(at);
        let better = found_mm < best.1;
        if better {
            best = (at, found_mm);
        }
        (better, best)
    };
    let mut found = best_of_grid(&mut look);
    let mut step = 1.0;
    while step > 0.1 {
        let (centre, mut better) = (found.0, false);
        for [proportional, integral] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, 1.0], [-1.0, -1.0]] {
            let (is_better, best) = look([centre[0] + step * proportional, centre[1] + step * integral]);
            better |= is_better;
            found = best;
        }
        if !better {
            step *= 0.5;
        }
    }
    (gains(found.0), found.1)
}

/// Gains as powers of 2, and their error, mm.
type Found = ([f64; 2], f64);

fn best_of_grid(look: &mut impl FnMut([f64; 2]) -> (bool, Found)) -> Found {
    let mut found = ([0.0; 2], f64::INFINITY);
    for proportional in [5.0, 6.5, 8.0, 9.5, 11.0, 12.5] {
        for integral in [2.0, 5.0, 8.0, 11.0, 14.0, 17.0] {
            (_, found) = look([proportional, integral]);
        }
    }
    found
}
