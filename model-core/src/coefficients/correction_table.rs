//! Coefficients of the correction table; `None` where it adds nothing.

use super::Builder;
use crate::correction_table::{ACROSS, Axis, NODES, Push, State, Unnamed, ValueGrid};
use crate::machine::{MachineError, Parameter as P};
use crate::number::{Number, Real};

/// What the table adds to: numbers of the machine file.
const FORCE: f64 = 1.0;
const FLOW_INTO_A: f64 = 2.0;
const FLOW_OUT_OF_B: f64 = 3.0;
const TRAVEL: f64 = 4.0;

impl<R: Real> Builder<'_, R> {
    /// Flow or spool travel.
    pub(super) fn unnamed<N: Number<Real = R>>(&self) -> Result<Option<Unnamed<N>>, MachineError> {
        let flow = self.bases.flow_m3_per_s;
        Ok(match self.table_of() {
            Some(FLOW_INTO_A) => Some(Unnamed::IntoA(self.table(flow)?)),
            Some(FLOW_OUT_OF_B) => Some(Unnamed::OutOfB(self.table(flow)?)),
            Some(TRAVEL) => Some(Unnamed::Travel(self.table(1.0)?)),
            _ => None,
        })
    }

    /// Force on the rod.
    pub(super) fn push<N: Number<Real = R>>(&self) -> Result<Option<Push<N>>, MachineError> {
        if self.table_of() != Some(FORCE) {
            return Ok(None);
        }
        let damping = self.table_damping() * R::constant(self.bases.velocity_m_per_s / self.bases.force_n);
        Ok(Some(Push {
            table: self.table(self.bases.force_n)?,
            damping: self.steep::<N>("steepest slope of the table over velocity", P::TableTo, damping)?,
        }))
    }

    /// The steepest slope against the velocity of a table of forces, N s/m; 0 where none damps.
    pub(super) fn table_damping(&self) -> R {
        if self.table_of() != Some(FORCE) {
            return R::ZERO;
        }
        let rows = self.rows();
        let mut steepest = [R::ZERO; 2];
        let mut seen = |slot: usize, fall: R| {
            if let Some(steepest) = steepest.get_mut(slot)
                && fall > *steepest
            {
                *steepest = fall;
            }
        };
        let spacing = |from: P, to: P, spaces: f64| (self.get(to) - self.get(from)) / R::constant(spaces);
        if self.state(P::TableOver) == Some(State::Velocity) {
            let spacing = spacing(P::TableFrom, P::TableTo, (NODES - 1) as f64);
            for (lower, upper) in rows.iter().zip(rows.iter().skip(1)) {
                for (lower, upper) in lower.iter().zip(upper) {
                    seen(0, (*lower - *upper) / spacing);
                }
            }
        }
        if self.state(P::TableOver2) == Some(State::Velocity) {
            let spacing = spacing(P::TableFrom2, P::TableTo2, (ACROSS - 1) as f64);
            for row in &rows {
                for (lower, upper) in row.iter().zip(row.iter().skip(1)) {
                    seen(1, (*lower - *upper) / spacing);
                }
            }
        }
        let [along, across] = steepest;
        along + across
    }

    /// What the table adds to, where it adds anything.
    fn table_of(&self) -> Option<f64> {
        let on = P::TABLE_VALUES.iter().any(|&value| !self.get(value).is_nil());
        on.then(|| self.get(P::TableQuantity).value())
    }

    fn state(&self, of: P) -> Option<State> {
        let states = [State::Velocity, State::Position, State::Spool, State::PressureA, State::PressureB];
        let number = self.get(of).value();
        let is = |known: i32| (f64::from(known) - number).abs() < 0.5;
        states.into_iter().zip(1..).find(|(_, known)| is(*known)).map(|(state, _)| state)
    }

    /// The values, node by node; of one state the first of each node.
    fn rows(&self) -> [[R; ACROSS]; NODES] {
        let across = if self.state(P::TableOver2).is_some() { ACROSS } else { 1 };
        let mut rows = [[R::ZERO; ACROSS]; NODES];
        for (row, values) in rows.iter_mut().zip(P::TABLE_VALUES.chunks(across)) {
            for (slot, &value) in row.iter_mut().zip(values) {
                *slot = self.get(value);
            }
        }
        rows
    }

    fn table<N: Number<Real = R>>(&self, base: f64) -> Result<ValueGrid<N>, MachineError> {
        let mut values = [[N::ZERO; ACROSS]; NODES];
        let across = if self.state(P::TableOver2).is_some() { ACROSS } else { 1 };
        for (row, of) in values.iter_mut().zip(P::TABLE_VALUES.chunks(across)) {
            for (slot, &of) in row.iter_mut().zip(of) {
                // Twice of it fits as well, so that the rise between two nodes does.
                let half = self.signal::<N>(
                    "twice a value of the table",
                    of,
                    R::constant(2.0) * self.get(of) / R::constant(base),
                )?;
                *slot = half.halved();
            }
        }
        Ok(ValueGrid {
            first: self.axis(P::TableOver, P::TableFrom, P::TableTo, (NODES - 1) as f64)?,
            second: self.axis(P::TableOver2, P::TableFrom2, P::TableTo2, (ACROSS - 1) as f64)?,
            values,
        })
    }

    fn axis<N: Number<Real = R>>(&self, over: P, from: P, to: P, spaces: f64) -> Result<Option<Axis<N>>, MachineError> {
        let Some(state) = self.state(over) else { return Ok(None) };
        let base = R::constant(match state {
            State::Velocity => self.bases.velocity_m_per_s,
            State::Position => self.bases.stroke_m,
            State::Spool => 1.0,
            State::PressureA | State::PressureB => self.bases.pressure_pa,
        });
        let per_state = R::constant(spaces) * base / (self.get(to) - self.get(from));
        Ok(Some(Axis {
            state,
            from: self.signal("first node of the table", from, self.get(from) / base)?,
            per_state: self.steep::<N>("nodes of the table per range of its state", to, per_state)?,
        }))
    }
}
