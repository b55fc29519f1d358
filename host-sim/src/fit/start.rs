//! The state that a recording starts from, as far as its sensors leave it open.

use model_core::machine::{Machine, MachineError};

use super::residuals::{soft, standardised};
use crate::prepare::Prepared;
use crate::recording::Signal;
use crate::simulate::StartOffset;

/// Standard deviation of the pressure level at rest, as a share of supply.
const LEVEL_SIGMA: f64 = 0.1;

/// Coordinates of a recording's start, each with a unit normal prior; 0 is what the recording says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StartState {
    /// Level of pressure at rest, where pressures are not recorded.
    pub level: f64,
    /// Position below the sensor's step.
    pub shift: f64,
}

impl StartState {
    /// The start in the simulation's terms.
    #[must_use]
    pub fn offset(&self, case: &Prepared) -> StartOffset<f64> {
        StartOffset { level: level(self.level), shift_m: self.shift * case.start_sigma_m }
    }
}

/// Whether the level of pressure at rest is not recorded.
pub(super) fn needs_level(case: &Prepared) -> bool {
    case.stimulus.start.pressures_pa.is_none()
}

/// Level at rest from its coordinate, between 0 and 1: a hard bound would stop the search at it, with a slope that is not there.
pub(super) fn level(coordinate: f64) -> f64 {
    1.0 / (1.0 + (-4.0 * LEVEL_SIGMA * coordinate).exp())
}

/// Derivative of the level by its coordinate.
pub(super) fn level_slope(coordinate: f64) -> f64 {
    4.0 * LEVEL_SIGMA * level(coordinate) * (1.0 - level(coordinate))
}

/// The start that suits a machine best on a recording that it was not fitted to: Gauss-Newton in the start's two coordinates
/// alone, the level's slope by a difference.
pub fn settle(machine: &Machine<f64>, case: &Prepared) -> Result<StartState, MachineError> {
    const STEP: f64 = 0.05;
    let mut state = StartState::default();
    let rounds = if needs_level(case) { 4 } else { 1 };
    for _ in 0..rounds {
        let here = standardised(machine, case, state)?;
        let moved = if needs_level(case) {
            Some(standardised(machine, case, StartState { level: state.level + STEP, ..state })?)
        } else {
            None
        };
        let (mut h, mut g) = ([[1.0, 0.0], [0.0, 1.0]], [state.level, state.shift]);
        for (index, (channel, residuals)) in case.channels.iter().zip(&here).enumerate() {
            let shift = if channel.signal == Signal::Position { -case.start_sigma_m / channel.noise } else { 0.0 };
            for (row, residual) in residuals.iter().enumerate() {
                let (value, slope) = soft(*residual, channel.tolerance);
                let by_level = moved.as_ref().map_or(0.0, |moved| slope * (moved[index][row] - residual) / STEP);
                let by_shift = slope * shift;
                h[0][0] += by_level * by_level;
                h[0][1] += by_level * by_shift;
                h[1][1] += by_shift * by_shift;
                g[0] += by_level * value;
                g[1] += by_shift * value;
            }
        }
        let determinant = h[0][0] * h[1][1] - h[0][1] * h[0][1];
        let step = [(h[1][1] * g[0] - h[0][1] * g[1]) / determinant, (h[0][0] * g[1] - h[0][1] * g[0]) / determinant];
        state.level -= step[0].clamp(-3.0, 3.0);
        state.shift -= step[1];
        if step[0].abs() < 1e-3 && step[1].abs() < 1e-3 {
            break;
        }
    }
    Ok(state)
}
