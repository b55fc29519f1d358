//! Model-following control: the model follows the set point, and the machine is made to follow the model.
//!
//! Two loops (S. Skoczowski, S. Domek, K. Pietrusewicz: *Model-following control with two PID controllers*; the paper's
//! introduction names the method for changing loads). The *model loop* closes around the reference model, which has neither
//! noise nor disturbance, so it may be as fast as the valve allows; its command goes to the machine as well. The *process loop*
//! sees only the difference between model and machine, and corrects it.
//!
//! ```text
//! model loop     v = v* + lead·dv*/dt + K·(y* − y_model) − damping·(fast part of F)
//!                w = opening of v under the model's load
//!                x = X(w) + g·(X(w) − x_model)                 u_model = (x + middle − offset)/gain
//! process loop   v = P·e + I·∫e − damping·(fast part of ΔF)    e = y_model − y, without what the sensor cannot tell
//!                w = what is kept + (opening of u_model + opening of v), each under the measured load
//!                x = X(w) + g·(X(w of the model's spool) − x_measured)
//! ```
//!
//! X steps over the valve's overlap (`overlap`); the opening takes area ratio and √Δp into account (`orifice`). ΔF is the difference of the
//! oil's force F = pa − α·pb between machine and model, where both pressures are measured. Its slow part is load or friction that the model lacks:
//! both openings are computed for it at once, before it causes a difference of position. Its fast part is the oil spring, which is damped.
//!
//! Everything is per unit in fixed point, at a fixed cost; no input of any size causes an overflow or a panic. Both commands keep to the
//! slew and the limit; the integral stands still while a limit holds the output back and the difference pushes further in that direction.
//!
//! ```
//! use model_core::control::{Follower, Observed, Predicted, SetPoint, Tuning};
//! use model_core::machine::{Machine, Parameter, Source, Tick};
//! use model_core::number::{Number, PerUnit};
//! use model_core::ports::ChamberState;
//!
//! let machine = Machine::with_defaults(Source::Valve).with(&[
//!     (Parameter::AreaA, 3.117e-3),
//!     (Parameter::AreaB, 1.861e-3),
//!     (Parameter::VolumeA, 5.2e-4),
//!     (Parameter::VolumeB, 3.3e-4),
//!     (Parameter::TimeConstant1, 0.018),
//!     (Parameter::RateLimit, 12.0),
//!     (Parameter::FlowLimit, 3.0e-4),
//! ]);
//! let tuning = Tuning::by_rule(&machine, true);
//! let follower = Follower::new(&machine, &tuning, Tick::OneMillisecond)?;
//!
//! // Model and machine rest in mid-stroke; the set point is a little further out.
//! let half = PerUnit::saturated(0.5);
//! let (a, b) = (PerUnit::saturated(0.3), half);
//! let model = Predicted { spool: PerUnit::ZERO, pressure_a: a, pressure_b: b, velocity: PerUnit::ZERO, position: half };
//! let seen = Observed { position: half, spool: Some(PerUnit::ZERO), pressures: Some(ChamberState { a, b }) };
//! let mut state = follower.at_rest(&model, &seen);
//! let wanted = SetPoint { position: PerUnit::saturated(0.51), velocity: PerUnit::ZERO };
//! let for_the_model = follower.model_command(&mut state, wanted, &model);
//! let for_the_machine = follower.command(&mut state, for_the_model, &model, &seen);
//! assert!(for_the_model > PerUnit::ZERO, "the model is driven out");
//! let apart = (for_the_machine - for_the_model).magnitude();
//! assert!(apart < PerUnit::saturated(1e-4), "and the machine, which is where the model is, with it");
//! # Ok::<(), model_core::control::FollowError>(())
//! ```

mod build;
mod orifice;
mod overlap;
#[cfg(test)]
mod tests;
mod tuning;

use fixed::types::{I4F28, U16F16};
use orifice::Orifice;
use overlap::Overlap;

use crate::number::{Number, PerUnit};
use crate::ports::ChamberState;

pub use build::FollowError;
pub use tuning::Tuning;

/// Where the rod is wanted, and how fast it is wanted to go there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetPoint {
    /// Of the stroke.
    pub position: PerUnit,
    /// Of the velocity base; positive extends.
    pub velocity: PerUnit,
}

/// The model's prediction of the machine's present state, per unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Predicted {
    /// Spool position; 1 is full travel, positive extends.
    pub spool: PerUnit,
    /// Pressure in A, of supply.
    pub pressure_a: PerUnit,
    /// Pressure in B, of supply.
    pub pressure_b: PerUnit,
    /// Velocity, of the velocity base; positive extends.
    pub velocity: PerUnit,
    /// Position, of the stroke.
    pub position: PerUnit,
}

/// What the machine's sensors measure now, per unit; the process loop uses whatever is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observed {
    /// Of the stroke.
    pub position: PerUnit,
    /// Spool position.
    pub spool: Option<PerUnit>,
    /// Both pressures, of supply.
    pub pressures: Option<ChamberState<PerUnit>>,
}

/// Coefficients of both loops at one tick: configuration, never state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follower {
    orifice: Orifice,
    overlap: Overlap,
    /// Spool travel at the middle of the overlap.
    middle: PerUnit,
    /// Command per spool travel.
    per_spool: I4F28,
    /// Spool travel per command.
    per_command: I4F28,
    /// Command that holds the spool at the middle of the overlap.
    neutral: PerUnit,
    command_limit: PerUnit,
    /// Largest change of a command in a tick.
    slew: PerUnit,
    velocity_limit: PerUnit,
    /// Lead over its filter's time constant.
    lead: U16F16,
    lead_share: I4F28,
    spool_gain: U16F16,
    model_gain: U16F16,
    process_gain: U16F16,
    integral_gain: U16F16,
    /// Half of the position sensor's resolution.
    unseen: PerUnit,
    load_share: I4F28,
    damping: U16F16,
}

/// State of both loops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FollowState {
    /// The set point's velocity, delayed by the lead's filter.
    velocity: PerUnit,
    /// Last command to the model.
    model_command: PerUnit,
    /// Last command to the machine.
    command: PerUnit,
    /// Integral of the process loop, velocity.
    integral: PerUnit,
    /// Slow part of the oil's force on the model.
    model_force: PerUnit,
    /// Slow part of the difference of the oil's force, machine less model.
    load: PerUnit,
}

impl FollowState {
    /// The process loop's integral, of the velocity base: the velocity that the machine needs in addition to the model's command.
    #[must_use]
    pub fn integral(&self) -> PerUnit {
        self.integral
    }

    /// Difference of the oil's force, machine less model, per unit of force, without its fast part.
    #[must_use]
    pub fn load(&self) -> PerUnit {
        self.load
    }
}

impl Follower {
    /// At rest with the spool in the middle of its overlap: the first commands are the neutral one, wherever the rod is.
    ///
    /// `model` is at rest at the machine's position; the difference of the oil's force on the two counts as load from the start.
    #[must_use]
    pub fn at_rest(&self, model: &Predicted, seen: &Observed) -> FollowState {
        let model_force = self.orifice.force(pressures(model));
        let load = seen.pressures.map_or(PerUnit::ZERO, |found| self.orifice.force(found) - model_force);
        FollowState {
            velocity: PerUnit::ZERO,
            model_command: self.neutral,
            command: self.neutral,
            integral: PerUnit::ZERO,
            model_force,
            load,
        }
    }

    /// The command, in 10 V, that holds the spool in the middle of its overlap.
    #[must_use]
    pub fn neutral(&self) -> PerUnit {
        self.neutral
    }

    /// Model loop: the command, in 10 V, that drives the model along the set point.
    #[inline]
    pub fn model_command(&self, state: &mut FollowState, wanted: SetPoint, model: &Predicted) -> PerUnit {
        let gained = wanted.velocity - state.velocity;
        state.velocity = state.velocity + PerUnit::dot([self.lead_share], [gained]);
        let led = wanted.velocity + gained.amplified(self.lead);
        let pulled = (wanted.position - model.position).amplified(self.model_gain);
        let force = self.orifice.force(pressures(model));
        let change = force - state.model_force;
        state.model_force = state.model_force + PerUnit::dot([self.load_share], [change]);
        let velocity = (led + pulled - change.amplified(self.damping)).limited(self.velocity_limit);
        let drop = self.orifice.drop(velocity > PerUnit::ZERO, force);
        let spool = self.overlap.spool(self.overlap.opened(self.orifice.opening(velocity, drop)));
        let hastened = spool + (spool - (model.spool - self.middle)).amplified(self.spool_gain);
        state.model_command = self.delivered(state.model_command, hastened);
        state.model_command
    }

    /// Process loop: the command, in 10 V, for the machine; `model_command` is the model's command in this tick, `model` and
    /// `seen` are the states before it acts.
    #[inline]
    pub fn command(
        &self,
        state: &mut FollowState,
        model_command: PerUnit,
        model: &Predicted,
        seen: &Observed,
    ) -> PerUnit {
        let assumed = self.orifice.force(pressures(model));
        let change = match seen.pressures {
            Some(pressures) => self.orifice.force(pressures) - assumed - state.load,
            None => PerUnit::ZERO,
        };
        state.load = state.load + PerUnit::dot([self.load_share], [change]);
        let apart = model.position - seen.position;
        let apart = apart - apart.limited(self.unseen);
        let velocity = apart.amplified(self.process_gain) + state.integral - change.amplified(self.damping);
        let asked = velocity;
        let velocity = asked.limited(self.velocity_limit);

        let fed = self.overlap.coordinate(PerUnit::dot([self.per_command], [model_command - self.neutral]));
        let followed = self.overlap.coordinate(model.spool - self.middle);
        let correction = Correction { velocity, assumed, found: assumed + state.load };
        let spool = self.overlap.spool(self.corrected(fed, &correction));
        let hastened = match seen.spool {
            Some(found) => {
                let target = self.overlap.spool(self.corrected(followed, &correction));
                spool + (target - (found - self.middle)).amplified(self.spool_gain)
            }
            None => spool,
        };
        let wanted = self.unlimited(hastened);
        state.command = self.limited(state.command, wanted);
        // No integration while a limit is active and the difference pushes further in that direction.
        let pushes_on =
            |beyond: PerUnit| beyond != PerUnit::ZERO && (beyond > PerUnit::ZERO) == (apart > PerUnit::ZERO);
        if !pushes_on(wanted - state.command) && !pushes_on(asked - velocity) {
            let integral = state.integral + apart.amplified(self.integral_gain);
            state.integral = integral.limited(self.velocity_limit);
        }
        state.command
    }

    /// A coordinate of the model, changed for the machine: the same flow under the machine's load, plus the correction.
    #[inline]
    fn corrected(&self, w: PerUnit, correction: &Correction) -> PerUnit {
        let opening = self.overlap.opening(w);
        let direction = if opening == PerUnit::ZERO { correction.velocity } else { opening };
        let extends = direction > PerUnit::ZERO;
        let assumed = self.orifice.drop(extends, correction.assumed);
        let found = self.orifice.drop(extends, correction.found);
        w - opening + found.instead_of(assumed, opening) + self.orifice.opening(correction.velocity, found)
    }

    /// The command, in 10 V, that holds the spool at a travel from the middle of the overlap.
    #[inline]
    fn unlimited(&self, spool: PerUnit) -> PerUnit {
        self.neutral + PerUnit::dot([self.per_spool], [spool])
    }

    /// Within the slew from the last command, and within the limit.
    #[inline]
    fn limited(&self, last: PerUnit, wanted: PerUnit) -> PerUnit {
        (last + (wanted - last).limited(self.slew)).limited(self.command_limit)
    }

    #[inline]
    fn delivered(&self, last: PerUnit, spool: PerUnit) -> PerUnit {
        self.limited(last, self.unlimited(spool))
    }
}

/// What the process loop adds to the model's opening.
#[derive(Clone, Copy, Debug)]
struct Correction {
    velocity: PerUnit,
    /// Force of the oil for which the model's opening was computed.
    assumed: PerUnit,
    /// Force of the oil that acts on the machine.
    found: PerUnit,
}

#[inline]
fn pressures(model: &Predicted) -> ChamberState<PerUnit> {
    ChamberState { a: model.pressure_a, b: model.pressure_b }
}
