//! State of a drive, its inputs in a tick, and the values that its links handed to each other.

use crate::chambers::cavitation::Voids;
use crate::flow::{Poppets, PumpDrive, SupplyState};
use crate::number::Number;
use crate::ports::{ChamberState, Flows, Forces, MotionState, Spool, States};
use crate::sensing::SensedState;
use crate::valve::ValveState;

/// State of a drive whose delay line holds `DELAY` ticks.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "N: serde::Serialize, N::Travel: serde::Serialize",
        deserialize = "N: serde::Deserialize<'de>, N::Travel: serde::Deserialize<'de>"
    ))
)]
pub struct DriveState<N: Number, const DELAY: usize = 64> {
    /// Spool and what leads to it; at rest and untouched in a pump-controlled drive.
    pub valve: ValveState<N, DELAY>,
    /// Chamber pressures.
    pub chambers: ChamberState<N>,
    /// Rounding remainder of the chamber pressures, below their step.
    pub rest: ChamberState<N>,
    /// Voids of both chambers, with `cavitation`.
    pub voids: Voids<N>,
    /// Velocity and position.
    pub motion: MotionState<N>,
    /// Supply pressure; constant without `supply-droop`.
    pub supply: SupplyState<N>,
    /// Load-holding valves, with `counterbalance`.
    pub poppets: Poppets<N>,
    /// State of the sensors.
    pub sensed: SensedState<N, DELAY>,
    /// How much of the oil's warming is done, 0..1.
    pub warmth: N::Travel,
    /// Temperature of the oil, per unit of [`Bases::temperature_c`](crate::machine::Bases::temperature_c): an input. If it is measured, set it
    /// before a tick; else it stays at the machine's reference temperature (0 where the viscosity does not depend on it).
    pub oil_temperature: N,
}

/// What drives the model in a tick: the input point and the values there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveInput<N> {
    /// Command, in 10 V, held over the tick.
    Command(N),
    /// Measured spool; the valve link is left out.
    Spool(Spool<N>),
    /// Both: the command moves the valve link, and the measured spool meters the oil. An error of
    /// the valve link reaches no other link, and the other links act on the valve only by its flow force.
    Followed {
        /// Command, in 10 V, held over the tick.
        command: N,
        /// Measured spool.
        spool: Spool<N>,
    },
    /// Speed of a pump and direction of its valve, held over the tick.
    Pump(PumpDrive<N>),
    /// Measured flows into A and out of B at both ends of the tick; valve and flow links are left out.
    Flow {
        /// At the start of the tick.
        from: Flows<N>,
        /// At its end.
        to: Flows<N>,
    },
    /// Measured force of the oil on the rod at both ends of the tick; only the mechanics are left.
    Force {
        /// At the start of the tick.
        from: N,
        /// At its end.
        to: N,
    },
}

/// External force on the rod beside the machine's constant load, at both ends of a tick; positive extends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load<N> {
    /// At the start of the tick.
    pub from: N,
    /// At its end.
    pub to: N,
}

impl<N: Number> Load<N> {
    /// No force beside the constant load.
    pub const NONE: Self = Self { from: N::ZERO, to: N::ZERO };
}

/// Values that the links handed to each other during a tick.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
pub struct Interfaces<N> {
    /// Spool, where the drive input is the spool or lies above it.
    pub spool: Option<Spool<N>>,
    /// Mean net flows of the tick, leakage included.
    pub flows: Flows<N>,
    /// Net forces at the start of the tick and at its two stages, friction left out.
    pub forces: Forces<N>,
    /// Mean velocity of the tick.
    pub velocity: N,
    /// Pressures halfway through the tick, as its start predicts them: the chambers have the capacity of these, with `entrained-air`.
    pub midway: ChamberState<N>,
    /// Position at the start of the tick, strokes.
    pub position: N,
}

impl<N: Number, const DELAY: usize> DriveState<N, DELAY> {
    /// No velocity, the oil cold.
    pub(crate) fn at_rest(
        valve: ValveState<N, DELAY>,
        pressures: ChamberState<N>,
        position: N::Travel,
        supply: SupplyState<N>,
    ) -> Self {
        Self {
            valve,
            chambers: pressures,
            rest: ChamberState { a: N::ZERO, b: N::ZERO },
            voids: ChamberState { a: N::ZERO.as_travel(), b: N::ZERO.as_travel() },
            motion: MotionState::at_rest(position),
            supply,
            poppets: Poppets { a: N::ZERO, b: N::ZERO },
            sensed: SensedState::at_rest(position),
            warmth: N::ZERO.as_travel(),
            oil_temperature: N::ZERO,
        }
    }
}

impl<N: Number> States<N> {
    /// The states of a drive with the spool at this position.
    #[inline]
    pub(crate) fn of<const DELAY: usize>(state: &DriveState<N, DELAY>, spool: N) -> Self {
        Self {
            velocity: state.motion.velocity,
            position: N::of_travel(state.motion.position),
            spool,
            pressure_a: state.chambers.a,
            pressure_b: state.chambers.b,
        }
    }
}
