//! A correction table for what no effect explains: it adds to one quantity of the model, over one or two of its states.
//!
//! ```text
//! u = 6·(x − from)/(to − from), 0..6           seven nodes over the first state
//! w = 2·(x₂ − from₂)/(to₂ − from₂), 0..2       three values a node, where there is a second
//! T = T₀ + Σ (Tᵢ₊₁ − Tᵢ)·clamp(u − i, 0, 1)    linear, or bilinear; held at the ends
//! ```
//!
//! A flow or a spool travel takes the states explicitly, at the start of the tick (for the spool its mean over the tick, for a travel each of its
//! ends). So a flow that falls with its own chamber's pressure must not empty the chamber within a tick, or it oscillates; the table
//! bounds this oscillation. A force over position is a spring evaluated at the tick's start: one of stiffness k has too little damping by
//! k·h/2.
//!
//! A force over velocity is evaluated at both stages. Its steepest damping slope s anywhere is moved to the implicit side:
//! F(v) = −s·v + (F(v) + s·v), where the first term joins the viscous friction. The sum is the table's, however steep it falls; elsewhere
//! the step's Jacobian is too large, which does not reduce the order. A slope that drives stays explicit: it drives the velocity away from
//! its present value, but makes no oscillation. Per unit, s is rounded to 2⁻¹⁶.
//!
//! Error against the formula: 2⁻²⁶ of the largest rise between two nodes, for each node, and the error in u from rounding 6/(to − from)
//! to 2⁻¹⁶. Values are below 4 per unit, so that no rise saturates.

use crate::number::{Mask, Number};
use crate::ports::{Flows, States};

/// One of the states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[doc(hidden)]
pub enum State {
    Velocity,
    Position,
    Spool,
    PressureA,
    PressureB,
}

impl State {
    #[inline]
    fn of<N: Copy>(self, states: &States<N>) -> N {
        match self {
            State::Velocity => states.velocity,
            State::Position => states.position,
            State::Spool => states.spool,
            State::PressureA => states.pressure_a,
            State::PressureB => states.pressure_b,
        }
    }
}

/// Nodes over one state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Axis<N: Number> {
    pub state: State,
    /// At the first node.
    pub from: N,
    /// Nodes per state.
    pub per_state: N::Steep,
}

impl<N: Number> Axis<N> {
    /// Nodes from the first.
    #[inline]
    fn nodes(&self, states: &States<N>) -> N {
        (self.state.of(states) - self.from).amplified(self.per_state).max(N::ZERO)
    }
}

/// Nodes of the first state.
pub(crate) const NODES: usize = 7;
/// Values of a node with a second state.
pub(crate) const ACROSS: usize = 3;

/// The table, per unit of its quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct ValueGrid<N: Number> {
    /// `None`: the first node everywhere.
    pub first: Option<Axis<N>>,
    /// `None`: the first of each node's values.
    pub second: Option<Axis<N>>,
    pub values: [[N; ACROSS]; NODES],
}

/// Value along equally spaced values, `nodes` from the first; held at the ends.
#[inline]
fn along<N: Number>(mut values: impl Iterator<Item = N>, nodes: N) -> N {
    let Some(mut lower) = values.next() else { return N::ZERO };
    let (mut total, mut left) = (lower, nodes);
    for upper in values {
        let inside = left.above(N::ZERO);
        if !inside.any() {
            break;
        }
        total = total + N::pick(inside, (upper - lower).times(left.min(N::ONE)), N::ZERO);
        left = left - N::ONE;
        lower = upper;
    }
    total
}

impl<N: Number> ValueGrid<N> {
    /// What the table adds in these states.
    #[inline]
    pub(crate) fn at(&self, states: States<N>) -> N {
        let nodes = self.first.as_ref().map_or(N::ZERO, |axis| axis.nodes(&states));
        match &self.second {
            None => along(self.values.iter().map(|[value, ..]| *value), nodes),
            Some(axis) => {
                let across = axis.nodes(&states);
                along(self.values.iter().map(|values| along(values.iter().copied(), across)), nodes)
            }
        }
    }
}

/// A correction table of the links above the mechanics.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub enum Unnamed<N: Number> {
    /// Flow into A.
    IntoA(ValueGrid<N>),
    /// Flow out of B.
    OutOfB(ValueGrid<N>),
    /// Spool travel, after the lags.
    Travel(ValueGrid<N>),
}

impl<N: Number> Unnamed<N> {
    /// What the table adds to the flows.
    #[inline]
    pub(crate) fn flows(&self, states: States<N>) -> Flows<N> {
        match self {
            Unnamed::IntoA(table) => Flows { a: table.at(states), b: N::ZERO },
            Unnamed::OutOfB(table) => Flows { a: N::ZERO, b: table.at(states) },
            Unnamed::Travel(_) => Flows { a: N::ZERO, b: N::ZERO },
        }
    }
}

/// A table of forces on the rod.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Push<N: Number> {
    pub table: ValueGrid<N>,
    /// s: its steepest damping slope, which is part of the implicit side too.
    pub damping: N::Steep,
}

impl<N: Number> Push<N> {
    /// F(v) + s·v.
    #[inline]
    pub(crate) fn at(&self, states: States<N>) -> N {
        self.table.at(states) + states.velocity.amplified(self.damping)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;
    use crate::drive::{Drive, DriveInput, DriveState, Load};
    use crate::machine::{Machine, MachineError, Parameter as P, Source, Tick};
    use crate::number::{PerUnit, Scalar};
    use crate::ports::ChamberState;

    fn press() -> Machine<f64> {
        let mut machine = Machine::with_defaults(Source::Valve);
        let cylinder = [(P::AreaA, 3.117e-3), (P::AreaB, 1.861e-3), (P::VolumeA, 5.2e-4), (P::VolumeB, 3.3e-4)];
        for (parameter, value) in cylinder {
            machine.set(parameter, value);
        }
        machine
    }

    /// The press with a table of one state.
    fn over(quantity: f64, state: f64, [from, to]: [f64; 2], values: [f64; 7]) -> Machine<f64> {
        let mut machine = press();
        for (parameter, value) in
            [(P::TableQuantity, quantity), (P::TableOver, state), (P::TableFrom, from), (P::TableTo, to)]
        {
            machine.set(parameter, value);
        }
        for (parameter, value) in P::TABLE_VALUES.into_iter().zip(values) {
            machine.set(parameter, value);
        }
        machine
    }

    /// Steps up, back and to rest; the states on the way.
    fn run<N: Scalar<Real = f64>>(machine: &Machine<f64>, ticks: u32) -> (DriveState<N>, Vec<[f64; 2]>) {
        let drive = Drive::<N>::new::<64>(machine, Tick::OneMillisecond).unwrap();
        let pressures = ChamberState { a: N::saturated(0.3), b: N::saturated(0.5) };
        let mut state: DriveState<N> = drive.at_rest(N::ZERO, pressures, N::travel(0.5));
        let mut way = Vec::new();
        for tick in 0..ticks {
            let command = [0.6, -0.6, 0.0, 0.2][(tick / 200 % 4) as usize];
            drive.step(&mut state, DriveInput::Command(N::saturated(command)), Load::NONE);
            let velocity = state.motion.velocity.to_f64() * drive.bases().velocity_m_per_s;
            way.push([velocity, N::strokes(state.motion.position)]);
        }
        (state, way)
    }

    #[test]
    fn between_two_nodes_the_table_is_a_straight_line_and_beyond_its_ends_it_is_held() {
        let axis = |state: State, per_state: f64| {
            Some(Axis { state, from: PerUnit::saturated(-0.3), per_state: PerUnit::steep(per_state).unwrap() })
        };
        let mut values = [[PerUnit::ZERO; ACROSS]; NODES];
        for (node, row) in values.iter_mut().enumerate() {
            for (across, value) in row.iter_mut().enumerate() {
                *value = PerUnit::saturated(0.1 * node as f64 * node as f64 + 0.5 * across as f64);
            }
        }
        let table = ValueGrid { first: axis(State::Velocity, 10.0), second: None, values };
        let two = ValueGrid { second: axis(State::Spool, 5.0), ..table };
        let at = |table: &ValueGrid<PerUnit>, velocity: f64, spool: f64| {
            let [velocity, spool] = [velocity, spool].map(PerUnit::saturated);
            table.at(States { velocity, spool, ..States::NONE }).to_f64()
        };
        for (velocity, expected) in [(-1.0, 0.0), (-0.25, 0.05), (0.0, 0.9), (0.05, 1.25), (0.3, 3.6), (7.0, 3.6)] {
            assert!((at(&table, velocity, 0.0) - expected).abs() < 1e-6, "{velocity}");
            assert!((at(&two, velocity, -0.3) - expected).abs() < 1e-6, "{velocity}");
            assert!((at(&two, velocity, -0.2) - expected - 0.25).abs() < 1e-6, "{velocity}");
            assert!((at(&two, velocity, 5.0) - expected - 1.0).abs() < 1e-6, "{velocity}");
        }
    }

    #[test]
    fn a_table_of_nothing_changes_no_bit() {
        let mut none = over(1.0, 1.0, [-0.1, 0.1], [0.0; 7]);
        none.set(P::TableOver2, 4.0);
        assert_eq!(run::<PerUnit>(&none, 900).0, run::<PerUnit>(&press(), 900).0);
        assert_eq!(run::<f64>(&none, 900).0, run::<f64>(&press(), 900).0);
    }

    #[test]
    fn a_straight_table_over_velocity_is_viscous_friction() {
        let table = over(1.0, 1.0, [-0.6, 0.6], [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(|node: f64| -4000.0 * node));
        let mut viscous = press();
        viscous.set(P::ViscousFriction, 3e4);
        // Under a given force, where no mass is matched to the oil spring (this match would depend on the friction).
        let driven = |machine: &Machine<f64>| {
            let drive = Drive::<f64>::new::<64>(machine, Tick::OneMillisecond).unwrap();
            let mut state: DriveState<f64> = drive.at_rest(0.0, ChamberState { a: 0.3, b: 0.5 }, 0.5);
            let force = |tick: u32| 4000.0 * libm::sin(0.02 * f64::from(tick)) / drive.bases().force_n;
            let step = |tick| {
                drive.step(&mut state, DriveInput::Force { from: force(tick), to: force(tick + 1) }, Load::NONE);
                state.motion.velocity * drive.bases().velocity_m_per_s
            };
            (0..800).map(step).collect::<Vec<f64>>()
        };
        for (one, other) in driven(&table).into_iter().zip(driven(&viscous)) {
            assert!((one - other).abs() < 1e-12, "{one} {other}");
        }
    }

    #[test]
    fn friction_as_steep_as_a_table_gets_does_not_chatter() {
        // 2 kN within 3 mm/s: a step of 1 ms would overshoot a mass of 20 kg 30 times.
        let brake = over(1.0, 1.0, [-3e-3, 3e-3], [2e3, 2e3, 2e3, 0.0, -2e3, -2e3, -2e3]);
        let (_, way) = run::<PerUnit>(&brake, 600);
        for pair in way[500..].windows(2) {
            assert!((pair[0][0] - pair[1][0]).abs() < 2e-3, "{pair:?}");
        }
    }

    #[test]
    fn every_quantity_over_every_state_agrees_in_fixed_point_and_moves_the_drive() {
        let (_, plain) = run::<f64>(&press(), 800);
        for (quantity, size) in [(1.0, 900.0), (2.0, 2e-5), (3.0, 2e-5), (4.0, 0.03)] {
            for (state, range) in
                [(1.0, [-0.2, 0.2]), (2.0, [0.1, 0.2]), (3.0, [-0.6, 0.6]), (4.0, [1e6, 6e6]), (5.0, [1e6, 6e6])]
            {
                let mut machine = over(quantity, state, range, [0.0; 7]);
                machine.set(P::TableOver2, 2.0);
                machine.set(P::TableFrom2, 0.1);
                machine.set(P::TableTo2, 0.2);
                for (index, value) in P::TABLE_VALUES.into_iter().enumerate() {
                    machine.set(value, size * [1.0, -0.6, 0.3, 0.8, -1.0][index % 5]);
                }
                let (fixed, real) = (run::<PerUnit>(&machine, 800).1, run::<f64>(&machine, 800).1);
                let mut moved = 0.0_f64;
                for ((fixed, real), plain) in fixed.iter().zip(&real).zip(&plain) {
                    assert!((fixed[1] - real[1]).abs() < 2e-5, "{quantity} {state}: {fixed:?} {real:?}");
                    moved = moved.max((real[1] - plain[1]).abs());
                }
                assert!(moved > 1e-5, "{quantity} {state}: {moved}");
            }
        }
    }

    #[test]
    fn numbers_between_those_of_the_list_and_an_empty_range_are_refused() {
        let new = |machine: &Machine<f64>| Drive::<PerUnit>::new::<64>(machine, Tick::OneMillisecond).err();
        let between = new(&over(1.5, 1.0, [-0.1, 0.1], [1.0; 7]));
        assert!(matches!(between, Some(MachineError::NotWhole { parameter: P::TableQuantity, .. })));
        let range = new(&over(1.0, 1.0, [0.1, 0.1], [1.0; 7]));
        assert!(matches!(range, Some(MachineError::DoesNotFit { parameter: P::TableTo, .. })));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        #[test]
        fn no_table_of_any_size_panics_or_leaves_the_format(
            quantity in 1..5_u8, state in 0..6_u8, second in 0..6_u8,
            range in prop::array::uniform2(-1.0..1.0_f64), shares in prop::array::uniform21(-1.0..1.0_f64),
        ) {
            let mut machine = over(f64::from(quantity), f64::from(state), [range[0], range[0] + 0.01 + range[1].abs()], [0.0; 7]);
            let base = [2.2e4, 1e-4, 1e-4, 1.0][usize::from(quantity) - 1];
            machine.set(P::TableOver2, f64::from(second));
            for (value, share) in P::TABLE_VALUES.into_iter().zip(shares) {
                machine.set(value, 3.0 * share * base);
            }
            let Ok(drive) = Drive::<PerUnit>::new::<64>(&machine, Tick::OneMillisecond) else { return Ok(()) };
            let pressures = ChamberState { a: PerUnit::saturated(0.3), b: PerUnit::saturated(0.5) };
            let mut state: DriveState<PerUnit> = drive.at_rest(PerUnit::ZERO, pressures, PerUnit::travel(0.5));
            for tick in 0..300 {
                let command = PerUnit::saturated(if tick % 50 < 25 { 8.0 } else { -8.0 });
                drive.step(&mut state, DriveInput::Command(command), Load::NONE);
                prop_assert!(drive.sensed(&state).spool.to_f64().abs() <= 8.0);
            }
        }
    }
}
