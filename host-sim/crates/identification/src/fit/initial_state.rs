//! The initial state of a recording, as far as its sensors leave it open.

use model_core::machine::{Machine, MachineError, Parameter};
use recording::Signal;
use simulation::{InputPoint, StartOffset};

use super::residuals::{soft, standardised_all};
use crate::experiment::Prepared;

/// Standard deviation of the logit of the level at rest: a tenth of supply about its half.
const LOGIT_SIGMA: f64 = 0.4;

/// Coordinates of a recording's initial state, each with a unit normal prior; 0 is the value from machine and recording.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StartState {
    /// Level of pressure at rest, where pressures are not recorded.
    pub level: f64,
    /// Difference of the position from the recorded one, in what its sensor leaves open: its resolution, or the play behind it.
    pub shift: f64,
}

impl StartState {
    /// The initial state of a recording on a machine, in the form that the simulation needs.
    #[must_use]
    pub fn offset(&self, machine: &Machine<f64>, case: &Prepared) -> StartOffset {
        StartOffset { level: Some(self.level_on(machine)), shift_m: self.shift * case.start_sigma_on(machine) }
    }

    /// Share of supply pressure in B at rest, around the machine's value. Its logit is moved, because a hard bound would stop
    /// the search there with a zero derivative.
    pub(crate) fn level_on(&self, machine: &Machine<f64>) -> f64 {
        let usual = machine.get(Parameter::LevelAtRest);
        at_logit(libm::log(usual / (1.0 - usual)) + LOGIT_SIGMA * self.level)
    }

    /// Derivative of the level with respect to its coordinate.
    pub(crate) fn level_slope(&self, machine: &Machine<f64>) -> f64 {
        let level = self.level_on(machine);
        LOGIT_SIGMA * level * (1.0 - level)
    }
}

/// The share with this logit, 0..1.
fn at_logit(logit: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-logit))
}

/// Whether the level of pressure at rest is needed, as it is not recorded.
pub(crate) fn needs_level(case: &Prepared) -> bool {
    // A force moves the rod whatever the pressures are.
    case.stimulus.start.pressures_pa.is_none() && case.stimulus.input_point != InputPoint::Force
}

/// The level at rest that a machine file should have after a fit: the mean of its recordings' levels, in their coordinate.
/// `None` where every recording has its pressures, or is entered at a force.
#[must_use]
pub fn level_at_rest(machine: &Machine<f64>, cases: &[&Prepared], starts: &[StartState]) -> Option<f64> {
    let levels = cases.iter().zip(starts).filter(|(case, _)| needs_level(case)).map(|(_, start)| start.level);
    let (sum, count) = levels.fold((0.0, 0.0), |(sum, count), level| (sum + level, count + 1.0));
    let mean = StartState { level: sum / count, shift: 0.0 };
    let range = Parameter::LevelAtRest.description();
    (count > 0.0).then(|| mean.level_on(machine).clamp(range.min, range.max))
}

/// The initial state that suits a machine best on a recording that it was not fitted to: Gauss-Newton in the two
/// coordinates of the initial state alone, the derivatives by the level and by a place within a play by differences.
pub fn settle(machine: &Machine<f64>, case: &Prepared) -> Result<StartState, MachineError> {
    const STEP: f64 = 0.05;
    let mut state = StartState::default();
    // A shift of millimetres, where the start is not known or in a play, takes several steps against a loss that large residuals enter linearly.
    let start_sigma_m = case.start_sigma_on(machine);
    let has_play = start_sigma_m > case.start_sigma_m;
    // What a shift changes of a gain is not the shift itself.
    let by_difference = has_play || case.stimulus.is_whitened();
    let rounds = match (case.unsettled > 0 || has_play, needs_level(case) || by_difference) {
        (true, _) => 12,
        (false, true) => 4,
        (false, false) => 1,
    };
    for _ in 0..rounds {
        let raised = needs_level(case).then_some(StartState { level: state.level + STEP, ..state });
        let shifted = by_difference.then_some(StartState { shift: state.shift + STEP, ..state });
        let starts = [Some(state), raised, shifted].into_iter().flatten();
        let mut runs = standardised_all(machine, starts.map(|start| (case, start)))?.into_iter();
        let here = runs.next().unwrap_or_default();
        let (raised, shifted) = (raised.and_then(|_| runs.next()), shifted.and_then(|_| runs.next()));
        let (mut h, mut g) = ([[1.0, 0.0], [0.0, 1.0]], [state.level, state.shift]);
        for (index, (channel, residuals)) in case.channels.iter().zip(&here).enumerate() {
            let shift = if channel.signal == Signal::Position { -start_sigma_m / channel.noise } else { 0.0 };
            for (row, residual) in residuals.iter().enumerate() {
                let (value, slope) = soft(*residual, channel.tolerance);
                let by = |moved: &Vec<Vec<f64>>| slope * (moved[index][row] - residual) / STEP;
                let by_level = raised.as_ref().map_or(0.0, by);
                let by_shift = shifted.as_ref().map_or(slope * shift, by);
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

/// The initial state of each recording, as it suits a machine best.
pub fn settled(machine: &Machine<f64>, cases: &[&Prepared]) -> Result<Vec<StartState>, MachineError> {
    cases.iter().map(|case| settle(machine, case)).collect()
}

#[cfg(test)]
mod tests {
    use model_core::machine::Source;

    use super::*;

    #[test]
    fn the_level_is_the_machines_at_the_middle_of_its_prior_and_stays_within_the_supply() {
        let mut machine = Machine::with_defaults(Source::Valve);
        machine.set(Parameter::LevelAtRest, 0.37);
        let level = |coordinate| StartState { level: coordinate, shift: 0.0 }.level_on(&machine);
        assert!((level(0.0) - 0.37).abs() < 1e-12);
        assert!((0.0..0.01).contains(&level(-30.0)) && (0.99..=1.0).contains(&level(30.0)));
        let slope = StartState { level: 0.7, shift: 0.0 }.level_slope(&machine);
        assert!(((level(0.701) - level(0.699)) / 2e-3 / slope - 1.0).abs() < 1e-5);
    }
}
