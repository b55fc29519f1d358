//! Model-following control: the model follows the set point, and the machine is made to follow the model.
//!
//! Two loops (S. Skoczowski, S. Domek, K. Pietrusewicz: *Model-following control with two PID controllers*; the paper's
//! introduction names the method for changing loads). The *model loop* closes around the reference model, which has neither
//! noise nor disturbance, so it may be as fast as the valve allows; its command goes to the machine as well. The *process loop*
//! sees only the difference between model and machine, and corrects it. A planned excitation takes the place of the model loop
//! ([`Follower::driven_command`]).
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

use orifice::Orifice;
use overlap::Overlap;

use crate::number::{PerUnit, Scalar};
use crate::ports::ChamberState;

pub use build::FollowError;
pub use tuning::Tuning;

/// Where the rod is wanted, and how fast it is wanted to go there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetPoint<N = PerUnit> {
    /// Of the stroke.
    pub position: N,
    /// Of the velocity base; positive extends.
    pub velocity: N,
}

/// The model's prediction of the machine's present state, per unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Predicted<N = PerUnit> {
    /// Spool position; 1 is full travel, positive extends.
    pub spool: N,
    /// Pressure in A, of supply.
    pub pressure_a: N,
    /// Pressure in B, of supply.
    pub pressure_b: N,
    /// Velocity, of the velocity base; positive extends.
    pub velocity: N,
    /// Position, of the stroke.
    pub position: N,
}

/// What the machine's sensors measure now, per unit; the process loop uses whatever is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observed<N = PerUnit> {
    /// Of the stroke.
    pub position: N,
    /// Spool position.
    pub spool: Option<N>,
    /// Both pressures, of supply.
    pub pressures: Option<ChamberState<N>>,
}

/// Coefficients of both loops at one tick: configuration, never state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follower<N: Scalar = PerUnit> {
    orifice: Orifice<N>,
    overlap: Overlap<N>,
    /// Spool travel at the middle of the overlap.
    middle: N,
    /// Command per spool travel.
    per_spool: N::Gain,
    /// Spool travel per command.
    per_command: N::Gain,
    /// Command that holds the spool at the middle of the overlap.
    neutral: N,
    command_limit: N,
    /// Largest change of a command in a tick.
    slew: N,
    velocity_limit: N,
    /// Lead over its filter's time constant.
    lead: N::Steep,
    lead_share: N::Gain,
    spool_gain: N::Steep,
    model_gain: N::Steep,
    process_gain: N::Steep,
    integral_gain: N::Steep,
    /// Half of the position sensor's resolution.
    unseen: N,
    load_share: N::Gain,
    damping: N::Steep,
}

/// State of both loops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FollowState<N = PerUnit> {
    /// The set point's velocity, delayed by the lead's filter.
    velocity: N,
    /// Last command to the model.
    model_command: N,
    /// Last command to the machine.
    command: N,
    /// Integral of the process loop, velocity.
    integral: N,
    /// Slow part of the oil's force on the model.
    model_force: N,
    /// Slow part of the difference of the oil's force, machine less model.
    load: N,
}

impl<N: Scalar> FollowState<N> {
    /// The process loop's integral, of the velocity base: the velocity that the machine needs in addition to the model's command.
    #[must_use]
    pub fn integral(&self) -> N {
        self.integral
    }

    /// Difference of the oil's force, machine less model, per unit of force, without its fast part.
    #[must_use]
    pub fn load(&self) -> N {
        self.load
    }
}

impl<N: Scalar> Follower<N> {
    /// At rest with the spool in the middle of its overlap: the first commands are the neutral one, wherever the rod is.
    ///
    /// `model` is at rest at the machine's position; the difference of the oil's force on the two counts as load from the start.
    #[must_use]
    pub fn at_rest(&self, model: &Predicted<N>, seen: &Observed<N>) -> FollowState<N> {
        let model_force = self.orifice.force(pressures(model));
        let load = seen.pressures.map_or(N::ZERO, |found| self.orifice.force(found) - model_force);
        FollowState {
            velocity: N::ZERO,
            model_command: self.neutral,
            command: self.neutral,
            integral: N::ZERO,
            model_force,
            load,
        }
    }

    /// The command, in 10 V, that holds the spool in the middle of its overlap.
    #[must_use]
    pub fn neutral(&self) -> N {
        self.neutral
    }

    /// Model loop: the command, in 10 V, that drives the model along the set point.
    #[inline]
    pub fn model_command(&self, state: &mut FollowState<N>, wanted: SetPoint<N>, model: &Predicted<N>) -> N {
        let gained = wanted.velocity - state.velocity;
        state.velocity = state.velocity + N::dot([self.lead_share], [gained]);
        let led = wanted.velocity + gained.amplified(self.lead);
        let pulled = (wanted.position - model.position).amplified(self.model_gain);
        let force = self.orifice.force(pressures(model));
        let change = force - state.model_force;
        state.model_force = state.model_force + N::dot([self.load_share], [change]);
        let velocity = (led + pulled - change.amplified(self.damping)).limited(self.velocity_limit);
        let drop = self.orifice.drop(velocity > N::ZERO, force);
        let spool = self.overlap.spool(self.overlap.opened(self.orifice.opening(velocity, drop)));
        let hastened = spool + (spool - (model.spool - self.middle)).amplified(self.spool_gain);
        state.model_command = self.delivered(state.model_command, hastened);
        state.model_command
    }

    /// In place of the model loop: the command, in 10 V, for a model that is driven by `wanted`, such as a planned excitation; within slew and limit. The
    /// model loop's filters go along, so that it can go on from where the model is.
    #[inline]
    pub fn driven_command(&self, state: &mut FollowState<N>, wanted: N, model: &Predicted<N>) -> N {
        state.velocity = state.velocity + N::dot([self.lead_share], [model.velocity - state.velocity]);
        let change = self.orifice.force(pressures(model)) - state.model_force;
        state.model_force = state.model_force + N::dot([self.load_share], [change]);
        state.model_command = self.limited(state.model_command, wanted);
        state.model_command
    }

    /// Process loop: the command, in 10 V, for the machine; `model_command` is the model's command in this tick, `model` and
    /// `seen` are the states before it acts.
    #[inline]
    pub fn command(&self, state: &mut FollowState<N>, model_command: N, model: &Predicted<N>, seen: &Observed<N>) -> N {
        let assumed = self.orifice.force(pressures(model));
        let change = match seen.pressures {
            Some(pressures) => self.orifice.force(pressures) - assumed - state.load,
            None => N::ZERO,
        };
        state.load = state.load + N::dot([self.load_share], [change]);
        let apart = model.position - seen.position;
        let apart = apart - apart.limited(self.unseen);
        let velocity = apart.amplified(self.process_gain) + state.integral - change.amplified(self.damping);
        let asked = velocity;
        let velocity = asked.limited(self.velocity_limit);

        let fed = self.overlap.coordinate(N::dot([self.per_command], [model_command - self.neutral]));
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
        let pushes_on = |beyond: N| beyond != N::ZERO && (beyond > N::ZERO) == (apart > N::ZERO);
        if !pushes_on(wanted - state.command) && !pushes_on(asked - velocity) {
            let integral = state.integral + apart.amplified(self.integral_gain);
            state.integral = integral.limited(self.velocity_limit);
        }
        state.command
    }

    /// A coordinate of the model, changed for the machine: the same flow under the machine's load, plus the correction.
    #[inline]
    fn corrected(&self, w: N, correction: &Correction<N>) -> N {
        let opening = self.overlap.opening(w);
        let direction = if opening == N::ZERO { correction.velocity } else { opening };
        let extends = direction > N::ZERO;
        let assumed = self.orifice.drop(extends, correction.assumed);
        let found = self.orifice.drop(extends, correction.found);
        w - opening + found.instead_of(assumed, opening) + self.orifice.opening(correction.velocity, found)
    }

    /// The command, in 10 V, that holds the spool at a travel from the middle of the overlap.
    #[inline]
    fn unlimited(&self, spool: N) -> N {
        self.neutral + N::dot([self.per_spool], [spool])
    }

    /// Within the slew from the last command, and within the limit.
    #[inline]
    fn limited(&self, last: N, wanted: N) -> N {
        (last + (wanted - last).limited(self.slew)).limited(self.command_limit)
    }

    #[inline]
    fn delivered(&self, last: N, spool: N) -> N {
        self.limited(last, self.unlimited(spool))
    }
}

/// What the process loop adds to the model's opening.
#[derive(Clone, Copy, Debug)]
struct Correction<N> {
    velocity: N,
    /// Force of the oil for which the model's opening was computed.
    assumed: N,
    /// Force of the oil that acts on the machine.
    found: N,
}

#[inline]
fn pressures<N: Scalar>(model: &Predicted<N>) -> ChamberState<N> {
    ChamberState { a: model.pressure_a, b: model.pressure_b }
}
