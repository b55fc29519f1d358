//! The mechanics link: forces → velocity and position. (8), (12)–(14) of the paper.
//!
//! m·dv/dt = F + Aa·pa − Ab·pb − D·v, scaled by the force Aa·(pressure base). The tick is the two-stage L-stable
//! linearly implicit step of `drive`; alone, this link takes the forces of the two stages.

use crate::number::Number;

/// γ = 1 − 1/√2, at which the two-stage step is L-stable.
pub const GAMMA: f64 = 1.0 - core::f64::consts::FRAC_1_SQRT_2;

/// Coefficients of the mass at one tick. All are divided by 1 + γ·h·D/m, the mass's own diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mechanics<N: Number> {
    /// Velocity gained in a tick per force.
    pub(crate) mobility: N::Gain,
    /// Velocity lost in a tick to viscous friction, per velocity.
    pub(crate) drag: N::Gain,
    /// −2/(1 + γ·h·D/m): what the second stage takes back of the first.
    pub(crate) back: N::Gain,
    /// ½(1 + γ) and ½γ: weights of the stages in the mean velocity.
    pub(crate) mean: [N::Gain; 2],
    /// 3/2 and 1/2: weights of the stages in the new velocity.
    pub(crate) weights: [N::Gain; 2],
    /// 1
    pub(crate) unity: N::Gain,
    /// Strokes per tick at velocity 1.
    pub(crate) travel: N::Gain,
    /// Dry friction force. 0 is neutral.
    pub(crate) coulomb: N,
    /// Twice the velocity that the dry friction takes in a tick.
    pub(crate) coulomb_turn: N,
    /// Constant external force, positive extends.
    pub(crate) load: N,
}

/// Velocity and position.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "N: serde::Serialize, N::Travel: serde::Serialize",
        deserialize = "N: serde::Deserialize<'de>, N::Travel: serde::Deserialize<'de>"
    ))
)]
pub struct MotionState<N: Number> {
    /// Velocity, per unit; positive extends.
    pub velocity: N,
    /// Position.
    pub position: N::Travel,
}

/// Net force on the rod without friction, in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forces<N> {
    /// At the start of the tick: what dry friction has to hold.
    pub start: N,
    /// First stage.
    pub first: N,
    /// Second stage.
    pub second: N,
}

/// How dry friction acts during one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contact {
    /// The rod sticks.
    Sticks,
    /// It slides; friction points against extending.
    Extends,
    /// It slides; friction points against retracting.
    Retracts,
    /// No motion and no force.
    Free,
}

impl<N: Number> Mechanics<N> {
    /// One tick under the given forces. Returns the mean velocity of the tick.
    #[inline]
    pub fn step(&self, state: &mut MotionState<N>, forces: Forces<N>) -> N {
        let contact = self.contact(state.velocity, forces.start);
        let first = self.first_stage(contact, state.velocity, forces.first);
        let second = self.second_stage(contact, state.velocity, first, forces.second);
        self.finish(contact, state, first, second)
    }

    /// Sticks, or slides which way. Set-valued: at rest, any force below the friction is held exactly.
    #[inline]
    pub(crate) fn contact(&self, velocity: N, force: N) -> Contact {
        if velocity > N::ZERO {
            Contact::Extends
        } else if velocity < N::ZERO {
            Contact::Retracts
        } else if force.magnitude() < self.coulomb {
            Contact::Sticks
        } else if force > N::ZERO {
            Contact::Extends
        } else if force < N::ZERO {
            Contact::Retracts
        } else {
            Contact::Free
        }
    }

    /// The dry friction force.
    #[inline]
    pub(crate) fn friction(&self, contact: Contact) -> N {
        match contact {
            Contact::Extends => -self.coulomb,
            Contact::Retracts => self.coulomb,
            Contact::Sticks | Contact::Free => N::ZERO,
        }
    }

    /// Velocity increment of the first stage.
    #[inline]
    pub(crate) fn first_stage(&self, contact: Contact, velocity: N, force: N) -> N {
        if contact == Contact::Sticks {
            return N::ZERO;
        }
        N::dot([self.mobility, self.drag], [force + self.friction(contact), -velocity])
    }

    /// Velocity increment of the second stage.
    #[inline]
    pub(crate) fn second_stage(&self, contact: Contact, velocity: N, first: N, force: N) -> N {
        if contact == Contact::Sticks {
            return N::ZERO;
        }
        N::dot([self.mobility, self.drag, self.back], [force + self.friction(contact), -(velocity + first), first])
    }

    /// Whether the increments of a tick are beyond the format.
    #[inline]
    pub(crate) fn is_held(first: N, second: N) -> bool {
        first.is_held() || second.is_held()
    }

    /// Moves the rod by the two increments and returns its mean velocity over the tick.
    ///
    /// Where an increment is held at the end of the format the step is no longer the method's, and no longer stable: two
    /// held stages can throw the rod to and fro for ever. It then goes on where it is pushed to, with a velocity of one half at
    /// most, from where the step is linear.
    #[inline]
    pub(crate) fn finish(&self, contact: Contact, state: &mut MotionState<N>, first: N, second: N) -> N {
        let [weigh_first, weigh_second] = self.mean;
        let mean = N::dot([self.unity, weigh_first, weigh_second], [state.velocity, first, second]);
        let slow = N::ONE.halved();
        let limit = |velocity: N| {
            if first.is_held() {
                first.limited(slow)
            } else if second.is_held() {
                velocity.limited(slow)
            } else {
                velocity
            }
        };
        let mean = limit(mean);
        state.position = N::travelled(state.position, [self.travel], [mean]);
        let moved = limit(state.velocity + N::dot(self.weights, [first, second]));
        // Friction turned with the velocity somewhere within the tick: give back what it took too much, at most to rest.
        state.velocity = match contact {
            Contact::Extends if moved < N::ZERO => (moved + self.coulomb_turn).min(N::ZERO),
            Contact::Retracts if moved > N::ZERO => (moved - self.coulomb_turn).max(N::ZERO),
            _ => moved,
        };
        mean
    }
}
