//! The two second-order shapes, stepped exactly from row to row.
//!
//! ```text
//! integrates   T·ẍ + ẋ = u                  x/u = 1/(s·(T·s + 1))
//! follows      ẍ/ω² + (2·ζ/ω)·ẋ + x = u     x/u = 1/(s²/ω² + 2·ζ·s/ω + 1)
//! ```
//! u is the mean of the input between two rows, a delay earlier. For an input that is held between rows a step is exact, however long it is.

/// A second-order shape of unit gain, without its delay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// An integrator behind a lag: the input is a velocity.
    Integrates {
        /// Time constant of the lag T, s.
        lag_s: f64,
    },
    /// It comes to rest at a value of its own for every input.
    Follows {
        /// Natural angular frequency ω, rad/s.
        omega: f64,
        /// Damping ratio ζ, 1.
        damping: f64,
    },
}

/// A shape's output and its rate of change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct State {
    pub(super) value: f64,
    pub(super) rate: f64,
}

/// One step of a shape over a time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// The next value and rate by the present ones, row by row.
    matrix: [[f64; 2]; 2],
    /// The same by the input.
    input: [f64; 2],
}

impl Shape {
    /// How long its output takes to get where the input leads it, s: the lag, or the sum of both time constants.
    #[must_use]
    pub fn settling_s(&self) -> f64 {
        match *self {
            Self::Integrates { lag_s } => lag_s,
            Self::Follows { omega, damping } => 2.0 * damping / omega,
        }
    }

    /// The time constant with which it comes to rest, s: of one that rings, that of its envelope.
    #[must_use]
    pub fn decay_s(&self) -> f64 {
        match *self {
            Self::Follows { omega, damping } if damping < 1.0 => 1.0 / (damping * omega),
            _ => self.settling_s(),
        }
    }

    /// Over this time, s.
    pub(super) fn step(&self, time_s: f64) -> Step {
        match *self {
            Self::Integrates { lag_s } => {
                let kept = libm::exp(-time_s / lag_s);
                let reached_s = lag_s * (1.0 - kept);
                Step { matrix: [[1.0, reached_s], [0.0, kept]], input: [time_s - reached_s, 1.0 - kept] }
            }
            Self::Follows { omega, damping } => {
                let decay = damping * omega;
                let apart = damping * damping - 1.0;
                let beta = omega * apart.abs().sqrt();
                // e^(−decay·t) times the (hyperbolic) cosine, and times the sine over beta.
                let (cosine, sine) = if beta * time_s < 1e-4 {
                    let kept = libm::exp(-decay * time_s);
                    (kept, kept * time_s)
                } else if apart < 0.0 {
                    let (sine, cosine) = libm::sincos(beta * time_s);
                    let kept = libm::exp(-decay * time_s);
                    (kept * cosine, kept * sine / beta)
                } else {
                    // ζω − ω√(ζ² − 1) without cancellation.
                    let slow = omega * omega / (decay + beta);
                    let (slow, fast) = (libm::exp(-slow * time_s), libm::exp(-(decay + beta) * time_s));
                    (0.5 * (slow + fast), 0.5 * (slow - fast) / beta)
                };
                let matrix = [[cosine + decay * sine, sine], [-omega * omega * sine, cosine - decay * sine]];
                Step { matrix, input: [1.0 - matrix[0][0], -matrix[1][0]] }
            }
        }
    }
}

impl Step {
    pub(super) fn from(&self, state: State, input: f64) -> State {
        let row = |index: usize| {
            let [value, rate]: [f64; 2] = self.matrix[index];
            value * state.value + rate * state.rate + self.input[index] * input
        };
        State { value: row(0), rate: row(1) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same by many small steps of the equation itself.
    fn slowly(shape: Shape, mut state: State, input: f64, time_s: f64) -> State {
        const STEPS: u32 = 200_000;
        let step = time_s / f64::from(STEPS);
        let acceleration = |state: State| match shape {
            Shape::Integrates { lag_s } => (input - state.rate) / lag_s,
            Shape::Follows { omega, damping } => {
                omega * omega * (input - state.value) - 2.0 * damping * omega * state.rate
            }
        };
        for _ in 0..STEPS {
            let half = State {
                value: state.value + 0.5 * step * state.rate,
                rate: state.rate + 0.5 * step * acceleration(state),
            };
            state = State { value: state.value + step * half.rate, rate: state.rate + step * acceleration(half) };
        }
        state
    }

    #[test]
    fn a_step_of_any_length_is_that_of_the_equation() {
        let shapes = [
            Shape::Integrates { lag_s: 0.04 },
            Shape::Follows { omega: 9.0, damping: 0.2 },
            Shape::Follows { omega: 9.0, damping: 1.0 },
            Shape::Follows { omega: 9.0, damping: 4.0 },
        ];
        let state = State { value: 0.3, rate: -0.7 };
        for shape in shapes {
            for time_s in [1e-3, 0.1, 0.7] {
                let (exact, slow) = (shape.step(time_s).from(state, 0.8), slowly(shape, state, 0.8, time_s));
                assert!((exact.value - slow.value).abs() < 1e-6, "{shape:?} {time_s}: {exact:?} {slow:?}");
                assert!((exact.rate - slow.rate).abs() < 1e-5, "{shape:?} {time_s}: {exact:?} {slow:?}");
            }
        }
    }
}
