//! The drive: all links in a chain, stepped together.
//!
//! Pressures and velocity form a stiff, coupled system. One tick solves it with the two-stage, L-stable, linearly implicit
//! Rosenbrock step ROS2 (Verwer, Spee, Blom, Hundsdorfer: *A second-order Rosenbrock method applied to photochemical dispersion
//! problems*, SIAM J. Sci. Comput. 20, 1999), γ = 1 − 1/√2:
//!
//! ```text
//! (1 − γhJ)·k1 = h·f(tₙ, zₙ)
//! (1 − γhJ)·k2 = h·f(tₙ₊₁, zₙ + k1) − 2·k1
//! zₙ₊₁ = zₙ + 3/2·k1 + 1/2·k2
//! ```
//!
//! For an orifice J takes the slope of the chord to Δp = 0, never the flatter tangent: with the tangent a stiff chamber that
//! empties through its orifice overshoots within a stage to where the root is steep, and the two stages can cancel far from the true
//! steady state.
//!
//! The velocity couples to both pressures and each pressure to the velocity only, so the system is eliminated to one
//! equation for the velocity by hand. The method keeps its second order with any approximate Jacobian J.
//!
//! Both stages are written so that the links do the last step themselves: the solution yields each tick's mean flows and
//! stage forces, from which [`Chambers`] and [`Mechanics`] alone reproduce the chain bit for bit.

use crate::chambers::{ChamberState, Chambers};
use crate::flow::{Edges, Flows, Linearised, Pump, PumpDrive};
use crate::machine::Bases;
use crate::mechanics::{Contact, Forces, Mechanics, MotionState, Surroundings};
use crate::number::Number;
use crate::sensors::{Sensed, SensedState, Sensors};
use crate::supply::SupplyState;
use crate::temperature::{Oil, Viscosity};
use crate::unnamed::{States, Unnamed};
use crate::valve::{AcrossEdges, Slider, Valve, ValveState};
use crate::vocabulary::{Effects, Plain, Vocabulary};

/// Where the oil comes from, with coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OilSource<N: Number> {
    /// Proportional valve on a constant supply.
    Valve(Valve<N>, Edges<N>),
    /// Pump with directional valve.
    Pump(Pump<N>),
}

/// Coefficients of a drive at one tick: configuration, never state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive<N: Number> {
    pub(crate) source: OilSource<N>,
    pub(crate) chambers: Chambers<N>,
    pub(crate) mechanics: Mechanics<N>,
    /// The mechanics under a given force: without the oil spring, whose turning the others' mass is matched to.
    pub(crate) unsprung: Mechanics<N>,
    /// γ
    pub(crate) gamma: N::Gain,
    /// γ²·mobility·stiffness of each chamber: the oil springs in the eliminated equation.
    pub(crate) springs: [N::Steep; 2],
    pub(crate) sensors: Sensors<N>,
    /// Of the oil, where it changes.
    pub(crate) viscosity: Option<Viscosity<N>>,
    /// Flow or slider travel without a name; a force stands in the mechanics.
    pub(crate) unnamed: Option<Unnamed<N>>,
    /// Whether it is a valve-controlled drive without any effect.
    pub(crate) plain: bool,
    pub(crate) bases: Bases,
}

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
    /// Slider and what leads to it; at rest and untouched in a pump-controlled drive.
    pub valve: ValveState<N, DELAY>,
    /// Chamber pressures.
    pub chambers: ChamberState<N>,
    /// What rounding left of the chamber pressures, below their step.
    pub rest: ChamberState<N>,
    /// Velocity and position.
    pub motion: MotionState<N>,
    /// Supply pressure; constant but for `supply-droop`.
    pub supply: SupplyState<N>,
    /// What the position's sensor has seen.
    pub sensed: SensedState<N, DELAY>,
    /// How much of the oil's warming is done, 0..1.
    pub warmth: N::Travel,
    /// Temperature of the oil, per unit of [`Bases::temperature_c`]: an input, for whoever measures it to set before a tick. It stays at
    /// the machine's reference temperature where nobody does (0 where the viscosity does not go by it).
    pub oil_temperature: N,
}

/// Where the chain is entered in a tick, and with what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Entry<N> {
    /// Command, in 10 V, held over the tick.
    Command(N),
    /// Measured slider; the valve link is left out.
    Slider(Slider<N>),
    /// Both: the valve runs beside, and the measured slider meters the oil. The valve's
    /// error reaches nothing below it, and what is below reaches the valve by its flow force only.
    Followed {
        /// Command, in 10 V, held over the tick.
        command: N,
        /// Measured slider.
        slider: Slider<N>,
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

/// What the links handed to each other during a tick.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
pub struct Interfaces<N> {
    /// Slider, where the tick entered above it.
    pub slider: Option<Slider<N>>,
    /// Mean net flows of the tick, leakage included.
    pub flows: Flows<N>,
    /// Net forces at the start of the tick and at its two stages, friction left out.
    pub forces: Forces<N>,
    /// Mean velocity of the tick.
    pub velocity: N,
    /// Position at the start of the tick, strokes.
    pub position: N,
}

/// What feeds the chambers in a tick, at its two stages.
enum Feed<N> {
    Edges(Slider<N>),
    Pump(PumpDrive<N>),
    Given { from: Flows<N>, to: Flows<N> },
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
            OilSource::Pump(_) => None,
        }
    }

    /// The chambers link.
    #[must_use]
    pub fn chambers(&self) -> &Chambers<N> {
        &self.chambers
    }

    /// The mechanics link, with the mass matched to the oil spring it works on; [`Entry::Force`] takes the mass as it is.
    #[must_use]
    pub fn mechanics(&self) -> &Mechanics<N> {
        &self.mechanics
    }

    /// The flow link at a point: flows into A and out of B without leakage, from a supply of which nothing was drawn.
    #[must_use]
    pub fn flows(&self, slider: N, pump: PumpDrive<N>, pressures: ChamberState<N>) -> Flows<N> {
        self.flows_from(self.unloaded().pressure, slider, pump, pressures)
    }

    /// The flow link at a point, with the supply at the pressure `supply` where it droops.
    #[must_use]
    pub fn flows_from(&self, supply: N, slider: N, pump: PumpDrive<N>, pressures: ChamberState<N>) -> Flows<N> {
        match &self.source {
            OilSource::Valve(_, edges) => edges.flow(slider, pressures, supply),
            OilSource::Pump(source) => {
                let flows = source.flow(pump, pressures.a, pressures.b);
                Flows { a: flows.a.flow, b: flows.b.flow }
            }
        }
    }

    /// The supply of which nothing was drawn for long.
    fn unloaded(&self) -> SupplyState<N> {
        match &self.source {
            OilSource::Valve(_, edges) => SupplyState::at_rest(edges.lines.supply),
            OilSource::Pump(pump) => SupplyState::at_rest(pump.lines.supply),
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
        let valve = match &self.source {
            OilSource::Valve(valve, _) => valve.at_rest(command),
            OilSource::Pump(_) => ValveState::idle(),
        };
        let rest = ChamberState { a: N::ZERO, b: N::ZERO };
        DriveState {
            valve,
            chambers: pressures,
            rest,
            motion: MotionState::at_rest(position),
            supply: self.unloaded(),
            sensed: SensedState::at_rest(position),
            warmth: N::ZERO.as_travel(),
            oil_temperature: self.reference_temperature(),
        }
    }

    /// The slider that the edges see: the valve's own, with the travel of an unnamed table.
    #[must_use]
    pub fn slider<const DELAY: usize>(&self, state: &DriveState<N, DELAY>) -> N {
        let slider = state.valve.slider();
        match &self.unnamed {
            Some(Unnamed::Travel(table)) => slider + table.at(Self::states(state, slider)),
            _ => slider,
        }
    }

    /// States of the drive with the slider here.
    #[inline]
    fn states<const DELAY: usize>(state: &DriveState<N, DELAY>, slider: N) -> States<N> {
        States {
            velocity: state.motion.velocity,
            position: N::of_travel(state.motion.position),
            slider,
            pressure_a: state.chambers.a,
            pressure_b: state.chambers.b,
        }
    }

    /// What the sensors read. The slider is the valve's own; a drive that is entered at a measured slider has it from there.
    #[must_use]
    pub fn sensed<const DELAY: usize>(&self, state: &DriveState<N, DELAY>) -> Sensed<N> {
        self.sensors.read(&state.sensed, self.slider(state), state.chambers, &state.motion)
    }

    /// One tick. Fixed cost; no input of any size overflows or panics.
    ///
    /// An entry that the drive's source cannot take (a pump's speed on a valve drive, a slider on a pump drive) counts
    /// as closed ports.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "what the caller does not read of the interfaces is then never computed")]
    pub fn step<const DELAY: usize>(
        &self,
        state: &mut DriveState<N, DELAY>,
        entry: Entry<N>,
        load: Load<N>,
    ) -> Interfaces<N> {
        if N::LEAN
            && self.plain
            && let Entry::Command(command) = entry
            && let Some(slider) = self.step_valve::<Plain, DELAY>(state, command)
        {
            return self.step_hydraulics::<Plain, DELAY>(state, &Feed::Edges(slider), load);
        }
        self.step_links(state, entry, load)
    }

    /// One tick of a drive that may have any effect. Out of line, so that it takes no registers from the one without.
    #[inline(never)]
    fn step_links<const DELAY: usize>(
        &self,
        state: &mut DriveState<N, DELAY>,
        entry: Entry<N>,
        load: Load<N>,
    ) -> Interfaces<N> {
        let closed = Flows { a: N::ZERO, b: N::ZERO };
        let feed = match entry {
            Entry::Force { from, to } => {
                let seen = self.step_force(state, from + load.from, to + load.to);
                self.step_beside(state);
                return seen;
            }
            Entry::Command(command) => match self.step_valve::<Effects, DELAY>(state, command) {
                Some(slider) => Feed::Edges(self.shifted(state, slider)),
                None => Feed::Given { from: closed, to: closed },
            },
            Entry::Followed { command, slider } => {
                self.step_valve::<Effects, DELAY>(state, command);
                Feed::Edges(slider)
            }
            Entry::Slider(slider) => Feed::Edges(slider),
            Entry::Pump(pump) => Feed::Pump(pump),
            Entry::Flow { from, to } => Feed::Given { from, to },
        };
        let seen = self.step_hydraulics::<Effects, DELAY>(state, &feed, load);
        self.step_beside(state);
        seen
    }

    /// What only reads the links: sensors and the oil's warming.
    #[inline]
    fn step_beside<const DELAY: usize>(&self, state: &mut DriveState<N, DELAY>) {
        self.sensors.step(&mut state.sensed, state.motion.position);
        if let Some(viscosity) = &self.viscosity {
            viscosity.step(&mut state.warmth);
        }
    }

    /// Only the valve, where the drive has one.
    #[inline]
    fn step_valve<V: Vocabulary, const DELAY: usize>(
        &self,
        state: &mut DriveState<N, DELAY>,
        command: N,
    ) -> Option<Slider<N>> {
        let OilSource::Valve(valve, edges) = &self.source else { return None };
        let across = if valve.feels_flow::<V>() {
            edges.across_open(state.chambers, state.supply.pressure)
        } else {
            AcrossEdges::NONE
        };
        Some(valve.step_with::<V, DELAY>(&mut state.valve, command, across))
    }

    /// The slider over a tick with the travel of an unnamed table.
    #[inline]
    fn shifted<const DELAY: usize>(&self, state: &DriveState<N, DELAY>, slider: Slider<N>) -> Slider<N> {
        let Some(Unnamed::Travel(table)) = &self.unnamed else { return slider };
        let shifted = |slider: N| slider + table.at(Self::states(state, slider));
        Slider { from: shifted(slider.from), to: shifted(slider.to) }
    }

    /// Only the mechanics, under a given force of the oil.
    #[inline]
    fn step_force<const DELAY: usize>(&self, state: &mut DriveState<N, DELAY>, from: N, to: N) -> Interfaces<N> {
        let rise = to - from;
        let constant = self.unsprung.load;
        let forces = Forces {
            start: from + constant,
            first: from + constant + rise.part(self.gamma),
            second: to + constant - rise.part(self.gamma),
            around: self.surroundings::<Effects, DELAY>(state, N::ZERO, self.oil::<Effects, DELAY>(state)),
        };
        let position = N::of_travel(state.motion.position);
        let velocity = self.unsprung.step(&mut state.motion, forces);
        Interfaces { slider: None, flows: Flows { a: N::ZERO, b: N::ZERO }, forces, velocity, position }
    }

    #[inline]
    fn step_hydraulics<V: Vocabulary, const DELAY: usize>(
        &self,
        state: &mut DriveState<N, DELAY>,
        feed: &Feed<N>,
        load: Load<N>,
    ) -> Interfaces<N> {
        let mechanics = &self.mechanics;
        let pressures = state.chambers;
        let velocity = state.motion.velocity;
        let position = N::of_travel(state.motion.position);
        let oil = self.oil::<V, DELAY>(state);
        let filled = self.chambers.at::<V>(pressures, position, oil.map(|oil| oil.thinness));
        let chambers = filled.as_ref().map_or(&self.chambers, |filled| &filled.chambers);
        let slider = match feed {
            Feed::Edges(slider) => (slider.from + slider.to).halved(),
            Feed::Pump(_) | Feed::Given { .. } => N::ZERO,
        };
        let around = self.surroundings::<V, DELAY>(state, slider, oil);
        let added = V::on(self.unnamed.as_ref()).map(|unnamed| unnamed.flows(Self::states(state, slider)));
        let with = |flows: Flows<N>| added.map_or(flows, |more| Flows { a: flows.a + more.a, b: flows.b + more.b });
        let equation = mechanics.equation::<V>(&state.motion, around);
        let constant = mechanics.load;

        let (flows, drawn) = self.feed_from::<V>(feed, pressures, state.supply.pressure);
        let yielding = chambers.yielding::<V>(&flows);
        let start = self.pressure_force(pressures) + load.from + constant;
        let contact = equation.contact(velocity, start);
        // 1/(1 + γ²·mobility·(springs that yield)): the eliminated equation for the velocity.
        let weights = match filled.as_ref().and_then(|filled| filled.shares) {
            Some(shares) => [yielding.a.of(shares.a), yielding.b.of(shares.b)],
            None => [yielding.a, yielding.b],
        };
        let give = |share: Option<N>| {
            N::inverse_one_plus(share.map_or(weights, |share| weights.map(|weight| weight.times(share))), self.springs)
        };
        let gives = if contact == Contact::Sticks { None } else { Some(equation.gives(give)) };

        // First stage.
        let inflow1 = with(chambers.inflow::<V>(Flows { a: flows.a.flow, b: flows.b.flow }, pressures));
        let net = Flows { a: inflow1.a - velocity, b: chambers.displaced_b(velocity) - inflow1.b };
        let trial = chambers.rise(Flows { a: yielding.a.of(net.a), b: yielding.b.of(net.b) });
        let force = self.stage_force(pressures, trial) + load.from + constant;
        let stage = equation.first_stage(contact, velocity);
        let guess = equation.first_increment(&stage, force, gives);
        let ahead = guess.part(self.gamma);
        let net1 = Flows { a: yielding.a.of(net.a - ahead), b: yielding.b.of(net.b + chambers.displaced_b(ahead)) };
        let k1 = chambers.rise(net1);
        let first = self.stage_force(pressures, k1) + load.from + constant;
        let v1 = equation.first_increment(&stage, first, None);

        // Second stage.
        let (pressures2, velocity2) = (ChamberState { a: pressures.a + k1.a, b: pressures.b + k1.b }, velocity + v1);
        let supply2 = self.supplied::<V>(feed, pressures2, state.supply, drawn);
        let inflow2 = with(chambers.inflow::<V>(self.feed_to::<V>(feed, pressures2, supply2.pressure), pressures2));
        let net = Flows {
            a: inflow2.a - velocity2 - net1.a - net1.a,
            b: chambers.displaced_b(velocity2) - inflow2.b - net1.b - net1.b,
        };
        let trial = chambers.rise(Flows { a: yielding.a.of(net.a), b: yielding.b.of(net.b) });
        let force = self.stage_force(pressures2, trial) + load.to + constant;
        let stage = equation.second_stage(contact, velocity, v1);
        let guess = equation.second_increment(&stage, force, gives);
        let ahead = guess.part(self.gamma);
        let net2 = Flows { a: yielding.a.of(net.a - ahead), b: yielding.b.of(net.b + chambers.displaced_b(ahead)) };
        let second = self.stage_force(pressures2, chambers.rise(net2)) + load.to + constant;
        let v2 = equation.second_increment(&stage, second, None);

        // The links take the step.
        let moved = equation.finish(contact, &mut state.motion, v1, v2);
        let mean = moved.solved;
        let kept =
            Flows { a: N::dot(mechanics.weights, [net1.a, net2.a]), b: N::dot(mechanics.weights, [net1.b, net2.b]) };
        // A flow that no pressure moves has the mean of its ends. Taken so, a closed valve passes exactly nothing: the solved
        // flow's rounding would pump the closed chambers up within hours.
        let solved = |flow: N| if Mechanics::is_held(v1, v2) { None } else { Some(flow) };
        let flows = Flows {
            a: chambers.mean::<V>(&flows.a, inflow1.a, inflow2.a, solved(kept.a + mean)),
            b: chambers.mean::<V>(&flows.b, inflow1.b, inflow2.b, solved(chambers.displaced_b(mean) - kept.b)),
        };
        let (flows, mean) = match moved.beyond {
            None => (flows, mean),
            Some(beyond) => (chambers.stopped(flows, beyond, &yielding), mean - beyond),
        };
        chambers.fill(&mut state.chambers, &mut state.rest, flows, mean);
        state.supply = self.supplied::<V>(feed, state.chambers, state.supply, drawn);
        let slider = if let Feed::Edges(slider) = feed { Some(*slider) } else { None };
        Interfaces { slider, flows, forces: Forces { start, first, second, around }, velocity: mean, position }
    }

    /// Flows of the feed at the start of the tick, with their slopes, and the flow drawn from a supply that droops.
    #[inline]
    fn feed_from<V: Vocabulary>(
        &self,
        feed: &Feed<N>,
        pressures: ChamberState<N>,
        supply: N,
    ) -> (Flows<Linearised<N>>, N) {
        let given = |flow: N| Linearised { flow, opening: N::ZERO, slope: self.chambers.unity };
        let flows = match (feed, &self.source) {
            (Feed::Edges(slider), OilSource::Valve(_, edges)) => {
                return edges.linearised_with::<V>(*slider, pressures, supply);
            }
            (Feed::Pump(drive), OilSource::Pump(pump)) => pump.flow(*drive, pressures.a, pressures.b),
            (Feed::Given { from, .. }, _) => Flows { a: given(from.a), b: given(from.b) },
            _ => Flows { a: given(N::ZERO), b: given(N::ZERO) },
        };
        (flows, N::ZERO)
    }

    /// Flows of the feed at the end of the tick.
    #[inline]
    fn feed_to<V: Vocabulary>(&self, feed: &Feed<N>, pressures: ChamberState<N>, supply: N) -> Flows<N> {
        match (feed, &self.source) {
            (Feed::Edges(slider), OilSource::Valve(_, edges)) => edges.flow_with::<V>(slider.to, pressures, supply),
            (Feed::Pump(drive), OilSource::Pump(pump)) => {
                let flows = pump.flow(*drive, pressures.a, pressures.b);
                Flows { a: flows.a.flow, b: flows.b.flow }
            }
            (Feed::Given { to, .. }, _) => *to,
            _ => Flows { a: N::ZERO, b: N::ZERO },
        }
    }

    /// The supply at the end of a tick that ends at these pressures; it stays where nothing feeds from it.
    #[inline]
    fn supplied<V: Vocabulary>(
        &self,
        feed: &Feed<N>,
        pressures: ChamberState<N>,
        supply: SupplyState<N>,
        drawn: N,
    ) -> SupplyState<N> {
        match (feed, &self.source) {
            (Feed::Edges(slider), OilSource::Valve(_, edges)) => {
                edges.supplied::<V>(slider.to, pressures, supply, drawn)
            }
            _ => supply,
        }
    }

    /// Temperature that the machine's values are for, where the viscosity goes by it.
    fn reference_temperature(&self) -> N {
        self.viscosity.and_then(|viscosity| viscosity.thinning).map_or(N::ZERO, |thinning| thinning.reference)
    }

    /// The oil at the start of a tick, where it changes.
    #[inline]
    fn oil<V: Vocabulary, const DELAY: usize>(&self, state: &DriveState<N, DELAY>) -> Option<Oil<N>> {
        V::on(self.viscosity.as_ref()).map(|viscosity| viscosity.oil(state.warmth, state.oil_temperature))
    }

    /// What friction depends on beside the motion.
    #[inline]
    fn surroundings<V: Vocabulary, const DELAY: usize>(
        &self,
        state: &DriveState<N, DELAY>,
        slider: N,
        oil: Option<Oil<N>>,
    ) -> Surroundings<N> {
        let pushed = V::on(self.mechanics.push.as_ref()).is_some();
        Surroundings {
            pressed: state.chambers.a.max(N::ZERO) + state.chambers.b.max(N::ZERO),
            viscosity: oil.map_or(N::ZERO, |oil| oil.excess),
            states: if pushed { Self::states(state, slider) } else { States::NONE },
        }
    }

    /// pa − α·pb.
    #[inline]
    fn pressure_force(&self, pressures: ChamberState<N>) -> N {
        pressures.a - self.chambers.displaced_b(pressures.b)
    }

    /// pa − α·pb with γ of a stage's increment ahead.
    #[inline]
    fn stage_force(&self, pressures: ChamberState<N>, increment: ChamberState<N>) -> N {
        let ahead = |pressure: N, increment: N| pressure + increment.part(self.gamma);
        self.pressure_force(ChamberState { a: ahead(pressures.a, increment.a), b: ahead(pressures.b, increment.b) })
    }
}
