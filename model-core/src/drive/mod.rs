//! The drive: all links in a chain, stepped together.
//!
//! The valve goes first; how the links below it are solved together is in `step`.

mod baked;
mod cavitating;
mod feed;
mod paper;
mod state;
pub(crate) mod step;

use baked::KnowsLinks;
use feed::{AnyFeed, Metered};
use step::Links;

use crate::chambers::Chambers;
use crate::correction_table::Unnamed;
use crate::effects::{AnyEffect, Plain};
use crate::flow::{Edges, Pump, PumpDrive, SupplyState};
use crate::machine::Bases;
use crate::mechanics::Mechanics;
use crate::number::Number;
use crate::oil::Viscosity;
use crate::ports::{AcrossEdges, ChamberState, Flows, Forces, Spool, States};
use crate::sensing::{Sensed, Sensors};
use crate::valve::{Valve, ValveState};

pub use baked::{Baked, BakedDrive};
pub use paper::PaperDrive;
pub use state::{DriveInput, DriveState, Interfaces, Load};
pub(crate) use step::StageWeights;

/// Where the oil comes from, with coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
pub enum OilSource<N: Number> {
    /// Proportional valve on a constant supply.
    Valve(Valve<N>, Edges<N>),
    /// Pump with directional valve.
    Pump(Pump<N>),
    /// None: a force moves the mass.
    None,
}

/// Coefficients of a drive at one tick: configuration, never state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
pub struct Drive<N: Number> {
    #[doc(hidden)]
    pub source: OilSource<N>,
    #[doc(hidden)]
    pub chambers: Chambers<N>,
    #[doc(hidden)]
    pub mechanics: Mechanics<N>,
    /// The mechanics under a given force: without the oil spring, to whose frequency the mass of the other mechanics is matched.
    #[doc(hidden)]
    pub unsprung: Mechanics<N>,
    #[doc(hidden)]
    pub weights: StageWeights<N>,
    #[doc(hidden)]
    pub sensors: Sensors<N>,
    /// Viscosity of the oil, where it changes.
    #[doc(hidden)]
    pub viscosity: Option<Viscosity<N>>,
    /// Correction table of a flow or a spool travel; one of a force is in the mechanics.
    #[doc(hidden)]
    pub unnamed: Option<Unnamed<N>>,
    /// Whether it is a valve-controlled drive without any effect, and without viscous friction that is too strong for its step.
    #[doc(hidden)]
    pub plain: bool,
    #[doc(hidden)]
    pub bases: Bases,
}

impl<N: Number> Drive<N> {
    /// The scales of all per-unit quantities.
    #[must_use]
    pub fn bases(&self) -> &Bases {
        &self.bases
    }

    /// The valve link, where the drive has one.
    #[must_use]
    pub fn valve(&self) -> Option<&Valve<N>> {
        match &self.source {
            OilSource::Valve(valve, _) => Some(valve),
            OilSource::Pump(_) | OilSource::None => None,
        }
    }

    /// The chambers link.
    #[must_use]
    pub fn chambers(&self) -> &Chambers<N> {
        &self.chambers
    }

    /// The mechanics link, with the mass matched to the oil spring it works on; [`DriveInput::Force`] takes the mass as it is.
    #[must_use]
    pub fn mechanics(&self) -> &Mechanics<N> {
        &self.mechanics
    }

    /// The flow link at a point: flows into A and out of B without leakage, from an unloaded supply.
    #[must_use]
    pub fn flows(&self, spool: N, pump: PumpDrive<N>, pressures: ChamberState<N>) -> Flows<N> {
        self.flows_from(self.unloaded().pressure, spool, pump, pressures)
    }

    /// The flow link at a point, with the supply at the pressure `supply` where it droops, and load-holding valves at rest.
    #[must_use]
    pub fn flows_from(&self, supply: N, spool: N, pump: PumpDrive<N>, pressures: ChamberState<N>) -> Flows<N> {
        match &self.source {
            OilSource::Valve(_, edges) => edges.flow(spool, pressures, supply),
            OilSource::Pump(source) => {
                let flows = source.flow(pump, pressures.a, pressures.b);
                Flows { a: flows.a.flow, b: flows.b.flow }
            }
            OilSource::None => Flows { a: N::ZERO, b: N::ZERO },
        }
    }

    /// The flow link at a state of the drive, with this spool or pump.
    #[must_use]
    pub fn flows_of<const DELAY: usize>(&self, state: &DriveState<N, DELAY>, spool: N, pump: PumpDrive<N>) -> Flows<N> {
        match &self.source {
            OilSource::Valve(_, edges) => {
                edges.flow_behind(spool, state.chambers, state.supply.pressure, state.poppets)
            }
            _ => self.flows_from(state.supply.pressure, spool, pump, state.chambers),
        }
    }

    /// The supply after a long time without any flow drawn.
    fn unloaded(&self) -> SupplyState<N> {
        match &self.source {
            OilSource::Valve(_, edges) => SupplyState::at_rest(edges.lines.supply),
            OilSource::Pump(pump) => SupplyState::at_rest(pump.lines.supply),
            OilSource::None => SupplyState::at_rest(N::ONE),
        }
    }

    /// A drive at rest: `command` (in 10 V) held for long, no velocity, nothing drawn from the supply.
    #[must_use]
    pub fn at_rest<const DELAY: usize>(
        &self,
        command: N,
        pressures: ChamberState<N>,
        position: N::Travel,
    ) -> DriveState<N, DELAY> {
        self.at_rest_with::<AnyEffect, DELAY>(command, pressures, position)
    }

    fn at_rest_with<V: KnowsLinks<N>, const DELAY: usize>(
        &self,
        command: N,
        pressures: ChamberState<N>,
        position: N::Travel,
    ) -> DriveState<N, DELAY> {
        let valve = match &self.source {
            OilSource::Valve(valve, _) => valve.at_rest_with::<V, DELAY>(command),
            OilSource::Pump(_) | OilSource::None => ValveState::idle(),
        };
        let state = DriveState::at_rest(valve, pressures, position, self.unloaded());
        let poppets = match &self.source {
            OilSource::Valve(_, edges) => edges.poppets::<V>(pressures),
            OilSource::Pump(_) | OilSource::None => state.poppets,
        };
        DriveState { oil_temperature: self.reference_temperature(), poppets, ..state }
    }

    /// The spool that the edges see: the valve's own, plus the travel of a correction table.
    #[must_use]
    #[inline]
    pub fn spool<const DELAY: usize>(&self, state: &DriveState<N, DELAY>) -> N {
        self.spool_with::<AnyEffect, DELAY>(state)
    }

    #[inline]
    fn spool_with<V: KnowsLinks<N>, const DELAY: usize>(&self, state: &DriveState<N, DELAY>) -> N {
        let spool = state.valve.spool();
        match &self.unnamed {
            _ if !V::TABLED => spool,
            Some(Unnamed::Travel(table)) => spool + table.at(States::of(state, spool)),
            _ => spool,
        }
    }

    /// Readings of the sensors. The spool is the valve's own; where a measured spool drives the model, the caller has it from the measurement.
    #[must_use]
    #[inline]
    pub fn sensed<const DELAY: usize>(&self, state: &DriveState<N, DELAY>) -> Sensed<N> {
        self.sensors.read(&state.sensed, self.spool(state), state.chambers, &state.motion)
    }

    /// One tick. Fixed cost; no input of any size causes an overflow or a panic.
    ///
    /// ```
    /// # use model_core::ports::ChamberState;
    /// # use model_core::drive::{Drive, DriveState, DriveInput, Load};
    /// # use model_core::number::PerUnit;
    /// # use model_core::machine::{Machine, Source, Tick};
    /// # use model_core::number::Number;
    /// # use model_core::machine::Parameter;
    /// use model_core::ports::Spool;
    ///
    /// let areas = [(Parameter::AreaA, 3.117e-3), (Parameter::AreaB, 1.861e-3)];
    /// let machine = Machine::with_defaults(Source::Valve).with(&areas).with(&[
    ///     (Parameter::VolumeA, 5.2e-4),
    ///     (Parameter::VolumeB, 3.3e-4),
    /// ]);
    /// let drive = Drive::<PerUnit>::new::<64>(&machine, Tick::OneMillisecond)?;
    /// let pressures = ChamberState { a: PerUnit::saturated(0.3), b: PerUnit::saturated(0.5) };
    /// let mut state: DriveState<PerUnit> = drive.at_rest(PerUnit::ZERO, pressures, PerUnit::travel(0.5));
    ///
    /// // Entered at a measured spool: the valve link is left out. A tenth open retracts where it is negative.
    /// let spool = PerUnit::saturated(-0.1);
    /// for _ in 0..100 {
    ///     drive.step(&mut state, DriveInput::Spool(Spool { from: spool, to: spool }), Load::NONE);
    /// }
    /// assert!(PerUnit::strokes(state.motion.position) < 0.5);
    /// # Ok::<(), model_core::machine::MachineError>(())
    /// ```
    ///
    /// A drive input that the drive's source cannot take (a pump's speed on a valve drive, a spool on a pump drive) counts
    /// as closed ports, and as no force on a mass that only a force moves.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "what the caller does not read of the interfaces is then never computed")]
    pub fn step<const DELAY: usize>(
        &self,
        state: &mut DriveState<N, DELAY>,
        drive_input: DriveInput<N>,
        load: Load<N>,
    ) -> Interfaces<N> {
        if let Some(seen) = self.step_plain(state, drive_input, load) {
            return seen;
        }
        if let Some(cavitation) = &self.chambers.effects.cavitation {
            return self.step_cavitating(cavitation, state, drive_input, load);
        }
        self.step_links((&self.chambers, &self.mechanics), state, drive_input, load)
    }

    /// One tick of a drive without effects under a command.
    #[inline(always)]
    fn step_plain<const DELAY: usize>(
        &self,
        state: &mut DriveState<N, DELAY>,
        drive_input: DriveInput<N>,
        load: Load<N>,
    ) -> Option<Interfaces<N>> {
        if N::LEAN
            && self.plain
            && let (DriveInput::Command(command), OilSource::Valve(valve, edges)) = (drive_input, &self.source)
        {
            let spool = valve.step_with::<Plain, DELAY>(&mut state.valve, command, AcrossEdges::NONE);
            let feed = Metered::new::<Plain>(edges, spool, state.poppets);
            return Some(self.links().step::<Plain, DELAY>(state, &feed, load));
        }
        None
    }

    /// One tick of a drive that may have any effect, with these chambers and this mass instead of its own. Out of line, so that it takes no registers
    /// from the step without effects.
    #[inline(never)]
    pub(crate) fn step_links<const DELAY: usize>(
        &self,
        own: (&Chambers<N>, &Mechanics<N>),
        state: &mut DriveState<N, DELAY>,
        drive_input: DriveInput<N>,
        load: Load<N>,
    ) -> Interfaces<N> {
        match self.force(drive_input, load) {
            Some(force) => self.step_under_force(state, force),
            None => self.step_fed::<AnyEffect, DELAY>(own, state, drive_input, load),
        }
    }

    /// The force that moves the mass in place of oil, at both ends of the tick.
    #[inline]
    fn force(&self, drive_input: DriveInput<N>, load: Load<N>) -> Option<[N; 2]> {
        match drive_input {
            DriveInput::Force { from, to } => Some([from + load.from, to + load.to]),
            _ if matches!(self.source, OilSource::None) => Some([load.from, load.to]),
            _ => None,
        }
    }

    /// One tick that oil moves.
    #[inline(always)]
    fn step_fed<V: KnowsLinks<N>, const DELAY: usize>(
        &self,
        (chambers, mechanics): (&Chambers<N>, &Mechanics<N>),
        state: &mut DriveState<N, DELAY>,
        drive_input: DriveInput<N>,
        load: Load<N>,
    ) -> Interfaces<N> {
        let closed = Flows { a: N::ZERO, b: N::ZERO };
        let given = |from, to| AnyFeed::Given { from, to, unity: self.chambers.unity };
        let feed = match (drive_input, &self.source) {
            (DriveInput::Command(command), OilSource::Valve(valve, edges)) => {
                let spool = Self::step_valve::<V, DELAY>(state, valve, edges, command);
                let spool = if V::TABLED { self.shifted(state, spool) } else { spool };
                Self::metered::<V, DELAY>(state, edges, spool)
            }
            (DriveInput::Followed { command, spool }, OilSource::Valve(valve, edges)) => {
                Self::step_valve::<V, DELAY>(state, valve, edges, command);
                Self::metered::<V, DELAY>(state, edges, spool)
            }
            (DriveInput::Spool(spool), OilSource::Valve(_, edges)) => Self::metered::<V, DELAY>(state, edges, spool),
            (DriveInput::Pump(drive), OilSource::Pump(pump)) => AnyFeed::Pump(pump, drive),
            (DriveInput::Flow { from, to }, _) => given(from, to),
            _ => given(closed, closed),
        };
        let seen = Links { chambers, mechanics, ..self.links() }.step::<V, DELAY>(state, &feed, load);
        self.step_beside(state);
        seen
    }

    /// One tick under a given force, load included. Out of line, so that it takes no registers from the other steps.
    #[inline(never)]
    fn step_under_force<const DELAY: usize>(&self, state: &mut DriveState<N, DELAY>, force: [N; 2]) -> Interfaces<N> {
        self.step_force::<AnyEffect, DELAY>(state, force)
    }

    /// What only reads the links: sensors and the oil's warming.
    #[inline]
    fn step_beside<const DELAY: usize>(&self, state: &mut DriveState<N, DELAY>) {
        self.sensors.step(&mut state.sensed, state.motion.position);
        if let Some(viscosity) = &self.viscosity {
            viscosity.step(&mut state.warmth);
        }
    }

    /// The links below the valve.
    #[inline]
    fn links(&self) -> Links<'_, N> {
        Links {
            chambers: &self.chambers,
            mechanics: &self.mechanics,
            weights: self.weights,
            viscosity: self.viscosity.as_ref(),
            unnamed: self.unnamed.as_ref(),
        }
    }

    /// Only the valve.
    #[inline]
    fn step_valve<V: KnowsLinks<N>, const DELAY: usize>(
        state: &mut DriveState<N, DELAY>,
        valve: &Valve<N>,
        edges: &Edges<N>,
        command: N,
    ) -> Spool<N> {
        let across = if valve.feels_flow::<V>() {
            edges.across_open::<V>(state.chambers, state.supply.pressure)
        } else {
            AcrossEdges::NONE
        };
        valve.step_with::<V, DELAY>(&mut state.valve, command, across)
    }

    /// The edges under a spool, and the load-holding valves, which the pressures move first.
    #[inline]
    fn metered<'a, V: KnowsLinks<N>, const DELAY: usize>(
        state: &mut DriveState<N, DELAY>,
        edges: &'a Edges<N>,
        spool: Spool<N>,
    ) -> AnyFeed<'a, N> {
        if let Some(holding) = edges.holding::<V>() {
            state.poppets = holding.step(state.poppets, state.chambers);
        }
        AnyFeed::Edges(Metered::new::<V>(edges, spool, state.poppets))
    }

    /// The spool over a tick, plus the travel of a correction table.
    #[inline]
    fn shifted<const DELAY: usize>(&self, state: &DriveState<N, DELAY>, spool: Spool<N>) -> Spool<N> {
        let Some(Unnamed::Travel(table)) = &self.unnamed else { return spool };
        let shifted = |spool: N| spool + table.at(States::of(state, spool));
        Spool { from: shifted(spool.from), to: shifted(spool.to) }
    }

    /// Only the mechanics, under a given force of the oil.
    #[inline(always)]
    fn step_force<V: KnowsLinks<N>, const DELAY: usize>(
        &self,
        state: &mut DriveState<N, DELAY>,
        [from, to]: [N; 2],
    ) -> Interfaces<N> {
        let (rise, links) = (to - from, self.links());
        let constant = self.unsprung.load;
        let ahead = rise.part(self.unsprung.gamma);
        let forces = Forces {
            start: from + constant,
            first: from + constant + ahead,
            second: ahead - ahead.part(self.unsprung.gamma),
            around: links.surroundings::<V, DELAY>(state, N::ZERO, links.oil::<V, DELAY>(state)),
        };
        let position = N::of_travel(state.motion.position);
        let velocity = self.unsprung.step_with::<V>(&mut state.motion, forces);
        self.step_beside(state);
        Interfaces {
            spool: None,
            flows: Flows { a: N::ZERO, b: N::ZERO },
            forces,
            velocity,
            midway: state.chambers,
            position,
        }
    }

    /// Temperature that the machine's values are for, per unit, where the viscosity follows a measured temperature.
    #[must_use]
    pub fn measured_oil(&self) -> Option<N> {
        self.viscosity.and_then(|viscosity| viscosity.thinning).map(|thinning| thinning.reference)
    }

    fn reference_temperature(&self) -> N {
        self.measured_oil().unwrap_or(N::ZERO)
    }
}
