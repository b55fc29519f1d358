//! The paper's model by itself: a valve-controlled drive without effects, in little more than a quarter of the memory and a
//! seventh of the code.
//!
//! The equations are those of [`Drive`], compiled with every effect known to be off; what such a step does not read is not kept. A
//! firmware whose machine has no effect uses this type, and the steps of all effects are then not linked.

use crate::chambers::Chambers;
use crate::drive::feed::Metered;
use crate::drive::state::{DriveState, Interfaces, Load};
use crate::drive::step::{Links, StageWeights};
use crate::drive::{Drive, OilSource};
use crate::effects::{Nothing, Plain};
use crate::flow::{Edges, SupplyState};
use crate::machine::Bases;
use crate::mechanics::Mechanics;
use crate::number::Number;
use crate::ports::{AcrossEdges, ChamberState};
use crate::sensing::{Sensed, Sensors};
use crate::valve::{Valve, ValveState};

/// Coefficients of a valve-controlled drive without effects at one tick: configuration, never state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperDrive<N: Number> {
    valve: Valve<N, Nothing>,
    edges: Edges<N, Nothing>,
    chambers: Chambers<N, Nothing>,
    mechanics: Mechanics<N, Nothing>,
    weights: StageWeights<N>,
    sensors: Sensors<N>,
    bases: Bases,
}

impl<N: Number> Drive<N> {
    /// The drive as one of the paper's model; `None` where it has a pump, an effect that a step computes, or so much viscous friction that
    /// full force moves it at a quarter of [`Bases::velocity_m_per_s`] at most. Hose compliance, unequal dead zones, the laminar transition
    /// and sensors' gain and offset only change coefficients, and are kept.
    #[must_use]
    pub fn without_effects(&self) -> Option<PaperDrive<N>> {
        let OilSource::Valve(valve, edges) = &self.source else { return None };
        self.plain.then(|| PaperDrive {
            valve: valve.with(Nothing),
            edges: edges.with(Nothing),
            chambers: self.chambers.with(Nothing),
            mechanics: self.mechanics.with(Nothing),
            weights: self.weights,
            sensors: self.sensors,
            bases: self.bases,
        })
    }
}

impl<N: Number> PaperDrive<N> {
    /// The scales of all per-unit quantities.
    #[must_use]
    pub fn bases(&self) -> &Bases {
        &self.bases
    }

    /// One tick under a command, in 10 V, held over it: that of [`Drive::step`], bit for bit.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "the compiler then sees that no effect is ever read")]
    pub fn step<const DELAY: usize>(
        &self,
        state: &mut DriveState<N, DELAY>,
        command: N,
        load: Load<N>,
    ) -> Interfaces<N> {
        let spool = self.valve.step_with::<Plain, DELAY>(&mut state.valve, command, AcrossEdges::NONE);
        let links = Links {
            chambers: &self.chambers,
            mechanics: &self.mechanics,
            weights: self.weights,
            viscosity: None,
            unnamed: None,
        };
        let feed = Metered::new::<Plain>(&self.edges, spool, state.poppets);
        links.step::<Plain, DELAY>(state, &feed, load)
    }

    /// A drive at rest: `command` (in 10 V) held for long, no velocity.
    #[must_use]
    pub fn at_rest<const DELAY: usize>(
        &self,
        command: N,
        pressures: ChamberState<N>,
        position: N::Travel,
    ) -> DriveState<N, DELAY> {
        let valve = ValveState::at_rest(self.valve.target(command));
        DriveState::at_rest(valve, pressures, position, SupplyState::at_rest(self.edges.lines.supply))
    }

    /// What the sensors read.
    #[must_use]
    pub fn sensed<const DELAY: usize>(&self, state: &DriveState<N, DELAY>) -> Sensed<N> {
        self.sensors.read(&state.sensed, state.valve.spool(), state.chambers, &state.motion)
    }
}
